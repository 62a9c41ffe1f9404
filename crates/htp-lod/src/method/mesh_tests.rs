//! The meshes that come out: of random level mixes and of random views, judged in integers from the plan's own bytes.

use super::*;
use crate::blocks::{ALL_COLLAPSED, Side};
use crate::grid::{Patch, Square};
use crate::leaves::{self, Leaf};
use crate::sight::Culling;
use std::collections::BTreeSet;
use terrain_core::walk::RandomWalk;
use terrain_core::watertight::{WatertightOracle, Watertightness};
use terrain_core::{MeshMirror, Sample, SplitMix64};

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

/// All leaves, in sight or not.
fn all_leaves(method: &Htp) -> Vec<Leaf> {
    let (grid, mut leaves) = (&method.grid, Vec::new());
    grid.cells(grid.whole()).for_each(|cell| leaves::collect(grid, &method.levels, cell, Culling::OFF, &mut leaves));
    leaves
}

/// Draws a restricted mix of levels over the whole DEM and judges the mesh.
fn judge_mix(method: &mut Htp, mirror: &mut MeshMirror, wish: impl Fn(Square) -> u8) -> Watertightness {
    let (mut plan, size) = (FramePlan::default(), method.grid.samples());
    method.initialise(&mut plan);
    method.levels.choose(&method.grid, wish);
    let Rendering::Instanced(instanced) = &mut method.rendering else { unreachable!("mixes are drawn by instances") };
    instanced.select(&method.grid, &method.levels, Culling::OFF);
    method.render(&mut plan);
    mirror.replay(&plan).unwrap();
    WatertightOracle::new(size[0], size[1]).check(mirror.triangles(), mirror.degenerate())
}

const SIZES: [[u32; 2]; 7] = [[317, 460], [193, 250], [28, 28], [30, 31], [54, 29], [2, 2], [2, 9]];

