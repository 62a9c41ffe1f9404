//! Which patches want to be split, by the metric alone: LOD computation (section 3, phase 4), from the top down.
//!
//! Of a DEM that is streamed, what may not be split for want of its cell (`window`) counts as not wished for, and is
//! noted.
//!
//! Every square knows the odometer reading at which one of the decisions in it, or in any square below it, may flip.
//! A frame visits only the squares where that has come, which are few: see `odometer`. Of a square that is to be split,
//! children are asked only where the eye is as near as the one that reaches farthest: errors shrink fast from level to
//! level, so that of most such squares no child is.

use crate::grid::{BOTH_HALVES, Grid, Half, Spot, Square};
use crate::rule::{Rule, Ways, sooner};
use crate::window::Sheet;
use std::collections::BTreeMap;
use terrain_core::odometer::{NEVER, Odometer, PASSED, rounded_down};

/// Bytes of [`Wishes`] for one square.
pub(crate) const BYTES_A_SQUARE: u64 = (size_of::<u8>() + size_of::<f32>()) as u64;

/// More for one that has children to ask: those above level 1.
pub(crate) const BYTES_A_PARENT: u64 = size_of::<bool>() as u64;

/// How much farther the eye must be than the children reach, so that no rounding has one ask after all.
const CLEAR_M: f64 = 1e-3;

/// The wishes of all patches above the finest layer.
pub(crate) struct Wishes {
    /// By level and square: the halves that want to be split. Empty on level 0, which has nothing finer.
    halves: Vec<Vec<u8>>,
    /// By level and square, from level 2: whether the children are asked one by one, and their deadlines count. Where they
    /// are not, none of them wishes for anything.
    asked: Vec<Vec<bool>>,
    /// By level and square: when the square is to be visited again, rounded down.
    deadlines_m: Vec<Vec<f32>>,
    /// By the number of a square's first patch: wishes that are denied, of patches whose parents' are not.
    denied: BTreeMap<u32, Denied>,
    /// By level: the squares in which the last update has changed any.
    flipped: Vec<Vec<Square>>,
}

/// Halves of a square that want to be split and may not.
#[derive(Clone, Copy)]
pub(crate) struct Denied {
    pub square: Square,
    pub halves: u8,
}

impl Wishes {
    /// Nothing is decided.
    pub fn new(grid: &Grid) -> Self {
        let squares = |level: u32| if level == 0 { 0 } else { grid.layers[level as usize].squares_stored() };
        Self {
            halves: (0..=grid.top()).map(|level| vec![0; squares(level)]).collect(),
            asked: (0..=grid.top()).map(|level| vec![false; if level > 1 { squares(level) } else { 0 }]).collect(),
            deadlines_m: (0..=grid.top()).map(|level| vec![PASSED as f32; squares(level)]).collect(),
            denied: BTreeMap::new(),
            flipped: vec![Vec::new(); grid.layers.len()],
        }
    }

    /// Wishes that are denied, and no parent's is.
    pub fn denied(&self) -> impl Iterator<Item = &Denied> {
        self.denied.values()
    }

    /// Has the next update decide anew what the loading of cells may have changed; `fewer` are those in which less may
    /// be split.
    pub fn reconsider(&mut self, grid: &Grid, fewer: &[[u32; 2]]) {
        let granted = self.denied.values().map(|denied| denied.square).filter(|square| grid.may_split(*square));
        let mut due: Vec<Square> = granted.collect();
        for (cell, level) in fewer.iter().flat_map(|cell| (1..=grid.window.streamed).map(move |level| (cell, level))) {
            // Without its sheet, the places are another cell's.
            let is_stored = level == grid.window.streamed || grid.window.holds(level, *cell);
            if is_stored && !grid.window.may_split(level, *cell) {
                let indices = grid.runs(Sheet { level, cell: *cell }).flat_map(|run| run.stored);
                let wished = indices.filter(|index| self.halves[level as usize][*index] != 0);
                due.extend(wished.map(|index| grid.spot_at(level, index).square));
            }
        }
        due.into_iter().for_each(|square| self.expire_path(grid, square));
    }

    /// Has a square and all above it visited.
    fn expire_path(&mut self, grid: &Grid, mut square: Square) {
        loop {
            self.deadlines_m[square.level as usize][grid.index(square)] = PASSED as f32;
            if square.level == grid.top() {
                return;
            }
            square = grid.parent_square(square);
        }
    }

    /// Takes note of what a square may not have.
    fn deny(&mut self, grid: &Grid, square: Square, halves: u8) {
        let number = grid.patch_number(square.half(Half::NorthWest));
        match halves {
            0 => self.denied.remove(&number),
            _ => self.denied.insert(number, Denied { square, halves }),
        };
    }

    /// By level and square: the halves that want to be split.
    pub fn halves(&self) -> &[Vec<u8>] {
        &self.halves
    }

    /// By level: the squares in which the last update has changed any.
    pub fn flipped(&self) -> &[Vec<Square>] {
        &self.flipped
    }

