//! TIFF and GeoTIFF.

mod codec;
mod geo;
mod ifd;
mod layout;
mod overview;
mod predictor;

use std::io::{self, Read};
use std::ops::Range;

use crate::DemError;
use crate::input::{Input, ReadSeek};
use crate::raster::{Facts, Grid, Heights};
use crate::samples::{ByteOrder, Packing, SampleType};

use codec::Compression;
use ifd::Tags;
pub use ifd::is_one;
use layout::Layout;
use predictor::{Predictor, RowLayout};

/// Bytes that are read at once, to the end of the row: a core has them at hand still when they are judged.
const AT_ONCE: u64 = 1 << 17;

pub struct TiffGrid {
    input: Input,
    facts: Facts,
    layout: Layout,
    order: ByteOrder,
    /// The band to read, from 0.
    band: u32,
}

/// `band` and `overview` count from 1.
pub fn open(mut input: Input, band: Option<u32>, overview: Option<u32>) -> Result<TiffGrid, DemError> {
    let tags = Tags::read(&mut input)?;
    let mut layout = Layout::read(&mut input, &tags)?;
    let bands = layout.bands;
    let chosen = band.unwrap_or(1);
    if !(1..=bands).contains(&chosen) {
        return Err(input.refuse(format!("no band {chosen}; expected 1 to {bands}")));
    }
    if layout.is_colour && layout.samples == SampleType::U8 && band.is_none() {
        let reason = "a TIFF of 8-bit colours, which is a picture; expected one number a sample, or --band";
        return Err(input.refuse(reason));
    }
    let mut facts = Facts::new(describe(&layout, &tags), layout.columns, layout.rows, layout.samples);
    facts.bands = bands;
    if bands > 1 && band.is_none() {
        facts.warnings.push(format!("{bands} bands: the first is read; --band chooses another"));
    }
    geo::read(&mut input, &tags, chosen - 1, &mut facts)?;
    if let Some(overview) = overview {
        layout = overview::read(&mut input, &tags, overview, &mut facts)?;
    }
    layout.join_strips(AT_ONCE);
    Ok(TiffGrid { input, facts, layout, order: tags.order, band: chosen - 1 })
}

fn describe(layout: &Layout, tags: &Tags) -> String {
    let name = if tags.count(geo::KEYS).is_some() { "GeoTIFF" } else { "TIFF" };
    let big = if tags.is_big { ", BigTIFF" } else { "" };
    let chunks = match layout.is_tiled {
        true => format!("tiles of {} x {}", layout.chunk_columns, layout.chunk_rows),
        false => format!("strips of {}", layout.chunk_rows),
    };
    let predictor = match layout.predictor {
        Predictor::None => "",
        Predictor::Differences => " with differences",
        Predictor::Floats => " with differences of floats",
    };
    format!("{name}{big}, {chunks}, {}{predictor}", layout.compression.name())
}

impl Grid for TiffGrid {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn decode(&mut self, heights: &mut Heights) -> Result<(), DemError> {
        let plane = if self.layout.is_planar { self.band as u64 * self.layout.chunks_a_plane() } else { 0 };
        let (mut row, mut sorted) = (vec![0; self.layout.row_bytes() as usize], Vec::new());
        for chunk in 0..self.layout.chunks_a_plane() {
            self.decode_chunk(chunk, plane, &mut row, &mut sorted, heights)?;
            if heights.is_stopped() {
                break;
            }
        }
        Ok(())
    }

    fn is_by_rows(&self) -> bool {
        !self.layout.is_tiled && !self.facts.south_up
    }
}

impl TiffGrid {
    fn decode_chunk(
        &mut self,
        chunk: u64,
        plane: u64,
        row: &mut [u8],
        sorted: &mut Vec<u8>,
        heights: &mut Heights,
    ) -> Result<(), DemError> {
        let [offset, bytes] = self.layout.chunks[(plane + chunk) as usize];
        if bytes == 0 {
            // Left out: its samples stay voids.
            return Ok(());
        }
        let layout = &self.layout;
        let first_row = (chunk / layout.across()) as u32 * layout.chunk_rows;
        let first_column = (chunk % layout.across()) as u32 * layout.chunk_columns;
        let (rows, columns) = (first_row + layout.rows_of(chunk), first_column.saturating_add(layout.chunk_columns));
        if !heights.wants(first_row..rows, first_column..columns) {
            return Ok(());
        }
        if self.is_plain_floats() && self.fill_rows(chunk, plane, first_row, heights)? {
            return Ok(());
        }
        let layout = &self.layout;
        let row_layout = RowLayout {
            interleaved: layout.interleaved() as usize,
            sample_bytes: layout.samples.bytes(),
            order: self.order,
        };
        let own = if layout.is_planar { 0 } else { self.band as usize * row_layout.sample_bytes };
        let stride = row_layout.interleaved * row_layout.sample_bytes;
        let packed = self.input.from(offset)?.take(bytes);
        let done = layout.compression.reader(packed).and_then(|mut reader| {
            for r in 0..layout.rows_of(chunk) {
                reader.read_exact(row)?;
                let order = layout.predictor.undo(row, row_layout, sorted);
                let packing = Packing { samples: layout.samples, order, stride };
                packing.put(heights, first_row + r, first_column, &row[own..]);
                if heights.is_stopped() {
                    break;
                }
            }
            Ok(())
        });
        done.map_err(|error| self.chunk_error(plane + chunk, error))
    }

    /// Whether rows of the file are rows of floats as a heightmap has them.
    fn is_plain_floats(&self) -> bool {
        let Layout { samples, compression, predictor, is_tiled, .. } = self.layout;
        (samples, self.order, self.layout.interleaved()) == (SampleType::F32, ByteOrder::Little, 1)
            && (compression, predictor, is_tiled) == (Compression::None, Predictor::None, false)
    }

    /// Reads a strip of such rows straight to where they are kept; false where that is not to be.
    fn fill_rows(&mut self, chunk: u64, plane: u64, first: u32, heights: &mut Heights) -> Result<bool, DemError> {
        let ([offset, bytes], rows) = (self.layout.chunks[(plane + chunk) as usize], self.layout.rows_of(chunk));
        let row_bytes = self.layout.row_bytes();
        if bytes < row_bytes * rows as u64 {
            return Ok(false);
        }
        let filled = fill(self.input.from(offset)?, heights, first..first + rows, AT_ONCE.div_ceil(row_bytes) as usize);
        filled.map_err(|error| self.chunk_error(plane + chunk, error))
    }

    /// Errors without a number by the operating system are the decoders'.
    fn chunk_error(&self, chunk: u64, error: std::io::Error) -> DemError {
        if error.raw_os_error().is_some() {
            return self.input.read_error(error);
        }
        let (name, compression) = (self.layout.chunk_name(), self.layout.compression.name());
        self.input.refuse(format!("{name} {chunk} is broken ({error}); expected {compression} samples: fetch it again"))
    }
}

/// So many rows at once.
fn fill(input: &mut dyn ReadSeek, heights: &mut Heights, rows: Range<u32>, at_once: usize) -> io::Result<bool> {
    for start in rows.clone().step_by(at_once) {
        let some = start..rows.end.min(start + at_once as u32);
        let Some(values) = heights.rows_to_fill(some.clone()) else { return Ok(false) };
        input.read_exact(bytemuck::cast_slice_mut(values))?;
        values.iter_mut().for_each(|value| *value = f32::from_bits(u32::from_le(value.to_bits())));
        heights.judge_rows(some);
    }
    Ok(true)
}
