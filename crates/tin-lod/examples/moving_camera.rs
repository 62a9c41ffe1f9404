//! Heights in, triangles out, for a camera that moves: `cargo run --release -p tin-lod --example moving_camera`

use std::sync::Arc;

use terrain_core::{Camera, FramePlan, FrameStats, Heightmap, Lens, LodMethod, View};
use tin_lod::{Options, Tin};

fn main() {
    // 257 x 257 samples, 30 m apart: a round hill of 400 m.
    let height_m = |column: i32, row: i32| (400 - (column - 128).pow(2) / 40 - (row - 128).pow(2) / 40).max(0) as f32;
    let heights_m = (0..257).flat_map(|row| (0..257).map(move |column| height_m(column, row))).collect();
    let heightmap = Arc::new(Heightmap::new(257, 257, [30.0, 30.0], heights_m).expect("a sound grid"));

    // No sample in view is farther than one pixel from the mesh.
    let options = Options { tolerance_px: 1.0, ..Options::default() };
    let mut tin = Tin::new(heightmap, options).expect("options in range");
    let lens = Lens { fov_y: 1.0, size_px: [1280, 720], near_m: 0.5 };
    let mut plan = FramePlan::default();
    for step in 0..6 {
        let eye_world = [1000.0 * step as f64, 600.0, 3855.0].into();
        let view = View::new(&Camera { eye_world, heading: 1.57, pitch: -0.2 }, &lens).expect("a finite camera");
        tin.plan(&view, &mut plan);
        let FrameStats { triangles, upload_bytes, .. } = FrameStats::of(&plan);
        println!("eye at {:5.0} m: {triangles} triangles, {upload_bytes} bytes to upload", view.eye_world.x);
    }
}
