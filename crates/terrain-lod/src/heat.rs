//! Error heat maps: the terrain in view, coloured by the screen-space error of the nearest sample of the DEM.
//!
//! Where the terrain is, the full grid's depths say; what the error is there, the error oracle. Of the points in a pixel the
//! worst counts. Classes double from an eighth of the tolerance to eight times it: blue within the tolerance, orange and
//! yellow beyond, and lighter with every class.

use image::{Rgb, RgbImage};
use terrain_core::error::{ErrorDistribution, ErrorOracle};
use terrain_core::{Heightmap, Sample, View};

use crate::lettering::{self, fill};
use crate::record::digits;

/// From the least error to the largest.
const CLASSES: [Rgb<u8>; 8] = [
    Rgb([20, 32, 74]),
    Rgb([28, 58, 115]),
    Rgb([37, 88, 150]),
    Rgb([51, 122, 176]),
    Rgb([234, 147, 68]),
    Rgb([251, 178, 73]),
    Rgb([253, 215, 93]),
    Rgb([250, 246, 175]),
];
/// Where there is nothing to measure: sky, or a sample at the rim that no triangle in view covers.
const NOTHING: Rgb<u8> = Rgb([222, 225, 230]);
const PAPER: Rgb<u8> = Rgb([255; 3]);
const INK: Rgb<u8> = Rgb([16, 20, 28]);

/// Depths beside each other that are apart by more than this are of different ridges.
const RIDGE_RATIO: f32 = 1.1;

/// One view of one mesh.
pub struct HeatMap<'a> {
    pub heightmap: &'a Heightmap,
    /// Of the mesh.
    pub oracle: &'a ErrorOracle<'a>,
    /// That the errors are measured in.
    pub view: &'a View,
    /// The full grid's in this view, `factor` x `factor` for each pixel: reversed, as the renderer gives them.
    pub depths: &'a [f32],
    pub factor: u32,
    pub tolerance_px: f64,
}

impl HeatMap<'_> {
    /// The map with its legend below.
    pub fn paint(&self) -> RgbImage {
        let [width, height] = self.view.size_px;
        let legend = Legend::of(width);
        let mut picture = RgbImage::from_pixel(width.max(legend.width()), height + legend.height(), PAPER);
        let unprojection = self.view.unprojection();
        for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
            let mut colour = NOTHING;
            if let Some(error_px) = self.worst_px(&unprojection, [column, row]) {
                colour = CLASSES[class(error_px, self.tolerance_px)];
                if self.is_ridge([column, row]) {
                    colour = colour.0.map(|channel| channel / 2).into();
                }
            }
            picture.put_pixel(column, row, colour);
        }
        let mut errors = ErrorDistribution::new(&[]);
        self.oracle.measure(self.view, &mut errors);
        let [max_px, p99_px] = [errors.max_px(), errors.percentile_px(0.99)].map(|px| digits(f64::from(px)));
        let facts = format!("error in px, in view: max {max_px}, P99 {p99_px}");
        legend.draw(&mut picture, height, self.tolerance_px, &facts);
        picture
    }

    /// The largest error of the samples nearest to what is seen in a pixel; none where that is nothing.
    fn worst_px(&self, unprojection: &terrain_core::Unprojection, pixel: [u32; 2]) -> Option<f32> {
        let points = self.points(pixel).filter(|(_, depth)| *depth > 0.0);
        let errors_px = points.map(|(at, depth)| {
            let seen = unprojection.point(at, f64::from(depth));
            self.oracle.error_px(self.view, self.nearest([seen.x, seen.z]))
        });
        errors_px.filter(|px| !px.is_nan()).reduce(f32::max)
    }

    /// The points of a pixel: where they are in the picture, in pixels, and their depths.
    fn points(&self, pixel: [u32; 2]) -> impl Iterator<Item = ([f64; 2], f32)> {
        let (factor, columns) = (self.factor, self.view.size_px[0] * self.factor);
        (0..factor * factor).map(move |i| {
            let fine = [pixel[0] * factor + i % factor, pixel[1] * factor + i / factor];
            let at = fine.map(|at| (f64::from(at) + 0.5) / f64::from(factor));
            (at, self.depths[(fine[1] * columns + fine[0]) as usize])
        })
    }

    fn nearest(&self, ground_m: [f64; 2]) -> Sample {
        let (spacing_m, last) =
            (self.heightmap.spacing_m(), [self.heightmap.columns(), self.heightmap.rows()].map(|n| f64::from(n - 1)));
        let [column, row] = [0, 1].map(|axis| (ground_m[axis] / spacing_m[axis]).round().clamp(0.0, last[axis]) as u32);
        Sample { column, row }
    }

    /// Whether something far behind is seen to the right of a pixel or below it: the line in between shows the land's forms.
    fn is_ridge(&self, [column, row]: [u32; 2]) -> bool {
        let first = |column: u32, row: u32| self.points([column, row]).next().map_or(0.0, |(_, depth)| depth);
        let own = first(column, row);
        let [width, height] = self.view.size_px;
        let next =
            [(column + 1 < width).then(|| first(column + 1, row)), (row + 1 < height).then(|| first(column, row + 1))];
        next.into_iter().flatten().any(|other| own.max(other) > RIDGE_RATIO * own.min(other))
    }
}