/// Judges random mixes on DEMs of all sizes with many k, and passes each verdict on.
fn for_all_mixes(lockstep: bool, mut verdict: impl FnMut(&Htp, [u32; 2], u64, Watertightness)) {
    for size in SIZES {
        let heightmap = rough(size[0], size[1]);
        for (k, layers) in [2, 3, 4, 5, 7, 16].into_iter().flat_map(|k| (2..=4).map(move |layers| (k, layers))) {
            let mut method = htp(&heightmap, k, layers, Batching::Instanced);
            if !lockstep {
                // Every square passes for one that does not cross the rim.
                method.grid.layers.iter_mut().for_each(|layer| layer.inside = [u32::MAX; 2]);
            }
            let mut mirror = MeshMirror::new(&method.buffers(), &heightmap);
            for seed in 0..if size[0] > 100 { 3 } else { 40 } {
                let found = judge_mix(&mut method, &mut mirror, |square| lot(seed, square));
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
        all_leaves(method).iter().for_each(|leaf| masks[leaf.mask as usize] += 1);
    });
    assert!(masks[..7].iter().all(|count| *count > 100), "blocks that no mix has tried: {masks:?}");
    assert_eq!(masks[7], 0);
}

/// Clamping alone is a trap: see `closure`. The signed area is right in every one of the broken meshes.
#[test]
fn without_lockstep_at_the_rim_triangles_fold_over() {
    let mut folded = [0; 17];
    for_all_mixes(false, |method, [columns, rows], seed, found| {
        let whole = 2 * (columns as i64 - 1) * (rows as i64 - 1);
        assert_eq!(found.doubled_area, whole, "{columns} x {rows}, seed {seed}");
        folded[method.grid.k as usize] += (found.inverted > 0) as u32;
    });
    assert!([3, 4, 5, 7].iter().all(|k| folded[*k] > 0), "{folded:?}");
}

/// Every set of wishes: among them is every restricted mix of levels, as the wishes that entail nothing.
#[test]
fn all_mixes_of_small_dems_are_watertight() {
    let mut drawn = BTreeSet::new();
    // Whole cells (columns and rows a cell's side and one), and DEMs that cells cross the rim of.
    for (k, layers, size) in
        [(2, 2, [13, 9]), (2, 3, [9, 9]), (2, 3, [8, 6]), (3, 2, [19, 19]), (3, 2, [17, 23]), (4, 2, [33, 33])]
    {
        let heightmap = rough(size[0], size[1]);
        let mut method = htp(&heightmap, k, layers, Batching::Instanced);
        let mut mirror = MeshMirror::new(&method.buffers(), &heightmap);
        // Two bits for each square whose halves can be split.
        let squares: Vec<Square> = (1..layers).flat_map(|level| method.grid.squares(level)).collect();
        for mix in 0..1u32 << (2 * squares.len()) {
            let number = |square: &Square| squares.iter().position(|other| other == square).unwrap();
            let found = judge_mix(&mut method, &mut mirror, |square| (mix >> (2 * number(&square)) & 3) as u8);
            assert!(found.covers(size[0], size[1]), "{size:?}, k {k}, mix {mix:b}: {found:?}");
            assert_restricted(&method);
            drawn.extend(all_leaves(&method).iter().map(|leaf| (k, leaf.patch.half as u8, leaf.mask)));
        }
    }
    // Each half with the plain list and all 6 matching blocks that can be drawn.
    let of = |k: u32| drawn.iter().filter(|(other, ..)| *other == k).count();
    assert_eq!([2, 3, 4].map(of), [14; 3], "{drawn:?}");
}

/// Neighbours differ by one level at most, and each mask says what its neighbours are.
pub(super) fn assert_restricted(method: &Htp) {
    let Htp { grid, levels, .. } = method;
    let is_split = |patch: Patch| levels.split().contains(grid, patch);
    for leaf in &all_leaves(method) {
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
            levels_seen.extend(all_leaves(&method).iter().map(|leaf| leaf.patch.square.level));
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
        for square in all_leaves(&method).iter().map(|leaf| leaf.patch.square).filter(|square| square.level > 0) {
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

const BATCHINGS: [Batching; 3] = [Batching::PerPatch, Batching::MergedCell, Batching::Instanced];

#[test]
fn all_batchings_draw_the_same_triangles() {
    for (columns, rows, k, layers) in [(193, 250, 3, 3), (54, 29, 2, 5), (100, 30, 4, 4), (41, 40, 9, 1)] {
        let heightmap = rough(columns, rows);
        for (metric, culling) in METRICS.into_iter().flat_map(|metric| [(metric, false), (metric, true)]) {
            let mut methods = BATCHINGS.map(|batching| {
                let options = Options { k, layers, batching, metric, ..Options::default() };
                Htp::new(heightmap.clone(), options).unwrap()
            });
            methods.iter_mut().for_each(|method| method.set_culling(culling));
            let mut mirrors = methods.each_ref().map(|method| MeshMirror::new(&method.buffers(), &heightmap));
            let mut plan = FramePlan::default();
            for view in RandomWalk::new(k as u64, &heightmap).take(30) {
                let mut draws = [0; 3];
                for ((method, mirror), draws) in methods.iter_mut().zip(&mut mirrors).zip(&mut draws) {
                    method.plan(&view, &mut plan);
                    mirror.replay(&plan).unwrap();
                    *draws = plan.draws.len();
                }
                let [per_patch, merged, instanced] = mirrors.each_ref().map(triangle_set);
                assert_eq!(per_patch, instanced);
                // A cell is culled as a whole.
                assert!(merged.is_superset(&per_patch) && (culling || merged == per_patch));
                assert!(draws[1] <= methods[1].grid.squares(layers - 1).count() && draws[2] <= 7, "{draws:?}");
            }
        }
    }
}

const METRICS: [LevelMetric; 3] = [LevelMetric::Distance, LevelMetric::Box, LevelMetric::Error];

#[test]
fn the_first_plan_sends_each_cell_once_and_the_second_nothing() {
    let heightmap = rough(100, 60);
    let view = RandomWalk::new(3, &heightmap).next().unwrap();
    for batching in BATCHINGS {
        let mut method = htp(&heightmap, 3, 3, batching);
        let mut plan = FramePlan::default();
        method.plan(&view, &mut plan);
        let uploads = |buffer: Buffer| plan.uploads.iter().filter(|upload| upload.buffer == buffer).count();
        let masks = all_leaves(&method).iter().map(|leaf| leaf.mask).collect::<BTreeSet<_>>().len();
        // 4 x 3 cells.
        let expected = match batching {
            Batching::PerPatch => [12, 1, 0],
            Batching::MergedCell => [12, 12, 0],
            Batching::Instanced => [1, 1, masks],
        };
        assert_eq!([Buffer::Vertices, Buffer::Indices, Buffer::Instances].map(uploads), expected, "{batching:?}");
        let uploaded: usize = plan.uploads.iter().map(|upload| upload.bytes.len()).sum();
        let sizes = method.buffers();
        if batching == Batching::PerPatch {
            assert_eq!(uploaded as u64, sizes.vertices + sizes.indices);
        }
        method.plan(&view, &mut plan);
        assert!(plan.uploads.is_empty());
    }
}
