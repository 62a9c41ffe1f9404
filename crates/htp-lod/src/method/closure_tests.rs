//! What is followed from view to view against the definition of the closure, written out with sets.

use super::stream_tests::{cells, streamed};
use super::*;
use crate::blocks::Side;
use crate::border::{Border, sides_of};
use crate::grid::{BOTH_HALVES, Half, Patch};
use std::collections::BTreeSet;
use terrain_core::walk::RandomWalk;
use terrain_core::{Camera, SplitMix64};

/// Patches by their numbers.
type Set = BTreeSet<u32>;

/// What is split by definition, and what comes of it.
#[derive(Default)]
struct Closed {
    split: Set,
    /// Numbers of the north-west halves of the blocks' squares, and errors.
    denied: BTreeSet<(u32, u16)>,
    /// Patches that came in by restriction, in round 1, and later.
    counts: [usize; 3],
}

struct Definition<'a> {
    rule: &'a Rule<'a>,
    border: Border,
}

impl Definition<'_> {
    fn patches(&self, level: u32) -> impl Iterator<Item = Patch> {
        let squares = self.rule.grid.squares(level).filter(|square| self.rule.grid.is_stored(*square));
        squares.flat_map(|square| Half::BOTH.map(|half| square.half(half)))
    }

    fn has(&self, set: &Set, patch: Patch) -> bool {
        set.contains(&self.rule.grid.patch_number(patch))
    }

    /// A patch, and its other half at the rim.
    fn enter(&self, set: &mut Set, patch: Patch) {
        let (grid, square) = (self.rule.grid, patch.square);
        let halves = if grid.crosses_rim(square) { BOTH_HALVES } else { patch.half.bit() };
        let halves = Half::BOTH.into_iter().filter(|half| halves & half.bit() != 0);
        set.extend(halves.map(|half| grid.patch_number(square.half(half))));
    }

    fn wishes(&self) -> Set {
        let (grid, mut wishes) = (self.rule.grid, Set::new());
        for patch in (1..=grid.top()).rev().flat_map(|level| self.patches(level)) {
            let with_parent = grid.parent(patch).is_none_or(|parent| self.has(&wishes, parent));
            let is_wish = self.rule.wish(self.rule.grid.spot(patch.square)) & patch.half.bit() != 0;
            if with_parent && is_wish && grid.may_split(patch.square) {
                wishes.insert(grid.patch_number(patch));
            }
        }
        wishes
    }

    /// Patches whose sides are touched from outside by split ones of the next finer level.
    fn restricted(&self, split: &Set, level: u32) -> Set {
        let (grid, mut found) = (self.rule.grid, Set::new());
        let finer = (level > 1).then(|| self.patches(level - 1)).into_iter().flatten();
        for child in finer.filter(|child| self.has(split, *child)) {
            let parents = Side::ALL.map(|side| grid.parent(grid.neighbour(child, side)?));
            let outside = parents.into_iter().flatten().filter(|parent| Some(*parent) != grid.parent(child));
            outside.for_each(|parent| self.enter(&mut found, parent));
        }
        found
    }

    /// What a patch wants by what is split.
    fn judge(&self, split: &Set, parent: Patch, wanted: &mut Set, denied: &mut BTreeSet<(u32, u16)>) {
        let grid = self.rule.grid;
        let beyond = |side: &Side| grid.neighbour(parent, *side).filter(|beyond| !self.has(split, *beyond));
        for (child, patch) in self.border.touching(grid, parent, 7).filter(|(_, patch)| !self.has(split, *patch)) {
            let error = |mask: u8| self.rule.block_error(parent, &child, mask);
            let is_too_bad = |mask: u8| self.rule.is_too_bad(self.rule.distance_m(patch.square), error(mask)).near;
            let mut mask: u8 = sides_of(child.touched).filter(|side| beyond(side).is_some()).map(Side::bit).sum();
            let mut kept = mask;
            while is_too_bad(kept) {
                kept &= !sides_of(kept).map(Side::bit).min_by_key(|side| error(kept & !side)).unwrap();
            }
            for side in sides_of(mask & !kept).filter(|side| grid.may_split(beyond(side).unwrap().square)) {
                self.enter(wanted, beyond(&side).unwrap());
                mask &= !side.bit();
            }
            if is_too_bad(mask) {
                denied.insert((grid.patch_number(patch.square.half(Half::NorthWest)), error(mask)));
            }
        }
    }

    fn close(&self) -> Closed {
        let (wishes, mut closed) = (self.wishes(), Closed::default());
        for level in 1..=self.rule.grid.top() {
            let restricted = self.restricted(&closed.split, level);
            closed.counts[0] += restricted.difference(&wishes).count();
            let base = wishes.union(&restricted).copied();
            let (mut entered, mut round): (Set, _) = (base.collect(), 0);
            while !entered.is_empty() {
                closed.split.extend(&entered);
                let mut wanted = Set::new();
                for patch in self.patches(level).filter(|patch| self.has(&entered, *patch)) {
                    self.judge(&closed.split, patch, &mut wanted, &mut closed.denied);
                }
                entered = wanted.difference(&closed.split).copied().collect();
                round = 2.min(round + 1);
                closed.counts[round] += entered.len();
            }
        }
        closed
    }
}

