//! What must be split beside what the metric asks for: neighbours differ by one level at most, across cells too
//! (section 2.2), and no matching block is too bad.
//!
//! What is split on a level follows from the wishes there and from what is split one level below, whatever the order of
//! work. Levels are closed from the finest up, each in two parts:
//!
//! - *Restriction* makes the level's *base*: the wishes, and each patch X one of whose sides is touched, from outside,
//!   by a patch of the level below that is split. If X were not split, that one's children would meet a neighbour that
//!   is two levels coarser. All patches that are split below have their parents in the base: each lies in a wish, or
//!   hangs together with one over split patches of its own level, and where these leave a parent they touch its side.
//! - *Repair* (not in the paper) goes in rounds. A patch is judged once, when it has come in, by what is split then:
//!   where the block of a child along a side is too bad, and nothing is split beyond, the patch beyond is wanted; of two
//!   sides, the one without which the block's error is smaller. Round 0 judges the base; all that it wants comes in
//!   together and is judged in round 1, and so on. To split the child would not help: a child is finer than what its
//!   block has to match. Later rounds only make blocks better (`errors`).
//!
//! ```text
//!   +---------+---------+---------+---------+    W wish       w its child, split below: touches the side of B
//!   |    C    |    W   w|    B    |    D    |    B base, by restriction
//!   |    2    |    0    |    0    |    1    |    D wanted in round 0 for a block of B, judged in round 1
//!   +---------+---------+---------+---------+    C wanted in round 1 by another patch that came in with D
//! ```
//!
//! So a change spreads no farther than to the neighbours of what has changed, level by level up, but for rounds from 1
//! on. Those are rare: about one split patch in 500 comes from repair, and they are made anew wherever the level has
//! changed. A view judges only patches of which a neighbour or child has changed, or whose deadline has passed.
//!
//! Of a DEM that is streamed, what the restriction asks for may always be split (`window`). What the repair asks for may
//! not: then the block stays as it is, and is noted.

use crate::blocks::Side;
use crate::border::{Border, sides_of};
use crate::deadlines::{self, Deadlines};
use crate::grid::{BOTH_HALVES, Grid, Half, Patch, Square};
use crate::repair::{DeniedBlock, Repair, Verdict, Wants};
use crate::rule::Rule;
use crate::split::{FrontierSquare, Split};
use crate::wishes::Wishes;
use std::collections::BTreeMap;
use terrain_core::odometer::{NEVER, Odometer};

/// Bytes of [`Closure`] for one square.
pub(crate) const BYTES_A_SQUARE: u64 = deadlines::BYTES_A_SQUARE;

/// To follow one square's change takes about as long as to close anew so many squares along the borders of levels.
const FLIP_COST: usize = 24;

/// Closes levels, and knows what of it holds how long.
pub(crate) struct Closure {
    border: Border,
    /// From level 0, which has nothing to split.
    levels: Vec<Level>,
    /// Squares along the borders of levels when all was closed anew.
    frontier: usize,
    /// How many of them take as long as to follow one flip.
    flip_cost: usize,
}

/// What is known of a level.
struct Level {
    /// Of the patches of the base.
    deadlines: Deadlines,
    /// What patches of the base want, by place in the level.
    wants: BTreeMap<u32, Wants>,
    /// What repair has split.
    forced: Vec<Patch>,
    /// Of the patches that repair has split.
    later: Later,
}

/// What rounds from 1 on have come to.
struct Later {
    deadline_m: f64,
    denied: Vec<DeniedBlock>,
}

/// Halves of a square that were split or merged.
#[derive(Clone, Copy)]
pub(crate) struct Change {
    pub square: Square,
    pub halves: u8,
}

impl Change {
    /// The patches.
    #[inline]
    pub fn patches(self) -> impl Iterator<Item = Patch> {
        Half::BOTH.into_iter().filter(move |half| self.halves & half.bit() != 0).map(move |half| self.square.half(half))
    }

    /// Those beyond their sides.
    pub fn beyond(self, grid: &Grid) -> impl Iterator<Item = Patch> {
        self.patches().flat_map(move |patch| Side::ALL.map(|side| grid.neighbour(patch, side))).flatten()
    }
}

impl Closure {
    pub fn new(grid: &Grid) -> Self {
        let places = |level: u32| if level == 0 { 0 } else { 2 * grid.layers[level as usize].squares_stored() };
        let levels = (0..=grid.top()).map(|level| Level::new(places(level))).collect();
        Self { border: Border::new(grid), levels, frontier: 0, flip_cost: FLIP_COST }
    }

