//! Heights in, triangles out: `cargo run --release -p tin-lod --example heights_to_triangles`

use terrain_core::Heightmap;

fn main() {
    // 513 x 513 samples, 30 m apart, row by row from the north-west: waves of 600 m.
    let height_m = |column: u32, row: u32| 300.0 * ((column as f32 / 60.0).sin() + (row as f32 / 45.0).cos());
    let heights_m = (0..513).flat_map(|row| (0..513).map(move |column| height_m(column, row))).collect();
    let heightmap = Heightmap::new(513, 513, [30.0, 30.0], heights_m).expect("a sound grid");

    for tolerance_m in [0.5, 2.0, 8.0, 32.0] {
        let triangles = tin_lod::mesh_at_tolerance(&heightmap, tolerance_m);
        let [a, b, c] = triangles[0];
        println!(
            "{tolerance_m:4} m: {} triangles of 524288, the first one from samples {a}, {b}, {c}",
            triangles.len()
        );
    }
}
