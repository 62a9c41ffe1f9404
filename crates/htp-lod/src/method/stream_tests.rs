//! Streamed cells against the same DEM in memory: with all that a view asks for, the same patches and blocks; without,
//! meshes that are whole.

use super::bound_tests::largest_error_px;
use super::*;
use crate::cells::{CellsHeader, cut};
use std::collections::BTreeSet;
use terrain_core::error::ErrorOracle;
use terrain_core::walk::RandomWalk;
use terrain_core::{Draw, MeshMirror, PatchInstance, contract};

/// Synthetic terrain, in whole metres (16 bits a height) or not (32).
pub(super) fn terrain(columns: u32, rows: u32, whole: bool) -> Arc<Heightmap> {
    let heights_m = terrain_dem::synthetic::generate(columns, rows, 5).heights_m().to_vec();
    let heights_m = heights_m.into_iter().map(|height_m| if whole { height_m.round() } else { height_m });
    Arc::new(Heightmap::new(columns, rows, [30.0, 25.0], heights_m.collect()).unwrap())
}

/// Loads blocking; windows of about so many cells.
pub(super) fn streamed(heightmap: &Heightmap, options: Options, window: u32) -> Htp {
    let options = Options { loading: Loading::Blocking, ..options };
    let (file, resident) = CellFile::open(Arc::new(cut(heightmap, &options))).unwrap();
    let sides = sides(file.header(), window);
    Htp::stream_windows(file, resident, options, &sides).unwrap()
}

/// Windows of so many cells or some more, of any size by level: that of a finer level may be the wider one. At most what
/// the DEM has.
pub(super) fn sides(header: &CellsHeader, window: u32) -> Vec<u32> {
    let all = header.cells().into_iter().max().unwrap();
    (0..header.streamed).map(|level| (window + [0, 3, 1][((level + window) % 3) as usize]).min(all)).collect()
}

pub(super) fn cells(heightmap: &Heightmap, options: &Options) -> u32 {
    (heightmap.columns().max(heightmap.rows()) - 1).div_ceil(options.k.pow(options.layers))
}

/// What plans draw: index list, place and tag of each patch.
#[derive(Default)]
struct Drawn {
    instances: Vec<u8>,
}

impl Drawn {
    fn patches(&mut self, plan: &FramePlan) -> BTreeSet<(u32, [i32; 2], u32)> {
        plan.growths.iter().for_each(|growth| self.instances.resize(growth.bytes as usize, 0));
        for upload in plan.uploads.iter().filter(|upload| upload.buffer == Buffer::Instances) {
            self.instances[upload.offset as usize..][..upload.bytes.len()].copy_from_slice(plan.bytes_of(upload));
        }
        let size = size_of::<PatchInstance>();
        let instance =
            |at: u32| -> PatchInstance { bytemuck::pod_read_unaligned(&self.instances[size * at as usize..][..size]) };
        let of = |draw: &Draw| {
            let start = draw.indices.start;
            draw.instances.clone().map(instance).map(move |found| (start, found.origin, found.tag)).collect::<Vec<_>>()
        };
        plan.draws.iter().flat_map(of).collect()
    }
}

/// Settings whose walks show all levels, on DEMs of one and two hundred samples.
fn settings() -> Vec<Options> {
    let mut all = Vec::new();
    for (k, layers) in [(2, 3), (2, 4), (3, 3), (4, 2), (9, 2)] {
        for (metric, px) in [(LevelMetric::Distance, 60.0), (LevelMetric::Box, 60.0), (LevelMetric::Error, 6.0)] {
            let batching = Batching::Instanced;
            all.push(Options { k, layers, metric, leg_px: px, tolerance_px: px, batching, ..Options::default() });
        }
    }
    all
}

#[test]
fn with_all_cells_in_the_window_plans_are_those_of_the_dem_in_memory() {
    for (columns, rows, whole) in [(134, 115, false), (97, 70, true)] {
        let heightmap = terrain(columns, rows, whole);
        for options in settings() {
            let window = cells(&heightmap, &options);
            let mut methods = [Htp::new(heightmap.clone(), options).unwrap(), streamed(&heightmap, options, window)];
            let [mut plan, mut expected] = [FramePlan::default(), FramePlan::default()];
            for (frame, view) in RandomWalk::new(options.k as u64, &heightmap).take(80).enumerate() {
                methods[0].plan(&view, &mut expected);
                methods[1].plan(&view, &mut plan);
                assert_eq!(plan.draws, expected.draws, "{options:?}, frame {frame}");
                let instances = |plan: &FramePlan| -> Vec<u8> {
                    let uploads = plan.uploads.iter().filter(|upload| upload.buffer == Buffer::Instances);
                    uploads.flat_map(|upload| plan.bytes_of(upload).to_vec()).collect()
                };
                assert_eq!(instances(&plan), instances(&expected), "{options:?}, frame {frame}");
                assert_eq!(plan.unheld_px, 0.0, "{options:?}, frame {frame}");
            }
        }
    }
}

