//! Where the bytes of a cell are, and what they mean: in the resident part and among the cells alike.

use super::file::CellsError;
use super::header::HEADER;
use super::{Cell, CellsHeader, local};
use crate::errors::record_length;

/// Column and row of the cell, at the start of each record.
const NUMBER: usize = 8;

/// At its end.
const CHECKSUM: usize = 4;

/// One of the two parts of a file: a record of equal length for each cell, row by row.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// In messages.
    name: &'static str,
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
    /// By level: squares whose ranges are kept.
    ranges: Vec<usize>,
    /// By level: error numbers.
    errors: Vec<usize>,
    /// What all checksums begin with: so that a record of another DEM is told.
    heights_crc: u32,
}

impl Part {
    /// The coarser levels of all cells.
    pub fn resident(header: &CellsHeader) -> Self {
        let levels = header.streamed..header.layers;
        Self {
            name: "resident part",
            step: header.coarse_step(),
            ranges: levels.clone().map(|level| local::squares(header, level).pow(2)).collect(),
            ..Self::of_levels(header, header.coarse_step(), levels)
        }
        .at(HEADER as u64)
    }

    /// The cells. Ranges follow from the heights, faster than they could be read.
    pub fn streamed(header: &CellsHeader) -> Self {
        Self { name: "cells", ..Self::of_levels(header, 1, 1..header.streamed) }.at(Self::resident(header).end())
    }

    fn of_levels(header: &CellsHeader, step: u32, levels: std::ops::Range<u32>) -> Self {
        let side = header.cell_side() / step;
        let codes = (side as usize + 1).pow(2);
        let numbers = |level| local::squares(header, level).pow(2) * record_length(header.k);
        Self {
            name: "",
            first_byte: 0,
            cells: header.cells(),
            step,
            side,
            heights: (codes * header.format.bytes() as usize).next_multiple_of(4),
            ranges: Vec::new(),
            errors: levels.map(numbers).collect(),
            heights_crc: header.heights_crc,
        }
    }

    fn at(self, first_byte: u64) -> Self {
        Self { first_byte, ..self }
    }

    /// Bytes of one record.
    pub fn record(&self) -> usize {
        let (ranges, errors): (usize, usize) = (self.ranges.iter().sum(), self.errors.iter().sum());
        NUMBER + self.heights + 8 * ranges + 2 * errors + CHECKSUM
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
        if !self.ranges.is_empty() {
            bytes.extend(content.ranges_m.iter().flatten().flatten().flat_map(|metres| metres.to_le_bytes()));
        }
        bytes.extend(content.errors.iter().flatten().flat_map(|code| code.to_le_bytes()));
        let checksum = self.checksum(&bytes[start..]);
        bytes.extend(checksum.to_le_bytes());
        debug_assert_eq!(bytes.len() - start, self.record());
    }

    /// Takes a record apart that is whole and that of the cell. Without the ranges that are not kept.
    pub fn parse(&self, cell: [u32; 2], bytes: &[u8]) -> Result<Cell, CellsError> {
        let damaged = || CellsError::damaged(format_args!("{}, cell ({}, {})", self.name, cell[0], cell[1]));
        let (content, checksum) = bytes.split_last_chunk().expect("a whole record");
        if self.checksum(content) != u32::from_le_bytes(*checksum) {
            return Err(damaged());
        }
        let (number, mut content) = content.split_at(NUMBER);
        let found = [&number[..4], &number[4..]].map(|at| u32::from_le_bytes(at.try_into().expect("4 bytes")));
        if found != cell {
            return Err(CellsError::WrongCell { expected: cell, found });
        }
        let mut take = |bytes: usize| content.split_off(..bytes).expect("a whole record");
        let heights = take(self.heights).to_vec();
        let ranges_m = self.ranges.iter().map(|squares| ranges(take(8 * squares))).collect();
        let errors = self.errors.iter().map(|numbers| numbers_of(take(2 * numbers))).collect();
        Ok(Cell { heights, ranges_m, errors })
    }

    fn checksum(&self, bytes: &[u8]) -> u32 {
        let mut crc = crc32fast::Hasher::new();
        crc.update(&self.heights_crc.to_le_bytes());
        crc.update(bytes);
        crc.finalize()
    }
}

fn ranges(bytes: &[u8]) -> Vec<[f32; 2]> {
    let pairs: &[[[u8; 4]; 2]] = bytes.as_chunks().0.as_chunks().0;
    pairs.iter().map(|pair| pair.map(f32::from_le_bytes)).collect()
}

fn numbers_of(bytes: &[u8]) -> Vec<u16> {
    bytes.as_chunks().0.iter().map(|number| u16::from_le_bytes(*number)).collect()
}
