//! Where the bytes of a cell are, and what they mean: in the resident part and among the cells alike.

use std::ops::Range;

use super::file::CellsError;
use super::{Cell, CellsHeader, local};
use crate::errors::record_length;

/// Column and row of the cell, at the start of each record.
const NUMBER: usize = 8;

/// A square's lowest and highest sample.
const RANGE: usize = 8;

/// At the end of each record.
const CHECKSUM: usize = 4;

/// One of the parts of a file: a record of equal length for each cell, row by row.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// In messages.
    name: String,
    /// The levels that it is for.
    pub levels: Range<u32>,
    /// Where the first record begins.
    first_byte: u64,
    /// Columns and rows of cells.
    cells: [u32; 2],
    /// Sample intervals of the DEM between neighbours in the records.
    pub step: u32,
    /// Those intervals along a cell.
    pub side: u32,
    /// Bytes of the codes.
    heights: usize,
    /// Squares whose ranges and errors are kept.
    squares: usize,
    /// Bytes of an error record.
    error_record: usize,
    /// What all checksums begin with: so that a record of another DEM is told.
    heights_crc: u32,
}

impl Part {
    /// The coarser levels of all cells.
    pub fn resident(header: &CellsHeader) -> Self {
        let first_byte = header.bytes();
        Self::new(header, "resident part".to_owned(), header.streamed..header.layers, first_byte)
    }

    /// In the order of the file: the resident part, and those of the streamed levels down to 0.
    pub fn all(header: &CellsHeader) -> Vec<Self> {
        let mut parts = vec![Self::resident(header)];
        for level in (0..header.streamed).rev() {
            let first_byte = parts.last().map_or(0, Self::end);
            parts.push(Self::new(header, format!("level {level}"), level..level + 1, first_byte));
        }
        parts
    }

    fn new(header: &CellsHeader, name: String, levels: Range<u32>, first_byte: u64) -> Self {
        let step = header.k.pow(levels.start);
        let side = header.cell_side() / step;
        let codes = (side as usize + 1).pow(2);
        Self {
            name,
            first_byte,
            cells: header.cells(),
            step,
            side,
            heights: (codes * header.format.bytes() as usize).next_multiple_of(4),
            squares: levels.clone().filter(|level| *level > 0).map(|level| local::squares(header, level).pow(2)).sum(),
            error_record: record_length(header.k),
            heights_crc: header.heights_crc,
            levels,
        }
    }

    /// Bytes of one record.
    pub fn record(&self) -> usize {
        NUMBER + self.heights + (RANGE + self.error_record) * self.squares + CHECKSUM
    }

    /// Where the record of a cell begins. Those of a row of cells lie side by side.
    pub fn offset(&self, [column, row]: [u32; 2]) -> u64 {
        self.first_byte + (row as u64 * self.cells[0] as u64 + column as u64) * self.record() as u64
    }

    /// The byte after the last record.
    pub fn end(&self) -> u64 {
        self.offset([0, self.cells[1]])
    }

    /// Appends a record.
    pub fn write(&self, cell: [u32; 2], content: &Cell, bytes: &mut Vec<u8>) {
        let start = bytes.len();
        cell.iter().for_each(|at| bytes.extend(at.to_le_bytes()));
        bytes.extend(&content.heights);
        if self.squares > 0 {
            bytes.extend(content.ranges_m.iter().flatten().flat_map(|metres| metres.to_le_bytes()));
        }
        bytes.extend(&content.errors);
        let checksum = self.checksum(&bytes[start..]);
        bytes.extend(checksum.to_le_bytes());
        debug_assert_eq!(bytes.len() - start, self.record());
    }

    /// Takes a record apart that is whole and that of the cell. Without the ranges of level 0.
    pub fn parse(&self, cell: [u32; 2], bytes: &[u8]) -> Result<Cell, CellsError> {
        let damaged = || CellsError::damaged(format_args!("{}, cell ({}, {})", self.name, cell[0], cell[1]));
        let (content, checksum) = bytes.split_last_chunk().expect("a whole record");
        if !cfg!(fuzzing) && self.checksum(content) != u32::from_le_bytes(*checksum) {
            return Err(damaged());
        }
        let (number, mut content) = content.split_at(NUMBER);
        let found = [&number[..4], &number[4..]].map(|at| u32::from_le_bytes(at.try_into().expect("4 bytes")));
        if found != cell {
            return Err(CellsError::WrongCell { expected: cell, found });
        }
        let mut take = |bytes: usize| content.split_off(..bytes).expect("a whole record");
        let heights = take(self.heights).to_vec();
        let ranges_m = ranges(take(RANGE * self.squares));
        let errors = take(self.error_record * self.squares).to_vec();
        Ok(Cell { heights, ranges_m, errors })
    }

    fn checksum(&self, bytes: &[u8]) -> u32 {
        let mut crc = crc32fast::Hasher::new();
        crc.update(&self.heights_crc.to_le_bytes());
        crc.update(&self.levels.start.to_le_bytes());
        crc.update(bytes);
        crc.finalize()
    }
}

fn ranges(bytes: &[u8]) -> Vec<[f32; 2]> {
    let pairs: &[[[u8; 4]; 2]] = bytes.as_chunks().0.as_chunks().0;
    pairs.iter().map(|pair| pair.map(f32::from_le_bytes)).collect()
}
