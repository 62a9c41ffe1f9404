//! How far a triangle is from the samples that it covers: an exact walk over its samples, no tolerance.
//!
//! ```text
//!        a           For each row, the columns that lie on the inner side of all three edges. An edge's signed
//!       /.\          area is linear along a row, so each edge bounds the row on one side, by an exact integer
//!      /. .\         division. Samples on an edge count for both of its triangles.
//!     b-_. .\
//!        -_ .\
//!          - c
//! ```

use terrain_core::{Heightmap, Sample};

/// A rectangle of samples, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SampleRect {
    pub first: Sample,
    pub last: Sample,
}

impl SampleRect {
    /// All samples of a DEM.
    pub fn whole(heightmap: &Heightmap) -> Self {
        let last = Sample { column: heightmap.columns() - 1, row: heightmap.rows() - 1 };
        Self { first: Sample { column: 0, row: 0 }, last }
    }
}

/// The largest vertical distance in metres between a triangle and the samples of `within` that it covers, rounded up.
/// Corners that run clockwise or have no area cover nothing.
pub(crate) fn max_deviation_m(heightmap: &Heightmap, corners: [Sample; 3], within: SampleRect) -> f32 {
    let plane = Plane::through(heightmap, corners);
    if plane.doubled_area <= 1 {
        return 0.0; // Pick's theorem: no sample but the corners.
    }
    let edges = [(0, 1), (1, 2), (2, 0)].map(|(from, to)| Edge::between(corners[from], corners[to]));
    let first_row = corners.iter().map(|corner| corner.row).min().expect("three corners").max(within.first.row);
    let last_row = corners.iter().map(|corner| corner.row).max().expect("three corners").min(within.last.row);
    let mut largest = 0.0_f64;
    for row in first_row..=last_row {
        let columns = (within.first.column as i64, within.last.column as i64);
        let (first, last) = edges.iter().fold(columns, |columns, edge| edge.clip(row, columns));
        if first <= last {
            largest = largest.max(plane.largest_of_row(heightmap, row, first as u32, last as u32));
        }
    }
    rounded_up(largest / plane.doubled_area as f64)
}

fn rounded_up(value: f64) -> f32 {
    let nearest = value as f32;
    if (nearest as f64) < value { nearest.next_up() } else { nearest }
}

/// An edge as a linear function of column and row, at least 0 on its inner side: `by_column * column + by_row * row
/// + constant`.
struct Edge {
    by_column: i64,
    by_row: i64,
    constant: i64,
}

impl Edge {
    fn between(from: Sample, to: Sample) -> Self {
        let [[x, z], [to_x, to_z]] = [from, to].map(|sample| [sample.column as i64, sample.row as i64]);
        let (by_column, by_row) = (to_z - z, x - to_x);
        Self { by_column, by_row, constant: -(by_column * x + by_row * z) }
    }

    /// The part of a range of columns that is on the inner side in a row; the result may be empty.
    fn clip(&self, row: u32, (first, last): (i64, i64)) -> (i64, i64) {
        let rest = self.by_row * row as i64 + self.constant;
        match self.by_column {
            0 if rest < 0 => (first, first - 1),
            0 => (first, last),
            slope if slope > 0 => (first.max(-rest.div_euclid(slope)), last), // the ceiling of -rest / slope
            slope => (first, last.min(rest.div_euclid(-slope))),
        }
    }
}

/// The plane of a triangle times its doubled area, relative to its first corner: the numerators of heights. Heights
/// are f32 and coordinates small integers, so in f64 next to nothing is rounded.
struct Plane {
    column: i64,
    row: i64,
    height_m: f64,
    doubled_area: i64,
    by_column: f64,
    by_row: f64,
}

impl Plane {
    fn through(heightmap: &Heightmap, [a, b, c]: [Sample; 3]) -> Self {
        let (column, row, height_m) = (a.column as i64, a.row as i64, heightmap.height_m(a) as f64);
        let leg =
            |to: Sample| (to.column as i64 - column, to.row as i64 - row, heightmap.height_m(to) as f64 - height_m);
        let ((ux, uz, uh), (vx, vz, vh)) = (leg(b), leg(c));
        Self {
            column,
            row,
            height_m,
            doubled_area: vx * uz - ux * vz,
            by_column: vh * uz as f64 - uh * vz as f64,
            by_row: vx as f64 * uh - ux as f64 * vh,
        }
    }

