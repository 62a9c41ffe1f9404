//! PNG: 16-bit greyscale in and out, heights packed in colours in.

use std::io::ErrorKind;
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{DynamicImage, ImageBuffer, ImageError, Limits, Luma};
use terrain_core::Heightmap;

use crate::input::Input;
use crate::raster::{Facts, Grid, Heights};
use crate::samples::SampleType;
use crate::{ColourCode, DemError, write_atomically};

const EXPECTED: &str = "a 16-bit greyscale PNG";

/// The first bytes of every PNG.
const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// The most bytes that one byte of a PNG can stand for, generously: 258 from 2 bits.
const MOST_A_BYTE: u64 = 1040;

/// What the decoder may allocate beside the picture itself, in bytes: its window, one row, colour profiles and texts.
const MAX_DECODER_BYTES: u64 = 64 << 20;

/// A PNG whose header is one that we read.
pub struct PngGrid {
    input: Input,
    facts: Facts,
    colours: Option<ColourCode>,
}

pub fn is_one(input: &Input) -> bool {
    input.start.starts_with(SIGNATURE)
}

pub fn open(input: Input, allow_8_bit: bool, colours: Option<ColourCode>) -> Result<PngGrid, DemError> {
    let checked = Header::parse(&input.start).and_then(|header| header.facts(allow_8_bit, colours));
    let facts = checked.map_err(|reason| input.refuse(reason))?;
    // A colour takes three bytes at least, a height one or two.
    let bytes_each = if colours.is_some() { 3 } else { facts.samples.bytes() as u64 };
    if facts.count().saturating_mul(bytes_each) > input.length.saturating_mul(MOST_A_BYTE) {
        let Facts { columns, rows, .. } = facts;
        let length = input.length;
        return Err(input
            .refuse(format!("a PNG of {length} bytes; expected more for {columns} x {rows} samples: fetch it again")));
    }
    Ok(PngGrid { input, facts, colours })
}

impl Grid for PngGrid {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn decode(&mut self, heights: &mut Heights) -> Result<(), DemError> {
        let columns = self.facts.columns as usize;
        let file = self.input.from(0)?;
        let picture = PngDecoder::with_limits(file, limits()).and_then(DynamicImage::from_decoder);
        match (picture.map_err(|e| picture_error(&self.input, e))?, self.colours) {
            (DynamicImage::ImageLuma16(grey), None) => put(heights, columns, grey.as_raw(), 1, |v| v[0] as f64),
            (DynamicImage::ImageLuma8(grey), None) => put(heights, columns, grey.as_raw(), 1, |v| v[0] as f64),
            (DynamicImage::ImageRgb8(rgb), Some(code)) => put(heights, columns, rgb.as_raw(), 3, |v| height_m(code, v)),
            (DynamicImage::ImageRgba8(rgba), Some(code)) => {
                put(heights, columns, rgba.as_raw(), 4, |v| height_m(code, v))
            }
            _ => return Err(self.input.refuse(format!("a PNG with transparent samples; expected {EXPECTED} without"))),
        }
        Ok(())
    }
}

/// Puts all rows; each sample is `channels` values.
fn put<T>(heights: &mut Heights, columns: usize, values: &[T], channels: usize, value: impl Fn(&[T]) -> f64) {
    for (row, values) in values.chunks(columns * channels).enumerate() {
        heights.put(row as u32, 0, values.chunks(channels).map(&value));
    }
}

fn height_m(code: ColourCode, colour: &[u8]) -> f64 {
    let [red, green, blue] = [colour[0], colour[1], colour[2]].map(f64::from);
    match code {
        ColourCode::Terrarium => red * 256.0 + green + blue / 256.0 - 32_768.0,
        ColourCode::Mapbox => (red * 65_536.0 + green * 256.0 + blue) * 0.1 - 10_000.0,
    }
}

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_image_width = Some(Heightmap::MAX_SIDE);
    limits.max_image_height = Some(Heightmap::MAX_SIDE);
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    limits
}

