//! Which patches want to be split, by the metric alone: LOD computation (section 3, phase 4), from the top down.
//!
//! Of a DEM that is streamed, what may not be split for want of its cell (`window`) counts as not wished for, and is
//! noted.
//!
//! Every square knows the odometer reading at which one of the decisions in it, or in any square below it, may flip.
//! A frame visits only the squares where that has come, which are few: see `odometer`.

use crate::grid::{BOTH_HALVES, Grid, Half, Spot, Square};
use crate::rule::{Rule, Ways, sooner};
use crate::window::Sheet;
use std::collections::BTreeMap;
use terrain_core::odometer::{NEVER, Odometer, PASSED, rounded_down};

/// Bytes of [`Wishes`] for one square.
pub(crate) const BYTES_A_SQUARE: u64 = (size_of::<u8>() + size_of::<f32>()) as u64;

/// The wishes of all patches above the finest layer.
pub(crate) struct Wishes {
    /// By level and square: the halves that want to be split. Empty on level 0, which has nothing finer.
    halves: Vec<Vec<u8>>,
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
        for cell in grid.squares(grid.top()).map(|cell| grid.spot(cell)) {
            let level = grid.top() as usize;
            if odometer.has_passed(self.deadlines_m[level][cell.index].into()) {
                let (wish, slack_m) = rule.wish(cell);
                let deadline_m = self.decide(rule, odometer, cell, wish, odometer.deadline_m(slack_m));
                self.deadlines_m[level][cell.index] = rounded_down(deadline_m);
            }
        }
    }

    /// Decides all anew in the next update.
    pub fn expire(&mut self) {
        self.deadlines_m.iter_mut().for_each(|layer| layer.fill(PASSED as f32));
    }

    /// Takes note of what a square at a position wishes for until a deadline, and has its children visited where that may
    /// concern them. Returns the next deadline of any.
    #[inline]
    fn decide(&mut self, rule: &Rule, odometer: &Odometer, spot: Spot, mut wish: u8, deadline_m: f64) -> f64 {
        let (grid, Spot { square, index, .. }) = (rule.grid, spot);
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
        if square.level == 1 || (wish == 0 && !flips) {
            deadline_m
        } else if wish == 0 {
            self.merge_children(rule, odometer, spot);
            deadline_m
        } else {
            sooner(deadline_m, self.visit_children(rule, odometer, spot, wish, flips))
        }
    }

    /// Decides for the children that are due, or for all. Returns the next deadline of any.
    fn visit_children(&mut self, rule: &Rule, odometer: &Odometer, parent: Spot, wish: u8, all: bool) -> f64 {
        let (grid, level, mut soonest_m) = (rule.grid, parent.square.level - 1, NEVER);
        let mut ways = Ways::default();
        rule.measure_ways(parent.square, &mut ways);
        for row in grid.brood(parent.square) {
            let j = row.j;
            for (i, (child, kin)) in row.children().enumerate() {
                let due_m = if all { PASSED } else { self.deadlines_m[level as usize][child.index].into() };
                if !odometer.has_passed(due_m) {
                    soonest_m = sooner(soonest_m, due_m);
                    continue;
                }
                let with_parent = kin.inside(wish);
                let (mut wished, mut deadline_m) = (0, NEVER);
                if with_parent != 0 {
                    let distance_m = ways.distance_m([i, j], grid.heights_m(level, child.index));
                    let (both, slack_m) = Rule::wish_at(distance_m, rule.reaches_m(child));
                    (wished, deadline_m) = (both & with_parent, odometer.deadline_m(slack_m));
                }
                deadline_m = self.decide(rule, odometer, child, wished, deadline_m);
                self.deadlines_m[level as usize][child.index] = rounded_down(deadline_m);
                soonest_m = sooner(soonest_m, deadline_m);
            }
        }
        soonest_m
    }

    /// Takes all wishes from a square's children, which are not asked again before it has one. So their deadlines, which
    /// would take most of the time, may stay what they are.
    fn merge_children(&mut self, rule: &Rule, odometer: &Odometer, parent: Spot) {
        let (level, streamed) = (parent.square.level - 1, rule.grid.window.streamed);
        for row in rule.grid.brood(parent.square) {
            for (child, _) in row.children() {
                if level <= streamed || self.halves[level as usize][child.index] != 0 {
                    self.decide(rule, odometer, child, 0, NEVER);
                }
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
