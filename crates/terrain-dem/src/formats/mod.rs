//! Elevation files by their content.

mod archive;
mod ascii;
mod dted;
mod esri;
mod foreign;
mod hgt;
mod keys;
mod npy;
mod packed;
mod pgm;
mod place;
pub mod png;
mod raw;
mod tiff;
mod usgs;
mod words;

use crate::input::Input;
use crate::raster::Grid;
use crate::{DemError, ReadOptions};

/// What a file may be, for messages.
pub const EXPECTED: &str =
    "an elevation file (GeoTIFF, 16-bit PNG, .hgt, .asc, .bil or .flt with .hdr, DTED, USGS DEM, PGM, .npy)";

/// The most bytes that a sample takes in an archive: a line of its own in a text.
const MAX_BYTES_A_SAMPLE: u64 = 16;

/// What an archive may always unpack to, in bytes, and what each of its own bytes may: its header is only seen then, and
/// elevations hardly ever get to a fiftieth of their size.
const LITTLE: u64 = 64 << 20;
const MOST_A_BYTE: u64 = 64;

/// The command that makes a file of a kind that is not read into one that is.
fn convert(shown: &str) -> String {
    format!("gdal_translate -co COMPRESS=DEFLATE {shown} OUT.tif")
}

/// Reads a file's header, whatever the file's name. Only `.hgt` and headers beside files of samples go by their names,
/// since nothing in them says what they are.
pub fn open(input: Input, options: &ReadOptions) -> Result<Box<dyn Grid>, DemError> {
    if archive::is_one(&input) {
        let by_length = LITTLE.saturating_add(input.length.saturating_mul(MOST_A_BYTE));
        let limit = options.limit().saturating_mul(MAX_BYTES_A_SAMPLE).min(by_length);
        let inner = archive::unpack(input, limit)?;
        if archive::is_one(&inner) {
            return Err(inner.refuse("an archive in an archive; expected the file itself: unpack it"));
        }
        return open_plain(inner, options);
    }
    open_plain(input, options)
}

fn open_plain(input: Input, options: &ReadOptions) -> Result<Box<dyn Grid>, DemError> {
    if let Some(layout) = options.raw {
        return Ok(Box::new(raw::open(input, layout)?));
    }
    if png::is_one(&input) {
        return Ok(Box::new(png::open(input, options.allow_8_bit, options.colours)?));
    }
    if tiff::is_one(&input) {
        return Ok(Box::new(tiff::open(input, options.band, options.overview)?));
    }
    if input.start.starts_with(npy::MAGIC) {
        return Ok(Box::new(npy::open(input)?));
    }
    if input.start.starts_with(dted::MAGIC) {
        return Ok(Box::new(dted::open(input)?));
    }
    if usgs::is_one(&input) {
        return Ok(Box::new(usgs::open(input)?));
    }
    if pgm::is_one(&input) {
        return pgm::open(input, options.allow_8_bit);
    }
    // Before text grids: a GridFloat's header begins as one.
    if esri::is_header(&input) {
        return Ok(Box::new(esri::open_by_header(&input)?));
    }
    if ascii::is_one(&input) {
        return Ok(Box::new(ascii::open(input)?));
    }
    if let Some(header) = esri::header_of(&input) {
        return Ok(Box::new(esri::open(input, header)?));
    }
    if hgt::is_one(&input) {
        return Ok(Box::new(hgt::open(input)?));
    }
    Err(input.refuse(foreign::reason(&input, EXPECTED)))
}
