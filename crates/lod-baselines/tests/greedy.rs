//! Greedy insertion is what bounded meshes are measured against (`tin-lod/benches/reference.rs`): it must be beyond doubt
//! itself. That its triangles are Delaunay is shown beside the triangulation.

use lod_baselines::GreedyInsertion;
use terrain_core::error::ErrorOracle;
use terrain_core::watertight::WatertightOracle;
use terrain_core::{Heightmap, SplitMix64};
use terrain_dem::synthetic;

/// The oracle's deviations are f32: it may see a deviation at the limit a ten-millionth above it. No other slack.
const ORACLE_ROUNDING: f64 = 1.000_000_1;

/// The deviations of all samples, in metres.
fn deviations_m(dem: &Heightmap, greedy: &GreedyInsertion) -> Vec<f32> {
    let mut oracle = ErrorOracle::new(dem);
    oracle.set_mesh(&greedy.triangles());
    let deviations_m: Vec<f32> = oracle.deviations_m().collect();
    assert!(deviations_m.iter().all(|d| !d.is_nan()), "a sample is not covered");
    deviations_m
}

/// Refines to each tolerance in turn, from the coarsest on, and checks bound and topology.
fn check(dem: &Heightmap, tolerances_m: &[f64]) {
    let mut greedy = GreedyInsertion::new(dem);
    let mut before = 0;
    for tolerance_m in tolerances_m {
        greedy.refine(*tolerance_m);
        let worst_m = deviations_m(dem, &greedy).into_iter().fold(0.0, f32::max) as f64;
        assert!(worst_m <= tolerance_m * ORACLE_ROUNDING, "{worst_m} m at {tolerance_m} m");
        let found = WatertightOracle::new(dem.columns(), dem.rows()).check(&greedy.triangles(), &[]);
        assert!(found.covers(dem.columns(), dem.rows()), "{found:?}");
        assert!(greedy.triangle_count() >= before);
        before = greedy.triangle_count();
    }
}

/// A DEM by a formula of column and row.
fn dem(columns: u32, rows: u32, mut height_m: impl FnMut(u32, u32) -> f64) -> Heightmap {
    let heights_m = (0..columns * rows).map(|i| height_m(i % columns, i / columns) as f32).collect();
    Heightmap::new(columns, rows, [30.0, 45.0], heights_m).unwrap()
}

#[test]
fn the_next_sample_is_the_worst_of_all() {
    for seed in 0..8 {
        let mut random = SplitMix64::new(seed);
        let dem = dem(19, 23, |x, z| (x * z) as f64 + random.range(0.0, 40.0));
        let mut greedy = GreedyInsertion::new(&dem);
        while let Some((sample, deviation_m)) = greedy.worst_sample() {
            let deviations_m = deviations_m(&dem, &greedy);
            let worst_m = deviations_m.iter().copied().fold(0.0, f32::max) as f64;
            let at_next_m = deviations_m[dem.index(sample) as usize] as f64;
            assert!((deviation_m - worst_m).abs() < 1e-5 && (at_next_m - worst_m).abs() < 1e-5, "seed {seed}");
            greedy.insert_worst();
            assert!(greedy.triangles().iter().any(|triangle| triangle.samples.contains(&sample)), "seed {seed}");
        }
        assert_eq!(greedy.triangle_count(), 2 * 18 * 22, "all samples are in");
    }
}

#[test]
fn meshes_are_watertight_delaunay_and_within_the_tolerance() {
    let dem = synthetic::generate(193, 150, 7);
    check(&dem, &[256.0, 64.0, 16.0, 4.0, 1.0, 0.01]);
    let mut greedy = GreedyInsertion::new(&dem);
    greedy.refine(10.0);
    assert!(greedy.triangle_count() > 500, "{} triangles", greedy.triangle_count());
}

/// Shapes that leave little room, and heights that put many samples on circles, or all but one on a plane.
#[test]
fn awkward_shapes_and_heights() {
    let mut random = SplitMix64::new(1);
    for (columns, rows) in [(2, 2), (2, 70), (70, 2), (3, 3), (9, 8), (31, 33), (66, 34)] {
        check(&dem(columns, rows, |_, _| random.range(0.0, 300.0)), &[1000.0, 10.0, 0.5]);
    }
    let heights: [fn(u32, u32) -> f64; 5] = [
        |_, _| -3.0,
        |x, z| if (x, z) == (20, 17) { 9000.0 } else { 0.0 },
        |x, z| if (x + z) % 2 == 0 { -1e4 } else { 1e4 },
        |x, z| x as f64 * 3.5 - z as f64,
        |x, z| ((x / 5 + z / 7) * 10) as f64,
    ];
    heights.into_iter().for_each(|height_m| check(&dem(70, 50, height_m), &[1000.0, 10.0, 0.5]));
}
