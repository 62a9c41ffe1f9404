//! Runs the program `terrain-lod` as a user does.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program with these arguments in a folder of its own choice.
pub fn terrain_lod(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_terrain-lod")).current_dir(folder).args(arguments).output().unwrap()
}

/// Runs `bench --no-gpu` with these further arguments and returns the rows of its summary.
pub fn bench(arguments: &[&str]) -> Vec<Row> {
    let place = tempfile::tempdir().unwrap();
    let all = [&["bench", "--no-gpu", "--repeats", "1", "--out", "results"], arguments].concat();
    let output = terrain_lod(place.path(), &all);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {said}");
    read_rows(&place.path().join("results/summary.csv"))
}

/// A row of `summary.csv`.
pub type Row = std::collections::BTreeMap<String, String>;

/// The rows of a CSV file.
pub fn read_rows(path: &Path) -> Vec<Row> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

/// A DEM that lies beside the project on some machines; without it the test says so and passes.
pub fn shared_dem(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/dem").join(name);
    if path.is_file() {
        return Some(path);
    }
    eprintln!("skipped: {} is not on this machine", path.display());
    None
}
