//! Whether the matching blocks along the sides of a split patch are good enough, and what is to be split where they
//! are not. See `closure` for when this is asked, and of what.

use crate::border::{Border, BorderChild, sides_of};
use crate::grid::{Grid, Half, Patch, Spot, Square};
use crate::rule::{Answer, Rule};
use crate::split::Split;
use terrain_core::odometer::{NEVER, Odometer};

/// A rule that knows errors, and what it takes to ask it.
pub(crate) struct Repair<'a> {
    pub rule: &'a Rule<'a>,
    pub odometer: &'a Odometer,
    pub border: &'a Border,
}

/// What comes out for a split patch with given patches around it, until a deadline.
pub(crate) struct Verdict {
    pub deadline_m: f64,
    /// Few patches have any.
    pub wants: Option<Box<Wants>>,
}

const NOTHING: Verdict = Verdict { deadline_m: NEVER, wants: None };

/// What blocks need that are too bad: most patches' need nothing.
#[derive(Default)]
pub(crate) struct Wants {
    /// Patches to be split; some may come twice.
    pub split: Vec<Patch>,
    /// What stays too bad.
    pub denied: Vec<DeniedBlock>,
}

/// A block that is too bad and stays so, since the patch beyond one of its sides may not be split.
#[derive(Clone, Copy)]
pub(crate) struct DeniedBlock {
    pub square: Square,
    /// In steps.
    pub error: u16,
}

impl Repair<'_> {
    fn grid(&self) -> &Grid {
        self.rule.grid
    }

    /// Judges the blocks of the children of a square's halves by what is split now. Nothing is wanted around what is not
    /// split.
    pub fn judge(&self, split: &Split, parent: Spot, halves: u8) -> [Verdict; 2] {
        let mut verdicts = [NOTHING; 2];
        let (halves, coarser) = (halves & split.halves_at(parent), split.coarser_sides(self.grid(), parent));
        let distance_m = self.rule.distance_at_m(parent);
        for half in Half::BOTH.into_iter().filter(|half| halves & half.bit() != 0 && coarser[*half as usize] != 0) {
            let (coarser, verdict) = (coarser[half as usize], &mut verdicts[half as usize]);
            if !self.are_all_fine(parent, half, distance_m, coarser, verdict) {
                self.judge_blocks(split, parent.square.half(half), coarser, verdict);
            }
        }
        verdicts
    }

    /// Whether all blocks are fine even where the eye is nearest to the patch: one comparison for all of them, and
    /// mostly the only one.
    fn are_all_fine(&self, spot: Spot, half: Half, distance_m: f64, coarser: u8, verdict: &mut Verdict) -> bool {
        let error = self.rule.worst_block_error(spot, half, coarser);
        if error == 0 {
            return true;
        }
        let answer = self.rule.is_too_bad(distance_m, error);
        if !answer.near {
            self.note(answer, verdict);
        }
        !answer.near
    }

    /// One by one.
    fn judge_blocks(&self, split: &Split, parent: Patch, coarser: u8, verdict: &mut Verdict) {
        for (child, patch) in self.border.touching(self.grid(), parent, coarser) {
            if !split.contains(self.grid(), patch) {
                let leaf = Leaf { parent, child, square: patch.square };
                self.judge_leaf(&leaf, coarser & child.touched, verdict);
            }
        }
    }

    fn note(&self, answer: Answer, verdict: &mut Verdict) {
        verdict.deadline_m = verdict.deadline_m.min(self.odometer.deadline_m(answer.slack_m));
    }

    fn judge_leaf(&self, leaf: &Leaf, mut mask: u8, verdict: &mut Verdict) {
        let kept = self.tolerable_sides(leaf, mask, verdict);
        for side in sides_of(mask & !kept) {
            let beyond = self.grid().neighbour(leaf.parent, side).expect("a coarser side has a neighbour");
            if self.grid().may_split(beyond.square) {
                verdict.wants.get_or_insert_default().split.push(beyond);
                mask &= !side.bit();
            }
        }
        if mask & !kept != 0 {
            let error = self.rule.block_error(leaf.parent, &leaf.child, mask);
            verdict.wants.get_or_insert_default().denied.push(DeniedBlock { square: leaf.square, error });
        }
    }

    /// What may stay collapsed of a mask.
    fn tolerable_sides(&self, leaf: &Leaf, mut mask: u8, verdict: &mut Verdict) -> u8 {
        let error = |mask: u8| self.rule.block_error(leaf.parent, &leaf.child, mask);
        let distance_m = self.rule.distance_m(leaf.square);
        while error(mask) > 0 {
            let answer = self.rule.is_too_bad(distance_m, error(mask));
            self.note(answer, verdict);
            if !answer.near {
                return mask;
            }
            let worst = sides_of(mask).map(|side| side.bit()).min_by_key(|side| error(mask & !side));
            mask &= !worst.expect("a mask without sides has no error");
        }
        mask
    }
}

/// A patch to draw along its parent's sides.
struct Leaf {
    parent: Patch,
    child: BorderChild,
    square: Square,
}
