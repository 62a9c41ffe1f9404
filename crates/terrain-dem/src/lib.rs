//! Elevation files in, terrain meshes out, and seeded synthetic terrain.
//!
//! [`open`] takes what a user types: a file, the name of a DEM that comes with the program, or `synthetic:193x250:7`.
//! A file is known by its content: GeoTIFF, PNG (16-bit greyscale), SRTM `.hgt`, ESRI ASCII grid, `.bil` and `.flt` with
//! their `.hdr`, DTED, USGS ASCII DEM, PGM, `.npy`; one that needs no second file also alone in a gzip or zip. Its northern row becomes the first one;
//! `height_m = value * scale + offset_m`. A TOML file of the same name beside it (the sidecar) says what the file does
//! not:
//!
//! ```toml
//! spacing_m = [74.8, 92.5]   # metres between samples in x and z, or one number for both
//! scale = 0.1                # metres a unit; 1 if left out
//! offset_m = -10             # 0 if left out
//! nodata = 0                 # the file's value that stands for no height
//! raw = "513x513:uint16"     # the layout of a file without a header
//! crs = "EPSG:32611"         # the coordinate system in words
//! place = { west = 368000.0, north = 3807000.0, step = [30.0, 30.0], keys = [[3072, 0, 1, 32611]] } # as a GeoTIFF would
//! source = "who measured it"
//! licence = "what one may do with it"
//! notice = "what its owner wants to be shown with it"
//! ```
//!
//! [`ReadOptions`] override the sidecar, and the sidecar the file.
//!
//! A folder or a pattern (`N4*W12*.hgt`) is one DEM of several tiles: joined by their places, the rims that they share
//! compared, gaps between them voids.
//!
//! Reading goes in three steps: `formats` finds the decoder and reads the header, which must agree with the file's length
//! before anything is allocated for it; the decoder puts its samples row by row into a `raster::Heights`; `load` turns
//! these into a [`Dem`], its voids filled and marked. [`open_rows`] hands the rows on instead of keeping them: for DEMs that
//! are larger than memory.

mod atomic;
mod dem_file;
mod error;
mod extremes;
mod formats;
mod georef;
mod input;
mod load;
mod mesh_file;
mod mosaic;
mod options;
mod part;
mod raster;
mod resample;
mod rows;
mod samples;
mod sidecar;
mod spikes;
pub mod synthetic;
mod tiles;
mod voids;

use std::io;
use std::path::Path;
use std::sync::Arc;

use terrain_core::Heightmap;

pub use atomic::write_atomically;
pub use dem_file::{DemFormat, SIDECAR_MARK, Steps, sidecar_of, write_dem};
pub use error::DemError;
pub use formats::png::{write_png_rgb_rows, write_png16, write_png16_rows};
pub use georef::Georeference;
pub use load::count_voids;
pub use mesh_file::{Mesh, MeshFormat};
pub use options::{ColourCode, HeightUnit, RawLayout, ReadOptions, VoidPolicy};
pub use part::Crop;
pub use rows::{DemRows, open_rows};
pub use sidecar::{parse_whereabouts, whereabouts};
pub use terrain_core::VoidMask;

use input::Input;
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
    /// Which samples had no height, and hold one from their rim; `None` where all had one. The heightmap has them as its
    /// [voids](Heightmap::voids), unless they count as filled.
    pub voids: Option<Arc<VoidMask>>,
    /// Where it lies, if that is known in a way that a GeoTIFF can say.
    pub georeference: Option<Georeference>,
    /// What the file was taken for.
    pub reading: Reading,
}

/// What the reader understood of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// In words: `GeoTIFF, tiles of 256 x 256, LZW`.
    pub format: String,
    /// The type of the samples: `int16`.
    pub samples: &'static str,
    /// Samples at one place, of which one is read.
    pub bands: u32,
    /// Who said the spacing, and how.
    pub spacing_from: String,
    /// The coordinate system, as the file names it.
    pub crs: Option<String>,
    /// The unit of the heights in the file, if it or the user says it; metres are assumed otherwise.
    pub unit: Option<HeightUnit>,
    /// Metres a step of the file's values.
    pub scale: f64,
    /// Metres at the value 0.
    pub offset_m: f64,
    /// The value that stood for no height.
    pub nodata: Option<f64>,
    /// What the user should know, one line each; the file's name is not in them.
    pub warnings: Vec<String>,
}

