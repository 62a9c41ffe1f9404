//! The order of the patches of a cell, and a number for every patch: what vertices go by.
//!
//! ```text
//!  | cell 0                                            | cell 1 ...
//!  | level 0                 | level 1      | level 2  |
//!  | NW SE | NW SE | NW SE ..| NW SE | NW ..| NW SE    |    square by square, row by row
//! ```
//!
//! In a cell at the DEM's rim, squares that do not exist keep their room, so that all cells are equal; only a DEM that
//! is narrower than a cell has narrower ones.

use crate::grid::{Grid, Half, Patch, Square};

/// The order of the patches in a cell's slot, and with it the numbers of all patches.
pub(crate) struct CellLayout {
    /// By level.
    layers: Vec<LayerLayout>,
    /// Patches in a slot.
    pub patches: u64,
}

struct LayerLayout {
    /// Squares along one side of a cell.
    squares_per_cell: u32,
    /// Columns and rows of squares with room in the slot.
    size: [u32; 2],
    /// Number of the level's first patch in the slot.
    first_patch: u64,
}

impl LayerLayout {
    /// The squares with room in the slot of a cell, row by row.
    fn squares(&self, level: u32, cell: Square) -> impl Iterator<Item = Square> + use<> {
        let [columns, rows] = self.size;
        let first = [cell.column, cell.row].map(|at| at * self.squares_per_cell);
        let square =
            move |place: u32| Square { level, column: first[0] + place % columns, row: first[1] + place / columns };
        (0..columns * rows).map(square)
    }
}

impl CellLayout {
    pub fn new(grid: &Grid) -> Self {
        let mut slot = Self { layers: Vec::new(), patches: 0 };
        for (level, layer) in grid.layers.iter().enumerate() {
            let squares_per_cell = grid.k.pow(grid.top() - level as u32);
            let size = layer.size.map(|squares| squares.min(squares_per_cell));
            slot.layers.push(LayerLayout { squares_per_cell, size, first_patch: slot.patches });
            slot.patches += 2 * size[0] as u64 * size[1] as u64;
        }
        slot
    }

    /// The patches with room in the slot of a cell, in their order.
    pub fn patches_of(&self, cell: Square) -> impl Iterator<Item = Patch> {
        let layers = self.layers.iter().enumerate();
        let squares = layers.flat_map(move |(level, layer)| layer.squares(level as u32, cell));
        squares.flat_map(|square| Half::BOTH.map(|half| square.half(half)))
    }

    /// Running number of a patch over all slots.
    pub fn patch_number(&self, grid: &Grid, patch: Patch) -> u64 {
        let Square { level, column, row } = patch.square;
        let LayerLayout { squares_per_cell: side, size, first_patch } = self.layers[level as usize];
        let cell = Square { level: grid.top(), column: column / side, row: row / side };
        let place = row % side * size[0] + column % side;
        grid.index(cell) as u64 * self.patches + first_patch + 2 * place as u64 + patch.half as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use std::collections::BTreeSet;
    use terrain_core::Heightmap;

    #[test]
    fn every_patch_has_its_own_number() {
        for (columns, rows, k) in [(60, 31, 3), (5, 200, 2), (3, 3, 7)] {
            let heights = vec![0.0; (columns * rows) as usize];
            let heightmap = Heightmap::new(columns, rows, [1.0; 2], heights).unwrap();
            let grid = Grid::new(&heightmap, &Options { k, ..Options::default() });
            let layout = CellLayout::new(&grid);
            let squares = || (0..=grid.top()).flat_map(|level| grid.squares(level));
            let number = |square: Square| Half::BOTH.map(|half| layout.patch_number(&grid, square.half(half)));
            let numbers: BTreeSet<u64> = squares().flat_map(number).collect();
            assert_eq!(numbers.len(), 2 * squares().count());
            let room = grid.squares(grid.top()).count() as u64 * layout.patches;
            assert!(numbers.iter().all(|number| *number < room));
        }
    }
}
