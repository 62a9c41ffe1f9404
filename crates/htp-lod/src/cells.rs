//! Cells as they are kept on disk and loaded one by one (section 4.2): what a DEM is cut into, once.
//!
//! Levels below [`CellsHeader::streamed`] are those that need dense samples; they are cut into cells and loaded around
//! the eye, each level by itself: the coarser ones are wanted farther out (`window`). Of the levels above all is kept
//! resident for good, for every cell: little, and always something to stand in for a cell that is not there.
//!
//! # The bytes
//!
//! ```text
//!  | header | resident part | coarsest streamed level | ... | level 0 | voids |    each part: a record a cell, row by row
//! ```
//!
//! | bytes of the header | little-endian |
//! |---|---|
//! | 8 | `htp-cell` |
//! | 4 | version: 3 |
//! | 5 x 4 | `k`, layers, streamed levels, columns and rows of the DEM |
//! | 2 x 8 | metres between samples in x and in z: f64 |
//! | 4 | bytes of a height: 2 or 4 |
//! | 2 x 8 | metres a step and metres at code 0: f64; zeros for heights of 4 bytes |
//! | 2 x 4 | lowest and highest height in metres: f32 |
//! | 4 | CRC-32 of the DEM's heights (f32, row by row) |
//! | 8 | samples that are voids |
//! | 4 | CRC-32 of the voids; 0 where there are none |
//! | 4 x 4 | bytes of the four texts |
//! | 4 | CRC-32 of the 108 bytes before |
//! | by the header | source, licence, notice and place of the DEM, UTF-8; empty where it has none |
//! | 4 | CRC-32 of the texts |
//!
//! | bytes of a record | |
//! |---|---|
//! | 2 x 4 | column and row of the cell |
//! | by the header | codes of its samples, both rims included, padded to 4 bytes: u16, or f32. For level n every `k^n`-th, in the resident part every [`CellsHeader::coarse_step`]-th |
//! | by the header | lowest and highest sample in metres of each square, by level from 1: f32 |
//! | by the header | error records (`errors`) of each square, by level from 1 |
//! | 4 | CRC-32 of the CRC-32 of the DEM's heights, the part's finest level (u32), and all of the record before |
//!
//! | voids | where there are any |
//! |---|---|
//! | a multiple of 8 | a bit a sample, row by row over the DEM: 64 to a u64, the first in its lowest bit, zeros after the last |
//!
//! All records of a part have the same length, so that a cell is found without a table: what is beyond the DEM repeats
//! its last samples, or holds zeros. The ranges of level 0 are not kept, since they follow from its samples.

mod bytes;
mod codes;
mod cutter;
mod file;
mod header;
mod local;
mod resident;
mod scan;
mod voids;

pub use cutter::{Cutter, cut, cut_steps};
pub use file::{CellFile, CellSource, CellsError};
pub use scan::{CutError, Scan};
pub use voids::Voids;

use terrain_core::{HeightFormat, HeightTiles};

use crate::budget;
use crate::options::{HtpError, Options};
use crate::stream;

/// What all cells of a DEM have in common.
#[derive(Clone, Debug, PartialEq)]
pub struct CellsHeader {
    /// [`Options::k`](crate::Options::k) that the cells are cut for.
    pub k: u32,
    /// [`Options::layers`](crate::Options::layers) likewise.
    pub layers: u32,
    /// Columns and rows of the DEM.
    pub samples: [u32; 2],
    /// Metres between neighbouring samples in x and in z.
    pub spacing_m: [f64; 2],
    /// How heights are kept; without loss.
    pub format: HeightFormat,
    /// Lowest and highest sample of the DEM in metres: stored errors count steps of 1/65,535 of the difference.
    pub height_range_m: [f32; 2],
    /// Levels that are streamed, from 0 up; fewer than `layers`.
    pub streamed: u32,
    /// CRC-32 of the DEM's heights (f32 little-endian, row by row): cells of another DEM are told by it.
    pub heights_crc: u32,
    /// Where the DEM has no heights: those that are kept there are the fill. `None` where it has all.
    pub voids: Option<Voids>,
    /// Where the DEM comes from.
    pub provenance: Provenance,
}

