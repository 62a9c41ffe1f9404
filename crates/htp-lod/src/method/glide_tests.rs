//! What is left of popping where levels glide: judged from the plans' own bytes, between the frames of a slow flight.

use super::*;
use terrain_core::error::ErrorOracle;
use terrain_core::popping::Popping;
use terrain_core::{Camera, Lens, MeshMirror};

const LENS: Lens = Lens { fov_y: 1.0, size_px: [640, 360], near_m: 1.0 };

/// A descent across a DEM: away from some of it and closer to the rest, in small steps.
fn slow_flight(heightmap: &Heightmap) -> Vec<View> {
    let [x_m, z_m] = heightmap.extent_m();
    let view = |frame: u32| {
        let way = frame as f64 / 120.0;
        let [x, z] = [(0.1 + 0.1 * way) * x_m, (0.9 - 0.1 * way) * z_m];
        let eye_world = [x, heightmap.ground_m(x, z) + 300.0 - 100.0 * way, z].into();
        View::new(&Camera { eye_world, heading: 0.8, pitch: -0.2 }, &LENS).unwrap()
    };
    (0..120).map(view).collect()
}

/// All popping of a flight, and in how many frames levels have changed.
fn popping(heightmap: &Arc<Heightmap>, options: Options) -> (Popping, usize) {
    let mut method = Htp::new(heightmap.clone(), options).unwrap();
    let mut mirror = MeshMirror::new(&method.buffers(), heightmap);
    let (mut oracle, mut plan) = (ErrorOracle::new(heightmap), FramePlan::default());
    let (mut popping, mut changes) = (Popping::default(), 0);
    for view in slow_flight(heightmap) {
        method.plan(&view, &mut plan);
        if mirror.replay(&plan).unwrap() {
            oracle.set_mesh(mirror.triangles());
            oracle.measure_popping(&view, &mut popping);
        }
        changes += method.levels.changed(&method.grid).next().is_some() as usize;
    }
    (popping, changes)
}

#[test]
fn levels_that_glide_do_not_pop() {
    let heights_m = terrain_dem::synthetic::generate(325, 325, 3).heights_m().to_vec();
    let heightmap = Arc::new(Heightmap::new(325, 325, [30.0; 2], heights_m).unwrap());
    for (k, layers) in [(2, 5), (3, 3), (4, 3)] {
        let popping_options = Options { k, layers, batching: Batching::Instanced, ..Options::default() };
        let (pops, changes) = popping(&heightmap, popping_options);
        let (glides, same_changes) = popping(&heightmap, Options { geomorph: true, ..popping_options });
        assert_eq!(changes, same_changes, "gliding changes no levels");
        assert!(changes > 40, "k {k}: {changes} changes of levels");
        let [popped_px, glided_px] = [&pops, &glides].map(|popping| popping.displacements().max_px());
        assert!(10.0 * glided_px < popped_px, "k {k}: {glided_px} px where {popped_px} px pop");
    }
}
