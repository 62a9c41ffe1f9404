//! The shared contract over real and awkward shapes, and what is the TIN's own.

#[path = "bounded/terrain.rs"]
#[expect(dead_code, reason = "no DEMs beside the project are wanted")]
mod terrain;

use std::sync::Arc;

use terrain_core::error::{ErrorDistribution, ErrorOracle};
use terrain_core::walk::RandomWalk;
use terrain_core::{FramePlan, Heightmap, LodMethod, MeshMirror, contract};
use terrain_dem::synthetic;
use tin_lod::{EdgePolicy, IndexStore, Options, Selector, Tin, Triangulator};

/// With every selector that the options fit.
fn check(dem: Heightmap, options: Options, seed: u64, frames: u32) {
    for selector in [Selector::Algorithm1, Selector::Bounded] {
        let options = Options { selector, ..options };
        if options.validate().is_ok() {
            check_one(dem.clone(), options, seed, frames);
        }
    }
}

fn check_one(dem: Heightmap, options: Options, seed: u64, frames: u32) {
    let dem = Arc::new(dem);
    let build =
        |threads| -> Box<dyn LodMethod> { Box::new(Tin::new(dem.clone(), Options { threads, ..options }).unwrap()) };
    contract::check(&dem, build, seed, frames);
}

#[test]
fn every_patch_size_over_synthetic_terrain() {
    for patch in [8, 16, 32, 64] {
        let options = Options { patch, ..Default::default() };
        check(synthetic::generate(193, 250, 7), options, patch as u64, 60);
    }
}

#[test]
fn groups_of_every_size() {
    for (patch, group) in [(8, 1), (8, 2), (8, 4), (16, 2), (16, 4), (32, 1), (32, 2), (64, 1)] {
        let options = Options { patch, group: Some(group), blocks: false, ..Default::default() };
        check_one(synthetic::generate(193, 250, 7), options, patch as u64, 60);
        check_one(synthetic::generate(131, 70, 7), Options { tolerance_px: 8.0, ..options }, patch as u64, 60);
        check_one(synthetic::generate(131, 70, 7), Options { blocks: true, ..options }, patch as u64, 60);
    }
}

#[test]
fn tolerances_and_spacings() {
    for (tolerance_px, max_spacing) in [(0.25, None), (4.0, Some(16)), (50.0, Some(1)), (1e6, Some(11))] {
        let options = Options { tolerance_px, max_spacing, patch: 16, ..Default::default() };
        check(synthetic::generate(120, 97, 3), options, 11, 60);
    }
}

#[test]
fn the_papers_edges() {
    let options = Options { patch: 16, edge_policy: EdgePolicy::Paper, ..Default::default() };
    check(synthetic::generate(193, 130, 5), options, 13, 100);
}

#[test]
fn every_triangulator() {
    for triangulator in [Triangulator::Grid, Triangulator::Delaunator, Triangulator::Spade] {
        let options = Options { triangulator, ..Default::default() };
        check(synthetic::generate(150, 161, 5), options, 21, 60);
        check(synthetic::generate(150, 161, 5), Options { patch: 64, tolerance_px: 0.25, ..options }, 22, 60);
        let rim = Options { patch: 8, ..options };
        for (columns, rows) in [(2, 2), (2, 70), (70, 2), (9, 8)] {
            check(synthetic::generate(columns, rows, 6), rim, 23, 60);
        }
    }
}

#[test]
fn the_papers_jitter() {
    for (triangulator, seed) in [(Triangulator::Delaunator, 1), (Triangulator::Spade, 2)] {
        let options = Options { triangulator, jitter: Some(seed), ..Default::default() };
        check(synthetic::generate(150, 161, 5), Options { patch: 16, tolerance_px: 0.25, ..options }, 31, 60);
        check(synthetic::generate(150, 161, 5), Options { patch: 64, tolerance_px: 4.0, ..options }, 32, 60);
    }
}

#[test]
fn smoothed_heights() {
    for (patch, edge_policy, seed) in [(8, EdgePolicy::Matched, 41), (32, EdgePolicy::Paper, 42)] {
        let algorithm1 = Options { selector: Selector::Algorithm1, edge_policy, patch, ..Default::default() };
        let options = Options { smoothing: true, tolerance_px: 2.0, ..algorithm1 };
        let dem = Arc::new(synthetic::generate(193, 130, 5));
        let build = |threads| -> Box<dyn LodMethod> {
            Box::new(Tin::new(dem.clone(), Options { threads, ..options }).unwrap())
        };
        contract::check_smoothed(&dem, build, seed, 100);
    }
}

