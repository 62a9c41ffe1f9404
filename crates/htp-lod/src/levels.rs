//! Which patches are split: the metric's wishes and what they entail, followed from view to view.
//!
//! A patch that is split is drawn as the patches of the next finer layer that it consists of; a patch is drawn when
//! its parent is split and it is not.

use crate::blocks::Side;
use crate::closure::{Change, Closure};
use crate::grid::{Grid, Square};
use crate::rule::Rule;
use crate::split::Split;
use crate::wishes::Wishes;
use terrain_core::odometer::Odometer;

/// The split patches of the last view.
pub(crate) struct Levels {
    wishes: Wishes,
    closure: Closure,
    odometer: Odometer,
    split: Split,
    /// Those of the view before, where all is closed anew.
    before: Split,
    is_closed_anew: bool,
    /// What has changed, where it is not.
    changes: Vec<Change>,
    /// Whether more or less may be split than in the last view.
    reopened: bool,
}

impl Levels {
    /// Nothing is split.
    pub fn new(grid: &Grid) -> Self {
        let wishes = Wishes::new(grid);
        let split = Split(wishes.halves().to_vec());
        let (before, closure) = (split.clone(), Closure::new(grid));
        let odometer = Odometer::default();
        Self { wishes, closure, odometer, before, split, is_closed_anew: false, changes: Vec::new(), reopened: false }
    }

    /// The split patches.
    pub fn split(&self) -> &Split {
        &self.split
    }

    /// Follows to a new view: decides what may have changed, and no more. What comes out is the same as if all were
    /// decided anew.
    pub fn follow(&mut self, rule: &Rule, view: &terrain_core::View) {
        self.changes.clear();
        self.is_closed_anew = false;
        let all_anew = !self.odometer.advance(view);
        if all_anew {
            self.wishes.expire();
        }
        self.wishes.update(rule, &self.odometer);
        let reopened = std::mem::take(&mut self.reopened);
        if all_anew || self.closure.is_cheaper_anew(&self.wishes) {
            return self.close(rule.grid, Some(rule));
        }
        self.changes = self.closure.follow(rule, &self.odometer, &self.wishes, &mut self.split, reopened);
    }

    /// To be told when more or less may be split than before, since cells have come or gone; `fewer` are those in which
    /// it is less.
    pub fn reconsider(&mut self, grid: &Grid, fewer: &[[u32; 2]]) {
        self.wishes.reconsider(grid, fewer);
        self.reopened = true;
    }

    /// What is drawn more coarsely than it should be, since it may not be split: squares, and how many pixels each
    /// counts.
    pub fn unheld<'a>(&'a self, rule: &'a Rule) -> impl Iterator<Item = (Square, f64)> + 'a {
        let patches = self.wishes.denied().map(|denied| (denied.square, rule.patch_px(denied.square, denied.halves)));
        let blocks = self.closure.denied().map(|block| (block.square, rule.block_px(block.square, block.error)));
        patches.chain(blocks)
    }

    /// Squares that hold a patch that was split or merged by the last view, and those beyond such a patch's sides:
    /// their children are drawn otherwise than before. Some may come twice. They are found one by one: who has seen
    /// that they are too many need not ask for the others.
    pub fn changed<'a>(&'a self, grid: &'a Grid) -> impl Iterator<Item = Square> + 'a {
        let levels = (1..=grid.top()).filter(|_| self.is_closed_anew);
        let differences = levels.flat_map(|level| self.differences(grid, level));
        self.changes.iter().copied().chain(differences).flat_map(|change| concerned(grid, change))
    }

    /// The split patches are the wishes and all that they entail.
    fn close(&mut self, grid: &Grid, rule: Option<&Rule>) {
        std::mem::swap(&mut self.split, &mut self.before);
        self.closure.close(grid, &self.wishes, &mut self.split, rule.map(|rule| (rule, &self.odometer)));
        self.is_closed_anew = true;
    }

    /// What has changed on one level since all was closed anew.
    fn differences<'a>(&'a self, grid: &'a Grid, level: u32) -> impl Iterator<Item = Change> + 'a {
        /// Squares that are compared at once: on large DEMs most are as before.
        const RUN: usize = 64;
        let [now, before] = [&self.split, &self.before].map(|split| split.0[level as usize].chunks(RUN));
        let runs = (0..).step_by(RUN).zip(now.zip(before)).filter(|(_, (now, before))| now != before);
        let squares = runs.flat_map(|(start, (now, before))| (start..).zip(now.iter().zip(before)));
        let changed = squares.filter(|(_, (now, before))| now != before);
        changed.map(move |(index, (now, before))| Change {
            square: grid.spot_at(level, index).square,
            halves: now ^ before,
        })
    }

    /// Takes wishes as given, whatever the metric.
    #[cfg(test)]
    pub fn choose(&mut self, grid: &Grid, wish: impl Fn(Square) -> u8) {
        self.changes.clear();
        self.wishes.set(grid, wish);
        self.close(grid, None);
    }

    /// Follows small steps and large ones alike.
    #[cfg(test)]
    pub fn never_anew(&mut self) {
        self.closure.never_anew();
    }

    /// The blocks that are left too bad: squares, and their errors in steps.
    #[cfg(test)]
    pub fn denied_blocks(&self) -> impl Iterator<Item = (Square, u16)> {
        self.closure.denied().map(|block| (block.square, block.error))
    }

    /// Decides all anew in the next view.
    #[cfg(test)]
    pub fn forget(&mut self) {
        self.odometer = Odometer::default();
    }
}

/// The square of a change, and those beyond its sides.
fn concerned(grid: &Grid, change: Change) -> impl Iterator<Item = Square> {
    // Beyond the hypotenuse the square is the same.
    let sides = change.patches().flat_map(|patch| [Side::Left, Side::Right].map(|side| (patch, side)));
    let beyond = sides.filter_map(|(patch, side)| Some(grid.neighbour(patch, side)?.square));
    std::iter::once(change.square).chain(beyond)
}
