//! 2,000 frames of a seeded random walk for each method: the whole contract in every frame, cracks first of all.

#[path = "../../htp-lod/tests/seen/mod.rs"]
mod seen;

use std::sync::Arc;

use htp_lod::{Batching, Htp};
use lod_baselines::{Decimated, FullGrid, Geomipmap, Rqt};
use terrain_core::{Heightmap, LodMethod, contract};
use terrain_dem::synthetic;
use tin_lod::{Selector, Tin};

const FRAMES: u32 = 2_000;
const SEED: u64 = 2026;

fn dem() -> Arc<Heightmap> {
    Arc::new(synthetic::generate(193, 250, 7))
}

fn walk(build: impl Fn(&Arc<Heightmap>, usize) -> Box<dyn LodMethod>) {
    let heightmap = dem();
    contract::check(&heightmap, |threads| build(&heightmap, threads), SEED, FRAMES);
}

fn tin(selector: Selector) {
    walk(|heightmap, threads| {
        let options = tin_lod::Options { threads, selector, ..Default::default() };
        Box::new(Tin::new(heightmap.clone(), options).unwrap())
    });
}

#[test]
fn tin_algorithm1() {
    tin(Selector::Algorithm1);
}

#[test]
fn tin_bounded() {
    tin(Selector::Bounded);
}

/// With legs so long that all three layers are in sight on so small a DEM, and so many of the 8 index lists.
fn htp(batching: Batching, leg_px: f64, lists: usize) {
    let options = htp_lod::Options { batching, leg_px, ..Default::default() };
    assert_eq!(seen::levels_and_lists(&dem(), options, SEED, FRAMES), [3, lists], "levels and index lists in sight");
    walk(|heightmap, _| Box::new(Htp::new(heightmap.clone(), options).unwrap()));
}

#[test]
fn htp_per_patch() {
    htp(Batching::PerPatch, 30.0, seen::LISTS_BY_DISTANCE);
}

#[test]
fn htp_instanced() {
    htp(Batching::Instanced, 30.0, seen::LISTS_BY_DISTANCE);
}

/// Legs so long that the restriction has work to do.
#[test]
fn htp_per_patch_with_all_matching_blocks() {
    htp(Batching::PerPatch, 300.0, seen::ALL_LISTS);
}

#[test]
fn htp_instanced_with_all_matching_blocks() {
    htp(Batching::Instanced, 300.0, seen::ALL_LISTS);
}

#[test]
fn htp_merged_cells_with_all_matching_blocks() {
    htp(Batching::MergedCell, 300.0, seen::ALL_LISTS);
}

#[test]
fn htp_by_error() {
    let options = htp_lod::Options { tolerance_px: 4.0, ..htp_lod::Options::bounded() };
    assert_eq!(seen::levels_and_lists(&dem(), options, SEED, FRAMES), [4, seen::ALL_LISTS]);
    walk(|heightmap, _| Box::new(Htp::new(heightmap.clone(), options).unwrap()));
}

#[test]
fn full_grid() {
    walk(|heightmap, _| Box::new(FullGrid::new(heightmap)));
}

#[test]
fn decimated() {
    walk(|heightmap, _| Box::new(Decimated::new(heightmap, 4).unwrap()));
}

#[test]
fn rqt() {
    walk(|heightmap, _| Box::new(Rqt::new(heightmap, 1.0).unwrap()));
}

#[test]
fn geomipmap() {
    walk(|heightmap, _| Box::new(Geomipmap::new(heightmap, 8.0).unwrap()));
}
