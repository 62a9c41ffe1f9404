//! What an engine does with the plans, here with plain arrays for buffers:
//! `cargo run --release -p htp-lod --example moving_camera_over_patches`

use std::sync::Arc;

use htp_lod::{Htp, Options};
use terrain_core::{Buffer, Camera, FramePlan, Heightmap, Lens, LodMethod, PatchInstance, View};

fn main() {
    // 257 x 257 samples, 30 m apart: a round hill of 400 m.
    let height_m = |column: i32, row: i32| (400 - (column - 128).pow(2) / 40 - (row - 128).pow(2) / 40).max(0) as f32;
    let heights_m = (0..257).flat_map(|row| (0..257).map(move |column| height_m(column, row))).collect();
    let heightmap = Arc::new(Heightmap::new(257, 257, [30.0, 30.0], heights_m).expect("a sound grid"));

    // No sample in view is farther than one pixel from the mesh.
    let mut htp = Htp::new(heightmap, Options::bounded()).expect("options in range");
    let lens = Lens { fov_y: 1.0, size_px: [1280, 720], near_m: 0.5 };
    let mut plan = FramePlan::default();
    // One patch of vertices, all index lists, and the instances, which alone change from frame to frame.
    let sizes = htp.buffers();
    let mut buffers = [sizes.vertices, sizes.indices, sizes.instances].map(|bytes| vec![0_u8; bytes as usize]);
    for step in 0..6 {
        let eye_world = [1000.0 * step as f64, 600.0, 3855.0].into();
        let view = View::new(&Camera { eye_world, heading: 1.57, pitch: -0.2 }, &lens).expect("a finite camera");
        htp.plan(&view, &mut plan);

        plan.growths.iter().for_each(|growth| buffers[growth.buffer as usize].resize(growth.bytes as usize, 0));
        for upload in &plan.uploads {
            let at = upload.offset as usize;
            buffers[upload.buffer as usize][at..at + upload.bytes.len()].copy_from_slice(plan.bytes_of(upload));
        }
        let patches: usize = plan.draws.iter().map(|draw| draw.instances.len()).sum();
        let first = plan.draws[0].instances.start as usize * size_of::<PatchInstance>();
        let bytes = &buffers[Buffer::Instances as usize][first..first + size_of::<PatchInstance>()];
        let instance: PatchInstance = bytemuck::pod_read_unaligned(bytes);
        println!(
            "eye at {:4.0} m: {patches} patches in {} draws, {} bytes sent; the first patch has its apex at {:?}",
            view.eye_world.x,
            plan.draws.len(),
            plan.bytes.len(),
            instance.origin,
        );
    }
}
