//! All baselines keep the contract of all methods, culled and whole, on DEMs of awkward shapes too.

use lod_baselines::{Decimated, Geomipmap, Rqt};
use terrain_core::{Heightmap, LodMethod, contract};

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
