//! How far a triangle is from the samples that it covers: exact walks over its samples, no tolerance.
//!
//! ```text
//!          top            For each row the samples between the long side (top to bottom) and the two short ones.
//!         / |             The ends of a row are fractions; their denominators are at most 64 rows, so that a
//!       /  .|             multiplication with a rounded-up reciprocal divides without error.
//!     / . . |
//!   mid . . |             Samples on a side count for both triangles. The patch's outline is not visited: its samples
//!      \_ . |             have thresholds of their own (`threshold_map.rs`).
//!         \_|
//!        bottom
//! ```
//!
//! Heights are taken relative to a corner, in f64: differences of f32 are exact there, and so are their products with
//! grid coordinates (13 bits) unless heights of very different magnitude meet. What is left is about 1e-12 m.

use terrain_core::Heightmap;

use crate::lattice::{Vertex, doubled_area, position, vertex};
use crate::patches::PatchArea;

/// The heights under a patch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatchHeights<'a> {
    /// From the north-western sample on, row by row.
    pub heights_m: &'a [f32],
    /// Heights from one row to the next.
    pub stride: usize,
    /// Grid intervals along x.
    pub width: u32,
    /// Grid intervals along z.
    pub depth: u32,
}

/// The sample that a triangle is farthest from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Worst {
    pub sample: Vertex,
    pub deviation_m: f64,
}

impl<'a> PatchHeights<'a> {
    pub fn new(heightmap: &'a Heightmap, area: PatchArea) -> Self {
        let first = heightmap.index(area.first) as usize;
        Self {
            heights_m: &heightmap.heights_m()[first..],
            stride: heightmap.columns() as usize,
            width: area.width,
            depth: area.depth,
        }
    }

    fn height_m(&self, sample: Vertex) -> f64 {
        let (column, row) = position(sample);
        self.heights_m[row as usize * self.stride + column as usize] as f64
    }

    /// As [`Self::worst_beyond`], with a limit for each block of 8 x 8 samples: of the samples beyond theirs the one that
    /// the triangle is farthest from.
    pub fn worst_beyond_blocks(&self, limits_m: &[[f64; 8]; 8], corners: [Vertex; 3]) -> Option<Worst> {
        let [a, b, c] = corners;
        if doubled_area(a, b, c) == 1 {
            return None;
        }
        let plane = Plane::through(self, corners);
        let doubled_area = plane.doubled_area as f64;
        let mut worst = (0.0, 0);
        for_rows(corners, self.depth, |row, first, last| {
            let (mut first, last) = (first.max(1), last.min(self.width as i32 - 1));
            while first <= last {
                let (block, start) = (first / 8, row as usize * self.stride);
                let end = last.min(8 * block + 7);
                let limit = limits_m[row as usize / 8][block as usize] * doubled_area;
                let mut found = (limit.max(worst.0), 0);
                let before = found.0;
                let heights_m = &self.heights_m[start + first as usize..=start + end as usize];
                plane.worst_of_row(first, row, heights_m, &mut found);
                if found.0 > before {
                    worst = found;
                }
                first = end + 1;
            }
        });
        let (numerator, sample) = worst;
        let found = numerator > 0.0 && !corners.contains(&sample);
        found.then(|| Worst { sample, deviation_m: numerator / doubled_area })
    }

    /// The sample inside the patch that a counter-clockwise triangle is farthest from, the first such by rows; `None`
    /// where no sample is farther than a limit.
    pub fn worst_beyond(&self, limit_m: f64, corners: [Vertex; 3]) -> Option<Worst> {
        let [a, b, c] = corners;
        if doubled_area(a, b, c) == 1 {
            return None; // Pick's theorem: no sample but the corners.
        }
        let plane = Plane::through(self, corners);
        let limit = limit_m * plane.doubled_area as f64;
        let mut worst = (limit, 0);
        for_rows(corners, self.depth, |row, first, last| {
            let (first, last) = (first.max(1), last.min(self.width as i32 - 1));
            if first <= last {
                let start = row as usize * self.stride;
                let heights_m = &self.heights_m[start + first as usize..=start + last as usize];
                plane.worst_of_row(first, row, heights_m, &mut worst);
            }
        });
        let (numerator, sample) = worst;
        // Where a corner is the worst, all is rounding.
        let found = numerator > limit && !corners.contains(&sample);
        found.then(|| Worst { sample, deviation_m: numerator / plane.doubled_area as f64 })
    }
}