/// The window slides and wraps, and what is outside of it may not be split.
#[test]
fn where_nothing_is_denied_a_small_window_draws_what_the_dem_in_memory_does() {
    let heightmap = terrain(300, 260, true);
    for options in settings() {
        let options = Options { tolerance_px: 25.0, ..options };
        let mut counts = [0; 2];
        for window in [2, 3, 5, 9].map(|window| window.min(cells(&heightmap, &options))) {
            let mut methods = [Htp::new(heightmap.clone(), options).unwrap(), streamed(&heightmap, options, window)];
            let [mut plan, mut expected] = [FramePlan::default(), FramePlan::default()];
            let mut drawn = [Drawn::default(), Drawn::default()];
            for (frame, view) in RandomWalk::new(window as u64, &heightmap).take(100).enumerate() {
                methods[0].plan(&view, &mut expected);
                methods[1].plan(&view, &mut plan);
                let [expected, found] = [drawn[0].patches(&expected), drawn[1].patches(&plan)];
                let is_held = plan.unheld_px == 0.0;
                assert!(!is_held || found == expected, "{options:?}, window {window}, frame {frame}");
                counts[is_held as usize] += 1;
            }
            let unloaded = plan.streaming.cells_unloaded;
            assert!(unloaded > 0 || window == cells(&heightmap, &options), "{options:?}, window {window}");
        }
        assert!(counts[1] > 40, "{options:?}: {counts:?}");
    }
}

/// What the loading of cells has decided anew is all that it may have changed.
#[test]
fn plans_of_streamed_cells_are_those_decided_anew() {
    let heightmap = terrain(193, 250, true);
    for options in settings() {
        for window in [1, 3, 4].map(|window| window.min(cells(&heightmap, &options))) {
            let [mut following, mut anew] = [(); 2].map(|_| streamed(&heightmap, options, window));
            following.levels.never_anew();
            let [mut plan, mut expected] = [FramePlan::default(), FramePlan::default()];
            for (frame, view) in RandomWalk::new(options.k as u64, &heightmap).take(60).enumerate() {
                following.plan(&view, &mut plan);
                anew.forget();
                anew.plan(&view, &mut expected);
                assert!(plan == expected, "{options:?}, window {window}, frame {frame}");
            }
        }
    }
}

/// Whatever is missing: no sample is farther off than what the plan says.
#[test]
fn what_is_not_held_is_a_bound() {
    let heightmap = terrain(193, 140, true);
    let mut oracle = ErrorOracle::new(&heightmap);
    let (mut plan, mut unheld) = (FramePlan::default(), 0);
    for (k, layers, window) in [(2, 4, 2), (2, 3, 4), (3, 3, 2), (3, 3, 3), (4, 2, 3)] {
        let batching = Batching::Instanced;
        let options =
            Options { k, layers, metric: LevelMetric::Error, tolerance_px: 3.0, batching, ..Options::default() };
        let mut method = streamed(&heightmap, options, window);
        method.set_culling(false);
        let mut mirror = MeshMirror::new(&method.buffers(), &heightmap);
        for view in RandomWalk::new(window as u64, &heightmap).take(60) {
            method.plan(&view, &mut plan);
            if mirror.replay(&plan).unwrap() {
                oracle.set_mesh(mirror.triangles());
            }
            let (found_px, bound_px) = (largest_error_px(&heightmap, &oracle, &view), plan.unheld_px.max(3.0));
            assert!(found_px <= bound_px * (1.0 + 1e-6), "{options:?}: {found_px} px, where {bound_px} were promised");
            unheld += (plan.unheld_px > 3.0 && plan.unheld_px.is_finite() && found_px > 3.0) as u32;
        }
    }
    assert!(unheld > 20, "{unheld}");
}

/// Whole meshes, the DEM's heights, equal plans of two methods, and no uploads for an unchanged view.
#[test]
fn streamed_cells_keep_the_contract() {
    for (columns, rows, whole) in [(134, 115, true), (66, 139, false)] {
        let heightmap = terrain(columns, rows, whole);
        for (options, window) in settings().into_iter().flat_map(|options| [1, 3, 4].map(|window| (options, window))) {
            let build = |_threads| -> Box<dyn LodMethod> {
                Box::new(streamed(&heightmap, options, window.min(cells(&heightmap, &options))))
            };
            contract::check(&heightmap, build, window as u64, 24);
        }
    }
}
