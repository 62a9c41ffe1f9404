//! Our readers against GDAL's writers: `gdal_matrix.py` writes one grid in many variants.
//!
//! Skipped with a message where Python or rasterio is missing.

use std::path::Path;
use std::process::{Command, Stdio};

use terrain_dem::{ReadOptions, read};

/// What the script says where rasterio is missing.
const SKIPPED: i32 = 77;

/// Fewer variants than this mean that the script lost some.
const AT_LEAST: usize = 40;

#[test]
fn every_variant_that_gdal_writes_has_equal_heights() {
    let folder = tempfile::tempdir().unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/gdal_matrix.py");
    let ran = Command::new("python3").arg(script).arg(folder.path()).stderr(Stdio::inherit()).output();
    let Ok(output) = ran else { return println!("skipped: no python3") };
    let list = String::from_utf8(output.stdout).unwrap();
    if output.status.code() == Some(SKIPPED) {
        return println!("skipped: {}", list.trim());
    }
    assert!(output.status.success(), "{list}");
    let mut wrong = Vec::new();
    for line in list.lines() {
        wrong.extend(difference(folder.path(), line).map(|difference| format!("{line}: {difference}")));
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), list.lines().count(), wrong.join("\n"));
    assert!(list.lines().count() >= AT_LEAST);
    println!("{} variants", list.lines().count());
}

/// What is wrong with one file, if anything is.
fn difference(folder: &Path, line: &str) -> Option<String> {
    let mut words = line.split('\t');
    let [file, expected] = [words.next()?, words.next()?].map(|name| folder.join(name));
    let expected: Vec<f64> =
        std::fs::read(expected).unwrap().as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    // PNG and PGM have no spacing.
    let spacing_m = line.contains("PN").then_some([30.0; 2]);
    let overview = line.contains("overview=1").then_some(1);
    let dem = match read(&file, &ReadOptions { spacing_m, allow_8_bit: true, overview, ..ReadOptions::default() }) {
        Ok(dem) => dem,
        Err(error) => return Some(error.to_string()),
    };
    let (columns, heights_m) = (dem.heightmap.columns() as usize, dem.heightmap.heights_m());
    let is_void =
        |i: usize| dem.voids.as_ref().is_some_and(|voids| voids.is_void((i % columns) as u32, (i / columns) as u32));
    let wrong =
        |i: &usize| is_void(*i) != expected[*i].is_nan() || !is_void(*i) && heights_m[*i] != expected[*i] as f32;
    let first = (0..expected.len()).find(wrong).map(|i| (i % columns, i / columns, heights_m[i], expected[i]));
    first.map(|(column, row, found, expected)| format!("{found} at {column}, {row}; expected {expected}"))
}