    /// The blocks that are left too bad.
    pub fn denied(&self) -> impl Iterator<Item = &DeniedBlock> {
        self.levels
            .iter()
            .flat_map(|level| level.wants.values().flat_map(|wants| &wants.denied).chain(&level.later.denied))
    }

    /// Whether it takes less time to close all anew than to follow what has flipped.
    pub fn is_cheaper_anew(&self, wishes: &Wishes) -> bool {
        self.flip_cost * wishes.flipped().iter().map(Vec::len).sum::<usize>() > self.frontier
    }

    /// Follows whatever has flipped.
    #[cfg(test)]
    pub fn never_anew(&mut self) {
        self.flip_cost = 0;
    }

    /// Splits whatever is needed, from nothing; repairs where there is a rule that knows errors.
    pub fn close(&mut self, grid: &Grid, wishes: &Wishes, split: &mut Split, rule: Option<(&Rule, &Odometer)>) {
        let Self { border, levels, frontier, .. } = self;
        let rule = rule.filter(|(rule, _)| rule.errors().is_some());
        let repair = rule.map(|(rule, odometer)| Repair { rule, odometer, border });
        *frontier = 0;
        let (mut squares, mut arrived) = (Vec::new(), Vec::new());
        for (number, level) in levels.iter_mut().enumerate().skip(1) {
            split.0[number].copy_from_slice(&wishes.halves()[number]);
            level.clear();
            arrived = restrict(grid, split, &squares, &arrived);
            squares.clear();
            split.frontier(grid, number as u32, &mut squares);
            *frontier += squares.len();
            if let Some(repair) = &repair {
                squares.iter().for_each(|square| level.judge(repair, split, *square, BOTH_HALVES));
                level.run_rounds(repair, &mut Draft::new(grid, split));
                arrived.extend(&level.forced);
            }
        }
    }

    /// Follows what has changed since. `reopened` says that more or less may be split than before. Returns what is
    /// split or merged by it.
    pub fn follow(
        &mut self,
        rule: &Rule,
        odometer: &Odometer,
        wishes: &Wishes,
        split: &mut Split,
        reopened: bool,
    ) -> Vec<Change> {
        let repair = Repair { rule, odometer, border: &self.border };
        let (mut changes, mut below) = (Vec::new(), 0..0);
        for (number, level) in self.levels.iter_mut().enumerate().skip(1) {
            let due = level.due(odometer, reopened);
            let is_same = below.is_empty() && wishes.flipped()[number].is_empty();
            let start = changes.len();
            if !is_same || !due.is_empty() || odometer.has_passed(level.later.deadline_m) {
                let level_below = &changes[below];
                let found = level.follow(&repair, wishes, split, (number as u32, level_below), due);
                changes.extend(found);
            }
            below = start..changes.len();
        }
        changes
    }
}

impl Level {
    fn new(places: usize) -> Self {
        let later = Later { deadline_m: NEVER, denied: Vec::new() };
        Self { deadlines: Deadlines::new(places), wants: BTreeMap::new(), forced: Vec::new(), later }
    }

    fn clear(&mut self) {
        self.deadlines.clear();
        self.wants.clear();
        self.forced.clear();
        self.later = Later { deadline_m: NEVER, denied: Vec::new() };
    }

    /// The places of the patches to judge though nothing around them has changed.
    fn due(&mut self, odometer: &Odometer, reopened: bool) -> Vec<u32> {
        let mut due = Vec::new();
        self.deadlines.take_passed(odometer, &mut due);
        if reopened {
            due.extend(self.wants.keys()); // who wants nothing does not ask what may be split
        }
        due
    }

    /// Follows what has changed on the level below, in the wishes and for those that are due.
    fn follow(
        &mut self,
        repair: &Repair,
        wishes: &Wishes,
        split: &mut Split,
        (number, below): (u32, &[Change]),
        mut due: Vec<u32>,
    ) -> Vec<Change> {
        let grid = repair.rule.grid;
        let mut draft = Draft::new(grid, split);
        self.forced.drain(..).for_each(|patch| draft.merge(patch));
        let base = rebase(repair.border, wishes, &mut draft, number, below);
        if repair.rule.errors().is_some() {
            let parents = below.iter().flat_map(|change| change.patches()).filter_map(|child| grid.parent(child));
            let around = base.iter().flat_map(|change| change.patches().chain(change.beyond(grid)));
            due.extend(parents.chain(around).map(|patch| grid.place_in_level(patch)));
            due.sort_unstable();
            due.dedup();
            if !self.wants.is_empty() {
                due.iter().for_each(|place| drop(self.wants.remove(place)));
            }
            for square in due.chunk_by(|a, b| a / 2 == b / 2) {
                let halves = square.iter().map(|place| 1 << (place % 2)).sum();
                let spot = grid.spot_at(number, square[0] as usize / 2);
                self.judge(repair, draft.split, draft.split.frontier_square(grid, spot), halves);
            }
            self.run_rounds(repair, &mut draft);
        }
        draft.changes()
    }

