//! PNG: 16-bit greyscale in and out, heights packed in colours in.

use std::io::{self, ErrorKind, Write};
use std::path::Path;

use png::{DecodingError, Limits};

use crate::input::{Input, ReadSeek};
use crate::raster::{Facts, Grid, Heights};
use crate::samples::{ByteOrder, Packing, SampleType};
use crate::{ColourCode, DemError, write_atomically};

const EXPECTED: &str = "a 16-bit greyscale PNG";

/// The first bytes of every PNG.
const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// The most bytes that one byte of a PNG can stand for, generously: 258 from 2 bits.
const MOST_A_BYTE: u64 = 1040;

/// What the decoder may allocate beside the picture itself, in bytes: its window, one row, colour profiles and texts.
const MAX_DECODER_BYTES: usize = 64 << 20;

/// A PNG whose header is one that we read.
pub struct PngGrid {
    input: Input,
    facts: Facts,
    colours: Option<ColourCode>,
    is_interlaced: bool,
}

pub fn is_one(input: &Input) -> bool {
    input.start.starts_with(SIGNATURE)
}

pub fn open(input: Input, allow_8_bit: bool, colours: Option<ColourCode>) -> Result<PngGrid, DemError> {
    let header = Header::parse(&input.start).map_err(|reason| input.refuse(reason))?;
    let facts = header.facts(allow_8_bit, colours).map_err(|reason| input.refuse(reason))?;
    // A colour takes three bytes at least, a height one or two.
    let bytes_each = if colours.is_some() { 3 } else { facts.samples.bytes() as u64 };
    if facts.count().saturating_mul(bytes_each) > input.length.saturating_mul(MOST_A_BYTE) {
        let Facts { columns, rows, .. } = facts;
        let length = input.length;
        return Err(input
            .refuse(format!("a PNG of {length} bytes; expected more for {columns} x {rows} samples: fetch it again")));
    }
    Ok(PngGrid { input, facts, colours, is_interlaced: header.interlace != 0 })
}

impl Grid for PngGrid {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn decode(&mut self, heights: &mut Heights) -> Result<(), DemError> {
        let file = self.input.from(0)?;
        let decoded = png::Decoder::new_with_limits(file, Limits { bytes: MAX_DECODER_BYTES }).read_info();
        let decoded = decoded.and_then(|mut reader| {
            if reader.info().trns.is_some() && self.colours.is_none() {
                return Ok(false);
            }
            let put =
                |row: u32, bytes: &[u8], heights: &mut Heights| put(&self.facts, self.colours, heights, row, bytes);
            match self.is_interlaced {
                true => put_interlaced(&mut reader, |row, bytes| put(row, bytes, heights)),
                false => put_rows(&mut reader, heights, put),
            }
            .map(|()| true)
        });
        match decoded {
            Ok(true) => Ok(()),
            Ok(false) => Err(self.input.refuse(format!("a PNG with transparent samples; expected {EXPECTED} without"))),
            Err(error) => Err(picture_error(&self.input, error)),
        }
    }

    fn is_by_rows(&self) -> bool {
        !self.is_interlaced
    }
}

type Reader<'a> = png::Reader<&'a mut dyn ReadSeek>;

/// Puts a row as soon as it is decoded.
fn put_rows(
    reader: &mut Reader,
    heights: &mut Heights,
    put: impl Fn(u32, &[u8], &mut Heights),
) -> Result<(), DecodingError> {
    let mut row = 0;
    while let Some(decoded) = reader.next_row()? {
        put(row, decoded.data(), heights);
        row += 1;
        if heights.is_stopped() {
            return Ok(());
        }
    }
    // What follows has checksums, too.
    reader.finish()
}

/// Decodes the picture as a whole: its rows come in seven passes.
fn put_interlaced(reader: &mut Reader, mut put: impl FnMut(u32, &[u8])) -> Result<(), DecodingError> {
    let mut picture = vec![0; reader.output_buffer_size().ok_or(DecodingError::LimitsExceeded)?];
    let row_bytes = reader.next_frame(&mut picture)?.line_size;
    picture.chunks(row_bytes).enumerate().for_each(|(row, bytes)| put(row as u32, bytes));
    reader.finish()
}

fn put(facts: &Facts, colours: Option<ColourCode>, heights: &mut Heights, row: u32, bytes: &[u8]) {
    match colours {
        None => {
            let stride = facts.samples.bytes();
            Packing { samples: facts.samples, order: ByteOrder::Big, stride }.put(heights, row, 0, bytes);
        }
        Some(code) => {
            let channels = bytes.len() / facts.columns as usize;
            heights.put(row, 0, bytes.chunks(channels).map(|colour| height_m(code, colour)));
        }
    }
}

fn height_m(code: ColourCode, colour: &[u8]) -> f64 {
    let [red, green, blue] = [colour[0], colour[1], colour[2]].map(f64::from);
    match code {
        ColourCode::Terrarium => red * 256.0 + green + blue / 256.0 - 32_768.0,
        ColourCode::Mapbox => (red * 65_536.0 + green * 256.0 + blue) * 0.1 - 10_000.0,
    }
}

fn picture_error(input: &Input, error: DecodingError) -> DemError {
    match error {
        DecodingError::IoError(e) if e.kind() == ErrorKind::UnexpectedEof => {
            input.refuse("the PNG ends before its last row; expected a whole file: fetch it again")
        }
        DecodingError::IoError(e) => input.read_error(e),
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
    interlace: u8,
}

impl Header {
    fn parse(start: &[u8]) -> Result<Self, String> {
        let (Some((columns, rest)), Some(b"IHDR")) =
            (start.get(16..).and_then(|s| s.split_first_chunk()), start.get(12..16))
        else {
            return Err(format!("a PNG without a header; expected {EXPECTED}: fetch it again"));
        };
        let Some((rows, &[bits, colour, _, _, interlace, ..])) = rest.split_first_chunk() else {
            return Err(format!("a PNG that ends in its header; expected {EXPECTED}: fetch it again"));
        };
        Ok(Self { columns: u32::from_be_bytes(*columns), rows: u32::from_be_bytes(*rows), bits, colour, interlace })
    }

    fn facts(&self, allow_8_bit: bool, colours: Option<ColourCode>) -> Result<Facts, String> {
        let Self { columns, rows, bits, colour, .. } = *self;
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
    assert_eq!(values.len() as u64, columns as u64 * rows as u64, "one value a sample");
    let mut all = values.chunks(columns as usize);
    write_png16_rows(path, columns, rows, &mut |row| {
        row.copy_from_slice(all.next().expect("one row of values a row"));
        Ok(())
    })
}

/// As [`write_png16`], with one row in memory: `fill` is given the rows from the northern one on, and may end the writing.
pub fn write_png16_rows(
    path: &Path,
    columns: u32,
    rows: u32,
    fill: &mut dyn FnMut(&mut [u16]) -> io::Result<()>,
) -> Result<(), DemError> {
    let written = write_atomically(path, |out| {
        let mut encoder = png::Encoder::new(out, columns, rows);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        let mut file = encoder.write_header()?;
        let mut out = file.stream_writer()?;
        let mut row = vec![0; columns as usize];
        for _ in 0..rows {
            fill(&mut row)?;
            let bytes: Vec<u8> = row.iter().flat_map(|value| value.to_be_bytes()).collect();
            out.write_all(&bytes)?;
        }
        out.finish()?;
        Ok(file.finish()?)
    });
    written.map_err(|e| DemError::io("write", path, e))
}
