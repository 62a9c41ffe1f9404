//! Heights and a camera in, triangles out: `cargo run --release -p htp-lod --example heights_to_patches`

use std::sync::Arc;

use htp_lod::{Htp, Options};
use terrain_core::{Camera, FramePlan, Heightmap, Lens, LodMethod, MeshMirror, View};

fn main() {
    // 513 x 513 samples, 30 m apart, row by row from the north-west: waves of 600 m.
    let height_m = |column: u32, row: u32| 300.0 * ((column as f32 / 60.0).sin() + (row as f32 / 45.0).cos());
    let heights_m = (0..513).flat_map(|row| (0..513).map(move |column| height_m(column, row))).collect();
    let heightmap = Arc::new(Heightmap::new(513, 513, [30.0, 30.0], heights_m).expect("a sound grid"));

    let camera = Camera { eye_world: [0.0, 900.0, 7680.0].into(), heading: 1.57, pitch: -0.1 };
    let lens = Lens { fov_y: 1.0, size_px: [1280, 720], near_m: 0.5 };
    let view = View::new(&camera, &lens).expect("a finite camera");
    for tolerance_px in [0.5, 1.0, 2.0, 4.0] {
        let options = Options { tolerance_px, ..Options::bounded() };
        let mut htp = Htp::new(heightmap.clone(), options).expect("options in range");
        htp.set_culling(false); // the whole DEM, as from this camera
        let mut plan = FramePlan::default();
        htp.plan(&view, &mut plan);
        // The mirror does what a GPU does with a plan.
        let mut mirror = MeshMirror::new(&htp.buffers(), &heightmap);
        mirror.replay(&plan).expect("a sound plan");
        let triangles = mirror.triangles();
        let [a, b, c] = triangles[0].samples.map(|sample| (sample.column, sample.row));
        println!("{tolerance_px} px: {} triangles of 524288, the first one {a:?}, {b:?}, {c:?}", triangles.len());
    }
}