/// The plane of a triangle times its doubled area, relative to its first corner: the numerators of heights.
struct Plane {
    column: i32,
    row: i32,
    height_m: f64,
    doubled_area: i32,
    by_column: f64,
    by_row: f64,
}

impl Plane {
    fn through(heights: &PatchHeights, [a, b, c]: [Vertex; 3]) -> Self {
        let ((column, row), height_m) = (position(a), heights.height_m(a));
        let leg = |to: Vertex| {
            let (x, z) = position(to);
            ((x - column) as f64, (z - row) as f64, heights.height_m(to) - height_m)
        };
        let ((ux, uz, uh), (vx, vz, vh)) = (leg(b), leg(c));
        let (by_column, by_row) = (vh * uz - uh * vz, vx * uh - ux * vh);
        Self { column, row, height_m, doubled_area: doubled_area(a, b, c), by_column, by_row }
    }

    /// Looks for a larger deviation (its numerator, and the sample) along a row, from the column `first` on.
    #[inline(always)]
    fn worst_of_row(&self, first: i32, row: i32, heights_m: &[f32], worst: &mut (f64, Vertex)) {
        let doubled_area = self.doubled_area as f64;
        let start = (row - self.row) as f64 * self.by_row;
        for (i, height_m) in heights_m.iter().enumerate() {
            let column = first + i as i32;
            let plane = start + (column - self.column) as f64 * self.by_column;
            let numerator = (plane - doubled_area * (*height_m as f64 - self.height_m)).abs();
            if numerator > worst.0 {
                *worst = (numerator, vertex(column as u32, row as u32));
            }
        }
    }
}

/// Calls `visit(row, first column, last column)` for the rows of a triangle between the first and the last of the
/// patch; the range may be empty.
#[inline(always)]
fn for_rows(corners: [Vertex; 3], depth: u32, mut visit: impl FnMut(i32, i32, i32)) {
    let [top, middle, bottom] = sorted(corners);
    let (end_of_upper, end_of_lower) = (position(middle).1, position(bottom).1);
    let long = Side::between(top, bottom);
    let long_is_left = doubled_area(top, bottom, middle) > 0;
    let mut row = position(top).1.max(1);
    let last = |end: i32| end.min(depth as i32 - 1);
    for (short, end) in [(Side::between(top, middle), end_of_upper), (Side::between(middle, bottom), end_of_lower)] {
        let Some(short) = short else { continue };
        let long = long.expect("a triangle with an area has rows");
        let (left, right) = if long_is_left { (&long, &short) } else { (&short, &long) };
        while row <= last(end) {
            visit(row, left.ceil(row), right.floor(row));
            row += 1;
        }
    }
}

fn sorted([mut a, mut b, mut c]: [Vertex; 3]) -> [Vertex; 3] {
    if a > b {
        (a, b) = (b, a);
    }
    if b > c {
        (b, c) = (c, b);
    }
    if a > b {
        (a, b) = (b, a);
    }
    [a, b, c]
}

/// A side of a triangle that is not along a row: its columns are `(start + row * run) / rise`.
#[derive(Clone, Copy)]
struct Side {
    start: i32,
    run: i32,
    rise: i32,
    reciprocal: u32,
}

/// Bits behind the point of [`RECIPROCALS`]: enough for numerators below 65 * 65 + 64 and denominators up to 64.
const RECIPROCAL_BITS: u32 = 19;

/// `1 / i`, rounded up.
static RECIPROCALS: [u32; 65] = {
    let mut reciprocals = [0; 65];
    let mut i = 1;
    while i < reciprocals.len() {
        reciprocals[i] = (1u32 << RECIPROCAL_BITS).div_ceil(i as u32);
        i += 1;
    }
    reciprocals
};

impl Side {
    fn between(upper: Vertex, lower: Vertex) -> Option<Self> {
        let ((x, z), (lower_x, lower_z)) = (position(upper), position(lower));
        let (run, rise) = (lower_x - x, lower_z - z);
        (rise > 0).then(|| Self { start: x * rise - z * run, run, rise, reciprocal: RECIPROCALS[rise as usize] })
    }

    fn floor(&self, row: i32) -> i32 {
        self.divide(self.start + row * self.run)
    }

    fn ceil(&self, row: i32) -> i32 {
        self.divide(self.start + row * self.run + self.rise - 1)
    }

