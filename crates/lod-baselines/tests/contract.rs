//! All baselines keep the contract of all methods, culled and whole, on DEMs of awkward shapes too.

use std::collections::BTreeSet;
use std::sync::Arc;

use lod_baselines::{Decimated, Geomipmap, Greedy, Rqt};
use terrain_core::walk::RandomWalk;
use terrain_core::{FramePlan, Heightmap, LodMethod, contract};

/// Synthetic terrain with a spacing of its own.
fn terrain(columns: u32, rows: u32, spacing_m: [f64; 2]) -> Heightmap {
    let heights_m = terrain_dem::synthetic::generate(columns, rows, 5).heights_m().to_vec();
    Heightmap::new(columns, rows, spacing_m, heights_m).unwrap()
}

/// Strips, sizes of powers of two and their neighbours, and sizes between.
const SHAPES: [[u32; 2]; 12] =
    [[2, 2], [3, 2], [2, 70], [70, 3], [9, 8], [17, 17], [33, 32], [34, 65], [66, 31], [97, 70], [129, 129], [130, 99]];

fn check(build: impl Fn(&Heightmap) -> Box<dyn LodMethod>, frames: u32) {
    for [columns, rows] in SHAPES {
        let dem = terrain(columns, rows, [30.0, 25.0]);
        contract::check(&dem, |_threads| build(&dem), (columns * rows) as u64, frames);
    }
}

#[test]
fn decimated_by_any_step() {
    for step in [1, 2, 3, 8, 64, 200] {
        check(|dem| Box::new(Decimated::new(dem, step).unwrap()), 20);
    }
}

#[test]
fn greedy_at_tolerances_from_all_samples_to_hardly_any() {
    for tolerance_px in [0.01, 1.0, 1e4] {
        check(|dem| Box::new(Greedy::new(Arc::new(dem.clone()), tolerance_px, 2e3).unwrap()), 10);
    }
}

#[test]
fn rqt_at_tolerances_from_all_samples_to_hardly_any() {
    for tolerance_px in [0.01, 1.0, 20.0, 1e4] {
        check(|dem| Box::new(Rqt::new(dem, tolerance_px).unwrap()), 30);
    }
}

#[test]
fn geomipmap_at_tolerances_from_all_samples_to_hardly_any() {
    for tolerance_px in [0.01, 1.0, 20.0, 200.0, 1e4] {
        check(|dem| Box::new(Geomipmap::new(dem, tolerance_px).unwrap()), 30);
    }
}

/// There are 81 lists for whole blocks, and most need several blocks of differing levels around one. `lists.rs` proves
/// each of them; here blocks meet.
#[test]
fn most_lists_of_geomipmap_are_drawn_and_keep_the_contract() {
    let dem = terrain(257, 257, [30.0, 25.0]);
    let mut lists = BTreeSet::new();
    for tolerance_px in [3.0, 15.0, 60.0] {
        let (seed, frames) = (3, 80);
        contract::check(&dem, |_threads| Box::new(Geomipmap::new(&dem, tolerance_px).unwrap()), seed, frames);
        let mut method = Geomipmap::new(&dem, tolerance_px).unwrap();
        let mut plan = FramePlan::default();
        for view in RandomWalk::new(seed, &dem).take(frames as usize) {
            method.plan(&view, &mut plan);
            lists.extend(plan.draws.iter().map(|draw| (draw.instances.start % 16, draw.indices.start)));
        }
    }
    assert!(lists.len() > 40, "{} lists: {lists:?}", lists.len());
    let levels: BTreeSet<u32> = lists.into_iter().map(|(level, _)| level).collect();
    assert_eq!(levels, BTreeSet::from([0, 1, 2, 3, 4, 5]));
}
