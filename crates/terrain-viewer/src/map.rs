//! The map: the DEM from above with the camera on it. A click flies there.

use egui::{
    Align2, Color32, ColorImage, Context, Image, Painter, Pos2, Rect, Sense, Shape, Stroke, StrokeKind, TextureHandle,
    TextureOptions, Ui, Window, vec2,
};
use terrain_core::{Heightmap, Sample, View};

use crate::command::{Command, Side};
use crate::gui::ACCENTS;
use crate::pane::{Cells, Pane};
use crate::state::State;

/// Points of the longer side.
pub const SIDE: f32 = 170.0;
/// Texels of the longer side.
const TEXELS: usize = 340;
/// How far a loaded cell covers the map, once for each level.
const LOADED: f32 = 0.22;

pub struct Map {
    image: ColorImage,
    /// Made when it is shown first, and with every new interface.
    texture: Option<TextureHandle>,
    extent_m: [f64; 2],
    spacing_m: [f64; 2],
}

/// What is on the map.
pub struct Shown<'a> {
    pub state: &'a State,
    pub panes: &'a [Pane; 2],
    pub view: &'a View,
}

/// Where the map lies in the window.
struct Place {
    rect: Rect,
    /// Points a metre.
    scale: f64,
}

impl Map {
    pub fn of(heightmap: &Heightmap) -> Self {
        Self {
            image: shaded_relief(heightmap),
            texture: None,
            extent_m: heightmap.extent_m(),
            spacing_m: heightmap.spacing_m(),
        }
    }

    pub fn show(&mut self, context: &Context, shown: &Shown, commands: &mut Vec<Command>) {
        Window::new("map")
            .title_bar(false)
            .resizable(false)
            .anchor(Align2::RIGHT_TOP, [-12.0, 12.0])
            .show(context, |ui| self.contents(ui, shown, commands));
    }

    fn contents(&mut self, ui: &mut Ui, shown: &Shown, commands: &mut Vec<Command>) {
        let Self { image, texture, extent_m: [x_m, z_m], spacing_m } = self;
        let texture =
            texture.get_or_insert_with(|| ui.ctx().load_texture("map", image.clone(), TextureOptions::LINEAR));
        let scale = f64::from(SIDE) / x_m.max(*z_m);
        let size = vec2((*x_m * scale) as f32, (*z_m * scale) as f32);
        let response = ui.add(Image::new((texture.id(), size)).sense(Sense::click()));
        let place = Place { rect: response.rect, scale };
        let painter = ui.painter_at(response.rect);
        for ((side, accent), pane) in [Side::Left, Side::Right].into_iter().zip(ACCENTS).zip(shown.panes) {
            if let Some(cells) = pane.cells().filter(|_| shown.state.shown.includes(side)) {
                paint_cells(&painter, &place, &cells, *spacing_m, accent);
            }
        }
        paint_camera(&painter, &place, shown);
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
            let moved = (at - response.rect.min) / size;
            let mut rig = shown.state.rig.clone();
            (rig.camera.eye_world.x, rig.camera.eye_world.z) = (f64::from(moved.x) * *x_m, f64::from(moved.y) * *z_m);
            commands.push(Command::Camera(rig.link()));
        }
    }
}

impl Place {
    fn of(&self, x_m: f64, z_m: f64) -> Pos2 {
        self.rect.min + vec2((x_m * self.scale) as f32, (z_m * self.scale) as f32)
    }
}

