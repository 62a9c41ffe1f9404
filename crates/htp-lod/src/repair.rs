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

impl Verdict {
    /// Of what is not split, or has no coarser sides.
    pub const NOTHING: Self = Self { deadline_m: NEVER, wants: None };
}

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

    /// Judges the blocks of a split patch's children by what is split now, with the distance to its square and its
    /// coarser sides.
    pub fn judge(&self, split: &Split, parent: Spot, half: Half, (distance_m, coarser): (f64, u8)) -> Verdict {
        let mut verdict = Verdict::NOTHING;
        // Mostly all blocks are fine even where the eye is nearest to the patch: one comparison for all of them.
        let error = self.rule.worst_block_error(parent, half, coarser);
        if error > 0 {
            let answer = self.rule.is_too_bad(distance_m, error);
            if answer.near {
                self.judge_blocks(split, parent.square.half(half), (distance_m, coarser), &mut verdict);
            } else {
                self.note(answer, &mut verdict);
            }
        }
        verdict
    }

    /// One by one. Most are fine where the eye is nearest to the parent, so no nearer to the child.
    fn judge_blocks(&self, split: &Split, parent: Patch, (distance_m, coarser): (f64, u8), verdict: &mut Verdict) {
        for child in self.border.children.iter().filter(|child| child.touched & coarser != 0) {
            let mask = coarser & child.touched;
            let error = self.rule.block_error(parent, child, mask);
            let answer = self.rule.is_too_bad(distance_m, error);
            if answer.near {
                let leaf =
                    self.border.child(self.grid(), parent, child).filter(|patch| !split.contains(self.grid(), *patch));
                if let Some(Patch { square, .. }) = leaf {
                    self.judge_leaf(&Leaf { parent, child: *child, square }, mask, verdict);
                }
            } else if error > 0 {
                self.note(answer, verdict);
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
