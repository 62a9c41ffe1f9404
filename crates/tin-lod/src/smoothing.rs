//! Smoothed heights: "the unselected neighbours could be used to interpolate the height data of a selected point"
//! (section 3.3 of the paper, last paragraph).
//!
//! ```text
//!   o . .      o kept   . left out
//!   . ? .      ? gets the mean of its own height and those of its 7 neighbours that are left out
//!   . . .
//! ```
//!
//! Samples on the border of a patch keep the DEM's heights: both patches know them, so no crack can open. Those inside
//! belong to one patch, and change with its triangles. A patch with all of its samples has the DEM's heights.
//!
//! The vertex buffer is no longer static, as the paper says. An updated patch writes a run a row: from its first kept
//! sample to its last, with the DEM's heights for what is left out in between.
//!
//! Measured on the Puget Sound DEM (1025 x 1025 samples, patches of 32, 40 frames of 640 x 360 pixels), plain and smoothed:
//!
//! | flight, tolerance | RMS in px | maximum in px | uploads a frame in bytes |
//! |---|---|---|---|
//! | ground-level, 1 px | 0.286, 0.290 | 5.7, 28.8 | 639 k, 1028 k |
//! | ground-level, 4 px | 0.602, 0.600 | 10.4, 28.8 | 142 k, 221 k |
//! | fly-over, 1 px | 0.260, 0.257 | 2.1, 2.1 | 178 k, 343 k |
//! | fly-over, 4 px | 0.509, 0.506 | 5.5, 5.4 | 2.3 k, 3.4 k |
//!
//! So there is next to nothing to gain in the mean, and much to lose near the eye, where a mean of 3 x 3 samples moves
//! a vertex by more than the tolerance.

use terrain_core::{BakedVertex, Heightmap, Sample};

use crate::triangulate::{KeptSamples, bits};

/// Vertices of neighbouring samples on a row of the DEM, inside one patch.
pub(crate) struct VertexRun {
    /// The western one.
    pub first: Sample,
    pub vertices: Vec<BakedVertex>,
}

/// The runs of a patch whose north-western corner is `corner`, from north to south.
pub(crate) fn smoothed_rows(heightmap: &Heightmap, corner: Sample, kept: &KeptSamples) -> Vec<VertexRun> {
    let run = |row: u32| {
        let columns = kept.interior[row as usize - 1];
        let (first, last) = (bits(columns).next()?, columns.ilog2());
        let vertex = |column| {
            let at = Sample { column: corner.column + column, row: corner.row + row };
            let dem = BakedVertex::of(heightmap, at);
            let height_m = || mean_m(heightmap, at, |x, z| kept.row(row + z - 1) >> (column + x - 1) & 1 == 1);
            if columns >> column & 1 == 1 { BakedVertex { height_m: height_m(), ..dem } } else { dem }
        };
        let first_sample = Sample { column: corner.column + first, row: corner.row + row };
        Some(VertexRun { first: first_sample, vertices: (first..=last).map(vertex).collect() })
    };
    (1..kept.depth).filter_map(run).collect()
}

/// Mean height of a sample and of its neighbours that are left out. `is_kept(x, z)` is asked for the 3 x 3 samples
/// around it, from (0, 0) in the north-west.
fn mean_m(heightmap: &Heightmap, at: Sample, is_kept: impl Fn(u32, u32) -> bool) -> f32 {
    let (mut sum_m, mut count) = (heightmap.height_m(at) as f64, 1.0);
    for (x, z) in (0..3).flat_map(|z| (0..3).map(move |x| (x, z))) {
        if !is_kept(x, z) {
            sum_m += heightmap.height_m(Sample { column: at.column + x - 1, row: at.row + z - 1 }) as f64;
            count += 1.0;
        }
    }
    (sum_m / count) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::select::Border;

    #[test]
    fn a_kept_sample_gets_the_mean_of_itself_and_of_what_is_left_out_beside_it() {
        let dem = Heightmap::new(9, 9, [1.0; 2], (0..81).map(|i| (i * i) as f32).collect()).unwrap();
        // A patch of 4 x 4 intervals that starts at column 2, row 3.
        let interior = [0b0110, 0b0000, 0b1010];
        let border = Border { north: 0b0010, ..Default::default() };
        let kept = KeptSamples { width: 4, depth: 4, border, interior: &interior, first_index: 0, row_stride: 9 };
        let corner = Sample { column: 2, row: 3 };
        let runs = smoothed_rows(&dem, corner, &kept);
        let h = |column: u32, row: u32| dem.height_m(Sample { column: 2 + column, row: 3 + row });
        let mean = |of: &[(u32, u32)]| of.iter().map(|at| h(at.0, at.1)).sum::<f32>() / of.len() as f32;
        let found = |i: usize| runs[i].vertices.iter().map(|v| v.height_m).collect::<Vec<_>>();
        assert_eq!(runs.iter().map(|run| (run.first.column, run.first.row)).collect::<Vec<_>>(), [(3, 4), (3, 6)]);
        // The corner of the patch and one sample of its northern side are kept: both stay out of the mean.
        let north_west = mean(&[(1, 1), (2, 0), (0, 1), (0, 2), (1, 2), (2, 2)]);
        let north_east = mean(&[(2, 1), (2, 0), (3, 0), (3, 1), (1, 2), (2, 2), (3, 2)]);
        assert_eq!(found(0), [north_west, north_east]);
        let south_west = mean(&[(1, 3), (0, 2), (1, 2), (2, 2), (0, 3), (2, 3), (1, 4), (2, 4)]);
        let south_east = mean(&[(3, 3), (2, 2), (3, 2), (4, 2), (2, 3), (4, 3), (2, 4), (3, 4)]);
        assert_eq!(found(1), [south_west, h(2, 3), south_east], "what is left out in between has the DEM's height");
    }
}
