//! The live schedule under random delays of the worker: every frame is whole, whatever has finished.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use terrain_core::walk::RandomWalk;
use terrain_core::{FramePlan, Heightmap, LodMethod, SplitMix64, contract};
use terrain_dem::synthetic;

use crate::{EdgePolicy, IndexStore, Options, Schedule, Selector, Tin};

/// Up to 2 ms, by lot; often none.
fn random_delay() {
    static STATE: AtomicU64 = AtomicU64::new(0);
    let lot = SplitMix64::mix(STATE.fetch_add(1, Ordering::Relaxed));
    if lot.is_multiple_of(3) {
        std::thread::sleep(Duration::from_micros(lot >> 32 & 2047));
    }
}

fn live(dem: &Arc<Heightmap>, options: Options) -> Tin {
    Tin::with_delays(dem.clone(), Options { schedule: Schedule::Live, ..options }, random_delay).unwrap()
}

#[test]
fn every_frame_is_whole_with_updates_half_done() {
    let dem = Arc::new(synthetic::generate(150, 131, 4));
    let (matched, paper) = (EdgePolicy::Matched, EdgePolicy::Paper);
    let (algorithm1, bounded) = (Selector::Algorithm1, Selector::Bounded);
    let cases = [(1, matched, algorithm1), (2, paper, algorithm1), (8, matched, algorithm1), (2, matched, bounded)];
    for (threads, edge_policy, selector) in cases {
        let options = Options { patch: 8, threads, edge_policy, selector, ..Default::default() };
        contract::check_live(&dem, Box::new(live(&dem, options)), threads as u64, 1_000);
    }
}

/// Plans the same view until nothing is stale.
fn settle(tin: &mut Tin, view: &terrain_core::View, plan: &mut FramePlan) {
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
    for edge_policy in [EdgePolicy::Matched, EdgePolicy::Paper] {
        // Fixed rooms: equal draws are equal triangles, in whatever order the updates came.
        let (selector, index_store) = (Selector::Algorithm1, IndexStore::Fixed);
        let options = Options { patch: 16, edge_policy, selector, index_store, ..Default::default() };
        for view in RandomWalk::new(8, &dem).step_by(20).take(10) {
            let (mut waits, mut races) = (Tin::new(dem.clone(), options).unwrap(), live(&dem, options));
            let (mut expected, mut plan) = (FramePlan::default(), FramePlan::default());
            waits.plan(&view, &mut expected);
            settle(&mut races, &view, &mut plan);
            assert_eq!(plan.draws, expected.draws, "{edge_policy:?}");
        }
    }
}

#[test]
fn a_method_that_is_dropped_in_the_middle_of_an_update_ends_its_worker() {
    let dem = Arc::new(synthetic::generate(97, 97, 1));
    for view in RandomWalk::new(5, &dem).take(50) {
        let mut tin = live(&dem, Options { patch: 8, ..Default::default() });
        tin.plan(&view, &mut FramePlan::default());
    }
}
