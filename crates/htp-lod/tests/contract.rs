//! Both batchings keep the contract of all methods, on DEMs that are no multiple of a cell.

use htp_lod::{Batching, Htp, Options};
use std::sync::Arc;
use terrain_core::contract::{self, Build};
use terrain_core::{Heightmap, LodMethod};

/// Synthetic terrain with a spacing of its own.
fn terrain(columns: u32, rows: u32, spacing_m: [f64; 2]) -> Heightmap {
    let heights_m = terrain_dem::synthetic::generate(columns, rows, 5).heights_m().to_vec();
    Heightmap::new(columns, rows, spacing_m, heights_m).unwrap()
}

fn check(heightmap: Heightmap, options: Options, frames: u32) {
    let heightmap = Arc::new(heightmap);
    for batching in [Batching::PerPatch, Batching::Instanced] {
        let build = |Build { culling, .. }: Build| -> Box<dyn LodMethod> {
            Box::new(Htp::new(heightmap.clone(), Options { batching, culling, ..options }).unwrap())
        };
        contract::check(&heightmap, build, options.k as u64, frames);
    }
}

#[test]
fn the_papers_setting_on_whole_cells() {
    check(terrain(82, 109, [30.0, 30.0]), Options::default(), 60);
}

#[test]
fn dems_that_are_no_multiple_of_a_cell() {
    check(terrain(193, 250, [30.0, 25.0]), Options::default(), 30);
    check(terrain(30, 31, [10.0, 10.0]), Options { k: 5, ..Options::default() }, 60);
    check(terrain(54, 29, [10.0, 40.0]), Options { k: 4, layers: 4, leg_px: 20.0, ..Options::default() }, 60);
    check(terrain(2, 9, [100.0, 100.0]), Options { k: 7, layers: 2, ..Options::default() }, 60);
}

/// With a remainder that leaves one step of a finest patch, strips along the rim lose triangles in most frames.
#[test]
fn many_layers_and_strips_that_vanish_at_the_rim() {
    check(terrain(97, 70, [30.0, 30.0]), Options { k: 2, layers: 6, ..Options::default() }, 60);
    check(terrain(134, 115, [80.0, 80.0]), Options::default(), 60);
}

#[test]
fn many_and_few_layers() {
    check(terrain(97, 65, [30.0, 30.0]), Options { k: 2, layers: 6, ..Options::default() }, 60);
    check(terrain(70, 97, [30.0, 30.0]), Options { k: 8, layers: 1, ..Options::default() }, 60);
}
