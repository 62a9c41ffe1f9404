//! The tolerance as a bound: the error of every sample of the DEM, in view or not, judged by the oracle from the plan's
//! own bytes.

use super::*;
use std::path::Path;
use terrain_core::error::ErrorOracle;
use terrain_core::walk::RandomWalk;
use terrain_core::{MeshMirror, Sample, SplitMix64};
use terrain_dem::ReadOptions;

/// The largest error of all samples in pixels.
pub(super) fn largest_error_px(heightmap: &Heightmap, oracle: &ErrorOracle, view: &View) -> f64 {
    let mut largest = 0.0_f64;
    for (i, deviation_m) in oracle.deviations_m().enumerate() {
        let [column, row] = [i as u32 % heightmap.columns(), i as u32 / heightmap.columns()];
        let [x, y, z] = heightmap.world(Sample { column, row });
        let distance_m = view.eye_world.distance([x, y, z].into());
        assert!(!deviation_m.is_nan(), "nothing covers column {column}, row {row}");
        if deviation_m > 0.0 {
            largest = largest.max(view.pixels(deviation_m as f64, distance_m));
        }
    }
    largest
}

/// The largest error over tolerance in a walk, with and without repair of the blocks that are too bad.
fn walk(heightmap: &Arc<Heightmap>, options: Options, seed: u64, frames: usize) -> [f64; 2] {
    let mut method = Htp::new(heightmap.clone(), Options { metric: LevelMetric::Error, ..options }).unwrap();
    method.set_culling(false);
    let mut mirror = MeshMirror::new(&method.buffers(), heightmap);
    let (mut oracle, mut plan, mut worst) = (ErrorOracle::new(heightmap), FramePlan::default(), [0.0_f64; 2]);
    for view in RandomWalk::new(seed, heightmap).take(frames) {
        for (repair, worst) in [true, false].into_iter().zip(&mut worst) {
            plan.clear();
            method.initialise(&mut plan);
            let rule = Rule::new(&method.options, &method.grid, method.errors.as_ref(), &view);
            method.levels.forget();
            if repair {
                method.levels.follow(&rule, &view);
            } else {
                method.levels.choose(&method.grid, |square| rule.wish(method.grid.spot(square)));
            }
            method.select_patches(&view);
            method.merge_vertex_buffers(&mut plan);
            method.render(&mut plan);
            mirror.replay(&plan).unwrap();
            oracle.set_mesh(mirror.triangles());
            *worst = worst.max(largest_error_px(heightmap, &oracle, &view) / options.tolerance_px);
        }
    }
    worst
}

fn smooth(columns: u32, rows: u32) -> (u32, u32, Vec<f32>) {
    (columns, rows, terrain_dem::synthetic::generate(columns, rows, 3).heights_m().to_vec())
}

/// Errors that hardly grow with the level: blocks are often worse than the patches that they match.
fn noise(columns: u32, rows: u32) -> (u32, u32, Vec<f32>) {
    let mut random = SplitMix64::new(5);
    (columns, rows, (0..columns * rows).map(|_| random.range(0.0, 15.0) as f32).collect())
}

#[test]
fn no_sample_of_synthetic_dems_is_farther_off_than_the_tolerance() {
    let mut without_repair = [0.0_f64; 6];
    for (columns, rows, heights_m) in [smooth(129, 97), smooth(82, 82), noise(64, 130)] {
        let heightmap = Arc::new(Heightmap::new(columns, rows, [30.0, 25.0], heights_m).unwrap());
        for (k, layers) in [(2, 2), (2, 4), (2, 6), (3, 2), (3, 4), (4, 3), (5, 2), (5, 3)] {
            for tolerance_px in [0.5, 1.0, 2.0, 4.0] {
                let options = Options { k, layers, tolerance_px, batching: Batching::Instanced, ..Options::default() };
                let [bounded, unrepaired] = walk(&heightmap, options, k as u64, 12);
                assert!(bounded <= 1.0 + 1e-6, "{columns} x {rows}, {options:?}: {bounded} times the tolerance");
                without_repair[k as usize] = without_repair[k as usize].max(unrepaired);
            }
        }
    }
    // The repair is what makes it a bound, though on DEMs as small as these only where there are many patches.
    assert!(without_repair[2] > 1.0, "{without_repair:?}");
}

/// A DEM that lies beside the project on some machines; without it the test says so and goes on.
fn shared(name: &str, spacing_m: f64) -> Option<Arc<Heightmap>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/dem").join(name);
    if !path.is_file() {
        eprintln!("skipped: {} is not on this machine", path.display());
        return None;
    }
    let options = ReadOptions { spacing_m: Some([spacing_m; 2]), scale: Some(0.1), ..Default::default() };
    Some(terrain_dem::read(&path, &options).unwrap().heightmap)
}

#[test]
fn no_sample_of_real_dems_is_farther_off_than_the_tolerance() {
    let dems = [("ps_1025.png", 160.0, 2), ("sthelens_30m_native.png", 30.0, 6), ("ps_257_crop_rainier.png", 160.0, 8)];
    let mut without_repair = 0.0_f64;
    for (name, spacing_m, frames) in dems {
        let Some(heightmap) = shared(name, spacing_m) else { continue };
        for (k, layers, tolerance_px) in [(2, 6, 2.0), (2, 4, 4.0), (3, 4, 1.0), (3, 3, 4.0), (4, 3, 0.5), (5, 3, 2.0)]
        {
            let options = Options { k, layers, tolerance_px, batching: Batching::Instanced, ..Options::default() };
            let [bounded, unrepaired] = walk(&heightmap, options, k as u64, frames);
            assert!(bounded <= 1.0 + 1e-6, "{name}, {options:?}: {bounded} times the tolerance");
            without_repair = without_repair.max(if k == 3 { unrepaired } else { 0.0 });
        }
        assert!(without_repair > 1.0, "the repair is what makes it a bound: {without_repair}");
    }
}
