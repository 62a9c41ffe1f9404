//! The live schedule under random delays of the worker: every frame is whole, whatever has finished.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use terrain_core::walk::RandomWalk;
use terrain_core::{BufferSizes, FramePlan, Heightmap, LodMethod, SplitMix64, Upload, View, contract};
use terrain_dem::synthetic;

use crate::mesh::Update;
use crate::worker::HandOver;
use crate::{EdgePolicy, IndexStore, Options, Schedule, Selector, Tin};

/// Up to 2 ms, by lot; often none.
fn random_delay() {
    static STATE: AtomicU64 = AtomicU64::new(0);
    let lot = SplitMix64::mix(STATE.fetch_add(1, Ordering::Relaxed));
    if lot.is_multiple_of(3) {
        std::thread::sleep(Duration::from_micros(lot >> 32 & 2047));
    }
}

fn with_delays(update: Update, pass_on: &mut dyn FnMut(Update)) {
    random_delay();
    pass_on(update);
}

fn live(dem: &Arc<Heightmap>, options: Options) -> Tin {
    live_with(dem, options, with_delays)
}

fn live_with(dem: &Arc<Heightmap>, options: Options, hand_over: HandOver) -> Tin {
    Tin::with(dem.clone(), Options { schedule: Schedule::Live, ..options }, None, hand_over).unwrap()
}

/// A method with something around its plans.
struct Around<F> {
    tin: Tin,
    plan: F,
}

impl<F: FnMut(&mut Tin, &View, &mut FramePlan) + Send> LodMethod for Around<F> {
    fn name(&self) -> &'static str {
        self.tin.name()
    }

    fn buffers(&self) -> BufferSizes {
        self.tin.buffers()
    }

    fn set_culling(&mut self, culling: bool) {
        self.tin.set_culling(culling);
    }

    fn plan(&mut self, view: &View, plan: &mut FramePlan) {
        (self.plan)(&mut self.tin, view, plan);
    }
}

/// Frames that take about as long as updates do, so that all ways to meet come up. Counts those that draw some of the
/// updates for their view, and not all.
fn paced(tin: Tin, half_done: Arc<AtomicU64>) -> Box<dyn LodMethod> {
    let plan = move |tin: &mut Tin, view: &View, plan: &mut FramePlan| {
        random_delay();
        tin.plan(view, plan);
        let is_half_done = !plan.uploads.is_empty() && plan.stale_patches > 0;
        half_done.fetch_add(is_half_done.into(), Ordering::Relaxed);
    };
    Box::new(Around { tin, plan })
}

/// 20,250 frames in all, in three tests that run side by side: both selectors, and both edge policies where the selector
/// has them, over DEMs of different shapes. One frame in 20 teleports.
fn every_frame_is_whole(threads: usize) {
    let (matched, paper) = (EdgePolicy::Matched, EdgePolicy::Paper);
    let cases = [
        (97, 81, 8, matched, Selector::Algorithm1),
        (75, 110, 8, paper, Selector::Algorithm1),
        (120, 70, 16, matched, Selector::Bounded),
    ];
    for (columns, rows, patch, edge_policy, selector) in cases {
        let dem = Arc::new(synthetic::generate(columns, rows, threads as u64));
        let options = Options { patch, threads, edge_policy, selector, ..Default::default() };
        let (seed, half_done) = (10 * patch as u64 + threads as u64, Arc::default());
        contract::check_live(&dem, paced(live(&dem, options), Arc::clone(&half_done)), seed, 2_250);
        let half_done = half_done.load(Ordering::Relaxed);
        assert!(half_done > 0, "a worker that never is half done proves nothing: {options:?}");
    }
}

#[test]
fn every_frame_is_whole_with_updates_half_done_on_1_thread() {
    every_frame_is_whole(1);
}

#[test]
fn every_frame_is_whole_with_updates_half_done_on_2_threads() {
    every_frame_is_whole(2);
}

#[test]
fn every_frame_is_whole_with_updates_half_done_on_8_threads() {
    every_frame_is_whole(8);
}

/// Small patches over a small DEM: most updates change edges. Frames until the contract notices, however busy the machine
/// is: it needs a worker that has had a core.
fn check_a_mutant(mutant: impl Fn(&Arc<Heightmap>, Options) -> Box<dyn LodMethod>) {
    let dem = Arc::new(synthetic::generate(97, 81, 3));
    let options = Options { patch: 8, threads: 2, selector: Selector::Algorithm1, ..Default::default() };
    contract::check_live(&dem, mutant(&dem, options), 5, 100_000);
}

/// A mutant: patches of one update, every second of them later than the others.
fn in_two_halves(update: Update, pass_on: &mut dyn FnMut(Update)) {
    let (even, odd) = update.triangulated.into_iter().partition(|made| made.node % 2 == 0);
    pass_on(Update { triangulated: even, ..Default::default() });
    std::thread::sleep(Duration::from_millis(5));
    pass_on(Update { triangulated: odd, ..update });
}

