//! The patches to draw and their matching blocks: the leaves of the hierarchy that are in sight.
//!
//! A side of a leaf is collapsed where the neighbour's parent is not split. Of the children of a split patch, only
//! those on its sides can meet anything coarser, and only there: a child's mask is the parent's coarser sides, of
//! which it keeps those that it touches. No child touches all three, so the block with three collapsed sides is never
//! drawn.

use crate::blocks::ALL_COLLAPSED;
use crate::grid::{Grid, Half, Patch, Square};
use crate::levels::Levels;
use terrain_core::View;

/// A patch to draw and the matching block to draw it with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Leaf {
    pub patch: Patch,
    /// Collapsed sides, see [`Side::bit`](crate::blocks::Side::bit).
    pub mask: u8,
}

/// How much of a square may be in sight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    None,
    Part,
    Whole,
}

/// How much of a square may be in sight; all without culling.
pub(crate) fn look(grid: &Grid, square: Square, culling: Option<&View>) -> Sight {
    let Some(view) = culling else { return Sight::Whole };
    let bounds = grid.bounds_world(square);
    if !view.sees(&bounds) {
        return Sight::None;
    }
    // Nothing is below the finest layer that could be spared a test.
    if square.level > 0 && view.sees_whole(&bounds) { Sight::Whole } else { Sight::Part }
}

/// The coarser sides of the halves of a square that are split.
pub(crate) fn coarser_sides(grid: &Grid, levels: &Levels, square: Square, split: u8) -> [Option<u8>; 2] {
    let is_split = |half: Half| split & half.bit() != 0;
    Half::BOTH.map(|half| is_split(half).then(|| levels.split().coarser_sides(grid, square.half(half))))
}

/// The masks of the halves of a child square whose parents are split, from [`coarser_sides`] of its parent.
pub(crate) fn leaf_masks(grid: &Grid, coarser_sides: [Option<u8>; 2], child: Square) -> [Option<u8>; 2] {
    let (i, j) = (child.column % grid.k, child.row % grid.k);
    Half::BOTH.map(|half| {
        let parent = grid.parent_half(half, i, j);
        let touched = if parent == half { grid.touched_sides(half, i, j) } else { 0 };
        coarser_sides[parent as usize].map(|coarser| coarser & touched)
    })
}

/// Appends the leaves of one cell; with a view, only those whose square may be in sight.
pub(crate) fn collect(grid: &Grid, levels: &Levels, cell: Square, culling: Option<&View>, leaves: &mut Vec<Leaf>) {
    // Nothing is coarser than the top layer.
    Visit { grid, levels, leaves }.square(cell, [Some(0); 2], culling);
}

struct Visit<'a> {
    grid: &'a Grid,
    levels: &'a Levels,
    leaves: &'a mut Vec<Leaf>,
}

impl Visit<'_> {
    /// `masks` holds the masks of the halves whose parent is split. `culling` is none where all is in sight.
    fn square(&mut self, square: Square, masks: [Option<u8>; 2], culling: Option<&View>) {
        let sight = look(self.grid, square, culling);
        if sight == Sight::None {
            return;
        }
        let split = self.levels.split().halves(self.grid, square);
        for half in Half::BOTH.into_iter().filter(|half| split & half.bit() == 0) {
            if let Some(mask) = masks[half as usize] {
                let patch = square.half(half);
                assert_ne!(mask, ALL_COLLAPSED, "{patch:?} meets coarser patches on all sides");
                self.leaves.push(Leaf { patch, mask });
            }
        }
        if split != 0 {
            self.children(square, split, culling.filter(|_| sight == Sight::Part));
        }
    }

    fn children(&mut self, square: Square, split: u8, culling: Option<&View>) {
        let coarser = coarser_sides(self.grid, self.levels, square, split);
        for child in self.grid.children(square) {
            let masks = leaf_masks(self.grid, coarser, child);
            if masks != [None; 2] {
                self.square(child, masks, culling);
            }
        }
    }
}
