//! What has to be known of a DEM before it can be cut: one pass over its rows.

use terrain_core::{HeightFormat, VoidMask};

use super::{CellsHeader, Provenance, Voids, codes};
use crate::options::{HtpError, Options};

/// Samples of which the coarsest streamed level drops all but one, along a row, at least: what stays resident is then
/// little.
const COARSE_STEP: u32 = 8;

/// Why a DEM cannot be cut.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CutError {
    /// Settings that no hierarchy has.
    #[error(transparent)]
    Options(#[from] HtpError),
    /// Nothing to stream, or nothing to keep.
    #[error("1 layer: expected at least 2, a resident one above those that are loaded")]
    OneLayer,
    /// The cells would be too large to be loaded one by one.
    #[error("k of {k} with {layers} layers makes cells of {side} sample intervals: expected at most {max}",
        side = (*.k as u64).pow(*.layers), max = Scan::MAX_CELL_SIDE)]
    Side {
        /// [`Options::k`].
        k: u32,
        /// [`Options::layers`].
        layers: u32,
    },
    /// What the DEM's files say of it is too long.
    #[error("{bytes} bytes of source, licence, notice and place: expected at most {max}", max = Provenance::MAX_BYTES)]
    Texts {
        /// All four together.
        bytes: usize,
    },
    /// The rows that were cut are not those that were scanned.
    #[error("the heights changed while they were cut; expected the same in both passes: cut them again")]
    Changed,
}

/// The first of two passes over the rows of a DEM: the range of its heights, how they can be kept without loss, and
/// their checksum.
pub struct Scan {
    header: CellsHeader,
    /// Formats that have held all heights so far, the best first.
    formats: Vec<HeightFormat>,
    heights: HeightsCrc,
}

impl Scan {
    /// The largest cell, in sample intervals. A row of cells is in memory as a whole while it is cut.
    pub const MAX_CELL_SIDE: u32 = 1024;

    /// For a DEM of some columns and rows. `declared` are the metres a step, and at the value 0, that its file states:
    /// heights are kept in 16 bits where these, or whole metres, say them exactly.
    pub fn new(
        samples: [u32; 2],
        spacing_m: [f64; 2],
        declared: Option<[f64; 2]>,
        options: &Options,
    ) -> Result<Self, CutError> {
        check_shape(options)?;
        let Options { k, layers, .. } = *options;
        let streamed = (1..layers - 1).find(|streamed| k.pow(*streamed) >= COARSE_STEP).unwrap_or(layers - 1);
        let header = CellsHeader {
            k,
            layers,
            samples,
            spacing_m,
            format: HeightFormat::F32,
            height_range_m: [f32::INFINITY, f32::NEG_INFINITY],
            streamed,
            heights_crc: 0,
            voids: None,
            provenance: Provenance::default(),
        };
        let formats = declared
            .into_iter()
            .chain([[1.0, 0.0]])
            .flat_map(formats_of)
            .filter(|format| codes::is_sound(*format))
            .collect();
        Ok(Self { header, formats, heights: HeightsCrc::default() })
    }

    /// Takes note of the samples that have no heights; the rows hold the fill there.
    pub fn set_voids(&mut self, mask: &VoidMask) {
        assert_eq!([mask.columns(), mask.rows()], self.header.samples, "a mask of the same DEM");
        self.header.voids = Voids::of(mask);
    }

    /// Takes the next row, from the north.
    pub fn push(&mut self, row_m: &[f32]) {
        self.heights.push(row_m);
        self.formats.retain(|format| row_m.iter().all(|height_m| codes::holds(*format, *height_m)));
        let [low, high] = &mut self.header.height_range_m;
        (*low, *high) = row_m.iter().fold((*low, *high), |(low, high), h| (low.min(*h), high.max(*h)));
    }

    /// What was found, after the last row.
    pub fn finish(self) -> CellsHeader {
        let format = self.formats.first().copied().unwrap_or(HeightFormat::F32);
        CellsHeader { format, heights_crc: self.heights.finish(), ..self.header }
    }
}

/// Values of a file as 16-bit codes: unsigned, and signed.
fn formats_of([scale_m, offset_m]: [f64; 2]) -> [HeightFormat; 2] {
    [0.0, i16::MIN as f64].map(|first| HeightFormat::U16 { scale_m, offset_m: offset_m + first * scale_m })
}

/// Refuses hierarchies that cannot be streamed.
pub(super) fn check_shape(options: &Options) -> Result<(), CutError> {
    options.validate()?;
    let Options { k, layers, .. } = *options;
    if layers < 2 {
        return Err(CutError::OneLayer);
    }
    if (k as u64).pow(layers) > Scan::MAX_CELL_SIDE as u64 {
        return Err(CutError::Side { k, layers });
    }
    Ok(())
}

/// [`CellsHeader::heights_crc`], row by row.
#[derive(Default)]
pub(super) struct HeightsCrc {
    crc: crc32fast::Hasher,
    bytes: Vec<u8>,
}

impl HeightsCrc {
    pub fn push(&mut self, row_m: &[f32]) {
        self.bytes.clear();
        self.bytes.extend(row_m.iter().flat_map(|height_m| height_m.to_le_bytes()));
        self.crc.update(&self.bytes);
    }

    pub fn finish(self) -> u32 {
        self.crc.finalize()
    }
}
