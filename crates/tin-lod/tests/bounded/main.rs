//! The bounded mesh against the oracles of whole DEMs: every sample's deviation, and every edge's twin.

mod terrain;
mod whole_dem;

use std::sync::Mutex;

use terrain_core::error::ErrorOracle;
use terrain_core::watertight::WatertightOracle;
use terrain_core::{Camera, Heightmap, Lens, Sample, SplitMix64, Triangle, View};
use terrain_dem::synthetic;
use tin_lod::ladder::{self, Level};
use tin_lod::levels::NodeLevels;
use tin_lod::{NodeId, Owners, PatchGrid, ThresholdMap, mesh_at_tolerance};
use whole_dem::{Bound, Leveled, Mesh, WholeDem};

/// The oracle's deviations are f32: it may see a deviation at the limit a ten-millionth above it. No other slack.
const ORACLE_ROUNDING: f64 = 1.000_000_1;

/// Triangulates, and asserts that the mesh is watertight and that no sample is above the tolerance of its node.
fn check(whole: &WholeDem, leveled: &Leveled, view: Option<&View>) -> (Mesh, Bound) {
    let mut mesh = Mesh::default();
    whole.triangulate(leveled, &mut mesh);
    let triangles = whole.triangles(&mesh);
    let (columns, rows) = (whole.dem.columns(), whole.dem.rows());
    let found = WatertightOracle::new(columns, rows).check(&triangles, &[]);
    assert!(found.covers(columns, rows), "{found:?}");
    let bound = whole.bound(leveled, &triangles, view);
    assert!(bound.worst <= ORACLE_ROUNDING, "{} samples above, up to {}", bound.above, bound.worst);
    (mesh, bound)
}

/// The map alone: with one level everywhere nothing may need a repair.
fn check_uniform(whole: &WholeDem, levels: impl Iterator<Item = Level>) {
    let mut fewest = usize::MAX;
    for level in levels {
        let (mesh, _) = check(whole, &whole.uniform(level), None);
        assert_eq!(mesh.nodes_repaired, 0);
        assert!(mesh.indices.len() <= fewest, "level {level} has more triangles than a finer one");
        fewest = mesh.indices.len();
    }
    let corners_alone = 6 * whole.maps.nodes().roots().len();
    assert!(fewest >= corners_alone);
}

#[test]
fn every_level_is_sound_on_real_terrain() {
    for dem in ["ps_257_crop_rainier", "sthelens_30m_257"].into_iter().filter_map(terrain::shared) {
        check_uniform(&WholeDem::new(dem, 32, 1), 0..=140);
    }
}

#[test]
fn every_level_is_sound_on_synthetic_terrain_in_patches_of_all_sizes() {
    for patch in [8, 16, 32, 64] {
        let whole = WholeDem::new(synthetic::generate(193, 150, 7), patch, 1);
        check_uniform(&whole, (0..=140).step_by(3).chain([254]));
        let full = check(&whole, &whole.uniform(0), None).0;
        assert_eq!(full.indices.len(), 6 * 192 * 149, "level 0 keeps every sample");
    }
}

/// Levels between 3 cm and 480 m, one a node or, in a third of the patches, one a block, as unlike each other as can be;
/// groups and patches by lot.
fn random(whole: &WholeDem, random: &mut SplitMix64) -> Leveled {
    let nodes = whole.maps.nodes();
    let mut owners = Owners::roots(nodes);
    for node in (0..nodes.len() as NodeId).rev() {
        // A group has a larger number than its members.
        if owners.of(nodes.patches_of(node).next().unwrap()) == node && random.below(2) == 0 {
            nodes.members(node).for_each(|member| owners.give(nodes, member));
        }
    }
    let mut level = || ladder::level_of(random.range(-5.0, 8.9).exp2());
    let mut levels: Vec<_> = (0..nodes.len()).map(|_| NodeLevels::Uniform(level())).collect();
    for patch in levels.iter_mut().take(nodes.patches().patches() as usize).step_by(3) {
        *patch = NodeLevels::Blocks([(); 8].map(|_| [(); 8].map(|_| level())));
    }
    Leveled { owners, levels }
}

/// Patches alone, and with groups.
const SIZES: [(u32, u32); 9] = [(8, 1), (16, 1), (32, 1), (64, 1), (8, 2), (8, 4), (16, 2), (16, 4), (32, 2)];

#[test]
fn any_mix_of_sizes_and_levels_is_watertight_and_within_the_tolerances() {
    let real = ["ps_257_crop_rainier", "sthelens_30m_257"].into_iter().filter_map(terrain::shared);
    for dem in real.chain([synthetic::generate(190, 250, 3)]) {
        for (patch, group) in SIZES {
            let whole = WholeDem::new(dem.clone(), patch, group);
            let mut lots = SplitMix64::new((patch + group) as u64);
            let meshes: Vec<Mesh> = (0..8).map(|_| check(&whole, &random(&whole, &mut lots), None).0).collect();
            assert!(meshes.iter().any(|mesh| mesh.repair.samples > 0), "nothing to repair: this proves nothing");
        }
    }
}

#[test]
fn awkward_shapes_and_heights() {
    for (name, dem) in terrain::awkward() {
        println!("{name}");
        for (patch, group) in SIZES {
            let whole = WholeDem::new(dem.clone(), patch, group);
            check_uniform(&whole, (0..=254).step_by(11));
            let mut lots = SplitMix64::new((patch + group) as u64);
            for _ in 0..4 {
                check(&whole, &random(&whole, &mut lots), None);
            }
        }
    }
}

