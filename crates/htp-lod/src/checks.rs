//! The decisions of the closure's pass, kept for as long as they hold: so that no pass is made where it would take the
//! same course as the last, and so that a pass compares again only what the eye may have changed.

use crate::border::Border;
use crate::grid::{Patch, Square};
use crate::rule::{Answer, Rule};
use terrain_core::odometer::{NEVER, Odometer};

/// Comparisons of a block's error with a distance. With the same wishes and the same answers the pass would take the
/// same course.
#[derive(Default)]
pub(crate) struct Checks {
    made: Vec<Check>,
    deadlines_m: Vec<f64>,
    soonest_m: f64,
}

struct Check {
    square: Square,
    /// In steps.
    error: u16,
    too_bad: bool,
}

impl Checks {
    pub fn clear(&mut self) {
        self.made.clear();
        self.deadlines_m.clear();
        self.soonest_m = NEVER;
    }

    pub fn push(&mut self, odometer: &Odometer, square: Square, error: u16, answer: Answer) {
        self.add(Check { square, error, too_bad: answer.near }, odometer.deadline_m(answer.slack_m));
    }

    fn add(&mut self, check: Check, deadline_m: f64) {
        self.made.push(check);
        self.deadlines_m.push(deadline_m);
        self.soonest_m = self.soonest_m.min(deadline_m);
    }

    /// Whether all answers are the same; looks again at those whose deadline has come.
    pub fn still_hold(&mut self, rule: &Rule, odometer: &Odometer) -> bool {
        if !odometer.has_passed(self.soonest_m) {
            return true;
        }
        self.soonest_m = NEVER;
        for (check, deadline_m) in self.made.iter().zip(&mut self.deadlines_m) {
            if odometer.has_passed(*deadline_m) {
                let answer = rule.is_too_bad(rule.distance_m(check.square), check.error);
                if answer.near != check.too_bad {
                    return false;
                }
                *deadline_m = odometer.deadline_m(answer.slack_m);
            }
            self.soonest_m = self.soonest_m.min(*deadline_m);
        }
        true
    }
}

/// That all blocks along the coarser sides of a patch are fine, even where the eye is nearest to the patch. Most are,
/// from pass to pass, and need not be looked at again.
#[derive(Clone, Copy)]
struct Verdict {
    /// The patch's number.
    patch: u32,
    coarser: u8,
    /// The largest error of the blocks, in steps.
    error: u16,
    deadline_m: f64,
}

/// The verdicts of the last pass and of this one, in the order of the patches' numbers.
#[derive(Default)]
pub(crate) struct Verdicts {
    before: Vec<Verdict>,
    /// Those of the last pass up to here belong to patches that this one has passed.
    next: usize,
    now: Vec<Verdict>,
}

impl Verdicts {
    /// Begins a pass.
    pub fn begin(&mut self) {
        std::mem::swap(&mut self.before, &mut self.now);
        self.now.clear();
        self.next = 0;
    }

    /// Compares all anew in the next pass.
    pub fn forget(&mut self) {
        self.now.clear();
    }

    /// Whether all blocks along the coarser sides of a patch are fine even where the eye is nearest to the patch: one
    /// comparison for all of them, or none while the verdict of the last pass holds.
    pub fn all_fine(
        &mut self,
        rule: &Rule,
        odometer: &Odometer,
        border: &Border,
        parent: Patch,
        coarser: u8,
        checks: &mut Checks,
    ) -> bool {
        let (patch, square) = (rule.grid.patch_number(parent), parent.square);
        let last = self.last(patch).filter(|last| last.coarser == coarser && !odometer.has_passed(last.deadline_m));
        if let Some(last) = last {
            checks.add(Check { square, error: last.error, too_bad: false }, last.deadline_m);
            self.keep(last);
            return true;
        }
        let errors = border.children.iter().map(|child| rule.block_error(parent, child, coarser & child.touched));
        let error = errors.max().unwrap_or(0);
        let answer = rule.is_too_bad(rule.distance_m(square), error);
        checks.push(odometer, square, error, answer);
        if !answer.near {
            self.keep(Verdict { patch, coarser, error, deadline_m: odometer.deadline_m(answer.slack_m) });
        }
        !answer.near
    }

    /// The verdict of the last pass on a patch. Patches come in the order of their numbers, but those that a level has
    /// split itself, which come after all others of the level and may go without.
    fn last(&mut self, patch: u32) -> Option<Verdict> {
        while self.before.get(self.next).is_some_and(|verdict| verdict.patch < patch) {
            self.next += 1;
        }
        self.before.get(self.next).copied().filter(|verdict| verdict.patch == patch)
    }

    fn keep(&mut self, verdict: Verdict) {
        if self.now.last().is_none_or(|last| last.patch < verdict.patch) {
            self.now.push(verdict);
        }
    }
}