/// The windows around the eye, level by level, with the cells in them that are loaded, more strongly where more levels are; and
/// the lines between cells, where they can be told apart.
fn paint_cells(painter: &Painter, place: &Place, cells: &Cells, spacing_m: [f64; 2], colour: Color32) {
    let [x_m, z_m] = spacing_m.map(|spacing_m| spacing_m * f64::from(cells.side));
    let corner = |[column, row]: [u32; 2]| place.of(f64::from(column) * x_m, f64::from(row) * z_m);
    for (level, [first, last]) in cells.windows.iter().enumerate() {
        for cell in cells.loaded.into_iter().flat_map(|loaded| loaded.of_level(level)) {
            let sheet = Rect::from_two_pos(corner(cell), corner(cell.map(|at| at + 1)));
            painter.rect_filled(sheet, 0.0, colour.gamma_multiply(LOADED));
        }
        let window = Rect::from_two_pos(corner(*first), corner(last.map(|at| at + 1)));
        painter.rect_stroke(window, 0.0, Stroke::new(1.0, colour), StrokeKind::Inside);
    }
    let step = vec2((x_m * place.scale) as f32, (z_m * place.scale) as f32);
    if step.min_elem() >= 3.0 {
        let stroke = Stroke::new(0.5, colour.gamma_multiply(0.5));
        let lines = |end: f32, step: f32| (1..).map(move |i| i as f32 * step).take_while(move |at| *at < end);
        for x in lines(place.rect.width(), step.x) {
            painter.vline(place.rect.left() + x, place.rect.y_range(), stroke);
        }
        for y in lines(place.rect.height(), step.y) {
            painter.hline(place.rect.x_range(), place.rect.top() + y, stroke);
        }
    }
}

/// Where it is, and what it sees.
fn paint_camera(painter: &Painter, place: &Place, shown: &Shown) {
    let rig = &shown.state.rig;
    let [width, height] = shown.view.size_px.map(f64::from);
    let half = ((0.5 * rig.fov_y).tan() * width / height).atan();
    let eye = place.of(rig.camera.eye_world.x, rig.camera.eye_world.z);
    let ray = |angle: f64| eye + vec2(angle.sin() as f32, -angle.cos() as f32) * 44.0;
    let heading = rig.camera.heading;
    let sees = vec![eye, ray(heading - half), ray(heading), ray(heading + half)];
    let yellow = Color32::from_rgb(255, 232, 120);
    painter.add(Shape::convex_polygon(sees, yellow.gamma_multiply(0.45), Stroke::new(1.0, yellow)));
    painter.circle(eye, 4.0, Color32::from_rgb(255, 90, 70), Stroke::new(1.5, Color32::WHITE));
}

/// Heights by tint, slopes by light from the north-west.
fn shaded_relief(heightmap: &Heightmap) -> ColorImage {
    let sides = [heightmap.columns(), heightmap.rows()].map(|side| side as usize);
    let scale = (TEXELS as f64 / sides[0].max(sides[1]) as f64).min(1.0);
    let size = sides.map(|side| ((side as f64 * scale) as usize).max(2));
    let last = Sample { column: heightmap.columns() - 1, row: heightmap.rows() - 1 };
    let [low_m, high_m] = heightmap.height_range_m(Sample { column: 0, row: 0 }, last);
    let texel = |x: usize, y: usize| {
        let along = |at: usize, size: usize, last: u32| (at as u64 * u64::from(last) / (size as u64 - 1)) as u32;
        let at = Sample { column: along(x, size[0], last.column), row: along(y, size[1], last.row) };
        let height = (heightmap.height_m(at) - low_m) / (high_m - low_m).max(1e-3);
        let [nx, ny, nz] = heightmap.normal(at);
        let light = (0.35 + 0.75 * (-0.6 * nx + 0.6 * ny - 0.53 * nz)).clamp(0.15, 1.1);
        let tint = |from: f32, to: f32| ((from + (to - from) * height) * light).clamp(0.0, 255.0) as u8;
        Color32::from_rgb(tint(104.0, 226.0), tint(132.0, 222.0), tint(92.0, 212.0))
    };
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
    ColorImage::new(size, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_of_any_shape_have_an_image() {
        for [columns, rows] in [[2, 2], [1000, 3], [65, 129]] {
            let flat = vec![0.0; (columns * rows) as usize];
            let image = shaded_relief(&Heightmap::new(columns, rows, [1.0; 2], flat).unwrap());
            assert!(image.size.iter().all(|side| (2..=TEXELS).contains(side)), "{:?}", image.size);
        }
    }
}