    /// Round 0 for halves of a square that want nothing yet, with the base split and nothing else.
    fn judge(&mut self, repair: &Repair, split: &Split, square: FrontierSquare, halves: u8) {
        for (half, Verdict { deadline_m, wants }) in verdicts(repair, split, square, halves) {
            let place = 2 * square.spot.index as u32 + half as u32;
            self.deadlines.set(place, deadline_m);
            if let Some(wants) = wants {
                self.wants.insert(place, *wants);
            }
        }
    }

    /// Splits what the base wants, and what that wants in turn.
    fn run_rounds(&mut self, repair: &Repair, draft: &mut Draft) {
        self.later = Later { deadline_m: NEVER, denied: Vec::new() };
        let mut wanted: Vec<Patch> = self.wants.values().flat_map(|wants| &wants.split).copied().collect();
        while !wanted.is_empty() {
            let first = self.forced.len();
            wanted.drain(..).for_each(|patch| self.forced.extend(draft.force(patch)));
            for parent in &self.forced[first..] {
                let square = draft.split.frontier_square(draft.grid, draft.grid.spot(parent.square));
                for (_, Verdict { deadline_m, wants }) in verdicts(repair, draft.split, square, parent.half.bit()) {
                    self.later.deadline_m = self.later.deadline_m.min(deadline_m);
                    let Wants { split, denied } = wants.map_or_else(Wants::default, |wants| *wants);
                    self.later.denied.extend(denied);
                    wanted.extend(split);
                }
            }
        }
    }
}

/// What comes out for halves of a square by what is split now.
fn verdicts(
    repair: &Repair,
    split: &Split,
    FrontierSquare { spot, coarser }: FrontierSquare,
    halves: u8,
) -> impl Iterator<Item = (Half, Verdict)> {
    let distance_m = repair.rule.distance_at_m(spot);
    Half::BOTH.into_iter().filter(move |half| halves & half.bit() != 0).map(move |half| {
        let coarser = coarser[half as usize];
        let verdict = || repair.judge(split, spot, half, (distance_m, coarser));
        (half, if coarser != 0 { verdict() } else { Verdict::NOTHING })
    })
}

/// The split patches while a level is followed, and what was split before in the squares that were touched.
struct Draft<'a> {
    grid: &'a Grid,
    split: &'a mut Split,
    /// The first entry of a square counts.
    before: Vec<(Square, u8)>,
}

impl<'a> Draft<'a> {
    fn new(grid: &'a Grid, split: &'a mut Split) -> Self {
        Self { grid, split, before: Vec::new() }
    }

    /// Returns the halves that were there.
    fn replace(&mut self, square: Square, halves: u8) -> u8 {
        debug_assert!(self.grid.is_stored(square), "nothing is kept of {square:?}");
        let before = self.split.replace(self.grid, square, halves);
        self.before.push((square, before));
        before
    }

    fn merge(&mut self, patch: Patch) {
        let halves = self.split.halves(self.grid, patch.square);
        self.replace(patch.square, halves & !patch.half.bit());
    }

    /// Splits a patch; returns those that were not yet split.
    fn force(&mut self, patch: Patch) -> impl Iterator<Item = Patch> + use<> {
        let square = patch.square;
        let halves = together(self.grid, square, patch.half.bit()) & !self.split.halves(self.grid, square);
        if halves != 0 {
            let now = self.split.halves(self.grid, square) | halves;
            self.replace(square, now);
        }
        Change { square, halves }.patches()
    }

    /// What is different in the end.
    fn changes(mut self) -> Vec<Change> {
        self.before.sort_by_key(|(square, _)| self.grid.index(*square));
        self.before.dedup_by_key(|(square, _)| *square);
        let change = |(square, before): &(Square, u8)| Change {
            square: *square,
            halves: before ^ self.split.halves(self.grid, *square),
        };
        self.before.iter().map(change).filter(|change| change.halves != 0).collect()
    }
}

