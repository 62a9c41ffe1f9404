//! Where what is kept of squares and patches is stored: see `layer`.

use super::{Grid, Layer, Patch, Square};
use crate::window::Sheet;
use std::ops::Range;

/// A square, and where what is kept of it is stored: its [`Grid::index`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    pub square: Square,
    pub index: usize,
    /// Its position in its brood.
    pub at: usize,
}

/// Squares of a cell that are side by side in a sheet and where they are stored.
pub(crate) struct Run {
    /// Position of the first one in the sheet: row by row, over the squares that do not exist, too.
    pub first: usize,
    pub stored: Range<usize>,
}

impl Grid {
    /// Where what is kept of a square is stored; on streamed levels that of its sheet's place in the window, which must
    /// be [held](Self::is_stored).
    #[inline]
    pub fn index(&self, square: Square) -> usize {
        self.spot(square).index
    }

    /// A square with its [index](Self::index).
    #[inline]
    pub fn spot(&self, square @ Square { column, row, .. }: Square) -> Spot {
        let layer = self.layer(square);
        let side = layer.brood;
        let at = (row % side * side + column % side) as usize;
        Spot { square, index: layer.brood_start([column / side, row / side]) + at, at }
    }

    /// Whether anything is kept of a square.
    #[inline]
    pub fn is_stored(&self, square: Square) -> bool {
        square.level >= self.window.streamed || self.window.holds(square.level, self.cell_number(square))
    }

    /// Whether anything is kept of a square's children. What is not stored shares its place with another square.
    #[inline]
    pub fn are_children_stored(&self, square: Square) -> bool {
        square.level > self.window.streamed || self.window.holds(square.level - 1, self.cell_number(square))
    }

    /// The square that is stored at an index.
    #[inline]
    pub fn spot_at(&self, level: u32, index: usize) -> Spot {
        let layer @ Layer { brood, broods, .. } = &self.layers[level as usize];
        let (number, at) = (index as u32 / layer.brood_size(), (index as u32 % layer.brood_size()) as usize);
        let stored = [number % broods[0], number / broods[0]];
        let [column, row] = [0, 1].map(|axis| stored[axis] * brood + layer.positions[at].at[axis]);
        let [column, row] = if layer.wraps { self.held_at(level, [column, row]) } else { [column, row] };
        Spot { square: Square { level, column, row }, index, at }
    }

    /// Column and row of the square that is stored at a place of a window.
    fn held_at(&self, level: u32, place: [u32; 2]) -> [u32; 2] {
        let per_cell = self.layers[level as usize].per_cell;
        let cell = self.window.holder(level, place.map(|at| at / per_cell));
        [0, 1].map(|axis| cell[axis] * per_cell + place[axis] % per_cell)
    }

    /// The squares of a sheet.
    pub fn runs(&self, Sheet { level, cell }: Sheet) -> impl Iterator<Item = Run> {
        let Layer { size, per_cell, brood, .. } = self.layers[level as usize];
        let [column, row] = cell.map(|at| at * per_cell);
        let [columns, rows] = [size[0] - column, size[1] - row].map(|left| left.min(per_cell));
        (0..rows).flat_map(move |j| {
            (0..columns).step_by(brood as usize).map(move |i| {
                let start = self.index(Square { level, column: column + i, row: row + j });
                let length = brood.min(columns - i) as usize;
                Run { first: (j * per_cell + i) as usize, stored: start..start + length }
            })
        })
    }

    /// Takes the height ranges of a sheet's squares.
    pub fn put(&mut self, sheet: Sheet, ranges_m: &[[f32; 2]]) {
        let mut heights_m = std::mem::take(&mut self.layers[sheet.level as usize].heights_m);
        for Run { first, stored } in self.runs(sheet) {
            let length = stored.len();
            heights_m[stored].copy_from_slice(&ranges_m[first..first + length]);
        }
        self.layers[sheet.level as usize].heights_m = heights_m;
    }

    /// Takes the height ranges of all squares of a level, row by row.
    pub(super) fn put_level(&mut self, level: u32, ranges_m: impl IntoIterator<Item = [f32; 2]>) {
        let mut heights_m = vec![[0.0; 2]; self.layers[level as usize].squares_stored()];
        for (square, range_m) in self.squares(level).zip(ranges_m) {
            heights_m[self.index(square)] = range_m;
        }
        if level == self.top() {
            let wider = |[low, high]: [f64; 2], [l, h]: [f32; 2]| [low.min(l.into()), high.max(h.into())];
            self.range_m = heights_m.iter().copied().fold(self.range_m, wider);
        }
        self.layers[level as usize].heights_m = heights_m;
    }

    /// Lowest and highest sample of all squares of a level, row by row, in metres.
    pub fn ranges_m(&self, level: u32) -> Vec<[f32; 2]> {
        let heights_m = &self.layers[level as usize].heights_m;
        self.squares(level).map(|square| heights_m[self.index(square)]).collect()
    }

    /// Patches of all layers so far that there is room for.
    pub fn places(&self) -> u32 {
        self.layers.last().map_or(0, |layer| layer.first_place + 2 * layer.squares_stored() as u32)
    }

    /// A number for patches that are stored, by the position of its square: below [`Self::places`].
    #[inline]
    pub fn place_at(&self, patch: Patch, index: usize) -> u32 {
        self.layer(patch.square).place_at(patch.half, index)
    }

    /// The same among the patches of one level.
    #[inline]
    pub fn place_in_level(&self, patch: Patch) -> u32 {
        2 * self.index(patch.square) as u32 + patch.half as u32
    }
}
