//! The meshes that come out: of random level mixes and of random views, judged in integers from the plan's own bytes.

use super::*;
use crate::blocks::{ALL_COLLAPSED, Side};
use crate::grid::Patch;
use std::collections::BTreeSet;
use terrain_core::walk::RandomWalk;
use terrain_core::watertight::{WatertightOracle, Watertightness};
use terrain_core::{MeshMirror, PatchInstance, Sample, SplitMix64};

fn rough(columns: u32, rows: u32) -> Arc<Heightmap> {
    let mut random = SplitMix64::new(columns as u64 * 70_000 + rows as u64);
    let heights = (0..columns * rows).map(|_| random.range(0.0, 300.0) as f32).collect();
    Arc::new(Heightmap::new(columns, rows, [100.0, 100.0], heights).unwrap())
}

fn htp(heightmap: &Arc<Heightmap>, k: u32, layers: u32, batching: Batching) -> Htp {
    let options = Options { k, layers, batching, ..Options::default() };
    let mut htp = Htp::new(heightmap.clone(), options).unwrap();
    htp.set_culling(false);
    htp
}

/// Halves that want to be split, drawn by lot for each patch; `seed` decides the share, too.
fn lot(seed: u64, square: Square) -> u8 {
    let hash = |salt: u64| SplitMix64::mix(seed ^ SplitMix64::mix(salt));
    let share = hash(0) % 100;
    let patch = |half: u64| hash(1 + half + 2 * square.level as u64 + 16 * square.column as u64) ^ square.row as u64;
    let split = |half: u64| (SplitMix64::mix(patch(half)) % 100 < share) as u8;
    split(0) | split(1) << 1
}

/// Draws a restricted mix of levels over the whole DEM and judges the mesh.
fn judge_mix(method: &mut Htp, mirror: &mut MeshMirror, size: [u32; 2], seed: u64) -> Watertightness {
    let mut plan = FramePlan::default();
    method.initialise(&mut plan);
    method.levels.choose(&method.grid, |square| lot(seed, square));
    leaves::collect(&method.grid, &method.levels, None, &mut method.leaves);
    method.render(&mut plan);
    mirror.replay(&plan).unwrap();
    WatertightOracle::new(size[0], size[1]).check(mirror.triangles(), mirror.degenerate())
}

const SIZES: [[u32; 2]; 7] = [[317, 460], [193, 250], [28, 28], [30, 31], [54, 29], [2, 2], [2, 9]];

/// Judges random mixes on DEMs of all sizes with many k, and passes each verdict on.
fn for_all_mixes(lockstep: bool, mut verdict: impl FnMut(&Htp, [u32; 2], u64, Watertightness)) {
    for size in SIZES {
        let heightmap = rough(size[0], size[1]);
        for (k, layers) in [2, 3, 4, 5, 7].into_iter().flat_map(|k| (2..=4).map(move |layers| (k, layers))) {
            let mut method = htp(&heightmap, k, layers, Batching::Instanced);
            if !lockstep {
                // Every square passes for one that does not cross the rim.
                method.grid.layers.iter_mut().for_each(|layer| layer.inside = [u32::MAX; 2]);
            }
            // Without lockstep there can be more leaves than finest patches.
            let sizes = method.buffers();
            let sizes = BufferSizes { instances: 2 * sizes.instances, ..sizes };
            let mut mirror = MeshMirror::new(&sizes, &heightmap);
            for seed in 0..if size[0] > 100 { 3 } else { 40 } {
                let found = judge_mix(&mut method, &mut mirror, size, seed);
                verdict(&method, size, seed, found);
            }
        }
    }
}

#[test]
fn restricted_mixes_are_watertight_on_dems_of_any_size() {
    let mut masks = [0; 8];
    for_all_mixes(true, |method, size, seed, found| {
        let k = method.grid.k;
        assert!(found.covers(size[0], size[1]), "{size:?}, k {k}, seed {seed}: {found:?}");
        assert_restricted(method);
        assert!(fits_its_instances(method));
        method.leaves.iter().for_each(|leaf| masks[leaf.mask as usize] += 1);
    });
    assert!(masks[..7].iter().all(|count| *count > 100), "blocks that no mix has tried: {masks:?}");
    assert_eq!(masks[7], 0);
}

fn fits_its_instances(method: &Htp) -> bool {
    size_of::<PatchInstance>() as u64 * method.leaves.len() as u64 <= method.buffers().instances
}

/// Clamping alone is a trap: see [`Levels`]. The signed area is right in every one of the broken meshes.
#[test]
fn without_lockstep_at_the_rim_triangles_fold_over() {
    let mut folded = [0; 8];
    for_all_mixes(false, |method, [columns, rows], seed, found| {
        let whole = 2 * (columns as i64 - 1) * (rows as i64 - 1);
        assert_eq!(found.doubled_area, whole, "{columns} x {rows}, seed {seed}");
        folded[method.grid.k as usize] += (found.inverted > 0) as u32;
    });
    assert!([3, 4, 5, 7].iter().all(|k| folded[*k] > 0), "{folded:?}");
}

