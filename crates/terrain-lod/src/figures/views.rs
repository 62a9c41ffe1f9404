//! Figures that are pictures: one view, drawn for several runs or in several looks.

use image::{Rgb, RgbImage, imageops};
use terrain_core::{FramePlan, FrameStats};
use terrain_renderer::Gpu;

use super::spec::{Figure, Panel};
use crate::bench::scene;
use crate::fault::Fault;
use crate::fine::FineRenderer;
use crate::lettering;
use crate::suite::Bench;

/// White pixels between panels.
const GAP: u32 = 8;

/// All panels with their labels below them.
pub fn draw(figure: &Figure, bench: &Bench, gpu: &Gpu) -> Result<RgbImage, Fault> {
    let [width, height] = figure.size_px();
    let scene = scene(gpu, &bench.dem.heightmap)?;
    let mut fine = FineRenderer::new(gpu, scene, bench.submission, [width, height])?;
    let columns = figure.columns.unwrap_or(u32::MAX).min(figure.panels.len() as u32);
    let scale = if width < 400 { 1 } else { 2 };
    let label = scale * lettering::HEIGHT + 8;
    let rows = (figure.panels.len() as u32).div_ceil(columns);
    let size = [columns * (width + GAP) - GAP, rows * (height + label + GAP) - GAP];
    let mut sheet = RgbImage::from_pixel(size[0], size[1], Rgb([255; 3]));
    for (i, panel) in (0..).zip(&figure.panels) {
        let Some((picture, triangles)) = self::panel(figure, panel, bench, &mut fine)? else { continue };
        let [left, top] = [i % columns * (width + GAP), i / columns * (height + label + GAP)].map(i64::from);
        imageops::replace(&mut sheet, &picture, left, top);
        let text = text(panel, triangles, width / scale);
        let middle = i64::from(width.saturating_sub(scale * lettering::width(&text)) / 2);
        lettering::write(&mut sheet, [left + middle, top + i64::from(height) + 5], scale, Rgb([20, 24, 32]), &text);
    }
    Ok(sheet)
}

/// The picture of one panel and its number of triangles; none where its run is not flown.
fn panel(
    figure: &Figure,
    panel: &Panel,
    bench: &Bench,
    fine: &mut FineRenderer,
) -> Result<Option<(RgbImage, u64)>, Fault> {
    let Some(run) = panel.run_of(bench) else { return Ok(None) };
    let mut method = run.converged().build(&bench.dem.heightmap, &bench.prepared)?;
    let mut buffers = fine.renderer.buffers(method.buffers())?;
    let mut plan = FramePlan::default();
    method.plan(&figure.plan_view(bench)?, &mut plan);
    let view = figure.drawn_view(bench, fine.size_px())?;
    let picture = fine.draw(&view, &plan, &mut buffers, &panel.look())?;
    Ok(Some((picture, FrameStats::of(&plan).triangles)))
}

/// The label with the triangles, where there is room for both.
fn text(panel: &Panel, triangles: u64, room: u32) -> String {
    let both = format!("{}: {} triangles", panel.label, grouped(triangles));
    if lettering::width(&both) <= room { both } else { panel.label.clone() }
}

/// 1234567 as 1,234,567.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let (first, rest) = digits.split_at((digits.len() - 1) % 3 + 1);
    let rest = rest.as_bytes().chunks(3).map(|three| format!(",{}", String::from_utf8_lossy(three)));
    std::iter::once(first.to_owned()).chain(rest).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn thousands_are_grouped() {
        assert_eq!([0, 999, 1000, 1_234_567].map(super::grouped), ["0", "999", "1,000", "1,234,567"]);
    }
}