    /// The largest deviation times the doubled area in a part of a row.
    fn largest_of_row(&self, heightmap: &Heightmap, row: u32, first: u32, last: u32) -> f64 {
        let start = heightmap.index(Sample { column: first, row }) as usize;
        let heights_m = &heightmap.heights_m()[start..=start + (last - first) as usize];
        let doubled_area = self.doubled_area as f64;
        let row_start = (row as i64 - self.row) as f64 * self.by_row;
        let numerator = |(i, height_m): (usize, &f32)| {
            let plane = row_start + (first as i64 + i as i64 - self.column) as f64 * self.by_column;
            (plane - doubled_area * (*height_m as f64 - self.height_m)).abs()
        };
        heights_m.iter().enumerate().map(numerator).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::{SplitMix64, Triangle};

    /// Barycentric weights at every sample of the rectangle: nothing shared with the walk.
    fn brute_force_m(heightmap: &Heightmap, [a, b, c]: [Sample; 3], within: SampleRect) -> f64 {
        let doubled_area = |samples| Triangle { samples, heights_m: [0.0; 3] }.doubled_area();
        let rows = within.first.row..=within.last.row;
        let columns = |row| (within.first.column..=within.last.column).map(move |column| Sample { column, row });
        let deviation_m = |p: Sample| {
            let weights = [[p, b, c], [a, p, c], [a, b, p]].map(doubled_area);
            let sum: f64 = weights.iter().zip([a, b, c]).map(|(w, v)| *w as f64 * heightmap.height_m(v) as f64).sum();
            let covered = weights.iter().all(|weight| *weight >= 0);
            covered.then(|| (sum / doubled_area([a, b, c]) as f64 - heightmap.height_m(p) as f64).abs())
        };
        rows.flat_map(columns).filter_map(deviation_m).fold(0.0, f64::max)
    }

    #[test]
    fn agrees_with_barycentric_weights_over_all_samples() {
        let mut random = SplitMix64::new(9);
        let mut covered = 0;
        for round in 0..3_000 {
            let (columns, rows) = (2 + random.below(40) as u32, 2 + random.below(40) as u32);
            let heights_m = (0..columns * rows).map(|_| random.range(-50.0, 4000.0) as f32).collect();
            let dem = Heightmap::new(columns, rows, [1.0; 2], heights_m).unwrap();
            let mut sample =
                || Sample { column: random.below(columns as u64) as u32, row: random.below(rows as u64) as u32 };
            let (corners, ends) = ([sample(), sample(), sample()], [sample(), sample()]);
            if (Triangle { samples: corners, heights_m: [0.0; 3] }).doubled_area() <= 0 {
                continue;
            }
            let end = |pick: fn(u32, u32) -> u32| Sample {
                column: pick(ends[0].column, ends[1].column),
                row: pick(ends[0].row, ends[1].row),
            };
            for within in [SampleRect::whole(&dem), SampleRect { first: end(u32::min), last: end(u32::max) }] {
                let found = max_deviation_m(&dem, corners, within) as f64;
                let expected = brute_force_m(&dem, corners, within);
                assert!((found - expected).abs() < 1e-3, "round {round}, {corners:?}: {found} for {expected}");
                covered += (expected > 1e-3) as u32;
            }
        }
        assert!(covered > 1_000, "{covered} triangles with samples inside");
    }

    #[test]
    fn clockwise_and_flat_triangles_cover_nothing() {
        let dem = Heightmap::new(5, 5, [1.0; 2], (0..25).map(|i| (i * 7 % 5) as f32).collect()).unwrap();
        let [a, b, c, d] = [(0, 0), (0, 4), (4, 0), (0, 2)].map(|(column, row)| Sample { column, row });
        let whole = SampleRect::whole(&dem);
        assert!(max_deviation_m(&dem, [a, b, c], whole) > 0.0);
        assert_eq!(max_deviation_m(&dem, [a, c, b], whole), 0.0);
        assert_eq!(max_deviation_m(&dem, [a, d, b], whole), 0.0);
    }
}