/// Where patches meet, so that patches of different levels agree; and elsewhere they do differ.
#[test]
fn borders_are_not_smoothed() {
    let dem = Arc::new(synthetic::generate(193, 130, 5));
    let options = Options { selector: Selector::Algorithm1, smoothing: true, patch: 16, ..Default::default() };
    let mut tin = Tin::new(dem.clone(), options).unwrap();
    let mut mirror = MeshMirror::new(&tin.buffers(), &dem);
    let (mut plan, mut smoothed) = (FramePlan::default(), 0);
    for (frame, view) in RandomWalk::new(6, &dem).take(100).enumerate() {
        tin.plan(&view, &mut plan);
        mirror.replay(&plan).unwrap();
        for triangle in mirror.triangles() {
            for (sample, height_m) in triangle.samples.into_iter().zip(triangle.heights_m) {
                let on_border = sample.column % 16 == 0 || sample.row % 16 == 0;
                let differs = height_m != dem.height_m(sample);
                assert!(!(on_border && differs), "frame {frame}, {sample:?}");
                smoothed += differs as u64;
            }
        }
    }
    assert!(smoothed > 0);
}

#[test]
fn awkward_shapes_and_heights() {
    for (name, dem) in terrain::awkward() {
        for patch in [8, 16, 32, 64] {
            println!("{name}, patch {patch}");
            check(dem.clone(), Options { patch, ..Default::default() }, 5, 40);
        }
    }
}

#[test]
fn what_is_no_dem_is_refused_in_one_line() {
    let refuse = |columns, rows, height_m| {
        let heights_m = vec![height_m; (columns * rows) as usize];
        Heightmap::new(columns, rows, [1.0; 2], heights_m).unwrap_err().to_string()
    };
    assert_eq!(refuse(1, 70, 0.0), "1 x 70 samples: expected 2 to 65535 along each side");
    assert_eq!(refuse(70, 1, 0.0), "70 x 1 samples: expected 2 to 65535 along each side");
    assert_eq!(refuse(2, 2, f32::NAN), "height NaN at column 0, row 0: expected a finite number");
    assert_eq!(refuse(2, 2, f32::INFINITY), "height inf at column 0, row 0: expected a finite number");
}

#[test]
fn a_plan_updates_only_outdated_patches() {
    let dem = Arc::new(synthetic::generate(513, 513, 2));
    let options = Options { selector: Selector::Algorithm1, ..Default::default() };
    let mut tin = Tin::new(dem.clone(), options).unwrap();
    let mut plan = FramePlan::default();
    let (mut updated, mut drawn) = (0, 0);
    for view in RandomWalk::new(4, &dem).take(200) {
        tin.plan(&view, &mut plan);
        updated += plan.work.iter().map(|work| work.patches as usize).sum::<usize>();
        drawn += plan.draws.len();
    }
    assert!(updated * 2 < drawn, "{updated} of {drawn} patches triangulated anew: nothing is kept between frames");
}

/// Groups are split and merged by the view alone: where the camera has been before leaves no trace.
#[test]
fn without_culling_the_bounded_mesh_is_a_function_of_the_view() {
    let dem = Arc::new(synthetic::generate(190, 247, 7));
    let tin = |options| {
        let mut tin = Tin::new(dem.clone(), options).unwrap();
        tin.set_culling(false);
        tin
    };
    for (patch, group) in [(8, 4), (16, 4), (32, 2)] {
        // Fixed rooms: equal draws are equal triangles.
        let index_store = IndexStore::Fixed;
        let options = Options { patch, group: Some(group), tolerance_px: 2.0, index_store, ..Default::default() };
        let (mut walks, mut groups_drawn) = (tin(options), 0);
        let (mut plan, mut expected) = (FramePlan::default(), FramePlan::default());
        for (frame, view) in RandomWalk::new(23, &dem).take(120).enumerate() {
            walks.plan(&view, &mut plan);
            if frame % 10 == 0 {
                tin(options).plan(&view, &mut expected);
                assert_eq!(plan.draws, expected.draws, "{options:?}, frame {frame}");
            }
            let patches = 189u32.div_ceil(patch) * 246u32.div_ceil(patch);
            groups_drawn += (plan.draws.len() < patches as usize) as u32;
        }
        assert!(groups_drawn > 60, "{options:?}: groups in {groups_drawn} of 120 frames");
    }
}

