//! 16-bit greyscale PNG, in and out.

use std::io::{BufRead, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngDecoder, PngEncoder};
use image::{DynamicImage, ImageBuffer, ImageError, Limits, Luma};
use terrain_core::Heightmap;

use crate::{DemError, MAX_SAMPLES, write_atomically};

pub const EXPECTED: &str = "a 16-bit greyscale PNG";

/// The first bytes of every PNG.
const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// What the decoder may allocate beside the picture itself, in bytes: its window, one row, colour profiles and texts.
const MAX_DECODER_BYTES: u64 = 64 << 20;

/// The values of a greyscale PNG, row by row.
#[derive(Debug, PartialEq)]
pub struct Image {
    pub columns: u32,
    pub rows: u32,
    pub values: Vec<u16>,
}

/// Decodes a PNG; `shown` stands for the file in messages.
pub fn decode(shown: &str, mut file: impl BufRead + Seek, allow_8_bit: bool) -> Result<Image, DemError> {
    let io_error = |e| DemError::io("read", Path::new(shown), e);
    let refuse = |reason| DemError::input(shown, reason);
    let mut start = Vec::new();
    (&mut file).take(Header::BYTES).read_to_end(&mut start).map_err(io_error)?;
    file.seek(SeekFrom::Start(0)).map_err(io_error)?;
    Header::parse(&start).and_then(|header| header.check(allow_8_bit)).map_err(refuse)?;

    let picture = PngDecoder::with_limits(file, limits()).and_then(DynamicImage::from_decoder);
    match picture.map_err(|e| picture_error(shown, e))? {
        DynamicImage::ImageLuma16(grey) => {
            Ok(Image { columns: grey.width(), rows: grey.height(), values: grey.into_raw() })
        }
        DynamicImage::ImageLuma8(grey) => Ok(Image {
            columns: grey.width(),
            rows: grey.height(),
            values: grey.into_raw().into_iter().map(u16::from).collect(),
        }),
        _ => Err(refuse(format!("a PNG with transparent samples; expected {EXPECTED} without"))),
    }
}

fn limits() -> Limits {
    let mut limits = Limits::default();
    limits.max_image_width = Some(Heightmap::MAX_SIDE);
    limits.max_image_height = Some(Heightmap::MAX_SIDE);
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    limits
}

fn picture_error(shown: &str, error: ImageError) -> DemError {
    match error {
        ImageError::IoError(e) if e.kind() == ErrorKind::UnexpectedEof => {
            DemError::input(shown, "the PNG ends before its last row; expected a whole file: fetch it again".to_owned())
        }
        ImageError::IoError(e) => DemError::io("read", Path::new(shown), e),
        e => {
            let reason = format!("a broken PNG ({e}); expected {EXPECTED}: fetch or convert it again");
            DemError::input(shown, reason.replace('\n', " "))
        }
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
    /// Signature, length and name of the chunk, and its first four fields.
    const BYTES: u64 = 26;

    fn parse(start: &[u8]) -> Result<Self, String> {
        if start.is_empty() {
            return Err(format!("an empty file; expected {EXPECTED}"));
        }
        if !start.starts_with(SIGNATURE) {
            let shown = start[..start.len().min(12)].escape_ascii();
            return Err(format!("not a PNG (starts with \"{shown}\"); expected {EXPECTED}"));
        }
        let (Some((columns, rest)), Some(b"IHDR")) =
            (start.get(16..).and_then(|s| s.split_first_chunk()), start.get(12..16))
        else {
            return Err(format!("a PNG without a header; expected {EXPECTED}: fetch it again"));
        };
        let Some((rows, &[bits, colour])) = rest.split_first_chunk() else {
            return Err(format!("a PNG that ends in its header; expected {EXPECTED}: fetch it again"));
        };
        Ok(Self { columns: u32::from_be_bytes(*columns), rows: u32::from_be_bytes(*rows), bits, colour })
    }

    fn check(&self, allow_8_bit: bool) -> Result<(), String> {
        let Self { columns, rows, bits, colour } = *self;
        match (bits, colour_name(colour)) {
            (16, "greyscale") => {}
            (8, "greyscale") if allow_8_bit => {}
            (8, "greyscale") => {
                return Err(format!(
                    "an 8-bit greyscale PNG, whose 256 heights show as steps; expected {EXPECTED}, or --allow-8-bit"
                ));
            }
            (_, colour) => return Err(format!("a PNG of {bits}-bit {colour}; expected {EXPECTED}: convert it")),
        }
        let side = 2..=Heightmap::MAX_SIDE;
        if !side.contains(&columns) || !side.contains(&rows) || columns as u64 * rows as u64 > MAX_SAMPLES {
            return Err(format!(
                "{columns} x {rows} samples; expected 2 to {} a side and at most {MAX_SAMPLES} in all: crop it",
                Heightmap::MAX_SIDE
            ));
        }
        Ok(())
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
