//! The paper's jitter: "randomly offsetting the 2D points sent to the triangulation" (section 3.3), against four points
//! on a square whose diagonals are as good as each other.
//!
//! Deviation: samples on the border stay where they are. They are shared, and a border that is not straight makes
//! triangles without area all along it.
//!
//! Deviation: the offsets are at most [`Jitter::SLIGHT`], where the paper says nothing of their size. That much breaks
//! every tie, and nothing else changes. Take patches of up to 64 intervals:
//!
//! - The in-circle determinant of four grid points is an integer. Offsets of `a` change it by less than
//!   `2.6e7 * a`, so below `a = 3.9e-8` no sign changes but that of 0; nor does the sign of an area.
//! - Could the result have a triangle of three samples in line? One of them is inside the patch, so there are corners
//!   of the patch on both sides of the line. With samples in line, the determinant is not 0 for any sample beside the
//!   line, and its sign tells the side. So one of the corners lies in the circle, and the triangle is not Delaunay.
//!
//! What is left is a Delaunay triangulation of the samples where they were. Larger offsets do more: of the Puget Sound
//! DEM (1025 x 1025 samples, patches of 32, 19 % kept, 406,320 triangles; delaunator and spade alike)
//!
//! | largest offset | 0.01 | 0.05 | 0.1 | 0.25 | 0.5 |
//! |---|---|---|---|---|---|
//! | triangles without area | 0 | 75 | 350 | 1965 | 12,955 |
//! | triangles turned over | 0 | 0 | 0 | 1 | 855 |
//! | patches with any of them | 0 % | 6 % | 24 % | 68 % | 80 % |
//!
//! Either is a crack: the method does not offer such offsets, only [`Triangulator::triangulate_jittered`] does.
//!
//! [`Triangulator::triangulate_jittered`]: super::Triangulator::triangulate_jittered

use terrain_core::SplitMix64;

use super::KeptSamples;

/// Random offsets of the samples inside a patch, in the plane (section 3.3 of the paper).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jitter {
    /// Largest offset along x and along z in grid intervals, 0 to 0.5. The triangles are sound up to [`Jitter::SLIGHT`].
    pub amplitude: f64,
    /// The offset of a sample depends on this and on its column and row in the patch, and on nothing else.
    pub seed: u64,
}

impl Jitter {
    /// 2^-25, about 3e-8 grid intervals: breaks ties between diagonals, and nothing else.
    pub const SLIGHT: f64 = 1.0 / (1 << 25) as f64;

    /// Where a sample is put, from its column and row.
    pub(super) fn moved(self, kept: &KeptSamples, at: [f64; 2]) -> [f64; 2] {
        let [column, row] = at.map(|along| along as u32);
        if column == 0 || column == kept.width || row == 0 || row == kept.depth {
            return at;
        }
        let mut random = SplitMix64::new(self.seed ^ SplitMix64::mix((row << 8 | column).into()));
        at.map(|along| along + random.range(-self.amplitude, self.amplitude))
    }
}