#[test]
fn both_index_stores_keep_the_contract_and_draw_the_same_triangles() {
    let dem = Arc::new(synthetic::generate(190, 247, 7));
    let stores =
        [IndexStore::Fixed, IndexStore::Packed].map(|index_store| Options { index_store, ..Default::default() });
    stores.iter().for_each(|options| check(synthetic::generate(150, 131, 5), *options, 31, 60));
    let mut tins = stores.map(|options| Tin::new(dem.clone(), options).unwrap());
    let mut mirrors = tins.each_ref().map(|tin| MeshMirror::new(&tin.buffers(), &dem));
    let mut plan = FramePlan::default();
    for (frame, view) in RandomWalk::new(3, &dem).take(100).enumerate() {
        for (tin, mirror) in tins.iter_mut().zip(&mut mirrors) {
            tin.plan(&view, &mut plan);
            mirror.replay(&plan).unwrap();
        }
        assert_eq!(mirrors[0].triangles(), mirrors[1].triangles(), "frame {frame}");
    }
    let [fixed, packed] = tins.map(|tin| tin.buffers().indices);
    assert!(4 * packed < fixed, "{packed} bytes packed, {fixed} fixed");
}

#[test]
fn options_out_of_range_are_refused_in_one_line() {
    let refuse = |options: Options| options.validate().unwrap_err().to_string();
    assert_eq!(refuse(Options { patch: 12, ..Default::default() }), "patch of 12 intervals: expected 8, 16, 32 or 64");
    assert_eq!(
        refuse(Options { tolerance_px: f64::NAN, ..Default::default() }),
        "tolerance of NaN px: expected a finite number above 0"
    );
    assert_eq!(
        refuse(Options { max_spacing: Some(33), ..Default::default() }),
        "maximum spacing of 33 intervals: expected 1 to 32, the side of a patch"
    );
    assert_eq!(
        refuse(Options { group: Some(4), ..Default::default() }),
        "group of 4 x 4 patches of 32 intervals: expected 1, 2 or 4, and at most 64 intervals"
    );
}

#[test]
fn smoothing_with_the_bounded_selector_is_refused() {
    let refused = Options { smoothing: true, ..Default::default() }.validate().unwrap_err().to_string();
    assert_eq!(refused, "smoothing needs the selector algorithm1");
}

#[test]
fn a_jitter_without_a_triangulator_of_floats_is_refused() {
    let options = Options { jitter: Some(1), selector: Selector::Algorithm1, ..Default::default() };
    assert_eq!(options.validate().unwrap_err().to_string(), "the jitter needs the triangulator delaunator or spade");
    assert!(Options { triangulator: Triangulator::Spade, ..options }.validate().is_ok());
}

/// The whole of it: in every frame of a walk no sample in view is farther off than the tolerance, edges between levels
/// and rim patches included.
fn assert_within_the_tolerance(dem: &Arc<Heightmap>, options: Options, frames: usize) {
    let mut tin = Tin::new(dem.clone(), options).unwrap();
    let mut mirror = MeshMirror::new(&tin.buffers(), dem);
    let (mut plan, mut oracle) = (FramePlan::default(), ErrorOracle::new(dem));
    for (frame, view) in RandomWalk::new(17, dem).take(frames).enumerate() {
        tin.plan(&view, &mut plan);
        if mirror.replay(&plan).unwrap() {
            oracle.set_mesh(mirror.triangles());
        }
        let mut errors = ErrorDistribution::new(&[]);
        oracle.measure(&view, &mut errors);
        let share = errors.max_px() as f64 / options.tolerance_px;
        assert!(share <= 1.0001, "{options:?}, frame {frame}: {share} times the tolerance");
    }
}

#[test]
fn the_bounded_selector_keeps_the_tolerance_in_every_frame() {
    let dem = Arc::new(synthetic::generate(190, 247, 7));
    let sizes = [(0.25, 32, 2), (1.0, 8, 4), (1.0, 8, 1), (1.0, 32, 2), (2.0, 64, 1), (4.0, 16, 4), (16.0, 8, 4)];
    for ((tolerance_px, patch, group), blocks) in sizes.into_iter().flat_map(|size| [(size, false), (size, true)]) {
        let options = Options { tolerance_px, patch, group: Some(group), blocks, ..Default::default() };
        assert_within_the_tolerance(&dem, options, 150);
    }
}

#[test]
fn the_bounded_selector_keeps_the_tolerance_on_awkward_shapes_and_heights() {
    for (name, dem) in terrain::awkward() {
        let dem = Arc::new(dem);
        for (tolerance_px, patch) in [(0.25, 64), (1.0, 8), (1.0, 32), (20.0, 16)] {
            println!("{name}");
            assert_within_the_tolerance(&dem, Options { tolerance_px, patch, ..Default::default() }, 60);
        }
    }
}