/// Neighbours differ by one level at most, and each mask says what its neighbours are.
fn assert_restricted(method: &Htp) {
    let Htp { grid, levels, leaves, .. } = method;
    let is_split = |patch: Patch| levels.is_split(grid, patch);
    for leaf in leaves {
        assert!(grid.parent(leaf.patch).is_none_or(is_split) && !is_split(leaf.patch));
        let mut mask = 0;
        for side in Side::ALL {
            let Some(neighbour) = grid.neighbour(leaf.patch, side) else { continue };
            let Some(coarser) = grid.parent(neighbour) else { continue };
            if !is_split(coarser) {
                mask |= side.bit();
                assert!(grid.parent(coarser).is_none_or(is_split), "{leaf:?} meets one that is two levels coarser");
            }
        }
        assert_eq!(leaf.mask, mask, "{leaf:?}");
        assert_ne!(leaf.mask, ALL_COLLAPSED);
    }
}

#[test]
fn levels_of_random_views_are_restricted() {
    for (k, layers) in [(2, 4), (3, 3), (4, 3), (7, 2)] {
        let heightmap = rough(317, 460);
        let mut method = htp(&heightmap, k, layers, Batching::Instanced);
        method.options.leg_px = 30.0;
        let mut plan = FramePlan::default();
        let mut levels_seen = BTreeSet::new();
        for view in RandomWalk::new(k as u64, &heightmap).take(100) {
            method.plan(&view, &mut plan);
            assert_restricted(&method);
            assert!(fits_its_instances(&method));
            levels_seen.extend(method.leaves.iter().map(|leaf| leaf.patch.square.level));
        }
        assert_eq!(levels_seen.len() as u32, layers);
    }
}

#[test]
fn no_leg_is_longer_than_allowed_but_on_the_finest_layer() {
    let heightmap = rough(193, 250);
    let mut method = htp(&heightmap, 3, 4, Batching::Instanced);
    let mut plan = FramePlan::default();
    for view in RandomWalk::new(7, &heightmap).take(50) {
        method.plan(&view, &mut plan);
        for square in method.leaves.iter().map(|leaf| leaf.patch.square).filter(|square| square.level > 0) {
            let distance_m = view.distance_m(&method.grid.bounds_world(square));
            assert!(view.pixels(method.grid.leg_m(square.level), distance_m) <= method.options.leg_px);
        }
    }
}

/// The triangles of a plan, whatever their order.
fn triangle_set(mirror: &MeshMirror) -> BTreeSet<[Sample; 3]> {
    let triangles: BTreeSet<_> = mirror.triangles().iter().map(|triangle| triangle.samples).collect();
    assert_eq!(triangles.len(), mirror.triangles().len());
    triangles
}

#[test]
fn both_batchings_draw_the_same_triangles() {
    for (columns, rows, k, layers) in [(193, 250, 3, 3), (54, 29, 2, 5), (100, 30, 4, 4), (41, 40, 9, 1)] {
        let heightmap = rough(columns, rows);
        let mut methods = [Batching::PerPatch, Batching::Instanced].map(|batching| {
            let options = Options { k, layers, batching, ..Options::default() };
            Htp::new(heightmap.clone(), options).unwrap()
        });
        let mut mirrors = methods.each_ref().map(|method| MeshMirror::new(&method.buffers(), &heightmap));
        let mut plans = [FramePlan::default(), FramePlan::default()];
        for view in RandomWalk::new(k as u64, &heightmap).take(40) {
            for ((method, mirror), plan) in methods.iter_mut().zip(&mut mirrors).zip(&mut plans) {
                method.plan(&view, plan);
                mirror.replay(plan).unwrap();
            }
            assert_eq!(triangle_set(&mirrors[0]), triangle_set(&mirrors[1]));
            assert_eq!(plans[0].draws.len(), methods[0].leaves.len());
            assert!(plans[1].draws.len() < 8);
        }
    }
}

#[test]
fn the_first_plan_sends_each_cell_once_and_the_second_nothing() {
    let heightmap = rough(100, 60);
    let view = RandomWalk::new(3, &heightmap).next().unwrap();
    for batching in [Batching::PerPatch, Batching::Instanced] {
        let mut method = htp(&heightmap, 3, 3, batching);
        let mut plan = FramePlan::default();
        method.plan(&view, &mut plan);
        // The indices, and 4 x 3 cells; or the indices, the one patch, and the instances.
        assert_eq!(plan.uploads.len(), if batching == Batching::PerPatch { 1 + 12 } else { 3 });
        let uploaded: usize = plan.uploads.iter().map(|upload| upload.bytes.len()).sum();
        let sizes = method.buffers();
        if batching == Batching::PerPatch {
            assert_eq!(uploaded as u64, sizes.vertices + sizes.indices);
        }
        method.plan(&view, &mut plan);
        assert!(plan.uploads.is_empty());
    }
}
