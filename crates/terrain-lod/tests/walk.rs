//! 2,000 frames of a seeded random walk for each method: the whole contract in every frame, cracks first of all.

use std::sync::Arc;

use htp_lod::{Batching, Htp};
use lod_baselines::FullGrid;
use terrain_core::contract::{self, Build};
use terrain_core::{Heightmap, LodMethod};
use terrain_dem::synthetic;
use tin_lod::Tin;

const FRAMES: u32 = 2_000;

fn walk(build: impl Fn(&Arc<Heightmap>, Build) -> Box<dyn LodMethod>) {
    let heightmap = Arc::new(synthetic::generate(193, 250, 7));
    contract::check(&heightmap, |b| build(&heightmap, b), 2026, FRAMES);
}

#[test]
fn tin() {
    walk(|heightmap, Build { culling, threads }| {
        let options = tin_lod::Options { culling, threads, ..Default::default() };
        Box::new(Tin::new(heightmap.clone(), options).unwrap())
    });
}

fn htp(batching: Batching) {
    walk(|heightmap, Build { culling, .. }| {
        let options = htp_lod::Options { culling, batching, ..Default::default() };
        Box::new(Htp::new(heightmap.clone(), options).unwrap())
    });
}

#[test]
fn htp_per_patch() {
    htp(Batching::PerPatch);
}

#[test]
fn htp_instanced() {
    htp(Batching::Instanced);
}

#[test]
fn full_grid() {
    walk(|heightmap, _| Box::new(FullGrid::new(heightmap)));
}
