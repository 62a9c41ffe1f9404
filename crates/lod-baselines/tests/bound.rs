//! The tolerance bounds the error at every sample of the DEM, in view or not, for the methods that say so.

use lod_baselines::{Geomipmap, Rqt};
use terrain_core::error::ErrorOracle;
use terrain_core::walk::RandomWalk;
use terrain_core::{FramePlan, Heightmap, LodMethod, MeshMirror, Sample, View};
use terrain_dem::synthetic;

/// Over all samples, and how many triangles were drawn.
fn largest_px(dem: &Heightmap, oracle: &ErrorOracle, view: &View) -> f64 {
    let error_px = |(i, deviation_m): (usize, f32)| {
        assert!(!deviation_m.is_nan(), "sample {i} is not covered");
        let at = Sample { column: i as u32 % dem.columns(), row: i as u32 / dem.columns() };
        let distance_m = view.eye_world.distance(dem.world(at).into());
        if deviation_m == 0.0 { 0.0 } else { view.pixels(deviation_m as f64, distance_m) }
    };
    oracle.deviations_m().enumerate().map(error_px).fold(0.0, f64::max)
}

/// Walks over a DEM; the error must stay within the tolerance and come near it.
fn check(dem: &Heightmap, mut method: impl LodMethod, tolerance_px: f64, seed: u64) {
    method.set_culling(false);
    let mut mirror = MeshMirror::new(&method.buffers(), dem);
    let mut oracle = ErrorOracle::new(dem);
    let (mut plan, mut largest, mut fewest) = (FramePlan::default(), 0.0_f64, usize::MAX);
    for (frame, view) in RandomWalk::new(seed, dem).take(60).enumerate() {
        method.plan(&view, &mut plan);
        if mirror.replay(&plan).unwrap() {
            oracle.set_mesh(mirror.triangles());
        }
        let error_px = largest_px(dem, &oracle, &view);
        assert!(error_px <= tolerance_px * 1.00001, "{tolerance_px} px, seed {seed}, frame {frame}: {error_px} px");
        (largest, fewest) = (largest.max(error_px), fewest.min(mirror.triangles().len()));
    }
    let full_grid = 2 * (dem.columns() as usize - 1) * (dem.rows() as usize - 1);
    assert!(largest > 0.5 * tolerance_px && fewest < full_grid / 2, "{largest} px, {fewest} triangles: no use");
}

#[test]
fn of_rqt() {
    for [columns, rows] in [[129, 129], [130, 99], [60, 200]] {
        let dem = synthetic::generate(columns, rows, 7);
        for tolerance_px in [1.0, 4.0, 30.0] {
            check(&dem, Rqt::new(&dem, tolerance_px).unwrap(), tolerance_px, columns as u64);
        }
    }
}

/// Wide, for enough blocks that levels differ.
#[test]
fn of_geomipmap() {
    for [columns, rows] in [[257, 257], [300, 170]] {
        let dem = synthetic::generate(columns, rows, 7);
        for tolerance_px in [4.0, 10.0, 30.0] {
            check(&dem, Geomipmap::new(&dem, tolerance_px).unwrap(), tolerance_px, columns as u64);
        }
    }
}
