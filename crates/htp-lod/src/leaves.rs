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

/// Collects the leaves cell by cell; with a view, only those whose square may be in sight.
pub(crate) fn collect(grid: &Grid, levels: &Levels, culling: Option<&View>, leaves: &mut Vec<Leaf>) {
    leaves.clear();
    let mut visit = Visit { grid, levels, leaves };
    for cell in grid.squares(grid.top()) {
        // Nothing is coarser than the top layer.
        visit.square(cell, [Some(0); 2], culling);
    }
}

struct Visit<'a> {
    grid: &'a Grid,
    levels: &'a Levels,
    leaves: &'a mut Vec<Leaf>,
}

impl Visit<'_> {
    /// `masks` holds the masks of the halves whose parent is split. `culling` is none where all is in sight.
    fn square(&mut self, square: Square, masks: [Option<u8>; 2], culling: Option<&View>) {
        let Some(culling) = self.look(square, culling) else { return };
        let split = self.levels.split_halves(self.grid, square);
        let mut coarser_sides = [None; 2];
        for half in Half::BOTH {
            let Some(mask) = masks[half as usize] else { continue };
            let patch = square.half(half);
            if split & half.bit() != 0 {
                coarser_sides[half as usize] = Some(self.levels.coarser_sides(self.grid, patch));
            } else {
                assert_ne!(mask, ALL_COLLAPSED, "{patch:?} meets coarser patches on all sides");
                self.leaves.push(Leaf { patch, mask });
            }
        }
        if coarser_sides != [None; 2] {
            self.children(square, coarser_sides, culling);
        }
    }

    fn children(&mut self, square: Square, coarser_sides: [Option<u8>; 2], culling: Option<&View>) {
        let (column, row) = (square.column * self.grid.k, square.row * self.grid.k);
        for child in self.grid.children(square) {
            let (i, j) = (child.column - column, child.row - row);
            let masks = Half::BOTH.map(|half| {
                let parent = self.grid.parent_half(half, i, j);
                let touched = if parent == half { self.grid.touched_sides(half, i, j) } else { 0 };
                coarser_sides[parent as usize].map(|coarser| coarser & touched)
            });
            if masks != [None; 2] {
                self.square(child, masks, culling);
            }
        }
    }

    /// None where a square is out of sight; otherwise the view that its children are to be tested against, if any.
    fn look<'v>(&self, square: Square, culling: Option<&'v View>) -> Option<Option<&'v View>> {
        let Some(view) = culling else { return Some(None) };
        let bounds = self.grid.bounds_world(square);
        if !view.sees(&bounds) {
            return None;
        }
        let has_children = square.level > 0;
        Some(if has_children && view.sees_whole(&bounds) { None } else { Some(view) })
    }
}
