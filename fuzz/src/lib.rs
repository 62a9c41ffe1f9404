//! What the targets share. No finding may be a panic, an endless loop, or memory beyond what the limit allows; a refusal is
//! one line.

use terrain_dem::{ReadOptions, read_bytes};

/// So few that a mutant is read in microseconds.
const MAX_SAMPLES: u64 = 1 << 16;

/// Reads the bytes as a file of this name.
pub fn read(name: &str, bytes: &[u8], options: ReadOptions) {
    let options = ReadOptions { max_samples: Some(MAX_SAMPLES), spacing_m: Some([1.0; 2]), ..options };
    match read_bytes(name, bytes.to_vec(), &options) {
        Ok(dem) => assert!(dem.heightmap.heights_m().len() as u64 <= MAX_SAMPLES),
        Err(error) => assert!(!error.is_io() && !error.to_string().contains('\n'), "{error}"),
    }
}
