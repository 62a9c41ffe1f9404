//! The three triangulators of patches, against each other and against oracles that share no code with them.

mod oracle;
mod patches;
mod real;
#[path = "../bounded/terrain.rs"]
#[expect(dead_code, reason = "only the DEMs beside the project are wanted")]
mod terrain;

use std::panic::{AssertUnwindSafe, catch_unwind};

use oracle::{Triangle, check, check_tiling, doubled_area, flipped_until_right, sorted, triangles};
use patches::Patch;
use terrain_core::{Heightmap, SplitMix64};
use tin_lod::{Border, Jitter, NodeMaps, Nodes, Triangulator};

fn triangulate(triangulator: Triangulator, patch: &Patch) -> Vec<Triangle> {
    let mut indices = Vec::new();
    triangulator.triangulate(&patch.kept(), &mut indices);
    triangles(&indices)
}

/// Runs a check on the random patches of many seeds. A panic names the seed and the patch.
fn for_seeds(seeds: std::ops::Range<u64>, largest: u32, check: impl Fn(&Patch)) {
    println!("seeds {seeds:?}, sides of 1 to {largest} intervals");
    for seed in seeds {
        let patch = Patch::random(seed, largest);
        let checked = catch_unwind(AssertUnwindSafe(|| check(&patch)));
        assert!(checked.is_ok(), "seed {seed}, sides of 1 to {largest} intervals: {patch:?}");
    }
}

fn check_grid(patch: &Patch) {
    check(patch, &triangulate(Triangulator::Grid, patch));
}

/// The triangulation that the samples alone determine, by flips from those of the two libraries.
fn check_against_libraries(patch: &Patch) {
    let grid = sorted(triangulate(Triangulator::Grid, patch));
    for library in [Triangulator::Spade, Triangulator::Delaunator] {
        let start = triangulate(library, patch);
        assert_eq!(start.len(), grid.len(), "{library:?}");
        assert_eq!(flipped_until_right(start), grid, "{library:?}");
    }
}

#[test]
fn many_small_patches() {
    for_seeds(0..80_000, 12, check_grid);
}

#[test]
fn patches_of_all_sizes() {
    for_seeds(100_000..116_000, 64, check_grid);
}

#[test]
fn every_width_with_every_depth() {
    for width in 1..=64 {
        for depth in 1..=64 {
            let mut random = SplitMix64::new(width as u64 * 65 + depth as u64);
            check_grid(&Patch::new(width, depth, |_, _| random.below(8) == 0));
        }
    }
}

#[test]
fn the_result_is_the_only_one_whatever_the_start() {
    for_seeds(200_000..203_000, 8, check_against_libraries);
    for_seeds(210_000..210_150, 20, check_against_libraries);
}

fn triangulate_jittered(triangulator: Triangulator, patch: &Patch, jitter: Jitter) -> Vec<Triangle> {
    let mut indices = Vec::new();
    triangulator.triangulate_jittered(&patch.kept(), jitter, &mut indices);
    triangles(&indices)
}

#[test]
fn a_slight_jitter_only_chooses_between_diagonals() {
    let check = |patch: &Patch| {
        for (library, seed) in [(Triangulator::Spade, 7), (Triangulator::Delaunator, 8)] {
            let found = triangulate_jittered(library, patch, Jitter { amplitude: Jitter::SLIGHT, seed });
            check_tiling(patch, &found).check_delaunay_but_for_ties();
        }
    };
    for_seeds(300_000..306_000, 12, check);
    for_seeds(310_000..311_500, 64, check);
}

#[test]
fn a_jitter_follows_its_seed() {
    let patch = Patch::new(16, 16, |_, _| true);
    let jittered = |seed| triangulate_jittered(Triangulator::Spade, &patch, Jitter { amplitude: Jitter::SLIGHT, seed });
    assert_eq!(jittered(1), jittered(1));
    assert_ne!(sorted(jittered(1)), sorted(jittered(2)));
    assert_ne!(sorted(jittered(1)), sorted(triangulate(Triangulator::Spade, &patch)));
}

