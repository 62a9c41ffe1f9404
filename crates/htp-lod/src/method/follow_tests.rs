//! What is followed from view to view is what comes out when all is decided and looked at anew: the same plans, byte
//! for byte.

use super::*;
use bytemuck::Zeroable;
use std::collections::BTreeSet;
use terrain_core::walk::RandomWalk;
use terrain_core::{Camera, PatchInstance, SplitMix64};

fn terrain(columns: u32, rows: u32) -> Arc<Heightmap> {
    let heights_m = terrain_dem::synthetic::generate(columns, rows, 11).heights_m().to_vec();
    Arc::new(Heightmap::new(columns, rows, [30.0; 2], heights_m).unwrap())
}

impl Htp {
    /// Decides and looks at all anew in the next plan.
    pub(super) fn forget(&mut self) {
        self.levels.forget();
        if let Rendering::Instanced(instanced) = &mut self.rendering {
            instanced.forget();
        }
    }

    /// Collects the leaves in sight anew where any level has changed, or never.
    fn collect_anew(&mut self, always: bool) {
        if let Rendering::Instanced(instanced) = &mut self.rendering {
            instanced.collect_anew(always);
        }
    }
}

/// Plans every view twice, and returns in how many frames levels have changed.
fn compare(heightmap: &Arc<Heightmap>, options: Options, views: impl Iterator<Item = View>) -> usize {
    let [mut following, mut anew] = [(); 2].map(|_| Htp::new(heightmap.clone(), options).unwrap());
    let [mut plan, mut expected] = [FramePlan::default(), FramePlan::default()];
    following.levels.never_anew();
    [&mut following, &mut anew].into_iter().for_each(|method| method.collect_anew(false));
    let mut changes = 0;
    for (frame, view) in views.enumerate() {
        following.plan(&view, &mut plan);
        anew.forget();
        anew.plan(&view, &mut expected);
        assert!(plan == expected, "{options:?}, frame {frame}");
        changes += following.levels.changed(&following.grid).next().is_some() as usize;
    }
    changes
}

/// Two layers or more of each metric, on DEMs of these sizes.
fn settings(batching: Batching) -> Vec<Options> {
    let mut all = Vec::new();
    for (k, layers) in [(2, 4), (3, 3), (4, 3), (5, 2)] {
        for (metric, px) in [(LevelMetric::Distance, 40.0), (LevelMetric::Box, 40.0), (LevelMetric::Error, 1.5)] {
            all.push(Options { k, layers, metric, leg_px: px, tolerance_px: px, batching, ..Options::default() });
        }
    }
    all
}

#[test]
fn plans_of_a_walk_are_those_decided_anew() {
    let heightmap = terrain(193, 250);
    for options in settings(Batching::Instanced) {
        let changes = compare(&heightmap, options, RandomWalk::new(options.k as u64, &heightmap).take(150));
        assert!(changes > 8, "{options:?}: {changes}");
    }
}

#[test]
fn merged_cells_of_a_walk_are_those_decided_anew() {
    let heightmap = terrain(120, 97);
    for options in settings(Batching::MergedCell) {
        let changes = compare(&heightmap, options, RandomWalk::new(3, &heightmap).take(60));
        assert!(changes > 3, "{options:?}: {changes}");
    }
}

/// Steps so small that most frames decide nothing: deadlines must not be late. Now and then the lens changes.
#[test]
fn plans_of_a_slow_flight_are_those_decided_anew() {
    let heightmap = terrain(193, 250);
    for options in settings(Batching::Instanced) {
        let (mut random, mut lens) = (SplitMix64::new(7), RandomWalk::LENS);
        let [x_m, z_m] = heightmap.extent_m();
        let views = (0..400).map(|frame| {
            let way_m = frame as f64 * 2.0 + random.range(0.0, 3.0);
            let [x, z] = [0.2 * x_m + way_m, 0.3 * z_m + way_m];
            let eye_world = [x, heightmap.ground_m(x, z) + 60.0, z].into();
            lens.size_px = if frame % 100 == 50 { [320, 180] } else { [640, 360] };
            View::new(&Camera { eye_world, heading: 1.0 + frame as f64 * 0.01, pitch: -0.1 }, &lens).unwrap()
        });
        let changes = compare(&heightmap, options, views);
        assert!((10..300).contains(&changes), "{options:?}: {changes}");
    }
}

/// What the GPU's instance buffer holds, and which instances each index list is drawn with.
struct Drawn {
    instances: Vec<PatchInstance>,
    by_list: BTreeSet<(u32, [i32; 2], u32)>,
}

impl Drawn {
    fn nothing() -> Self {
        Self { instances: vec![PatchInstance::zeroed(); 1 << 16], by_list: BTreeSet::new() }
    }

    fn replay(&mut self, plan: &FramePlan) {
        for upload in plan.uploads.iter().filter(|upload| upload.buffer == Buffer::Instances) {
            let bytes = bytemuck::cast_slice_mut::<_, u8>(&mut self.instances);
            bytes[upload.offset as usize..][..upload.bytes.len()].copy_from_slice(plan.bytes_of(upload));
        }
        self.by_list.clear();
        for draw in &plan.draws {
            for instance in &self.instances[draw.instances.start as usize..draw.instances.end as usize] {
                let is_new = self.by_list.insert((draw.indices.start, instance.origin, instance.tag));
                assert!(is_new, "{instance:?} is drawn twice");
            }
        }
    }
}

/// Jumps, small steps, turns, and views without culling.
#[test]
fn leaves_collected_anew_are_those_that_are_followed() {
    let heightmap = terrain(193, 250);
    for options in settings(Batching::Instanced) {
        let mut methods = [false, true].map(|anew| {
            let mut method = Htp::new(heightmap.clone(), options).unwrap();
            method.collect_anew(anew);
            (method, Drawn::nothing(), FramePlan::default())
        });
        let mut changes = 0;
        for (frame, view) in RandomWalk::new(options.k as u64 + 5, &heightmap).take(150).enumerate() {
            for (method, drawn, plan) in &mut methods {
                method.set_culling(frame % 7 != 3);
                method.plan(&view, plan);
                drawn.replay(plan);
            }
            let [(method, followed, _), (_, anew, _)] = &methods;
            assert_eq!(anew.by_list, followed.by_list, "{options:?}, frame {frame}");
            changes += method.levels.changed(&method.grid).next().is_some() as usize;
        }
        assert!(changes > 8, "{options:?}: {changes}");
    }
}