#[test]
#[should_panic(expected = "tin, live, seed 5")]
fn the_contract_notices_an_update_in_two_halves() {
    check_a_mutant(|dem, options| paced(live_with(dem, options, in_two_halves), Arc::default()));
}

/// A mutant: the second half of the bytes of each write comes a frame late, but for the first frame's.
fn half_written(tin: Tin) -> Box<dyn LodMethod> {
    let (mut whole, mut late, mut is_first) = (FramePlan::default(), FramePlan::default(), true);
    let write = |to: &mut FramePlan, from: &FramePlan, upload: &Upload, bytes: Range<usize>| {
        to.upload(upload.buffer, upload.offset + bytes.start as u64, &from.bytes_of(upload)[bytes]);
    };
    let plan = move |tin: &mut Tin, view: &View, plan: &mut FramePlan| {
        random_delay();
        tin.plan(view, &mut whole);
        plan.clone_from(&whole);
        if std::mem::replace(&mut is_first, false) {
            return;
        }
        (plan.uploads, plan.bytes) = (std::mem::take(&mut late.uploads), std::mem::take(&mut late.bytes));
        for upload in &whole.uploads {
            let (half, all) = (upload.bytes.len() / 8 * 4, upload.bytes.len());
            write(plan, &whole, upload, 0..half);
            write(&mut late, &whole, upload, half..all);
        }
    };
    Box::new(Around { tin, plan })
}

#[test]
#[should_panic(expected = "tin, live, seed 5")]
fn the_contract_notices_a_region_half_written() {
    check_a_mutant(|dem, options| half_written(live(dem, options)));
}

/// Plans the same view until nothing is stale.
fn settle(tin: &mut Tin, view: &View, plan: &mut FramePlan) {
    let start = Instant::now();
    tin.plan(view, plan);
    while plan.stale_patches > 0 {
        assert!(start.elapsed() < Duration::from_secs(60), "the worker does not catch up");
        std::thread::sleep(Duration::from_millis(1));
        tin.plan(view, plan);
    }
}

#[test]
fn the_worker_catches_up_when_the_camera_rests() {
    let dem = Arc::new(synthetic::generate(193, 250, 7));
    let mut tin = live(&dem, Options { patch: 16, ..Default::default() });
    let (mut plan, mut stale) = (FramePlan::default(), 0);
    for (i, view) in RandomWalk::new(3, &dem).take(200).enumerate() {
        tin.plan(&view, &mut plan);
        stale += plan.stale_patches;
        if i % 50 == 49 {
            settle(&mut tin, &view, &mut plan);
        }
    }
    assert!(stale > 0, "a worker that is never behind is none");
}

/// A request in parts would leave the paper's edges between the parts as coarse as they began.
#[test]
fn a_worker_that_has_caught_up_draws_what_a_plan_that_waits_draws() {
    let dem = Arc::new(synthetic::generate(193, 250, 7));
    let (matched, paper) = (EdgePolicy::Matched, EdgePolicy::Paper);
    let (algorithm1, bounded) = (Selector::Algorithm1, Selector::Bounded);
    for (selector, edge_policy) in [(algorithm1, matched), (algorithm1, paper), (bounded, matched)] {
        // Fixed rooms: equal draws are equal triangles, in whatever order the updates came.
        let index_store = IndexStore::Fixed;
        let options = Options { patch: 16, edge_policy, selector, index_store, ..Default::default() };
        for view in RandomWalk::new(8, &dem).step_by(20).take(10) {
            let (mut waits, mut races) = (Tin::new(dem.clone(), options).unwrap(), live(&dem, options));
            let (mut expected, mut plan) = (FramePlan::default(), FramePlan::default());
            waits.plan(&view, &mut expected);
            settle(&mut races, &view, &mut plan);
            assert_eq!(plan.draws, expected.draws, "{options:?}");
        }
    }
}

#[test]
#[should_panic(expected = "the thread of the updates has panicked")]
fn a_worker_that_panics_does_not_leave_a_method_that_is_stale_for_ever() {
    let dem = Arc::new(synthetic::generate(97, 97, 1));
    let options = Options { patch: 8, ..Default::default() };
    let mut tin = live_with(&dem, options, |_, _| panic!("on purpose"));
    settle(&mut tin, &RandomWalk::new(5, &dem).next().unwrap(), &mut FramePlan::default());
}

#[test]
fn a_method_that_is_dropped_in_the_middle_of_an_update_ends_its_worker() {
    let dem = Arc::new(synthetic::generate(97, 97, 1));
    for view in RandomWalk::new(5, &dem).take(50) {
        let mut tin = live(&dem, Options { patch: 8, ..Default::default() });
        tin.plan(&view, &mut FramePlan::default());
    }
}
