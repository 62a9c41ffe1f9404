//! From kept samples to triangles: a Delaunay triangulation in the plane, lifted back by the samples' own heights
//! (section 3.3 of the paper).
//!
//! Deviation: the paper moves the points at random, so that four points on a square do not confuse its
//! triangulation. All of ours are exact and need no such help: here it is an option (`jitter.rs`).
//!
mod delaunator;
mod grid;
mod jitter;
mod spade;

use std::cell::RefCell;

use crate::select::{Border, Mask, inner_bits};

pub(crate) use grid::GridKernel;
pub use jitter::Jitter;

/// What connects the kept samples of a patch.
///
/// All three are exact and give the same number of triangles. Where four samples lie on a circle either diagonal is
/// Delaunay: `Grid` decides by a rule on the samples alone, the other two by the order of their work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Triangulator {
    /// A sweep made for patches of a grid, in integers. Its triangulation is a function of the set of kept samples:
    /// of four on a circle, the diagonal stays that does not touch the last of them (by row, then column).
    #[default]
    Grid,
    /// The crate `delaunator`: a sweep over sorted points, with adaptive predicates.
    Delaunator,
    /// The crate `spade`, bulk loading: the oracle of the tests and the baseline of the benches.
    Spade,
}

/// The kept samples of one patch, and where the patch lies in the vertex buffer.
///
/// A patch is a rectangle of grid intervals. Its four corners are always kept.
#[derive(Clone, Copy, Debug)]
pub struct KeptSamples<'a> {
    /// Grid intervals along x, 1 to 64.
    pub width: u32,
    /// Grid intervals along z, 1 to 64.
    pub depth: u32,
    /// Samples kept on the four sides.
    pub border: Border,
    /// Samples kept on the `depth - 1` rows between the northern and the southern side: bit `i` for column `i`, of
    /// the columns 1 to `width - 1`.
    pub interior: &'a [Mask],
    /// Index of the north-western corner in the vertex buffer (or 0, for indices that the draw adds it to).
    pub first_index: u32,
    /// Indices from one row of the vertex buffer to the next: the DEM's samples along x where it holds the whole DEM
    /// row by row.
    pub row_stride: u32,
}

impl Triangulator {
    /// Appends the indices of the patch's triangles, counter-clockwise seen from above (x east, z south).
    ///
    /// # Panics
    ///
    /// If a side is not 1 to 64 intervals long, or a mask names a sample that is not an inner one of its row or side.
    pub fn triangulate(self, kept: &KeptSamples, indices: &mut Vec<u32>) {
        kept.validate();
        match self {
            Self::Grid => {
                thread_local!(static KERNEL: RefCell<GridKernel> = RefCell::new(GridKernel::new()));
                KERNEL.with_borrow_mut(|kernel| kernel.triangulate(kept, indices));
            }
            Self::Delaunator => delaunator::triangulate(kept, &|at| at, indices),
            Self::Spade => spade::triangulate(kept, &|at| at, indices),
        }
    }

    /// As [`Triangulator::triangulate`], with the samples inside the patch moved at random before they are connected.
    /// Offsets above [`Jitter::SLIGHT`] may leave triangles without area, or turned over.
    ///
    /// # Panics
    ///
    /// As [`Triangulator::triangulate`]; and with `Grid`, which knows integers alone.
    pub fn triangulate_jittered(self, kept: &KeptSamples, jitter: Jitter, indices: &mut Vec<u32>) {
        kept.validate();
        let moved = |at| jitter.moved(kept, at);
        match self {
            Self::Grid => panic!("the grid kernel cannot connect samples that are moved"),
            Self::Delaunator => delaunator::triangulate(kept, &moved, indices),
            Self::Spade => spade::triangulate(kept, &moved, indices),
        }
    }
}

/// Where in the plane a sample is put, from its column and row.
type Place<'a> = &'a dyn Fn([f64; 2]) -> [f64; 2];

impl KeptSamples<'_> {
    /// Column and row of all kept samples, row by row.
    pub fn positions(&self) -> impl Iterator<Item = (u32, u32)> {
        (0..=self.depth).flat_map(|row| {
            let west = self.has_west(row).then_some((0, row));
            let east = self.has_east(row).then_some((self.width, row));
            west.into_iter().chain(bits(self.inner_row(row)).map(move |column| (column, row))).chain(east)
        })
    }

    /// Index of a sample in the vertex buffer.
    fn index(&self, column: u32, row: u32) -> u32 {
        self.first_index + row * self.row_stride + column
    }

    /// The kept samples of a row, but for its two ends.
    fn inner_row(&self, row: u32) -> Mask {
        match row {
            0 => self.border.north,
            _ if row == self.depth => self.border.south,
            _ => self.interior[row as usize - 1],
        }
    }

    /// The kept samples of a row, both ends included: bit `i` for column `i`, up to 65 of them.
    pub(crate) fn row(&self, row: u32) -> u128 {
        self.inner_row(row) as u128 | self.has_west(row) as u128 | (self.has_east(row) as u128) << self.width
    }

    fn has_west(&self, row: u32) -> bool {
        row == 0 || row == self.depth || self.border.west >> row & 1 == 1
    }

    fn has_east(&self, row: u32) -> bool {
        row == 0 || row == self.depth || self.border.east >> row & 1 == 1
    }

    fn validate(&self) {
        let Self { width, depth, border, interior, .. } = *self;
        let sides = 1..=64;
        assert!(sides.contains(&width) && sides.contains(&depth), "patch of {width} x {depth}: expected 1 to 64");
        assert_eq!(interior.len() as u32, depth - 1, "one mask for each interior row");
        let rows = interior.iter().fold(border.north | border.south, |all, row| all | row);
        assert_eq!(rows & !inner_bits(width), 0, "a row names samples that are not its inner ones");
        let sides = border.west | border.east;
        assert_eq!(sides & !inner_bits(depth), 0, "a side names samples that are not its inner ones");
    }
}

/// Positions of the set bits, lowest first.
pub(crate) fn bits(mut mask: Mask) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let next = (mask != 0).then(|| mask.trailing_zeros());
        mask &= mask.wrapping_sub(1);
        next
    })
}
