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

pub fn open(mut input: Input, allow_8_bit: bool, colours: Option<ColourCode>) -> Result<PngGrid, DemError> {
    let header = Header::parse(&input.start).map_err(|reason| input.refuse(reason))?;
    let mut facts = header.facts(allow_8_bit, colours).map_err(|reason| input.refuse(reason))?;
    facts.nodata = match colours {
        None if header.has_alpha() => Some(f64::NAN),
        None => transparent_value(&mut input)?,
        Some(_) => None,
    };
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
            let put =
                |row: u32, bytes: &[u8], heights: &mut Heights| put(&self.facts, self.colours, heights, row, bytes);
            match self.is_interlaced {
                true => put_interlaced(&mut reader, |row, bytes| put(row, bytes, heights)),
                false => put_rows(&mut reader, heights, put),
            }
        });
        decoded.map_err(|error| picture_error(&self.input, error))
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
        None if bytes.len() > facts.columns as usize * facts.samples.bytes() => {
            // Grey and alpha; what is wholly transparent is a void.
            let samples = bytes.as_chunks().0.iter().map(|&[a, b, c, d]| match [c, d] {
                [0, 0] => f64::NAN,
                _ => f64::from(u16::from_be_bytes([a, b])),
            });
            heights.put(row, 0, samples);
        }
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
    fn has_alpha(&self) -> bool {
        matches!(colour_name(self.colour), "greyscale and alpha" | "colour and alpha")
    }

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
            (16, "greyscale and alpha", None) => ("PNG with alpha", SampleType::U16),
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

/// Chunks before the picture's own that are looked at; a PNG has a dozen at most.
const MAX_CHUNKS: u32 = 1000;

/// The grey that stands for nothing (PNG specification, 11.3.1.1: tRNS), if the file has one.
fn transparent_value(input: &mut Input) -> Result<Option<f64>, DemError> {
    let mut at = SIGNATURE.len() as u64;
    for _ in 0..MAX_CHUNKS {
        if !input.holds(at, 12) {
            break;
        }
        let head = input.bytes_at(at, 8)?;
        let (length, name) = head.split_first_chunk().expect("eight bytes");
        let length = u32::from_be_bytes(*length);
        match name {
            b"tRNS" if length == 2 && input.holds(at + 8, 2) => {
                let value = input.bytes_at(at + 8, 2)?;
                return Ok(Some(f64::from(u16::from_be_bytes([value[0], value[1]]))));
            }
            b"IDAT" => break,
            _ => at += 12 + u64::from(length),
        }
    }
    Ok(None)
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
    let mut values = vec![0; columns as usize];
    write_rows(path, [columns, rows], (png::ColorType::Grayscale, png::BitDepth::Sixteen), &mut |bytes| {
        fill(&mut values)?;
        let pairs = bytes.as_chunks_mut().0.iter_mut();
        pairs.zip(&values).for_each(|(pair, value)| *pair = value.to_be_bytes());
        Ok(())
    })
}

/// Writes a picture of 8-bit red, green and blue, with one row in memory.
pub fn write_png_rgb_rows(
    path: &Path,
    columns: u32,
    rows: u32,
    fill: &mut dyn FnMut(&mut [[u8; 3]]) -> io::Result<()>,
) -> Result<(), DemError> {
    write_rows(path, [columns, rows], (png::ColorType::Rgb, png::BitDepth::Eight), &mut |bytes| {
        fill(bytes.as_chunks_mut().0)
    })
}

fn write_rows(
    path: &Path,
    [columns, rows]: [u32; 2],
    (colour, depth): (png::ColorType, png::BitDepth),
    fill: &mut dyn FnMut(&mut [u8]) -> io::Result<()>,
) -> Result<(), DemError> {
    let written = write_atomically(path, |out| {
        let mut encoder = png::Encoder::new(out, columns, rows);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        let mut file = encoder.write_header()?;
        let mut out = file.stream_writer()?;
        let mut row = vec![0; columns as usize * colour.samples() * (depth as usize / 8)];
        for _ in 0..rows {
            fill(&mut row)?;
            out.write_all(&row)?;
        }
        out.finish()?;
        Ok(file.finish()?)
    });
    written.map_err(|e| DemError::io("write", path, e))
}
