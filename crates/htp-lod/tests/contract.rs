//! All batchings keep the contract of all methods, on DEMs that are no multiple of a cell. The legs are as long as it
//! takes for all layers to be in sight on DEMs as small as these.

mod seen;

use htp_lod::{Batching, Htp, LevelMetric, Options};
use seen::{ALL_LISTS, LISTS_BY_DISTANCE};
use std::sync::Arc;
use terrain_core::{Heightmap, LodMethod, contract};

/// Synthetic terrain with a spacing of its own.
fn terrain(columns: u32, rows: u32, spacing_m: [f64; 2]) -> Heightmap {
    let heights_m = terrain_dem::synthetic::generate(columns, rows, 5).heights_m().to_vec();
    Heightmap::new(columns, rows, spacing_m, heights_m).unwrap()
}

/// Checks a walk that must show all layers and so many of the 8 index lists.
fn check(heightmap: Heightmap, options: Options, frames: u32, lists: usize) {
    let (heightmap, seed) = (Arc::new(heightmap), options.k as u64);
    let seen = seen::levels_and_lists(&heightmap, options, seed, frames);
    assert_eq!(seen, [options.layers as usize, lists], "levels and index lists in sight");
    for batching in [Batching::PerPatch, Batching::MergedCell, Batching::Instanced] {
        let build = |_threads| -> Box<dyn LodMethod> {
            Box::new(Htp::new(heightmap.clone(), Options { batching, ..options }).unwrap())
        };
        contract::check(&heightmap, build, seed, frames);
    }
}

/// By error, with tolerances at which all layers and nearly all lists are in sight on DEMs as small as these.
#[test]
fn levels_by_error() {
    let by_error = |k: u32, layers: u32, tolerance_px: f64| Options {
        k,
        layers,
        metric: LevelMetric::Error,
        tolerance_px,
        ..Options::default()
    };
    check(terrain(97, 70, [30.0, 25.0]), by_error(2, 5, 60.0), 80, ALL_LISTS);
    check(terrain(134, 115, [30.0, 25.0]), by_error(3, 3, 6.0), 80, ALL_LISTS);
    check(terrain(97, 130, [30.0, 25.0]), by_error(4, 2, 16.0), 80, 6);
}

#[test]
fn levels_by_box() {
    let options = Options { metric: LevelMetric::Box, ..options(3, 3, 30.0) };
    check(terrain(193, 250, [30.0, 25.0]), options, 30, LISTS_BY_DISTANCE);
}

/// Levels that glide into one another: all that share a vertex agree on its height, whatever the mix of levels. The last
/// two have rings that are narrower than a patch, so that corners glide while finer patches are drawn beside them.
#[test]
fn levels_that_glide_share_the_heights_of_their_vertices() {
    let check = |heightmap: Heightmap, options: Options, frames: u32, lists: usize| {
        let (heightmap, seed) = (Arc::new(heightmap), options.k as u64);
        let seen = seen::levels_and_lists(&heightmap, options, seed, frames);
        assert_eq!(seen, [options.layers as usize, lists], "levels and index lists in sight");
        let options = Options { batching: Batching::Instanced, geomorph: true, ..options };
        let build = |_threads| -> Box<dyn LodMethod> { Box::new(Htp::new(heightmap.clone(), options).unwrap()) };
        contract::check_morphed(&heightmap, build, seed, frames, options.k.pow(options.layers - 1));
    };
    check(terrain(193, 250, [30.0, 25.0]), options(3, 3, 30.0), 30, LISTS_BY_DISTANCE);
    check(terrain(54, 29, [10.0, 40.0]), options(4, 2, 600.0), 60, LISTS_BY_DISTANCE);
    check(terrain(97, 70, [30.0, 30.0]), options(2, 6, 350.0), 60, ALL_LISTS);
    check(terrain(134, 115, [80.0, 80.0]), options(3, 3, 45.0), 60, LISTS_BY_DISTANCE);
}

fn options(k: u32, layers: u32, leg_px: f64) -> Options {
    Options { k, layers, leg_px, ..Options::default() }
}

#[test]
fn the_papers_setting_on_whole_cells() {
    check(terrain(82, 109, [30.0, 30.0]), options(3, 3, 60.0), 60, LISTS_BY_DISTANCE);
}

#[test]
fn dems_that_are_no_multiple_of_a_cell() {
    check(terrain(193, 250, [30.0, 25.0]), options(3, 3, 30.0), 30, LISTS_BY_DISTANCE);
    check(terrain(54, 29, [10.0, 40.0]), options(4, 2, 600.0), 60, LISTS_BY_DISTANCE);
}

/// Too small for all blocks, or for any.
#[test]
fn dems_of_hardly_a_cell() {
    check(terrain(30, 31, [10.0, 10.0]), options(5, 2, 200.0), 60, 3);
    check(terrain(2, 9, [100.0, 100.0]), options(7, 2, 20_000.0), 60, 1);
}

/// Six layers whose rings are narrower than a patch keep the restriction busy. With a remainder that leaves one step of
/// a finest patch, strips along the rim lose triangles in most frames.
#[test]
fn many_layers_and_strips_that_vanish_at_the_rim() {
    check(terrain(97, 70, [30.0, 30.0]), options(2, 6, 350.0), 60, ALL_LISTS);
    check(terrain(97, 65, [30.0, 30.0]), options(2, 6, 350.0), 60, ALL_LISTS);
    check(terrain(134, 115, [80.0, 80.0]), options(3, 3, 45.0), 60, LISTS_BY_DISTANCE);
}

#[test]
fn few_layers() {
    check(terrain(70, 97, [30.0, 30.0]), options(8, 2, 250.0), 100, LISTS_BY_DISTANCE);
    check(terrain(70, 97, [30.0, 30.0]), options(8, 1, 8.0), 60, 1);
}
