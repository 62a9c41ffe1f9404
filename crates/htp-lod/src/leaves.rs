//! The patches to draw and their matching blocks: the leaves of the hierarchy that are in sight.
//!
//! A side of a leaf is collapsed where the neighbour's parent is not split. Of the children of a split patch, only
//! those on its sides can meet anything coarser, and only there: a child's mask is the parent's coarser sides, of
//! which it keeps those that it touches. No child touches all three, so the block with three collapsed sides is never
//! drawn.

use crate::blocks::ALL_COLLAPSED;
use crate::grid::{Grid, Half, Kin, Layer, Patch, Spot};
use crate::levels::Levels;
use crate::sight::{Culling, Sight};

/// A patch to draw and the matching block to draw it with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Leaf {
    pub patch: Patch,
    /// Collapsed sides, see [`Side::bit`](crate::blocks::Side::bit).
    pub mask: u8,
}

/// What becomes of the leaves, and what is to be known of the way to them.
pub(crate) trait Sink {
    /// A leaf, the position of its square, and the squares of its level.
    fn leaf(&mut self, leaf: Leaf, index: usize, layer: &Layer);

    /// A square above the finest layer that is in sight, and so much of it.
    fn seen(&mut self, _spot: Spot, _sight: Sight) {}
}

impl Sink for Vec<Leaf> {
    fn leaf(&mut self, leaf: Leaf, _index: usize, _layer: &Layer) {
        self.push(leaf);
    }
}

/// The coarser sides of the halves of a square that are split.
#[inline]
pub(crate) fn coarser_sides(grid: &Grid, levels: &Levels, spot: Spot, split: u8) -> [Option<u8>; 2] {
    let [north_west, south_east] = levels.split().coarser_sides(grid, spot);
    let of = |half: Half, sides: u8| (split & half.bit() != 0).then_some(sides);
    [of(Half::NorthWest, north_west), of(Half::SouthEast, south_east)]
}

/// The masks of the halves of a child square whose parents are split, from [`coarser_sides`] of its parent.
#[inline]
pub(crate) fn leaf_masks(coarser_sides: [Option<u8>; 2], kin: &Kin) -> [Option<u8>; 2] {
    let mask = |half: Half| {
        let coarser = coarser_sides[kin.parents[half as usize] as usize];
        coarser.map(|coarser| coarser & kin.touched[half as usize])
    };
    [mask(Half::NorthWest), mask(Half::SouthEast)]
}

/// Passes on the leaves of one cell whose square may be in sight.
pub(crate) fn collect(grid: &Grid, levels: &Levels, cell: Spot, culling: Culling, sink: &mut impl Sink) {
    // Nothing is coarser than the top layer.
    Visit { grid, levels, sink }.square(cell, [Some(0); 2], culling);
}

struct Visit<'a, S> {
    grid: &'a Grid,
    levels: &'a Levels,
    sink: &'a mut S,
}

impl<S: Sink> Visit<'_, S> {
    /// `masks` holds the masks of the halves whose parent is split; `culling` is that of what is around the square.
    fn square(&mut self, spot: Spot, masks: [Option<u8>; 2], culling: Culling) {
        let Some(culling) = culling.inside(self.grid, spot) else { return };
        let split = self.levels.split().halves_at(spot);
        self.leaves(spot, masks, split);
        if spot.square.level > 0 {
            self.sink.seen(spot, culling.sight());
            if split != 0 {
                self.children(spot, split, culling);
            }
        }
    }

    /// The halves that are not split.
    fn leaves(&mut self, Spot { square, index, .. }: Spot, masks: [Option<u8>; 2], split: u8) {
        for half in Half::BOTH {
            let Some(mask) = masks[half as usize] else { continue };
            if split & half.bit() == 0 {
                self.leaf(square.half(half), mask, index, self.grid.layer(square));
            }
        }
    }

    #[inline]
    fn leaf(&mut self, patch: Patch, mask: u8, index: usize, layer: &Layer) {
        assert_ne!(mask, ALL_COLLAPSED, "{patch:?} meets coarser patches on all sides");
        self.sink.leaf(Leaf { patch, mask }, index, layer);
    }

    fn children(&mut self, parent: Spot, split: u8, culling: Culling) {
        if culling.is_whole() {
            return self.children_in_sight(parent, split);
        }
        let coarser = coarser_sides(self.grid, self.levels, parent, split);
        for row in self.grid.brood(parent.square) {
            for (child, kin) in row.children() {
                let masks = leaf_masks(coarser, kin);
                if masks != [None; 2] {
                    self.square(child, masks, culling);
                }
            }
        }
    }

    /// The same where all of them are in sight, as most are.
    fn children_in_sight(&mut self, parent: Spot, split: u8) {
        let (grid, levels) = (self.grid, self.levels);
        let coarser = levels.split().coarser_sides(grid, parent);
        let layer = &grid.layers[parent.square.level as usize - 1];
        for half in Half::BOTH.into_iter().filter(|half| split & half.bit() != 0) {
            for (spot, child) in grid.child_patches(parent.square.half(half)) {
                if levels.split().halves_at(spot) & child.half.bit() == 0 {
                    self.leaf(spot.square.half(child.half), coarser[half as usize] & child.touched, spot.index, layer);
                }
            }
        }
        if parent.square.level > 1 {
            let children = grid.brood(parent.square).flat_map(|row| row.children());
            for (child, _) in children.filter(|(_, kin)| kin.inside(split) != 0) {
                self.sink.seen(child, Sight::Whole);
                let split = levels.split().halves_at(child);
                if split != 0 {
                    self.children_in_sight(child, split);
                }
            }
        }
    }
}
