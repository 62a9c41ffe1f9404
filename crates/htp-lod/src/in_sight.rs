//! Which leaves are in sight, followed from view to view: what `leaves` collects anew, as changes.
//!
//! The tree of squares is culled from the top. A square that was wholly in sight, still is, and holds no changed
//! level is left as it is, and so is one that was and still is out of sight: a frame visits the squares that the
//! frustum's planes cross, those that enter or leave, and those where levels have changed. After a jump that is nearly
//! all there is: then all leaves are collected anew.

use crate::grid::{Grid, Half, Layer, Spot, Square};
use crate::leaves::{self, Leaf, Sink, coarser_sides, leaf_masks};
use crate::levels::Levels;
use crate::sight::{Culling, Sight};
use crate::slots::Slots;

/// Bytes of [`InSight`] for one square.
pub(crate) const BYTES_A_SQUARE: u64 = size_of::<State>() as u64;

/// To follow one change of levels takes about as long as to collect so many leaves.
const CHANGE_COST: usize = 40;

/// What the last frame has found.
pub(crate) struct InSight {
    /// By level and square; nothing for level 0.
    layers: Vec<Vec<State>>,
    /// How many leaves take as long as to follow one change.
    change_cost: usize,
}

#[derive(Clone, Copy)]
struct State {
    sight: Sight,
    /// Whether levels have changed in or below the square since it was visited last.
    changed: bool,
}

const NOTHING: State = State { sight: Sight::None, changed: false };

impl InSight {
    /// Nothing is in sight.
    pub fn new(grid: &Grid) -> Self {
        let squares = |level: u32| if level == 0 { 0 } else { grid.layers[level as usize].squares_stored() };
        let layers = (0..=grid.top()).map(|level| vec![NOTHING; squares(level)]).collect();
        Self { layers, change_cost: CHANGE_COST }
    }

    /// Follows to a new view: has `slots` draw the leaves that are in sight, and no others.
    pub fn follow(&mut self, grid: &Grid, levels: &Levels, culling: Culling, slots: &mut Slots) {
        let most = slots.drawn().checked_div(self.change_cost).unwrap_or(usize::MAX);
        let changed: Vec<Square> = levels.changed(grid).take(most.saturating_add(1)).collect();
        if changed.len() > most {
            return self.collect(grid, levels, culling, slots);
        }
        changed.into_iter().for_each(|square| self.mark(grid, square));
        let mut visit = Visit { grid, levels, layers: &mut self.layers, slots };
        culling.cells(grid, &mut |cell, culling| match culling {
            Some(culling) if culling.is_whole() && visit.is_drawn(cell) => {}
            // Nothing is coarser than the top layer.
            Some(culling) => visit.square(cell, [Some(0); 2], culling),
            None => visit.clear(cell),
        });
    }

    /// The same from nothing.
    fn collect(&mut self, grid: &Grid, levels: &Levels, culling: Culling, slots: &mut Slots) {
        slots.clear();
        self.layers.iter_mut().for_each(|layer| layer.fill(NOTHING));
        let mut anew = Anew { layers: &mut self.layers, slots };
        culling.cells_in_sight(grid, |cell, culling| leaves::collect(grid, levels, cell, culling, &mut anew));
    }

    /// Marks a square and all above it. What is out of sight needs no mark: all of it is visited when it comes in
    /// sight. So above a marked square in sight all are marked.
    fn mark(&mut self, grid: &Grid, mut square: Square) {
        loop {
            let state = &mut self.layers[square.level as usize][grid.index(square)];
            if state.changed || state.sight == Sight::None {
                return;
            }
            state.changed = true;
            if square.level == grid.top() {
                return;
            }
            square = grid.parent_square(square);
        }
    }

    /// Has leaves collected anew where any level has changed, or never.
    #[cfg(test)]
    pub fn collect_anew(&mut self, always: bool) {
        self.change_cost = if always { usize::MAX } else { 0 };
    }

    /// As if all levels had changed.
    #[cfg(test)]
    pub fn mark_all(&mut self) {
        self.layers.iter_mut().flatten().for_each(|state| state.changed = true);
    }
}

/// Draws the leaves that are collected, where nothing is drawn.
struct Anew<'a> {
    layers: &'a mut [Vec<State>],
    slots: &'a mut Slots,
}

impl Sink for Anew<'_> {
    #[inline]
    fn leaf(&mut self, Leaf { patch, mask }: Leaf, index: usize, layer: &Layer) {
        self.slots.enter(layer.place_at(patch.half, index), mask, layer.instance(patch));
    }

    fn seen(&mut self, Spot { square, index, .. }: Spot, sight: Sight) {
        self.layers[square.level as usize][index].sight = sight;
    }
}

struct Visit<'a> {
    grid: &'a Grid,
    levels: &'a Levels,
    layers: &'a mut [Vec<State>],
    slots: &'a mut Slots,
}

impl Visit<'_> {
    /// Whether all of a cell is drawn as it should be: the masks of its own patches never change.
    #[inline]
    fn is_drawn(&self, Spot { square, index, .. }: Spot) -> bool {
        let state = self.layers[square.level as usize].get(index); // nothing for level 0
        state.is_some_and(|state| state.sight == Sight::Whole && !state.changed)
    }

    /// `masks` holds the masks of the halves whose parent is split; `culling` is that of what is around the square.
    fn square(&mut self, spot: Spot, masks: [Option<u8>; 2], culling: Culling) {
        let Some(culling) = culling.inside(self.grid, spot) else { return self.clear(spot) };
        let split = self.levels.split().halves_at(spot);
        for half in Half::BOTH {
            let mask = masks[half as usize].filter(|_| split & half.bit() == 0);
            self.set(spot, half, mask);
        }
        if spot.square.level > 0 && self.must_descend(spot, culling.sight(), split) {
            self.children(spot, split, culling);
        }
    }

    /// Takes note of the sight, and returns whether something may have changed below a square.
    fn must_descend(&mut self, Spot { square, index, .. }: Spot, sight: Sight, split: u8) -> bool {
        let state = &mut self.layers[square.level as usize][index];
        let before = std::mem::replace(state, State { sight, changed: false });
        let same_sight = before.sight == Sight::Whole && sight == Sight::Whole;
        before.changed || (split != 0 && !same_sight)
    }

    fn children(&mut self, parent: Spot, split: u8, culling: Culling) {
        let coarser = coarser_sides(self.grid, self.levels, parent, split);
        for row in self.grid.brood(parent.square) {
            for (child, kin) in row.children() {
                match leaf_masks(coarser, kin) {
                    [None, None] => self.clear(child),
                    masks => self.square(child, masks, culling),
                }
            }
        }
    }

    /// Draws nothing of a square. Nothing is drawn below what is not split, and so of what is not stored.
    fn clear(&mut self, spot: Spot) {
        if !self.grid.is_stored(spot.square) {
            return;
        }
        if spot.square.level > 0 {
            let state = &mut self.layers[spot.square.level as usize][spot.index];
            if std::mem::replace(&mut state.sight, Sight::None) == Sight::None {
                return;
            }
            for row in self.grid.brood(spot.square) {
                row.children().for_each(|(child, _)| self.clear(child));
            }
        }
        Half::BOTH.into_iter().for_each(|half| self.set(spot, half, None));
    }

    fn set(&mut self, Spot { square, index, .. }: Spot, half: Half, mask: Option<u8>) {
        let patch = square.half(half);
        self.slots.set(self.grid.place_at(patch, index), mask, || self.grid.instance(patch));
    }
}