#[test]
fn a_plane_has_its_corners_alone() {
    for height_m in [|_, _| 12.5, terrain::exact_ramp, terrain::rounded_ramp] {
        let whole = WholeDem::new(terrain::dem(65, 65, height_m), 32, 1);
        assert_eq!(check(&whole, &whole.uniform(1), None).0.indices.len(), 4 * 6);
    }
}

#[test]
fn heights_beyond_all_measure_end_in_a_watertight_mesh() {
    let mut random = SplitMix64::new(1);
    let whole = WholeDem::new(terrain::dem(50, 50, |_, _| random.range(-f32::MAX as f64, f32::MAX as f64)), 16, 4);
    for level in [0, 100, 254] {
        let mut mesh = Mesh::default();
        let mut leveled = self::random(&whole, &mut random);
        leveled
            .levels
            .iter_mut()
            .enumerate()
            .for_each(|(i, of_node)| *of_node = NodeLevels::Uniform(level / (1 + i as u8 % 2)));
        whole.triangulate(&leveled, &mut mesh);
        let found = WatertightOracle::new(50, 50).check(&whole.triangles(&mesh), &[]);
        assert!(found.covers(50, 50), "{found:?}");
    }
}

#[test]
fn the_map_is_the_same_on_any_number_of_threads_and_tells_its_progress() {
    let dem = synthetic::generate(193, 250, 7);
    let grid = PatchGrid::new(&dem, 16);
    let build = |threads| {
        let told = Mutex::new(Vec::new());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let progress = |done, total| told.lock().unwrap().push((done, total));
        let map = pool.install(|| ThresholdMap::build(&dem, &grid, &progress));
        let (mut told, patches) = (told.into_inner().unwrap(), grid.patches() as usize);
        told.sort_unstable();
        assert_eq!(told, (1..=patches).map(|done| (done, patches)).collect::<Vec<_>>());
        map
    };
    let alone = build(1);
    assert!([2, 3, 8].into_iter().all(|threads| build(threads) == alone));
}

/// Eye above the ground at a place between 0 and 1 of the DEM's extent, looking north.
fn view(dem: &Heightmap, [x, z]: [f64; 2], above_m: f64) -> View {
    let [width_m, depth_m] = dem.extent_m();
    let (x_m, z_m) = (x * width_m, z * depth_m);
    let camera = Camera { eye_world: [x_m, dem.ground_m(x_m, z_m) + above_m, z_m].into(), heading: 0.0, pitch: 0.0 };
    View::new(&camera, &Lens { fov_y: 60f64.to_radians(), size_px: [1280, 720], near_m: 1.0 }).unwrap()
}

#[test]
fn the_tolerance_in_pixels_is_a_bound() {
    let real = ["ps_257_crop_rainier", "sthelens_30m_257"].into_iter().filter_map(terrain::shared);
    for dem in real.chain([synthetic::generate(250, 193, 5)]) {
        let whole = WholeDem::new(dem, 16, 4);
        for (place, above_m) in [([0.5, 0.5], 100.0), ([0.02, 0.02], 100.0), ([0.5, 0.5], 20_000.0)] {
            let view = view(&whole.dem, place, above_m);
            for (tolerance_px, blocks) in
                [0.25, 0.5, 1.0, 2.0, 4.0].into_iter().flat_map(|px| [(px, false), (px, true)])
            {
                let (_, bound) = check(&whole, &whole.of_view(&view, tolerance_px, blocks), Some(&view));
                assert!(bound.worst_px <= tolerance_px * ORACLE_ROUNDING, "{} px", bound.worst_px);
            }
        }
    }
}

#[test]
fn puget_sound_at_one_pixel_needs_a_twentieth_of_its_triangles() {
    let Some(dem) = terrain::shared("ps_1025") else { return };
    let whole = WholeDem::new(dem, 32, 1);
    let view = view(&whole.dem, [0.5, 0.5], 100.0);
    let (mesh, bound) = check(&whole, &whole.of_view(&view, 1.0, false), Some(&view));
    let triangles = mesh.indices.len() / 3;
    assert!(triangles <= 105_000, "{triangles} triangles of 2,097,152");
    assert!(bound.worst_px <= 1.0, "{} px", bound.worst_px);
}

/// The shortest way in: no camera, no patches to be seen.
#[test]
fn a_mesh_at_one_tolerance_covers_the_dem_and_keeps_the_tolerance() {
    for (columns, rows) in [(2, 2), (130, 97), (65, 200)] {
        let dem = synthetic::generate(columns, rows, 5);
        for tolerance_m in [0.0, 1.0, 20.0, 1e9] {
            let triangle = |corners: &[u32; 3]| {
                let samples = corners.map(|i| Sample { column: i % columns, row: i / columns });
                Triangle { samples, heights_m: samples.map(|sample| dem.height_m(sample)) }
            };
            let triangles: Vec<Triangle> = mesh_at_tolerance(&dem, tolerance_m).iter().map(triangle).collect();
            assert!(WatertightOracle::new(columns, rows).check(&triangles, &[]).covers(columns, rows));
            let mut oracle = ErrorOracle::new(&dem);
            oracle.set_mesh(&triangles);
            let worst_m = oracle.deviations_m().fold(0.0, f32::max);
            assert!(f64::from(worst_m) <= tolerance_m * ORACLE_ROUNDING, "{worst_m} for {tolerance_m} m");
        }
    }
}
