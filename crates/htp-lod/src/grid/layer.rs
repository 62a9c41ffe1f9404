//! The squares of one level, and where they are stored: all of them, or those of the cells in the window (`window`).
//!
//! The children of a square, its *brood*, are stored side by side: who decides for a square goes on to all of its
//! children. Broods follow each other row by row, and so do the squares of the top layer, which have no parent.
//!
//! ```text
//!    0  1  2 |  9 10 11      k = 3: positions of the squares of a level below the top. A brood that reaches
//!    3  4  5 | 12 13 14      over the rim takes its full room.
//!    6  7  8 | 15 16 17
//!   ---------+---------
//!   18 19 20 | 27 28 29
//! ```

use super::{Half, Patch, Square, TAG_NUMBERS};
use terrain_core::{PatchInstance, PatchTag};

/// All squares of one level.
pub(crate) struct Layer {
    /// Legs of the small triangles, in sample intervals: `k^level`.
    pub step: u32,
    /// Width of a square in sample intervals: `k^(level + 1)`.
    pub side: u32,
    /// Columns and rows of squares that exist.
    pub size: [u32; 2],
    /// Columns and rows of squares that end on the DEM's last column and row or before.
    pub inside: [u32; 2],
    /// Squares along a brood; 1 on the top layer.
    pub brood: u32,
    /// Columns and rows of broods that there is room for: all, or those of the cells in the window.
    pub broods: [u32; 2],
    /// Whether that is less than all.
    pub wraps: bool,
    /// By position in a brood.
    pub(super) positions: Vec<Position>,
    /// Squares along a cell.
    pub per_cell: u32,
    /// Number of the level's first patch, see [`Grid::patch_number`](super::Grid::patch_number).
    pub(super) first_patch: u32,
    /// See [`Grid::place_at`](super::Grid::place_at).
    pub(super) first_place: u32,
    /// Lowest and highest sample of each square that is stored, in metres.
    pub(super) heights_m: Vec<[f32; 2]>,
}

impl Layer {
    /// Squares that there is room for.
    pub fn squares_stored(&self) -> usize {
        self.broods.iter().map(|broods| (broods * self.brood) as usize).product()
    }

    #[inline]
    pub(super) fn patch_number(&self, Patch { square: Square { column, row, .. }, half }: Patch) -> u32 {
        self.first_patch + 2 * (row * self.size[0] + column) + half as u32
    }

    /// See [`Grid::place_at`](super::Grid::place_at).
    #[inline]
    pub fn place_at(&self, half: Half, index: usize) -> u32 {
        self.first_place + 2 * index as u32 + half as u32
    }

    #[inline]
    pub(super) fn tag(&self, patch: Patch) -> PatchTag {
        PatchTag { patch: self.patch_number(patch) % TAG_NUMBERS, level: patch.square.level }
    }

    /// See [`Grid::instance`](super::Grid::instance).
    #[inline]
    pub fn instance(&self, patch: Patch) -> PatchInstance {
        let (Square { column, row, .. }, step) = (patch.square, self.step as i16);
        let (apex, step) = match patch.half {
            Half::NorthWest => ([column, row], step),
            Half::SouthEast => ([column + 1, row + 1], -step),
        };
        let (origin, tag) = (apex.map(|at| (at * self.side) as i32), self.tag(patch).to_instance());
        PatchInstance { origin, leg_u: [0, step], leg_v: [step, 0], tag }
    }

    /// Where a brood is stored, by its column and row among the broods of the DEM: those of the parent.
    #[inline]
    pub(super) fn brood_start(&self, [mut column, mut row]: [u32; 2]) -> usize {
        if self.wraps {
            (column, row) = (column % self.broods[0], row % self.broods[1]);
        }
        (row as usize * self.broods[0] as usize + column as usize) * self.brood_size() as usize
    }

    /// Squares of a brood.
    #[inline]
    pub(super) fn brood_size(&self) -> u32 {
        self.brood * self.brood
    }
}

/// What the squares at one position of all broods have in common.
pub(super) struct Position {
    /// Column and row in the brood.
    pub at: [u32; 2],
    /// How far from it the squares in the west, north, east and south are stored; not beyond the ends of what wraps.
    pub around: [isize; 4],
}

impl Position {
    /// In broods of so many squares a side, so many broods a row.
    pub fn all(side: u32, broods: u32) -> Vec<Self> {
        (0..side).flat_map(|row| (0..side).map(move |column| Self::new(side, broods, [column, row]))).collect()
    }

    fn new(side: u32, broods: u32, at: [u32; 2]) -> Self {
        let (last, brood) = (side as isize - 1, (side * side) as isize);
        // By axis: to the next square in the brood, and to the same position in the next brood.
        let (step, next_brood) = ([1, side as isize], [brood, brood * broods as isize]);
        let to_next_brood = |axis: usize| next_brood[axis] - last * step[axis];
        let back = |axis: usize| if at[axis] == 0 { -to_next_brood(axis) } else { -step[axis] };
        let on = |axis: usize| if at[axis] as isize == last { to_next_brood(axis) } else { step[axis] };
        Self { at, around: [back(0), back(1), on(0), on(1)] }
    }
}
