//! Real tiles, which are too large for the repository: skipped with a message where they are not.

use std::path::{Path, PathBuf};

use terrain_core::Sample;
use terrain_dem::{Dem, ReadOptions, VoidPolicy, read};

/// Beside the repository.
fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/dem").join(name);
    if !path.is_file() {
        println!("skipped: no {}", path.display());
        return None;
    }
    Some(path)
}

fn range_m(dem: &Dem) -> [f32; 2] {
    let map = &dem.heightmap;
    map.height_range_m(Sample { column: 0, row: 0 }, Sample { column: map.columns() - 1, row: map.rows() - 1 })
}

/// SRTM, 1 arc-second, warped to UTM: int16 in tiles.
#[test]
fn big_tujunga() {
    let Some(path) = shared("bigtujunga.tif") else { return };
    let dem = read(&path, &ReadOptions::default()).unwrap();
    let map = &dem.heightmap;
    assert_eq!((map.columns(), map.rows(), map.spacing_m()), (1197, 643, [30.0, 30.0]));
    // The San Gabriel mountains, from the edge of Los Angeles to Mount Wilson's neighbours.
    let [low, high] = range_m(&dem);
    assert!((200.0..400.0).contains(&low) && (1800.0..2600.0).contains(&high), "{low} to {high} m");
    println!("{:?}, {low} to {high} m", dem.reading);
}

/// SRTM, 3 arc-seconds: the Three Sisters in Oregon, with 392 voids.
#[test]
fn three_sisters() {
    let Some(path) = shared("N44W122.hgt") else { return };
    let dem = read(&path, &ReadOptions::default()).unwrap();
    let (map, voids) = (&dem.heightmap, dem.voids.as_ref().unwrap());
    assert_eq!((map.columns(), map.rows(), voids.count()), (1201, 1201, 392));
    // A third of 1/1200 degree at latitude 44.5: 79.6 km and 111.1 km a degree.
    let [x, z] = map.spacing_m();
    assert!((x - 66.3).abs() < 0.1 && (z - 92.6).abs() < 0.1, "{x} x {z} m");
    // The fills keep to the range of the samples around them.
    assert_eq!(range_m(&dem), [322.0, 3130.0]);
    assert_eq!(
        dem.reading.warnings,
        ["392 of 1442401 samples (0.027 %) are voids: left open (--voids fill fills them from their rim)"]
    );
    let refused = read(&path, &ReadOptions { voids: VoidPolicy::Error, ..ReadOptions::default() }).unwrap_err();
    assert!(refused.to_string().ends_with("are voids; expected none, or --voids hole or fill"), "{refused}");
}
