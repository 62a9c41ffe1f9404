//! Sets of patches that are split, and where they end.

use crate::blocks::ALL_COLLAPSED;
use crate::grid::{BOTH_HALVES, Grid, Half, Patch, Spot, Square};

/// A set of patches: bits by level and square. Nothing on level 0, which has nothing finer.
#[derive(Clone)]
pub(crate) struct Split(pub Vec<Vec<u8>>);

/// A square with split patches where a level ends.
#[derive(Clone, Copy)]
pub(crate) struct FrontierSquare {
    pub spot: Spot,
    /// By half: the sides beyond which nothing is split; none of a half that is not split itself.
    pub coarser: [u8; 2],
}

impl Split {
    /// The halves of a square that are split.
    #[inline]
    pub fn halves(&self, grid: &Grid, square: Square) -> u8 {
        self.halves_at(grid.spot(square))
    }

    /// The same where its position is known.
    #[inline]
    pub fn halves_at(&self, Spot { square, index, .. }: Spot) -> u8 {
        if square.level == 0 { 0 } else { self.0[square.level as usize][index] }
    }

    #[inline]
    pub fn contains(&self, grid: &Grid, patch: Patch) -> bool {
        self.halves(grid, patch.square) & patch.half.bit() != 0
    }

    /// Whether any of a patch's children of its own half is split, given by their positions in the brood. Nothing is
    /// split beyond the DEM.
    #[inline]
    pub fn any_child(&self, grid: &Grid, Patch { square, half }: Patch, positions: &[usize]) -> bool {
        let (level, start) = (square.level as usize - 1, grid.brood_start(square));
        positions.iter().any(|at| self.0[level][start + at] & half.bit() != 0)
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

    /// Appends the squares of a level that hold split patches with coarser sides.
    pub fn frontier(&self, grid: &Grid, level: u32, list: &mut Vec<FrontierSquare>) {
        for index in non_zero(&self.0[level as usize]) {
            let square = self.frontier_square(grid, grid.spot_at(level, index));
            if square.coarser != [0; 2] {
                list.push(square);
            }
        }
    }

    /// What of a square is split, and where it has coarser sides.
    #[inline(always)]
    pub fn frontier_square(&self, grid: &Grid, spot: Spot) -> FrontierSquare {
        let (halves, [north_west, south_east]) = (self.halves_at(spot), self.coarser_sides(grid, spot));
        let of_split = |half: Half, coarser: u8| if halves & half.bit() != 0 { coarser } else { 0 };
        FrontierSquare { spot, coarser: [of_split(Half::NorthWest, north_west), of_split(Half::SouthEast, south_east)] }
    }

    /// Of both halves of a square, as if both were split: the sides beyond which nothing is split. There the children
    /// meet a coarser neighbour.
    #[inline(always)]
    pub fn coarser_sides(&self, grid: &Grid, spot: Spot) -> [u8; 2] {
        let bits = &self.0[spot.square.level as usize];
        let [west, north, east, south] = grid.around(spot, |index| bits[index], BOTH_HALVES);
        let own = bits[spot.index];
        // By the other half of all three, in the order of the sides' bits.
        let [north_west, south_east] =
            [[own, west, north].map(|halves| halves >> 1), [own, east, south].map(|halves| halves & 1)];
        [north_west, south_east].map(|[hypotenuse, left, right]| ALL_COLLAPSED ^ (hypotenuse | left << 1 | right << 2))
    }
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
    use std::collections::BTreeSet;
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
    fn the_frontier_of_a_window_is_that_of_square_by_square() {
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
                let is_frontier = |square: &Square| {
                    let sides = split.coarser_sides(&grid, grid.spot(*square));
                    let split = Half::BOTH.map(|half| split.contains(&grid, square.half(half)));
                    split[0] && sides[0] != 0 || split[1] && sides[1] != 0
                };
                let expected: BTreeSet<usize> = stored().filter(is_frontier).map(|square| grid.index(square)).collect();
                let length = found.len();
                let found: BTreeSet<usize> = found.into_iter().map(|square| square.spot.index).collect();
                assert_eq!(found.len(), length);
                assert_eq!(found, expected, "window {window}, eye {eye:?}");
            }
        }
    }
}
