//! A mesh for other programs, as Wavefront OBJ:
//! `cargo run --release -p tin-lod --example export_obj -- 2.0 > hill.obj`

use std::io::{self, BufWriter, Write};

use terrain_core::Heightmap;

fn main() -> io::Result<()> {
    let tolerance_m = std::env::args().nth(1).map_or(1.0, |metres| metres.parse().expect("a tolerance in metres"));
    // 257 x 257 samples, 10 m apart: a round hill of 400 m.
    let height_m = |column: i32, row: i32| (400 - (column - 128).pow(2) / 40 - (row - 128).pow(2) / 40).max(0) as f32;
    let heights_m = (0..257).flat_map(|row| (0..257).map(move |column| height_m(column, row))).collect();
    let heightmap = Heightmap::new(257, 257, [10.0, 10.0], heights_m).expect("a sound grid");

    let mut out = BufWriter::new(io::stdout().lock());
    for (i, height_m) in heightmap.heights_m().iter().enumerate() {
        writeln!(out, "v {} {height_m} {}", i % 257 * 10, i / 257 * 10)?;
    }
    for corners in tin_lod::mesh_at_tolerance(&heightmap, tolerance_m) {
        let [a, b, c] = corners.map(|sample| sample + 1); // OBJ counts from 1
        writeln!(out, "f {a} {b} {c}")?;
    }
    out.flush()
}
