//! Rectangles of cells.

use super::{Grid, Spot, Square};
use std::ops::Range;
use terrain_core::Aabb;

/// Some columns and rows of cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region {
    first: [u32; 2],
    end: [u32; 2],
}

impl Region {
    fn side(self, axis: usize) -> u32 {
        self.end[axis] - self.first[axis]
    }

    /// Cells along its longer side.
    pub fn longest_side(self) -> u32 {
        self.side(0).max(self.side(1))
    }

    /// Cut across the longer side.
    pub fn halves(self) -> [Self; 2] {
        let axis = usize::from(self.side(1) > self.side(0));
        let middle = self.first[axis] + self.side(axis) / 2;
        let [mut before, mut after] = [self; 2];
        (before.end[axis], after.first[axis]) = (middle, middle);
        [before, after]
    }
}

impl Grid {
    /// All cells.
    pub fn whole(&self) -> Region {
        Region { first: [0; 2], end: self.layers[self.top() as usize].size }
    }

    /// The cells of a region, row by row, as they are stored.
    #[inline]
    pub fn cells(&self, Region { first, end }: Region) -> impl Iterator<Item = Spot> + use<> {
        let (level, a_row) = (self.top(), self.layers[self.top() as usize].size[0] as usize);
        let [columns, rows] = [0, 1].map(|axis| -> Range<u32> { first[axis]..end[axis] });
        let spot = move |square @ Square { column, row, .. }: Square| Spot {
            square,
            index: row as usize * a_row + column as usize,
            at: 0,
        };
        rows.flat_map(move |row| columns.clone().map(move |column| spot(Square { level, column, row })))
    }

    /// A world box around all cells of a region, as high as the whole DEM.
    pub fn region_bounds_world(&self, Region { first, end }: Region) -> Aabb {
        let interval_m = |axis: usize| {
            let [first, last] = [first[axis], end[axis] - 1].map(|at| self.interval_m(axis, self.top(), at));
            [first[0], last[1]]
        };
        let ([x, z], [low, high]) = ([0, 1].map(interval_m), self.range_m);
        Aabb { min: [x[0], low, z[0]], max: [x[1], high, z[1]] }
    }
}