/// Follows views; returns the counts of all, and how many blocks were denied.
fn follow(mut method: Htp, views: impl Iterator<Item = View>, at: &str) -> ([usize; 3], usize) {
    let (mut plan, mut counts, mut denied) = (FramePlan::default(), [0; 3], 0);
    method.levels.never_anew();
    for (frame, view) in views.enumerate() {
        method.plan(&view, &mut plan);
        let (grid, levels) = (&method.grid, &method.levels);
        let rule = Rule::new(&method.options, grid, method.errors.as_ref(), &view);
        let definition = Definition { rule: &rule, border: Border::new(grid) };
        let expected = definition.close();
        for patch in (1..=grid.top()).flat_map(|level| definition.patches(level)) {
            let [found, expected] = [levels.split().contains(grid, patch), definition.has(&expected.split, patch)];
            assert_eq!(found, expected, "{at}, frame {frame}, {patch:?}");
        }
        let blocks = levels.denied_blocks();
        let blocks = blocks.map(|(square, error)| (grid.patch_number(square.half(Half::NorthWest)), error));
        assert_eq!(blocks.collect::<BTreeSet<_>>(), expected.denied, "{at}, frame {frame}");
        counts.iter_mut().zip(expected.counts).for_each(|(sum, count)| *sum += count);
        denied += expected.denied.len();
    }
    (counts, denied)
}

/// Hills, and errors on top that hardly grow with the level: blocks are often worse than the patches that they match.
fn rough(columns: u32, rows: u32) -> Arc<Heightmap> {
    let mut random = SplitMix64::new(5);
    let hills = terrain_dem::synthetic::generate(columns, rows, 3);
    let heights_m = hills.heights_m().iter().map(|height_m| height_m.round() + random.below(8) as f32);
    Arc::new(Heightmap::new(columns, rows, [30.0, 25.0], heights_m.collect()).unwrap())
}

/// A walk with jumps, then a flight in small steps across the DEM and beyond its rim.
fn views(heightmap: &Heightmap, seed: u64) -> impl Iterator<Item = View> {
    let [x_m, z_m] = heightmap.extent_m();
    let mut random = SplitMix64::new(seed);
    let flight = (0..60).map(move |frame| {
        let way = frame as f64 / 50.0 + random.range(-0.005, 0.005);
        let camera = Camera { eye_world: [way * x_m, 90.0, (1.0 - way) * z_m].into(), heading: 1.0, pitch: -0.1 };
        View::new(&camera, &RandomWalk::LENS).unwrap()
    });
    RandomWalk::new(seed, heightmap).take(40).chain(flight)
}

/// Whole cells, and DEMs that cells cross the rim of.
#[test]
fn what_is_followed_is_what_the_definition_says() {
    let mut sums = [0; 3];
    for (seed, (k, layers)) in [(2, 2), (2, 4), (2, 6), (3, 3), (3, 4), (4, 3), (5, 2)].into_iter().enumerate() {
        for (columns, rows) in [(82, 82), (129, 97), (64, 130)] {
            let heightmap = rough(columns, rows);
            for (metric, tolerance_px) in
                [(LevelMetric::Error, 2.0), (LevelMetric::Error, 6.0), (LevelMetric::Distance, 1.0)]
            {
                let batching = Batching::Instanced;
                let options = Options { k, layers, metric, tolerance_px, leg_px: 40.0, batching, ..Options::default() };
                let method = Htp::new(heightmap.clone(), options).unwrap();
                let at = format!("seed {seed}, {columns} x {rows}, {options:?}");
                let (counts, _) = follow(method, views(&heightmap, seed as u64), &at);
                sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            }
        }
    }

    assert!(sums[0] > 1000 && sums[1] > 1000 && sums[2] > 5, "restriction, round 1 and later: {sums:?}");
}

#[test]
fn what_is_followed_in_a_window_is_what_the_definition_says() {
    let (mut sums, mut all_denied) = ([0; 3], 0);
    for (seed, (k, layers)) in [(2, 3), (2, 4), (3, 3), (4, 2)].into_iter().enumerate() {
        for (columns, rows) in [(129, 161), (150, 118)] {
            let heightmap = rough(columns, rows);
            for (window, tolerance_px) in [(2, 3.0), (3, 6.0), (5, 2.0), (5, 6.0)] {
                let batching = Batching::Instanced;
                let metric = LevelMetric::Error;
                let options = Options { k, layers, metric, tolerance_px, batching, ..Options::default() };
                let method = streamed(&heightmap, options, cells(&heightmap, &options).min(window));
                let at = format!("seed {seed}, {columns} x {rows}, window {window}, {options:?}");
                let (counts, denied) = follow(method, views(&heightmap, seed as u64), &at);
                sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
                all_denied += denied;
            }
        }
    }

    assert!(sums[0] > 50 && sums[1] > 20 && all_denied > 20, "{sums:?}, {all_denied} denied");
}