    fn divide(&self, numerator: i32) -> i32 {
        ((numerator as u32 * self.reciprocal) >> RECIPROCAL_BITS) as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::SplitMix64;

    #[test]
    fn reciprocals_divide_exactly() {
        for rise in 1..=64 {
            let side = Side { start: 0, run: 0, rise, reciprocal: RECIPROCALS[rise as usize] };
            assert!((0..=64 * rise + rise - 1).all(|numerator| side.divide(numerator) == numerator / rise));
        }
    }

    /// Barycentric weights over all samples of the patch, as the error oracle does it.
    fn plain_worst(heights: &PatchHeights, [a, b, c]: [Vertex; 3]) -> Option<f64> {
        let inner = (1..heights.depth).flat_map(|row| (1..heights.width).map(move |column| vertex(column, row)));
        let deviation_m = |p: Vertex| {
            let weights = [doubled_area(b, c, p), doubled_area(c, a, p), doubled_area(a, b, p)];
            let sum: f64 = weights.iter().zip([a, b, c]).map(|(w, v)| *w as f64 * heights.height_m(v)).sum();
            let covered = weights.iter().all(|w| *w >= 0);
            covered.then(|| (sum / doubled_area(a, b, c) as f64 - heights.height_m(p)).abs())
        };
        inner.filter_map(deviation_m).max_by(f64::total_cmp).filter(|worst_m| *worst_m > 1e-9)
    }

    fn random_triangle(random: &mut SplitMix64, width: u32, depth: u32) -> Option<[Vertex; 3]> {
        let mut corner = || vertex(random.below(width as u64 + 1) as u32, random.below(depth as u64 + 1) as u32);
        let [a, b, c] = [corner(), corner(), corner()];
        match doubled_area(a, b, c) {
            0 => None,
            area if area < 0 => Some([a, c, b]),
            _ => Some([a, b, c]),
        }
    }

    #[test]
    fn the_worst_beyond_the_limits_of_blocks_is_the_worst_of_those_samples() {
        let (mut random, mut beyond) = (SplitMix64::new(4), 0);
        for _ in 0..2_000 {
            let (width, depth) = (1 + random.below(64) as u32, 1 + random.below(64) as u32);
            let heights_m: Vec<f32> = (0..65 * 65).map(|_| random.range(-50.0, 400.0) as f32).collect();
            let heights = PatchHeights { heights_m: &heights_m, stride: 65, width, depth };
            let Some(corners) = random_triangle(&mut random, width, depth) else { continue };
            let limits_m = [(); 8].map(|_| [(); 8].map(|_| random.range(300.0, 500.0)));
            // The worst of all is the worst of the blocks' worst ones.
            let mut expected_m = None::<f64>;
            for (block_row, block) in (0..8).flat_map(|row| (0..8).map(move |block| (row, block))) {
                let mut alone_m = [[f64::INFINITY; 8]; 8];
                alone_m[block_row][block] = limits_m[block_row][block];
                if let Some(worst) = heights.worst_beyond_blocks(&alone_m, corners) {
                    let (column, row) = position(worst.sample);
                    assert_eq!((row as usize / 8, column as usize / 8), (block_row, block));
                    assert!(worst.deviation_m > limits_m[block_row][block]);
                    expected_m = Some(expected_m.unwrap_or(0.0).max(worst.deviation_m));
                }
            }
            let found = heights.worst_beyond_blocks(&limits_m, corners);
            assert_eq!(found.map(|worst| worst.deviation_m), expected_m);
            let uniform = heights.worst_beyond_blocks(&[[300.0; 8]; 8], corners);
            assert_eq!(uniform, heights.worst_beyond(300.0, corners));
            beyond += found.is_some() as u32;
        }
        assert!(beyond > 100, "{beyond} triangles beyond a limit: too few to show anything");
    }

    #[test]
    fn agrees_with_barycentric_weights_over_all_samples() {
        let mut random = SplitMix64::new(9);
        for _ in 0..3_000 {
            let (width, depth) = (1 + random.below(64) as u32, 1 + random.below(64) as u32);
            let heights_m: Vec<f32> = (0..65 * 65).map(|_| random.range(-50.0, 4000.0) as f32).collect();
            let heights = PatchHeights { heights_m: &heights_m, stride: 65, width, depth };
            let Some(corners) = random_triangle(&mut random, width, depth) else { continue };
            match (heights.worst_beyond(1e-9, corners), plain_worst(&heights, corners)) {
                (Some(found), Some(expected_m)) => assert!((found.deviation_m - expected_m).abs() < 1e-9),
                (None, None) => {}
                other => panic!("{corners:x?}: {other:?}"),
            }
        }
    }
}