fn picture_error(input: &Input, error: ImageError) -> DemError {
    match error {
        ImageError::IoError(e) if e.kind() == ErrorKind::UnexpectedEof => {
            input.refuse("the PNG ends before its last row; expected a whole file: fetch it again")
        }
        ImageError::IoError(e) => input.read_error(e),
        e => input.refuse(format!("a broken PNG ({e}); expected {EXPECTED}: fetch or convert it again")),
    }
}

/// The image header (PNG specification, 11.2.1). Read here because the decoder widens 1, 2 and 4 bits to 8, and
/// palettes to colours, without a word, and because a size can be refused before anything of it is allocated.
#[derive(Debug)]
struct Header {
    columns: u32,
    rows: u32,
    bits: u8,
    colour: u8,
}

impl Header {
    fn parse(start: &[u8]) -> Result<Self, String> {
        let (Some((columns, rest)), Some(b"IHDR")) =
            (start.get(16..).and_then(|s| s.split_first_chunk()), start.get(12..16))
        else {
            return Err(format!("a PNG without a header; expected {EXPECTED}: fetch it again"));
        };
        let Some((rows, &[bits, colour, ..])) = rest.split_first_chunk() else {
            return Err(format!("a PNG that ends in its header; expected {EXPECTED}: fetch it again"));
        };
        Ok(Self { columns: u32::from_be_bytes(*columns), rows: u32::from_be_bytes(*rows), bits, colour })
    }

    fn facts(&self, allow_8_bit: bool, colours: Option<ColourCode>) -> Result<Facts, String> {
        let Self { columns, rows, bits, colour } = *self;
        let (what, samples) = match (bits, colour_name(colour), colours) {
            (8, "colour" | "colour and alpha", Some(ColourCode::Terrarium)) => ("PNG, Terrarium", SampleType::U32),
            (8, "colour" | "colour and alpha", Some(ColourCode::Mapbox)) => {
                ("PNG, Mapbox terrain-RGB", SampleType::U32)
            }
            (_, colour, Some(_)) => {
                return Err(format!("a PNG of {bits}-bit {colour}; expected 8-bit colour, or no --png-colours"));
            }
            (16, "greyscale", None) => ("PNG", SampleType::U16),
            (8, "greyscale", None) if allow_8_bit => ("PNG", SampleType::U8),
            (8, "greyscale", None) => {
                return Err(format!(
                    "an 8-bit greyscale PNG, whose 256 heights show as steps; expected {EXPECTED}, or --allow-8-bit"
                ));
            }
            (_, colour, None) => return Err(format!("a PNG of {bits}-bit {colour}; expected {EXPECTED}: convert it")),
        };
        Ok(Facts::new(what, columns, rows, samples))
    }
}

fn colour_name(colour: u8) -> &'static str {
    match colour {
        0 => "greyscale",
        2 => "colour",
        3 => "palette",
        4 => "greyscale and alpha",
        6 => "colour and alpha",
        _ => "unknown-colour",
    }
}

/// Writes a 16-bit greyscale PNG of `columns * rows` values, row by row.
pub fn write_png16(path: &Path, columns: u32, rows: u32, values: &[u16]) -> Result<(), DemError> {
    let picture = ImageBuffer::<Luma<u16>, _>::from_raw(columns, rows, values)
        .filter(|_| values.len() as u64 == columns as u64 * rows as u64)
        .expect("one value a sample");
    let written = write_atomically(path, |out| {
        let encoder = PngEncoder::new_with_quality(out, CompressionType::Best, FilterType::Adaptive);
        picture.write_with_encoder(encoder).map_err(|e| match e {
            ImageError::IoError(e) => e,
            e => std::io::Error::other(e),
        })
    });
    written.map_err(|e| DemError::io("write", path, e))
}