/// The halves that are split with others.
///
/// Deviation: a square that crosses the DEM's rim splits both halves together, so that a hypotenuse is never collapsed
/// there. Otherwise the collapsed edge, clamped, would cut across the DEM while the clamped inner row lies beyond it,
/// and triangles would fold over.
fn together(grid: &Grid, square: Square, halves: u8) -> u8 {
    debug_assert!(halves == 0 || grid.may_split(square), "{square:?} must be split and may not");
    if halves != 0 && grid.crosses_rim(square) { BOTH_HALVES } else { halves }
}

/// Brings the base of a level up to date: where wishes have flipped, and beyond the parents of what has changed below.
fn rebase(border: &Border, wishes: &Wishes, draft: &mut Draft, number: u32, below: &[Change]) -> Vec<Change> {
    let grid = draft.grid;
    let beyond = below.iter().flat_map(|change| change.beyond(grid)).map(|patch| grid.parent_square(patch.square));
    let mut changes = Vec::new();
    for square in wishes.flipped()[number as usize].iter().copied().chain(beyond) {
        let wished = wishes.halves()[number as usize][grid.index(square)];
        let base = wished | restricted(grid, border, draft.split, square, BOTH_HALVES & !wished);
        if base != draft.split.halves(grid, square) {
            let halves = base ^ draft.replace(square, base);
            changes.push(Change { square, halves });
        }
    }
    changes
}

/// Those of some halves of a square that the restriction splits.
fn restricted(grid: &Grid, border: &Border, split: &Split, square: Square, halves: u8) -> u8 {
    let is_touched = |patch: Patch| {
        let touches = |(side, beyond): (Side, Patch)| touches(grid, border, split, beyond, side);
        Side::ALL.into_iter().filter_map(|side| Some((side, grid.neighbour(patch, side)?))).any(touches)
    };
    let found = Change { square, halves }.patches().filter(|patch| is_touched(*patch));
    together(grid, square, found.map(|patch| patch.half.bit()).sum()) & halves
}

/// Whether a child of a patch that touches a side is split. The same side leads back to the neighbour beyond.
fn touches(grid: &Grid, border: &Border, split: &Split, patch: Patch, side: Side) -> bool {
    patch.square.level > 1
        && grid.are_children_stored(patch.square)
        && split.any_child(grid, patch, border.positions(patch.half, side))
}

/// Splits what the restriction asks for beside the wishes of a level, and returns it. Of the level below it takes the
/// frontier, and the patches that no wish has split.
fn restrict(grid: &Grid, split: &mut Split, frontier: &[FrontierSquare], arrived: &[Patch]) -> Vec<Patch> {
    let mut added = Vec::new();
    // What is split has a parent that is, unless it has just arrived.
    for parent in arrived.iter().filter_map(|child| grid.parent(*child)) {
        enter(grid, split, parent, &mut added);
    }
    for FrontierSquare { spot, coarser } in frontier {
        let touched = grid.kin_at(spot.at).touched;
        let touching = [0, 1].map(|half| touched[half] & coarser[half]);
        if touching != [0; 2] {
            restrict_beyond(grid, split, grid.parent_square(spot.square), touching, &mut added);
        }
    }
    for Patch { square, half } in arrived {
        let mut touching = [0; 2];
        touching[*half as usize] = grid.kin(*square).touched[*half as usize];
        restrict_beyond(grid, split, grid.parent_square(*square), touching, &mut added);
    }
    added
}

/// Splits the patches beyond those sides of a square's halves that are touched by a child that is split.
fn restrict_beyond(grid: &Grid, split: &mut Split, square: Square, touching: [u8; 2], added: &mut Vec<Patch>) {
    let coarser = split.coarser_sides(grid, grid.spot(square));
    for half in Half::BOTH {
        for side in sides_of(touching[half as usize] & coarser[half as usize]) {
            let beyond = grid.neighbour(square.half(half), side).expect("a coarser side has a neighbour");
            enter(grid, split, beyond, added);
        }
    }
}

/// Splits a patch, and takes note of what was not split.
fn enter(grid: &Grid, split: &mut Split, Patch { square, half }: Patch, added: &mut Vec<Patch>) {
    let halves = split.insert(grid, square, together(grid, square, half.bit()));
    added.extend(Change { square, halves }.patches());
}
