//! DEMs to test on.

use std::path::Path;

use terrain_core::{Heightmap, Sample, SplitMix64};
use terrain_dem::ReadOptions;

/// A DEM that lies beside the project on some machines; without it the test says so and goes on.
pub fn shared(name: &str) -> Option<Heightmap> {
    let (spacing_m, offset_m) = match name.split('_').next() {
        Some("ps") => (160.0, 0.0),
        Some("deathvalley") => (80.0, -110.0),
        _ => (30.0, 0.0),
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/dem");
    let path = folder.join(name).with_extension("png");
    if !path.is_file() {
        eprintln!("skipped: {} is not on this machine", path.display());
        return None;
    }
    let options = ReadOptions {
        spacing_m: Some([spacing_m; 2]),
        scale: Some(0.1),
        offset_m: Some(offset_m),
        ..Default::default()
    };
    Some(terrain_dem::read(&path, &options).unwrap().heightmap.as_ref().clone())
}

/// A DEM by a formula of column and row.
pub fn dem(columns: u32, rows: u32, mut height_m: impl FnMut(u32, u32) -> f64) -> Heightmap {
    let heights_m = (0..columns * rows).map(|i| height_m(i % columns, i / columns) as f32).collect();
    Heightmap::new(columns, rows, [30.0, 45.0], heights_m).unwrap()
}

/// Shapes that leave little room, and heights that put many samples on circles, or all but one on a plane.
pub fn awkward() -> Vec<(String, Heightmap)> {
    let mut random = SplitMix64::new(1);
    let mut all = Vec::new();
    for (columns, rows) in [(2, 2), (2, 70), (70, 2), (3, 3), (9, 8), (31, 33), (65, 65), (66, 34)] {
        all.push((format!("{columns} x {rows}"), dem(columns, rows, |_, _| random.range(0.0, 300.0))));
    }
    let mut push = |name: &str, dem| all.push((name.to_owned(), dem));
    push("flat", dem(70, 50, |_, _| -3.0));
    push("spike", dem(70, 50, |x, z| if (x, z) == (20, 17) { 9000.0 } else { 0.0 }));
    push("spike on an edge", dem(70, 50, |x, z| if (x, z) == (32, 17) { 9000.0 } else { 0.0 }));
    push("checkerboard", dem(70, 50, |x, z| if (x + z) % 2 == 0 { -1e4 } else { 1e4 }));
    push("huge heights", dem(70, 50, |_, _| random.range(-1e6, 1e6)));
    push("small hills, very high up", dem(70, 50, |x, z| 1e6 + ((x * z) % 7) as f64));
    push("plane", dem(70, 50, exact_ramp));
    push("plane but for the rounding", dem(70, 50, rounded_ramp));
    push("steps", dem(70, 50, |x, z| ((x / 5 + z / 7) * 10) as f64));
    push("sea with islands", sea(0.0));
    push("land in missing values", sea(-32_768.0));
    all
}

/// A slope whose heights f32 has exactly.
pub fn exact_ramp(x: u32, z: u32) -> f64 {
    x as f64 * 3.5 - z as f64
}

/// A slope whose heights f32 rounds, each another way.
pub fn rounded_ramp(x: u32, z: u32) -> f64 {
    x as f64 * 0.1 + z as f64 * 0.37
}

/// Rough terrain, 85 % of it at one height below all the rest. Nothing knows of missing values: they are heights.
fn sea(level_m: f64) -> Heightmap {
    let land = terrain_dem::synthetic::generate(90, 75, 4);
    let mut heights_m = land.heights_m().to_vec();
    heights_m.sort_by(f32::total_cmp);
    let shore_m = heights_m[heights_m.len() * 85 / 100] as f64;
    dem(90, 75, |column, row| {
        let height_m = land.height_m(Sample { column, row }) as f64;
        if height_m > shore_m { height_m - shore_m } else { level_m }
    })
}