/// Opens what the user typed: `synthetic:COLUMNSxROWS:SEED`, a name in [`built_in_names`], a folder or a pattern
/// (`N4*W12*.hgt`) of tiles, or else a path (`./jacksboro` for a file of a built-in's name).
pub fn open(spec: &str, options: &ReadOptions) -> Result<Dem, DemError> {
    if spec.starts_with(synthetic::PREFIX) {
        return open_synthetic(spec, options);
    }
    if let Some(tiles) = tiles_of(spec)? {
        return mosaic::load(spec, &tiles, options);
    }
    let (input, sidecar) = find(spec)?;
    load::load(input, sidecar, options)
}

/// The tiles that a folder or a pattern names; a built-in DEM comes before a folder of its name.
fn tiles_of(spec: &str) -> Result<Option<tiles::Tiles>, DemError> {
    if built_in_names().any(|name| name == spec) { Ok(None) } else { tiles::named(spec) }
}

/// A built-in DEM, or a file, with its sidecar.
fn find(spec: &str) -> Result<(Input, Sidecar), DemError> {
    if let Some((name, png, sidecar)) = BUILT_IN.iter().find(|(name, ..)| *name == spec) {
        let sidecar = Sidecar::parse(&format!("{name}.toml"), sidecar)?;
        return Ok((Input::memory((*name).to_owned(), format!("{name}.png"), *png)?, sidecar));
    }
    find_file(Path::new(spec))
}

/// What a user may name, for messages.
fn expected() -> String {
    let built_in: Vec<&str> = built_in_names().collect();
    format!("{}, {}COLUMNSxROWS:SEED, or a built-in DEM: {}", formats::EXPECTED, synthetic::PREFIX, built_in.join(", "))
}

/// The DEMs that come with the program.
pub fn built_in_names() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|(name, ..)| *name)
}

/// Reads an elevation file and its sidecar.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Dem, DemError> {
    let (input, sidecar) = find_file(path)?;
    load::load(input, sidecar, options)
}

fn find_file(path: &Path) -> Result<(Input, Sidecar), DemError> {
    let shown = path.display().to_string();
    let io_error = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => DemError::input(&shown, format!("no such file; expected {}", expected())),
        _ => DemError::io("read", path, source),
    };
    if !path.metadata().map_err(io_error)?.is_file() {
        return Err(DemError::input(&shown, format!("not a file; expected {}", formats::EXPECTED)));
    }
    Ok((Input::open(path)?, Sidecar::read(&path.with_extension("toml"))?))
}

/// Reads an elevation file that is in memory. Its name stands for it in messages, and tells the place of an `.hgt`; it has
/// no sidecar.
pub fn read_bytes(name: &str, bytes: Vec<u8>, options: &ReadOptions) -> Result<Dem, DemError> {
    load::load(Input::memory(name.to_owned(), name.to_owned(), bytes)?, Sidecar::default(), options)
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
    let whole = Dem {
        name: format!("synthetic-{columns}x{rows}-{seed}"),
        heightmap: Arc::new(heightmap),
        source: Some(spec.to_owned()),
        licence: None,
        notice: None,
        voids: None,
        georeference: None,
        reading: synthetic_reading(options),
    };
    let part = part::part(whole, options.crop, options.thin.unwrap_or(1));
    part.and_then(|part| resample::resample(part, options.resample_m)).map_err(|reason| DemError::input(spec, reason))
}

fn synthetic_reading(options: &ReadOptions) -> Reading {
    Reading {
        format: "synthetic".to_owned(),
        samples: "float32",
        bands: 1,
        spacing_from: options.spacing_m.map_or("the generator", |_| "--spacing").to_owned(),
        crs: None,
        unit: Some(HeightUnit::Metre),
        scale: options.scale.unwrap_or(1.0),
        offset_m: options.offset_m.unwrap_or(0.0),
        nodata: None,
        warnings: Vec::new(),
    }
}

#[cfg(test)]
mod tests;
