//! Triangles and draws of whole DEMs without culling, by sizes of patches and groups.

use terrain_core::{Camera, Heightmap, Lens, View};

use crate::whole_dem::{Mesh, WholeDem};

pub fn compare(dem: &Heightmap, sizes: &[(u32, u32)]) {
    let wholes: Vec<WholeDem> = sizes.iter().map(|(patch, group)| WholeDem::new(dem.clone(), *patch, *group)).collect();
    for (place, at, above_m) in
        [("mid", [0.5, 0.5], 100.0), ("corner", [0.02, 0.02], 100.0), ("high", [0.5, 0.5], 20_000.0)]
    {
        for tolerance_px in [0.5, 1.0, 2.0] {
            println!("{place} {tolerance_px} px");
            let view = view(dem, at, above_m);
            let ways = sizes.iter().zip(&wholes).flat_map(|way| [false, true].map(|blocks| (way, blocks)));
            for (((patch, group), whole), blocks) in ways {
                let (leveled, mut mesh) = (whole.of_view(&view, tolerance_px, blocks), Mesh::default());
                whole.triangulate(&leveled, &mut mesh);
                let bound = whole.bound(&leveled, &whole.triangles(&mesh), Some(&view));
                let triangles = mesh.indices.len() / 3;
                let share = bound.worst_px / tolerance_px;
                let name = format!("patch {patch} group {group}{}", if blocks { " blocks" } else { "" });
                println!("  {name:24} {triangles:6} triangles, {:4} draws, {share:.4} of the tolerance", mesh.nodes);
            }
        }
    }
}

fn view(dem: &Heightmap, [x, z]: [f64; 2], above_m: f64) -> View {
    let [width_m, depth_m] = dem.extent_m();
    let (x_m, z_m) = (x * width_m, z * depth_m);
    let camera = Camera { eye_world: [x_m, dem.ground_m(x_m, z_m) + above_m, z_m].into(), heading: 0.0, pitch: 0.0 };
    View::new(&camera, &Lens { fov_y: 60f64.to_radians(), size_px: [1280, 720], near_m: 1.0 }).unwrap()
}
