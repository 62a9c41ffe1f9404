//! What the targets share. No finding may be a panic, an endless loop, or memory beyond what the limit allows; a refusal is
//! one line.

use std::path::Path;

use terrain_dem::{Dem, DemError, ReadOptions, read_bytes};

/// So few that a mutant is read in microseconds.
const MAX_SAMPLES: u64 = 1 << 16;

/// Reads the bytes as a file of this name.
pub fn read(name: &str, bytes: &[u8], options: ReadOptions) {
    check(read_bytes(name, bytes.to_vec(), &limited(options)));
}

/// Reads a file that has others beside it.
pub fn read_file(path: &Path, options: ReadOptions) {
    check(terrain_dem::read(path, &limited(options)));
}

fn limited(options: ReadOptions) -> ReadOptions {
    ReadOptions { max_samples: Some(MAX_SAMPLES), spacing_m: Some([1.0; 2]), ..options }
}

fn check(read: Result<Dem, DemError>) {
    match read {
        Ok(dem) => assert!(dem.heightmap.heights_m().len() as u64 <= MAX_SAMPLES),
        Err(error) => assert!(!error.is_io() && !error.to_string().contains('\n'), "{error}"),
    }
}
