//! What must be split beside what the metric asks for: neighbours differ by one level at most, across cells too
//! (section 2.2), and no matching block is too bad.
//!
//! Level by level from the finest up. At the sides of the split patches of a level, beyond which nothing is split:
//!
//! - *Restriction*: where a child along such a side is split itself, its neighbour would be two levels coarser. The
//!   patch beyond the side is split.
//! - *Repair* (not in the paper): where the block of a child along such a side is too bad, the patch beyond is split,
//!   so that the side is no longer collapsed; of two sides, the one without which the block's error is smaller. To
//!   split the child would not help: a child is finer than what its block has to match.
//!
//! Of a DEM that is streamed, what the restriction asks for may always be split (`window`). What the repair asks for may
//! not: then the block stays as it is, and is noted.
//!
//! What is split so only makes blocks better, and has children that are fine (`errors`), so one pass up the levels is
//! enough; inside a level a list grows while it is worked off. The order of the list is fixed, and with it the result.

use crate::border::{Border, BorderChild, sides_of};
use crate::checks::{Checks, Verdicts};
use crate::grid::{BOTH_HALVES, Grid, Half, Patch, Square};
use crate::levels::Split;
use crate::rule::Rule;
use terrain_core::odometer::Odometer;

/// The pass up the levels, and the decisions that it has made.
pub(crate) struct Closure {
    border: Border,
    /// Split patches of the level in work that have coarser sides, or had.
    list: Vec<Patch>,
    checks: Checks,
    verdicts: Verdicts,
    denied: Vec<DeniedBlock>,
}

/// A block that is too bad and stays so, since the patch beyond one of its sides may not be split.
pub(crate) struct DeniedBlock {
    pub square: Square,
    /// In steps.
    pub error: u16,
}

impl Closure {
    pub fn new(grid: &Grid) -> Self {
        let (checks, verdicts) = (Checks::default(), Verdicts::default());
        Self { border: Border::new(grid), list: Vec::new(), checks, verdicts, denied: Vec::new() }
    }

    /// The blocks that the last pass has left too bad.
    pub fn denied(&self) -> &[DeniedBlock] {
        &self.denied
    }

    pub fn has_denied(&self) -> bool {
        !self.denied.is_empty()
    }

    /// Compares all anew in the next pass.
    pub fn expire(&mut self) {
        self.verdicts.forget();
    }

    /// Splits whatever is needed; repairs where there is a rule that knows errors.
    pub fn close(&mut self, grid: &Grid, split: &mut Split, rule: Option<(&Rule, &Odometer)>) {
        self.checks.clear();
        self.denied.clear();
        self.verdicts.begin();
        for level in 1..=grid.top() {
            self.list.clear();
            split.frontier(grid, level, &mut self.list);
            if level > 1 {
                self.restrict(grid, split);
            }
            if let Some((rule, odometer)) = rule.filter(|(rule, _)| rule.errors().is_some()) {
                self.repair(rule, odometer, split);
            }
        }
    }

    /// Whether a pass for the same wishes would still take the same course.
    pub fn still_holds(&mut self, rule: &Rule, odometer: &Odometer) -> bool {
        self.checks.still_hold(rule, odometer)
    }

    fn restrict(&mut self, grid: &Grid, split: &mut Split) {
        let mut next = 0;
        while let Some(parent) = self.list.get(next).copied() {
            next += 1;
            for side in sides_of(split.coarser_sides(grid, parent)) {
                let mut children = self.border.touching(grid, parent, side.bit());
                if children.any(|(_, child)| split.contains(grid, child)) {
                    let beyond = grid.neighbour(parent, side).expect("a coarser side has a neighbour");
                    force(grid, split, beyond, &mut self.list);
                }
            }
        }
    }

    fn repair(&mut self, rule: &Rule, odometer: &Odometer, split: &mut Split) {
        let Self { border, list, checks, verdicts, denied } = self;
        let mut next = 0;
        while let Some(parent) = list.get(next).copied() {
            next += 1;
            let mut coarser = split.coarser_sides(rule.grid, parent);
            if coarser == 0 || verdicts.all_fine(rule, odometer, border, parent, coarser, checks) {
                continue;
            }
            for (child, patch) in border.touching(rule.grid, parent, coarser) {
                if !split.contains(rule.grid, patch) {
                    let leaf = Leaf { parent, child, square: patch.square };
                    let kept = leaf.tolerable_sides(rule, odometer, coarser & child.touched, checks);
                    for side in sides_of(coarser & child.touched & !kept) {
                        let beyond = rule.grid.neighbour(parent, side).expect("a coarser side has a neighbour");
                        if rule.grid.may_split(beyond.square) {
                            force(rule.grid, split, beyond, list);
                            coarser &= !side.bit();
                        }
                    }
                    denied.extend(leaf.denied(rule, coarser & child.touched, kept));
                }
            }
        }
    }
}

/// Splits a patch.
///
/// Deviation: a square that crosses the DEM's rim splits both halves together, so that a hypotenuse is never collapsed
/// there. Otherwise the collapsed edge, clamped, would cut across the DEM while the clamped inner row lies beyond it,
/// and triangles would fold over.
fn force(grid: &Grid, split: &mut Split, patch: Patch, list: &mut Vec<Patch>) {
    debug_assert!(grid.may_split(patch.square), "{patch:?} must be split and may not");
    let halves = if grid.crosses_rim(patch.square) { BOTH_HALVES } else { patch.half.bit() };
    let added = split.insert(grid, patch.square, halves);
    list.extend(Half::BOTH.into_iter().filter(|half| added & half.bit() != 0).map(|half| patch.square.half(half)));
}

/// A patch to draw along its parent's sides.
struct Leaf {
    parent: Patch,
    child: BorderChild,
    square: Square,
}

impl Leaf {
    /// The block with a mask, where that is more than what may be kept and too bad.
    fn denied(&self, rule: &Rule, mask: u8, kept: u8) -> Option<DeniedBlock> {
        if mask & !kept == 0 {
            return None;
        }
        let error = rule.block_error(self.parent, &self.child, mask);
        let is_too_bad = rule.is_too_bad(rule.distance_m(self.square), error).near;
        is_too_bad.then_some(DeniedBlock { square: self.square, error })
    }

    /// What may stay collapsed of a mask.
    fn tolerable_sides(&self, rule: &Rule, odometer: &Odometer, mut mask: u8, checks: &mut Checks) -> u8 {
        if mask == 0 {
            return 0; // an earlier child has had the side beyond it split
        }
        let distance_m = rule.distance_m(self.square);
        loop {
            let error = rule.block_error(self.parent, &self.child, mask);
            if error == 0 {
                return mask;
            }
            let answer = rule.is_too_bad(distance_m, error);
            checks.push(odometer, self.square, error, answer);
            if !answer.near {
                return mask;
            }
            let without = |side: u8| rule.block_error(self.parent, &self.child, mask & !side);
            let worst = sides_of(mask).map(|side| side.bit()).min_by_key(|side| without(*side));
            mask &= !worst.expect("a mask without sides has no error");
        }
    }
}