/// Where a DEM comes from, on which terms, and where it lies, as far as its files say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Provenance {
    /// Who measured it, and where it can be had.
    pub source: Option<String>,
    /// On which terms.
    pub licence: Option<String>,
    /// What whoever passes it on must say.
    pub notice: Option<String>,
    /// Its place and coordinate system, in the words of whoever cut it: nobody here reads them.
    pub place: Option<String>,
}

impl Provenance {
    /// Bytes of all four texts, at most.
    pub const MAX_BYTES: usize = 1 << 16;

    fn texts(&self) -> [&str; 4] {
        [&self.source, &self.licence, &self.notice, &self.place].map(|text| text.as_deref().unwrap_or_default())
    }

    /// Refuses texts that are too long to be kept with cells.
    pub fn check(&self) -> Result<(), CutError> {
        let bytes = self.texts().map(str::len).iter().sum();
        if bytes > Self::MAX_BYTES { Err(CutError::Texts { bytes }) } else { Ok(()) }
    }
}

impl CellsHeader {
    /// Samples of the DEM.
    pub(crate) fn count(&self) -> u64 {
        self.samples.iter().map(|side| *side as u64).product()
    }

    /// Sample intervals along a cell.
    pub fn cell_side(&self) -> u32 {
        self.k.pow(self.layers)
    }

    /// Columns and rows of cells.
    pub fn cells(&self) -> [u32; 2] {
        self.samples.map(|samples| (samples - 1).div_ceil(self.cell_side()))
    }

    /// Whether the cells can be flown over with these options: cut for the same hierarchy, and a window that they fit in.
    pub fn check(&self, options: &Options) -> Result<(), HtpError> {
        options.validate_streamed()?;
        stream::check(self, options)?;
        budget::sides(self, options).map(drop)
    }

    /// Where the heights lie for windows of so many cells, by level.
    pub(crate) fn tiles(&self, sides: &[u32]) -> HeightTiles {
        let mut windows = [0; HeightTiles::MAX_LEVELS];
        windows[..sides.len()].copy_from_slice(sides);
        HeightTiles {
            format: self.format,
            samples: self.samples,
            k: self.k,
            coarse_level: self.streamed,
            cell_side: self.cell_side(),
            windows,
        }
    }

    /// Sample intervals between the resident samples.
    pub fn coarse_step(&self) -> u32 {
        self.k.pow(self.streamed)
    }

    /// Columns and rows of the resident samples; the last ones are the DEM's.
    pub fn coarse_size(&self) -> [u32; 2] {
        self.samples.map(|samples| (samples - 1).div_ceil(self.coarse_step()) + 1)
    }

    /// Metres of one step of the stored errors.
    pub fn step_m(&self) -> f64 {
        let [low, high] = self.height_range_m.map(f64::from);
        (high - low) / u16::MAX as f64
    }

    /// Settings that have the hierarchy of these cells; all else as by default.
    fn options(&self) -> Options {
        Options { k: self.k, layers: self.layers, ..Options::default() }
    }
}

/// What is kept of the levels from [`CellsHeader::streamed`] up, for the whole DEM.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resident {
    /// Codes of every [`CellsHeader::coarse_step`]-th sample and of the last column and row, row by row; padded to a
    /// multiple of 4 bytes.
    pub heights: Vec<u8>,
    /// Lowest and highest sample of each square, in metres: by level from `streamed`, row by row over the DEM.
    pub ranges_m: Vec<Vec<[f32; 2]>>,
    /// Records of the error table (`errors`), by level from `streamed`, row by row over the DEM.
    pub errors: Vec<Vec<u8>>,
}

/// What is loaded of one cell for one level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// Codes of its samples, every `k^level`-th, both rims included, row by row; beyond the DEM's last column and row they
    /// repeat it. Padded to a multiple of 4 bytes.
    pub heights: Vec<u8>,
    /// Lowest and highest sample of each square, in metres: row by row, `k^(layers - 1 - level)` squares a row. Squares
    /// beyond the DEM hold zeros.
    pub ranges_m: Vec<[f32; 2]>,
    /// Error records of the same squares; none on level 0.
    pub errors: Vec<u8>,
}

#[cfg(test)]
mod tests;