/// Why the method offers no larger one.
#[test]
fn a_large_jitter_leaves_triangles_without_area() {
    let patch = Patch::new(32, 32, |_, _| true);
    for (amplitude, is_sound) in [(Jitter::SLIGHT, true), (0.5, false)] {
        let found = triangulate_jittered(Triangulator::Delaunator, &patch, Jitter { amplitude, seed: 1 });
        assert_eq!(found.into_iter().all(|triangle| doubled_area(triangle) > 0), is_sound, "{amplitude}");
    }
}

#[test]
fn four_corners_are_joined_across_the_last_of_them() {
    // The last corner, south-east, counts as lifted. Technique B starts its meshes with this very diagonal.
    for (width, depth) in [(1, 1), (64, 64), (3, 50)] {
        let found = sorted(triangulate(Triangulator::Grid, &Patch::new(width, depth, |_, _| false)));
        let (e, s) = (width as i64, depth as i64);
        assert_eq!(found, [[[0, 0], [0, s], [e, 0]], [[0, s], [e, s], [e, 0]]]);
    }
}

#[test]
fn all_samples_and_regular_sets_of_the_largest_patch() {
    type Keep = fn(u32, u32) -> bool;
    let sets: [Keep; 10] = [
        |_, _| true,
        |x, z| x % 64 == 0 || z % 64 == 0,
        |x, z| (x + z) % 2 == 0,
        |x, z| x % 8 == 0 && z % 8 == 0,
        |x, _| x == 31,
        |_, z| z == 63,
        |x, z| x == z,
        |x, z| x + z == 64,
        |x, z| (x as i32 - 32).abs() == (z as i32 - 20).abs(),
        |x, z| (x as i32 - 32).pow(2) + (z as i32 - 32).pow(2) == 625,
    ];
    for keep in sets {
        check_grid(&Patch::new(64, 64, keep));
    }
}

#[test]
fn indices_are_appended() {
    let patch = Patch::new(5, 4, |x, z| (x * z) % 3 == 1);
    for triangulator in [Triangulator::Grid, Triangulator::Delaunator, Triangulator::Spade] {
        let mut indices = vec![7, 8, 9];
        triangulator.triangulate(&patch.kept(), &mut indices);
        assert_eq!(indices[..3], [7, 8, 9]);
        assert_eq!(triangles(&indices[3..]), triangulate(triangulator, &patch));
    }
}

#[test]
#[should_panic(expected = "a row names samples that are not its inner ones")]
fn a_mask_with_a_corner_is_refused() {
    let border = Border { south: 1 << 5, ..Border::default() };
    triangulate(Triangulator::Grid, &Patch { border, ..Patch::new(5, 4, |_, _| false) });
}

/// Checks the patches that both selectors make of a DEM, at so many tolerances and in patches of all sizes. Returns how
/// many.
fn check_real(dem: &Heightmap, tolerances: u64) -> u32 {
    let mut checked = 0;
    for side in [8, 16, 32, 64] {
        let maps = NodeMaps::build(dem, Nodes::new(dem, side, (64 / side).min(2)));
        for i in 0..tolerances {
            let seed = side as u64 * 1000 + i;
            println!("patches of {side} intervals, seed {seed}");
            checked += real::bounded(dem, &maps, seed, check_grid);
            let tolerance_m = SplitMix64::new(seed).range(-4.4, 10.0).exp2();
            checked += real::algorithm1(dem, maps.nodes().patches(), tolerance_m, check_grid);
        }
    }
    checked
}

#[test]
fn patches_of_real_terrain() {
    for name in ["ps_257_crop_rainier", "sthelens_30m_257", "sthelens_30m_native"] {
        let checked = terrain::shared(name).map(|dem| check_real(&dem, 2));
        println!("{name}: {checked:?} patches");
    }
}

#[test]
#[ignore = "1.7 million patches, some minutes of one core"]
fn patches_of_large_real_terrain() {
    for name in ["ps_1025", "deathvalley_2049_80m"] {
        let checked = terrain::shared(name).map(|dem| check_real(&dem, 8));
        println!("{name}: {checked:?} patches");
    }
}

#[test]
#[ignore = "10 million patches, some minutes of one core"]
fn ten_million_patches() {
    for_seeds(1_000_000..10_000_000, 12, check_grid);
    for_seeds(10_000_000..11_000_000, 40, check_grid);
}
