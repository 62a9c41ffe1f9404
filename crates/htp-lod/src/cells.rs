//! Cells as they are kept on disk and loaded one by one (section 4.2): what a DEM is cut into, once.
//!
//! Levels below [`CellsHeader::streamed`] are those that need dense samples; they are cut into cells and loaded around
//! the eye. Of the coarser levels all is kept resident for good, for every cell: little, and always something to stand
//! in for a cell that is not there.

use terrain_core::HeightFormat;

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
}

impl CellsHeader {
    /// Sample intervals along a cell.
    pub fn cell_side(&self) -> u32 {
        self.k.pow(self.layers)
    }

    /// Columns and rows of cells.
    pub fn cells(&self) -> [u32; 2] {
        self.samples.map(|samples| (samples - 1).div_ceil(self.cell_side()))
    }

    /// Sample intervals between the resident samples.
    pub fn coarse_step(&self) -> u32 {
        self.k.pow(self.streamed)
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
    /// Records of the error table (`errors`), by level from `max(streamed, 1)`, row by row over the DEM.
    pub errors: Vec<Vec<u16>>,
}

/// What is loaded of one cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    /// Codes of its `(side + 1)^2` samples, both rims included, row by row; beyond the DEM's last column and row they
    /// repeat it. Padded to a multiple of 4 bytes.
    pub heights: Vec<u8>,
    /// Lowest and highest sample of each square, in metres: by level from 0 to `streamed - 1`, row by row,
    /// `k^(layers - 1 - level)` squares a row. Squares beyond the DEM hold zeros.
    pub ranges_m: Vec<Vec<[f32; 2]>>,
    /// Error records, by level from 1 to `streamed - 1`; likewise.
    pub errors: Vec<Vec<u16>>,
}