    /// Decides anew what may have changed.
    pub fn update(&mut self, rule: &Rule, odometer: &Odometer) {
        self.flipped.iter_mut().for_each(Vec::clear);
        let grid = rule.grid;
        if grid.top() == 0 {
            return;
        }
        for cell in grid.cells(grid.whole()) {
            let level = grid.top() as usize;
            if odometer.has_passed(self.deadlines_m[level][cell.index].into()) {
                let deadline_m = self.ask(rule, odometer, cell, BOTH_HALVES, rule.distance_at_m(cell));
                self.deadlines_m[level][cell.index] = rounded_down(deadline_m);
            }
        }
    }

    /// Decides all anew in the next update.
    pub fn expire(&mut self) {
        self.deadlines_m.iter_mut().for_each(|layer| layer.fill(PASSED as f32));
    }

    /// Asks those halves of a square whose parents want to be split, in a distance from the eye. Returns the next deadline
    /// of any in it.
    #[inline]
    fn ask(&mut self, rule: &Rule, odometer: &Odometer, spot: Spot, with_parent: u8, distance_m: f64) -> f64 {
        let (wish, slack_m) = Rule::wish_at(distance_m, rule.reaches_m(spot));
        let deadline_m = odometer.deadline_m(slack_m);
        let (wish, flips) = self.note(rule.grid, spot, wish & with_parent);
        if spot.square.level == 1 {
            return deadline_m;
        }
        // Of most squares that are split, no child is to be.
        let slack_m = if wish == 0 { f64::INFINITY } else { distance_m - rule.children_reach_m(spot) };
        let asks = slack_m < CLEAR_M;
        let asked = std::mem::replace(&mut self.asked[spot.square.level as usize][spot.index], asks);
        if asks {
            return sooner(deadline_m, self.visit_children(rule, odometer, spot, wish, flips || !asked));
        }
        if asked {
            self.merge_children(rule.grid, spot);
        }
        sooner(deadline_m, odometer.deadline_m(slack_m))
    }

    /// Takes note of what a square wishes for. Returns what of it is granted, and whether that is new.
    #[inline]
    fn note(&mut self, grid: &Grid, Spot { square, index, .. }: Spot, mut wish: u8) -> (u8, bool) {
        if square.level <= grid.window.streamed {
            let denied = if grid.may_split(square) { 0 } else { wish };
            self.deny(grid, square, denied);
            wish &= !denied;
        }
        let is_whole = wish == 0 || wish == BOTH_HALVES;
        debug_assert!(is_whole || !grid.crosses_rim(square), "{square:?} wants one half at the rim");
        let flips = std::mem::replace(&mut self.halves[square.level as usize][index], wish) != wish;
        if flips {
            self.flipped[square.level as usize].push(square);
        }
        (wish, flips)
    }

    /// Asks the children that are due, or all. Returns the next deadline of any.
    fn visit_children(&mut self, rule: &Rule, odometer: &Odometer, parent: Spot, wish: u8, all: bool) -> f64 {
        let (grid, level, mut soonest_m) = (rule.grid, parent.square.level - 1, NEVER);
        let mut ways = Ways::default();
        rule.measure_ways(parent.square, &mut ways);
        for row in grid.brood(parent.square) {
            let j = row.j;
            for (i, (child, kin)) in row.children().enumerate() {
                let mut deadline_m = if all { PASSED } else { self.deadlines_m[level as usize][child.index].into() };
                if odometer.has_passed(deadline_m) {
                    deadline_m = match kin.inside(wish) {
                        0 => {
                            self.give_up(grid, child);
                            NEVER
                        }
                        with_parent => {
                            let distance_m = ways.distance_m([i, j], grid.heights_m(level, child.index));
                            self.ask(rule, odometer, child, with_parent, distance_m)
                        }
                    };
                    self.deadlines_m[level as usize][child.index] = rounded_down(deadline_m);
                }
                soonest_m = sooner(soonest_m, deadline_m);
            }
        }
        soonest_m
    }

    /// Takes all wishes from a square's children, which are not asked before all are.
    fn merge_children(&mut self, grid: &Grid, parent: Spot) {
        for row in grid.brood(parent.square) {
            for (child, _) in row.children() {
                self.give_up(grid, child);
            }
        }
    }

    /// Takes all wishes from a square and from what is below.
    fn give_up(&mut self, grid: &Grid, spot: Spot) {
        let level = spot.square.level as usize;
        if self.halves[level][spot.index] != 0 || spot.square.level <= grid.window.streamed {
            self.note(grid, spot, 0);
            if level > 1 && std::mem::take(&mut self.asked[level][spot.index]) {
                self.merge_children(grid, spot);
            }
        }
    }

    /// Sets all wishes, those of patches with a parent that wants to be split; at the rim, of both halves together.
    #[cfg(test)]
    pub fn set(&mut self, grid: &Grid, wish: impl Fn(Square) -> u8) {
        for level in (1..=grid.top()).rev() {
            for square in grid.squares(level) {
                let parent = grid.parent_square(square);
                let with_parent = match level == grid.top() {
                    true => BOTH_HALVES,
                    false => grid.kin(square).inside(self.halves[level as usize + 1][grid.index(parent)]),
                };
                let wish = if grid.crosses_rim(square) && wish(square) != 0 { BOTH_HALVES } else { wish(square) };
                self.halves[level as usize][grid.index(square)] = wish & with_parent;
            }
        }
    }
}