/// The class of an error: doubling from an eighth of the tolerance, which the lower half does not exceed.
fn class(error_px: f32, tolerance_px: f64) -> usize {
    (1..CLASSES.len()).take_while(|i| f64::from(error_px) > edge_px(*i, tolerance_px)).count()
}

/// The lower end of a class.
fn edge_px(class: usize, tolerance_px: f64) -> f64 {
    tolerance_px * 2.0_f64.powi(class as i32 - (CLASSES.len() / 2) as i32)
}

/// The strip below the map.
struct Legend {
    scale: u32,
    /// Width of a class's box in pixels.
    step: u32,
}

impl Legend {
    fn of(width: u32) -> Self {
        let scale = if width < 600 { 1 } else { 2 };
        Self { scale, step: (2 * width / (2 * CLASSES.len() as u32 + 1)).max(34 * scale) }
    }

    /// Half a box is left free at the sides.
    fn width(&self) -> u32 {
        self.step * (2 * CLASSES.len() as u32 + 1) / 2
    }

    /// Boxes, their edges' numbers, and a line of facts.
    fn height(&self) -> u32 {
        self.scale * (14 + 3 * (lettering::HEIGHT + 4))
    }

    fn draw(&self, picture: &mut RgbImage, top: u32, tolerance_px: f64, facts: &str) {
        let (scale, line) = (self.scale, i64::from(self.scale * (lettering::HEIGHT + 4)));
        let (left, top) = (i64::from(self.step / 4), i64::from(top) + i64::from(3 * scale));
        let edge = |i: usize| left + i as i64 * i64::from(self.step);
        let boxes = top + line;
        for (i, colour) in CLASSES.into_iter().enumerate() {
            fill(picture, [edge(i), boxes], [self.step, 10 * scale], colour);
        }
        let centred = |picture: &mut RgbImage, [x, y]: [i64; 2], scale: u32, text: &str| {
            let half = i64::from(scale * lettering::width(text) / 2);
            lettering::write(picture, [x - half, y], scale, INK, text);
        };
        let numbers: Vec<String> = (1..CLASSES.len()).map(|i| digits(edge_px(i, tolerance_px))).collect();
        // Smaller where they would run into each other.
        let widest = numbers.iter().map(|number| lettering::width(number)).max().unwrap_or_default();
        let small = if scale * (widest + 1) > self.step { 1 } else { scale };
        for (i, number) in (1..).zip(&numbers) {
            centred(picture, [edge(i), boxes + i64::from(12 * scale)], small, number);
        }
        // The tolerance cuts through the boxes, and says so above them.
        let middle = edge(CLASSES.len() / 2);
        fill(picture, [middle - i64::from(scale), boxes - i64::from(2 * scale)], [2 * scale, 12 * scale], INK);
        centred(picture, [middle, top], scale, &format!("tolerance {} px", digits(tolerance_px)));
        let room = (picture.width() / scale).saturating_sub(lettering::width(facts)) / 2 * scale;
        lettering::write(picture, [i64::from(room), boxes + i64::from(12 * scale) + line], scale, INK, facts);
    }
}

#[cfg(test)]
mod tests;
