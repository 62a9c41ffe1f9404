//! Which patches are split: LOD computation (section 3, phase 4), restricted to a difference of one level
//! (section 2.2).
//!
//! A patch that is split is drawn as the patches of the next finer layer that it consists of. The decision is a set
//! of bits, one a patch; a patch is drawn when its parent is split and it is not.

use crate::blocks::Side;
use crate::grid::{BOTH_HALVES, Grid, Half, Patch, Square};

/// The split patches of all levels.
pub(crate) struct Levels {
    /// By level and square: the halves that are split. Empty on level 0, which has nothing finer.
    split: Vec<Vec<u8>>,
}

impl Levels {
    /// Nothing is split.
    pub fn new(grid: &Grid) -> Self {
        let bytes = |level: u32| if level == 0 { 0 } else { grid.squares(level).count() };
        Self { split: (0..=grid.top()).map(|level| vec![0; bytes(level)]).collect() }
    }

    /// Decides anew, from the top layer down and then, for the restriction, from the bottom up. `wish` returns the
    /// halves of a square that want to be split; it is not asked for patches whose parent is not split.
    pub fn choose(&mut self, grid: &Grid, wish: impl Fn(Square) -> u8) {
        self.refine(grid, wish);
        self.restrict(grid);
    }

    fn refine(&mut self, grid: &Grid, wish: impl Fn(Square) -> u8) {
        self.split.iter_mut().for_each(|layer| layer.fill(0));
        if grid.top() > 0 {
            grid.squares(grid.top()).for_each(|cell| self.split(grid, cell, wish(cell)));
        }
        for level in (2..=grid.top()).rev() {
            for square in grid.squares(level) {
                let split = self.split_halves(grid, square);
                if split == 0 {
                    continue;
                }
                for child in grid.children(square) {
                    let drawn = children_of(grid, split, child);
                    if drawn != 0 {
                        self.split(grid, child, wish(child) & drawn);
                    }
                }
            }
        }
    }

    /// Splits whatever is needed for neighbours to differ by one level at most, across cells too: the parents of a
    /// split patch's neighbours must be split. A patch that is forced here has no split children, so one pass from
    /// the finest level up is enough.
    fn restrict(&mut self, grid: &Grid) {
        for level in 1..grid.top() {
            for square in grid.squares(level) {
                let split = self.split_halves(grid, square);
                for half in Half::BOTH.into_iter().filter(|half| split & half.bit() != 0) {
                    let neighbours = Side::ALL.map(|side| grid.neighbour(square.half(half), side));
                    for parent in neighbours.into_iter().flatten().filter_map(|patch| grid.parent(patch)) {
                        self.split(grid, parent.square, parent.half.bit());
                    }
                }
            }
        }
    }

    /// Deviation: a square that crosses the DEM's rim splits both halves together, so that a hypotenuse is never
    /// collapsed there. Otherwise the collapsed edge, clamped, would cut across the DEM while the clamped inner row
    /// lies beyond it, and triangles would fold over.
    fn split(&mut self, grid: &Grid, square: Square, halves: u8) {
        let halves = if halves != 0 && grid.crosses_rim(square) { BOTH_HALVES } else { halves };
        self.split[square.level as usize][grid.index(square)] |= halves;
    }

    /// The halves of a square that are split.
    pub fn split_halves(&self, grid: &Grid, square: Square) -> u8 {
        if square.level == 0 { 0 } else { self.split[square.level as usize][grid.index(square)] }
    }

    pub fn is_split(&self, grid: &Grid, patch: Patch) -> bool {
        self.split_halves(grid, patch.square) & patch.half.bit() != 0
    }

    /// The sides of a split patch beyond which nothing is split: there its children meet a coarser neighbour.
    pub fn coarser_sides(&self, grid: &Grid, patch: Patch) -> u8 {
        let coarser = |side: &Side| grid.neighbour(patch, *side).is_some_and(|other| !self.is_split(grid, other));
        Side::ALL.iter().filter(|side| coarser(side)).map(|side| side.bit()).sum()
    }
}

/// The halves of a child square that lie in the given halves of its parent.
fn children_of(grid: &Grid, parents: u8, child: Square) -> u8 {
    let (i, j) = (child.column % grid.k, child.row % grid.k);
    let inside = |half: &Half| parents & grid.parent_half(*half, i, j).bit() != 0;
    Half::BOTH.iter().filter(|half| inside(half)).map(|half| half.bit()).sum()
}
