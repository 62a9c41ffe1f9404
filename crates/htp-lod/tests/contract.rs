//! Both batchings keep the contract of all methods, on DEMs that are no multiple of a cell.

use htp_lod::{Batching, Htp, Options};
use std::sync::Arc;
use terrain_core::contract::{self, Build};
use terrain_core::{Heightmap, LodMethod, SplitMix64};

/// Hills with a little noise.
fn hills(columns: u32, rows: u32, spacing_m: [f64; 2]) -> Heightmap {
    let mut random = SplitMix64::new(columns as u64);
    let mut height = |column: u32, row: u32| {
        let (x, z) = (column as f64 / 17.0, row as f64 / 23.0);
        (80.0 * (x.sin() + z.cos()) + random.range(0.0, 10.0)) as f32
    };
    let heights = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
    let heights = heights.map(|(column, row)| height(column, row)).collect();
    Heightmap::new(columns, rows, spacing_m, heights).unwrap()
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
    check(hills(82, 109, [30.0, 30.0]), Options::default(), 60);
}

#[test]
fn dems_that_are_no_multiple_of_a_cell() {
    check(hills(193, 250, [30.0, 25.0]), Options::default(), 30);
    check(hills(30, 31, [10.0, 10.0]), Options { k: 5, ..Options::default() }, 60);
    check(hills(54, 29, [10.0, 40.0]), Options { k: 4, layers: 4, leg_px: 20.0, ..Options::default() }, 60);
    check(hills(2, 9, [100.0, 100.0]), Options { k: 7, layers: 2, ..Options::default() }, 60);
}

#[test]
fn many_and_few_layers() {
    check(hills(97, 70, [30.0, 30.0]), Options { k: 2, layers: 6, ..Options::default() }, 60);
    check(hills(70, 97, [30.0, 30.0]), Options { k: 8, layers: 1, ..Options::default() }, 60);
}
