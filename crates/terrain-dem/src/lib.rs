//! Elevation files in, terrain meshes out, and seeded synthetic terrain.
//!
//! [`open`] takes what a user types: a file, the name of a DEM that comes with the program, or `synthetic:193x250:7`.
//! A file is a 16-bit greyscale PNG, the northern row first; `height_m = value * scale + offset_m`. A TOML file of the
//! same name beside it (the sidecar) says what the numbers mean:
//!
//! ```toml
//! spacing_m = [74.8, 92.5]   # metres between samples in x and z, or one number for both
//! scale = 0.1                # metres a unit; 1 if left out
//! offset_m = -10             # 0 if left out
//! source = "who measured it"
//! licence = "what one may do with it"
//! notice = "what its owner wants to be shown with it"
//! ```
//!
//! [`ReadOptions`] override the sidecar.

mod atomic;
mod error;
mod ply;
mod png;
mod sidecar;
pub mod synthetic;

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Seek};
use std::path::Path;
use std::sync::Arc;

use terrain_core::Heightmap;

pub use atomic::write_atomically;
pub use error::DemError;
pub use ply::write_ply;
pub use png::write_png16;

use sidecar::Sidecar;

/// The largest DEM in samples: 23,170 x 23,170, or about 3 GB of memory while it is read.
pub const MAX_SAMPLES: u64 = 1 << 29;

/// A DEM that comes with the program: name, PNG, sidecar.
const BUILT_IN: [(&str, &[u8], &str); 1] = [(
    "jacksboro",
    include_bytes!("../../../data/dem/jacksboro.png"),
    include_str!("../../../data/dem/jacksboro.toml"),
)];

/// A DEM and where it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct Dem {
    /// The file's name without its extension; fit for file names.
    pub name: String,
    /// The heights, shared with the methods that fly over them.
    pub heightmap: Arc<Heightmap>,
    /// Who made it, and by what way it came here.
    pub source: Option<String>,
    /// What one may do with it.
    pub licence: Option<String>,
    /// What its owner wants to be shown with it.
    pub notice: Option<String>,
}

/// What the user says about a DEM. `None` leaves it to the sidecar.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Metres between neighbouring samples in x and z, positive. Without it the sidecar must say it.
    pub spacing_m: Option<[f64; 2]>,
    /// Metres a unit; 1 if the sidecar does not say it either.
    pub scale: Option<f64>,
    /// Height of the value 0 in metres; 0 if the sidecar does not say it either.
    pub offset_m: Option<f64>,
    /// Take a PNG of 8 bits a sample too, whose 256 heights show as steps; off by default.
    pub allow_8_bit: bool,
}

/// Opens what the user typed: `synthetic:COLUMNSxROWS:SEED`, a name in [`built_in_names`], or else a path
/// (`./jacksboro` for a file of a built-in's name).
pub fn open(spec: &str, options: &ReadOptions) -> Result<Dem, DemError> {
    if spec.starts_with(synthetic::PREFIX) {
        return open_synthetic(spec, options);
    }
    if let Some((name, png, sidecar)) = BUILT_IN.iter().find(|(name, ..)| *name == spec) {
        let sidecar = Sidecar::parse(&format!("{name}.toml"), sidecar)?;
        return decode(name, name, Cursor::new(*png), sidecar, options);
    }
    read(Path::new(spec), options)
}

/// What a user may name, for messages.
fn expected() -> String {
    let built_in: Vec<&str> = built_in_names().collect();
    format!("{}, {}COLUMNSxROWS:SEED, or a built-in DEM: {}", png::EXPECTED, synthetic::PREFIX, built_in.join(", "))
}

/// The DEMs that come with the program.
pub fn built_in_names() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|(name, ..)| *name)
}

/// Reads a PNG and its sidecar.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Dem, DemError> {
    let shown = path.display().to_string();
    let io_error = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => DemError::input(&shown, format!("no such file; expected {}", expected())),
        _ => DemError::io("read", path, source),
    };
    if !path.metadata().map_err(io_error)?.is_file() {
        return Err(DemError::input(&shown, format!("not a file; expected {}", png::EXPECTED)));
    }
    let file = BufReader::new(File::open(path).map_err(io_error)?);
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    decode(&name, &shown, file, Sidecar::read(&path.with_extension("toml"))?, options)
}

/// `shown` stands for the file in messages.
fn decode(
    name: &str,
    shown: &str,
    file: impl BufRead + Seek,
    sidecar: Sidecar,
    options: &ReadOptions,
) -> Result<Dem, DemError> {
    let Some(spacing_m) = options.spacing_m.or(sidecar.spacing_m) else {
        let reason = "no spacing; expected `spacing_m = [30.0, 30.0]` (metres) in a file of the same name that ends in \
                      .toml, or --spacing 30";
        return Err(DemError::input(shown, reason.to_owned()));
    };
    let image = png::decode(shown, file, options.allow_8_bit)?;
    let scale = options.scale.or(sidecar.scale).unwrap_or(1.0);
    let offset_m = options.offset_m.or(sidecar.offset_m).unwrap_or(0.0);
    let heights_m = image.values.iter().map(|&value| (value as f64 * scale + offset_m) as f32).collect();
    let heightmap = Heightmap::new(image.columns, image.rows, spacing_m, heights_m)
        .map_err(|e| DemError::input(shown, e.to_string()))?;
    let Sidecar { source, licence, notice, .. } = sidecar;
    Ok(Dem { name: name.to_owned(), heightmap: Arc::new(heightmap), source, licence, notice })
}

fn open_synthetic(spec: &str, options: &ReadOptions) -> Result<Dem, DemError> {
    let Some((columns, rows, seed)) = synthetic::parse(spec) else {
        let reason = format!(
            "no synthetic terrain; expected synthetic:COLUMNSxROWS:SEED with 2 to {} samples a side and at most \
             {MAX_SAMPLES} in all, such as synthetic:193x250:7",
            Heightmap::MAX_SIDE
        );
        return Err(DemError::input(spec, reason));
    };
    let plain = synthetic::generate(columns, rows, seed);
    let (scale, offset_m) = (options.scale.unwrap_or(1.0), options.offset_m.unwrap_or(0.0));
    let heights_m = plain.heights_m().iter().map(|&height_m| (height_m as f64 * scale + offset_m) as f32).collect();
    let spacing_m = options.spacing_m.unwrap_or(plain.spacing_m());
    let heightmap =
        Heightmap::new(columns, rows, spacing_m, heights_m).map_err(|e| DemError::input(spec, e.to_string()))?;
    let name = format!("synthetic-{columns}x{rows}-{seed}");
    Ok(Dem { name, heightmap: Arc::new(heightmap), source: Some(spec.to_owned()), licence: None, notice: None })
}

#[cfg(test)]
mod tests;
