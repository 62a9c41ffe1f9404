//! The squares of one level, and where they are stored: all of them, or those of the cells in the window (`window`).

use std::ops::Range;

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
    /// Columns and rows of squares that there is room for: all, or those of the cells in the window.
    pub stored: [u32; 2],
    /// Whether that is less than all.
    pub wraps: bool,
    /// Squares along a cell.
    pub per_cell: u32,
    /// Number of the level's first patch, see [`Grid::patch_number`](super::Grid::patch_number).
    pub(super) first_patch: u32,
    /// See [`Grid::place_at`](super::Grid::place_at).
    pub(super) first_place: u32,
    /// Lowest and highest sample of each square that is stored, in metres, row by row.
    pub(super) heights_m: Vec<[f32; 2]>,
}

impl Layer {
    /// Lowest and highest sample of each square, row by row.
    pub fn ranges_m(&self) -> &[[f32; 2]] {
        &self.heights_m
    }

    /// Squares that there is room for.
    pub fn squares_stored(&self) -> usize {
        self.stored[0] as usize * self.stored[1] as usize
    }

    /// Where the squares of a cell are stored: one range a row of them.
    pub fn rows_of(&self, cell: [u32; 2]) -> impl Iterator<Item = Range<usize>> + use<> {
        let (size, stored, per_cell) = (self.size, self.stored.map(|at| at as usize), self.per_cell);
        let first = cell.map(|at| at * per_cell);
        let columns = per_cell.min(size[0] - first[0]) as usize;
        (first[1]..(first[1] + per_cell).min(size[1])).map(move |row| {
            let start = row as usize % stored[1] * stored[0] + first[0] as usize % stored[0];
            start..start + columns
        })
    }
}
