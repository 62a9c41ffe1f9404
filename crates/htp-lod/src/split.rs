//! Sets of patches that are split, and where they end.

use crate::blocks::Side;
use crate::grid::{BOTH_HALVES, Grid, Half, Patch, Run, Square};

/// A set of patches: bits by level and square. Nothing on level 0, which has nothing finer.
#[derive(Clone)]
pub(crate) struct Split(pub Vec<Vec<u8>>);

impl Split {
    /// The halves of a square that are split.
    #[inline]
    pub fn halves(&self, grid: &Grid, square: Square) -> u8 {
        self.halves_at(square.level, grid.index(square))
    }

    /// The same by the square's position.
    #[inline]
    pub fn halves_at(&self, level: u32, index: usize) -> u8 {
        if level == 0 { 0 } else { self.0[level as usize][index] }
    }

    #[inline]
    pub fn contains(&self, grid: &Grid, patch: Patch) -> bool {
        self.halves(grid, patch.square) & patch.half.bit() != 0
    }

    /// Adds halves of a square; returns those that were not there.
    pub fn insert(&mut self, grid: &Grid, square: Square, halves: u8) -> u8 {
        let bits = &mut self.0[square.level as usize][grid.index(square)];
        let added = halves & !*bits;
        *bits |= halves;
        added
    }

    /// Replaces the halves of a square; returns those that were there.
    pub fn replace(&mut self, grid: &Grid, square: Square, halves: u8) -> u8 {
        std::mem::replace(&mut self.0[square.level as usize][grid.index(square)], halves)
    }

    /// Appends the patches of a level that have coarser sides, square by square, row by row over the DEM.
    pub fn frontier(&self, grid: &Grid, level: u32, list: &mut Vec<Patch>) {
        let (bits, layer) = (&self.0[level as usize], &grid.layers[level as usize]);
        let columns = layer.stored[0] as usize;
        for Run { first, start, length } in grid.runs(level) {
            let line = &bits[start..start + length];
            // Beyond the seams of a window the next position is not the next square.
            let ends = if layer.wraps {
                [0, columns - 1].map(|end| end.wrapping_sub(start % columns))
            } else {
                [usize::MAX; 2]
            };
            let is_inside = |at: usize| !ends.contains(&at) && is_inside(bits, columns, start + at);
            for at in non_zero(line).filter(|at| !is_inside(*at)) {
                let square = Square { column: first.column + at as u32, ..first };
                let sides = self.coarser_sides_of_both(grid, square);
                for half in Half::BOTH {
                    if line[at] & half.bit() != 0 && sides[half as usize] != 0 {
                        list.push(square.half(half));
                    }
                }
            }
        }
    }

    /// [`Self::coarser_sides`] of both halves of a square, as if both were split.
    #[inline]
    pub fn coarser_sides_of_both(&self, grid: &Grid, square: Square) -> [u8; 2] {
        [self.coarser_sides(grid, square.half(Half::NorthWest)), self.coarser_sides(grid, square.half(Half::SouthEast))]
    }

    /// The sides of a split patch beyond which nothing is split: there its children meet a coarser neighbour.
    #[inline]
    pub fn coarser_sides(&self, grid: &Grid, patch: Patch) -> u8 {
        let (bits, other) = (&self.0[patch.square.level as usize], patch.half.other().bit());
        let beyond = grid.beyond(patch);
        let coarser = |side: Side| beyond[side as usize].is_some_and(|index| bits[index] & other == 0);
        let bit = |side: Side| side.bit() * coarser(side) as u8;
        bit(Side::Hypotenuse) | bit(Side::Left) | bit(Side::Right)
    }
}

/// Whether all is split in a square, given by its position, and beyond its sides: most of what is split at all. Beyond
/// the rim nothing is, so that squares along it may be told otherwise.
fn is_inside(bits: &[u8], columns: usize, index: usize) -> bool {
    let has = |index: Option<usize>, half: Half| {
        index.and_then(|index| bits.get(index)).is_some_and(|bits| bits & half.bit() != 0)
    };
    bits[index] == BOTH_HALVES
        && has(index.checked_sub(1), Half::SouthEast)
        && has(index.checked_sub(columns), Half::SouthEast)
        && has(Some(index + 1), Half::NorthWest)
        && has(Some(index + columns), Half::NorthWest)
}

/// Positions of the bytes other than 0. On large DEMs nearly all are 0.
fn non_zero(bytes: &[u8]) -> impl Iterator<Item = usize> {
    const RUN: usize = 32;
    let runs = bytes.chunks(RUN).enumerate().filter(|(_, run)| run.iter().fold(0, |all, byte| all | byte) != 0);
    let positions = runs.flat_map(|(i, run)| (RUN * i..).zip(run));
    positions.filter(|(_, byte)| **byte != 0).map(|(position, _)| position)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::{CellFile, cut};
    use crate::options::Options;
    use crate::wishes::Wishes;
    use std::sync::Arc;
    use terrain_core::{Heightmap, SplitMix64};

    /// A grid of 13 x 9 cells with a window of so many, and all of the window held.
    fn grid(window: u32, eye: [u32; 2]) -> Grid {
        let options = Options { k: 2, layers: 3, ..Options::default() };
        let heightmap = Heightmap::new(101, 70, [1.0; 2], vec![0.0; 7070]).unwrap();
        let (file, resident) = CellFile::open(Arc::new(cut(&heightmap, &options))).unwrap();
        let mut grid = Grid::streamed(file.header(), resident.ranges_m, &options, &[window; 2]);
        grid.window.follow(eye);
        grid.window.inside().collect::<Vec<_>>().into_iter().for_each(|sheet| grid.window.enter(sheet));
        grid
    }

    /// Next to a seam the byte before or after is another square's.
    #[test]
    fn the_frontier_of_a_window_is_that_of_square_by_square_in_the_order_of_the_dem() {
        let mut random = SplitMix64::new(1);
        for (window, eye) in [(2, [5, 5]), (3, [7, 3]), (3, [12, 8]), (5, [4, 6]), (13, [6, 6])] {
            let grid = grid(window, eye);
            for _ in 0..300 {
                let mut split = Split(Wishes::new(&grid).halves().to_vec());
                // Nearly all: most squares are inside.
                let stored = || grid.squares(1).filter(|square| grid.is_stored(*square));
                for square in stored() {
                    let halves = if random.below(12) > 0 { BOTH_HALVES } else { random.below(4) as u8 };
                    split.insert(&grid, square, halves);
                }
                let mut found = Vec::new();
                split.frontier(&grid, 1, &mut found);
                let patches = stored().flat_map(|square| Half::BOTH.map(|half| square.half(half)));
                let is_frontier =
                    |patch: &Patch| split.contains(&grid, *patch) && split.coarser_sides(&grid, *patch) != 0;
                let expected: Vec<Patch> = patches.filter(is_frontier).collect();
                assert_eq!(found, expected, "window {window}, eye {eye:?}");
            }
        }
    }
}
