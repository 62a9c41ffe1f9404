//! From the rows of a DEM to cells, one row of cells at a time: only their samples are in memory.

use rayon::prelude::*;
use terrain_core::{Heightmap, VoidMask};

use super::bytes::Part;
use super::file::{CellSource, CellsError};
use super::scan::{CutError, HeightsCrc, Scan};
use super::{Cell, CellsHeader, Voids, codes, local, voids};
use crate::errors::ErrorTable;
use crate::grid::Grid;
use crate::options::Options;

/// The second of two passes over the rows of a DEM. The bytes that it makes may be written in any order:
/// [`Self::header_bytes`] at 0, the piece of the voids, and those of each row of cells.
///
/// ```text
///  rows --push--> last row of a row of cells? --cut--> a piece for the resident part, and for each streamed level
/// ```
pub struct Cutter {
    header: CellsHeader,
    /// In the order of the file.
    parts: Vec<Part>,
    /// Rows of the current row of cells, one after the other.
    heights_m: Vec<f32>,
    /// Rows taken so far.
    rows: u32,
    heights: HeightsCrc,
}

/// Bytes, and where in the file they go.
pub type Piece = (u64, Vec<u8>);

impl Cutter {
    /// For a DEM that has been scanned.
    pub fn new(header: CellsHeader) -> Self {
        let parts = Part::all(&header);
        let rows = header.cell_side().min(header.samples[1] - 1) as usize + 1;
        let heights_m = Vec::with_capacity(rows * header.samples[0] as usize);
        Self { header, parts, heights_m, rows: 0, heights: HeightsCrc::default() }
    }

    /// Bytes of the whole file.
    pub fn file_bytes(&self) -> u64 {
        self.records_end() + voids::length(&self.header)
    }

    fn records_end(&self) -> u64 {
        self.parts.last().expect("the resident part at least").end()
    }

    /// The voids that the scan was told of. [`CutError::Changed`] for others.
    pub fn cut_voids(&self, mask: &VoidMask) -> Result<Piece, CutError> {
        if Voids::of(mask) == self.header.voids {
            Ok((self.records_end(), voids::to_bytes(mask)))
        } else {
            Err(CutError::Changed)
        }
    }

    /// The first bytes of the file.
    pub fn header_bytes(&self) -> Vec<u8> {
        self.header.to_bytes()
    }

    /// Takes the next row; the row of cells that it completes, if it does.
    pub fn push(&mut self, row_m: &[f32]) -> Option<u32> {
        assert_eq!(row_m.len(), self.header.samples[0] as usize, "samples of a row");
        let (side, last) = (self.header.cell_side(), self.header.samples[1] - 1);
        if self.rows > 1 && (self.rows - 1).is_multiple_of(side) {
            // The last row of the cells to the north is the first of those to the south.
            let kept = self.heights_m.len() - row_m.len();
            self.heights_m.drain(..kept);
        }
        self.heights_m.extend(row_m);
        self.heights.push(row_m);
        let row = self.rows;
        self.rows += 1;
        (row > 0 && (row.is_multiple_of(side) || row == last)).then(|| (row - 1) / side)
    }

    /// Cuts the row of cells that is complete, on the threads of the current pool.
    ///
    /// [`CutError::Changed`] if a height is not finite, or none that the format found by the scan can hold.
    pub fn cut(&self) -> Result<Vec<Piece>, CutError> {
        let row = (self.rows - 2) / self.header.cell_side();
        let columns = (0..self.header.cells()[0]).into_par_iter();
        let cells: Result<Vec<Vec<Cell>>, CutError> = columns.map(|column| self.cut_cell([column, row])).collect();
        let cells = cells?;
        let piece = |(i, part): (usize, &Part)| {
            let mut bytes = Vec::with_capacity(cells.len() * part.record());
            for (column, cell) in cells.iter().enumerate() {
                part.write([column as u32, row], &cell[i], &mut bytes);
            }
            (part.offset([0, row]), bytes)
        };
        Ok(self.parts.iter().enumerate().map(piece).collect())
    }

    /// Whether a file has the row of cells that is complete already, whole and with the heights of these rows.
    ///
    /// Checksums do not tell that: an earlier cut may have read other heights after the same scan. Errors and ranges
    /// need no look, since they follow from the heights.
    pub fn has_row(&self, source: &dyn CellSource, row: u32) -> Result<bool, CellsError> {
        for column in 0..self.header.cells()[0] {
            if !self.has_cell(source, [column, row])? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    fn has_cell(&self, source: &dyn CellSource, cell: [u32; 2]) -> Result<bool, CellsError> {
        let Ok(heightmap) = self.heightmap(cell) else { return Ok(false) };
        for part in &self.parts {
            let mut bytes = vec![0; part.record()];
            source.read_at(part.offset(cell), &mut bytes)?;
            if !part.parse(cell, &bytes).is_ok_and(|kept| kept.heights == self.codes(&heightmap, part)) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether a file was begun for the same DEM and the same cells.
    pub fn began(&self, source: &dyn CellSource) -> bool {
        let has_length = source.len().is_ok_and(|bytes| bytes == self.file_bytes());
        has_length && CellsHeader::read(source).is_ok_and(|header| header == self.header)
    }

    /// Refuses cells whose rows were not those of the scan; to be asked after the last row.
    pub fn finish(self) -> Result<(), CutError> {
        if self.heights.finish() == self.header.heights_crc { Ok(()) } else { Err(CutError::Changed) }
    }

    /// What stays resident of a cell, and what is loaded of it for each streamed level.
    fn cut_cell(&self, cell: [u32; 2]) -> Result<Vec<Cell>, CutError> {
        let header = &self.header;
        let heightmap = self.heightmap(cell)?;
        let grid = Grid::new(&heightmap, &header.options());
        let errors = ErrorTable::with_step(&heightmap, &grid, header.step_m());
        let levels = |part: &Part| part.levels.clone().filter(|level| *level > 0);
        let of_part = |part: &Part| Cell {
            heights: self.codes(&heightmap, part),
            ranges_m: levels(part).flat_map(|level| local::ranges_m(header, &grid, level)).collect(),
            errors: levels(part).flat_map(|level| self.errors(&grid, &errors, level)).collect(),
        };
        Ok(self.parts.iter().map(of_part).collect())
    }

    /// The samples of a cell. A height that has no code would be kept as another, under errors that are its own.
    fn heightmap(&self, cell: [u32; 2]) -> Result<Heightmap, CutError> {
        let header = &self.header;
        let first = (cell[0] * header.cell_side()) as usize;
        let row_m = |row: u32| &self.heights_m[row as usize * header.samples[0] as usize + first..];
        let heightmap = local::heightmap(header, cell, row_m).ok_or(CutError::Changed)?;
        let has_codes = heightmap.heights_m().iter().all(|height_m| codes::holds(header.format, *height_m));
        if has_codes { Ok(heightmap) } else { Err(CutError::Changed) }
    }

    fn codes(&self, heightmap: &Heightmap, part: &Part) -> Vec<u8> {
        let [last_column, last_row] = [heightmap.columns() - 1, heightmap.rows() - 1];
        let mut codes = Vec::new();
        for row in 0..=part.side {
            for column in 0..=part.side {
                let (column, row) = ((column * part.step).min(last_column), (row * part.step).min(last_row));
                let height_m = heightmap.height_m(terrain_core::Sample { column, row });
                codes::push(self.header.format, height_m, &mut codes);
            }
        }
        codes::pad(&mut codes);
        codes
    }

    fn errors(&self, grid: &Grid, errors: &ErrorTable, level: u32) -> Vec<u8> {
        let (size, side) = (grid.layers[level as usize].size, local::squares(&self.header, level));
        local::padded(&errors.records(grid, level), size, side, crate::errors::record_length(self.header.k))
    }
}

/// The whole file as bytes: for a DEM that is in memory. Panics if its options are such that [`Scan::new`] refuses them.
pub fn cut(heightmap: &Heightmap, options: &Options) -> Vec<u8> {
    cut_steps(heightmap, None, options)
}

/// As [`cut`], of heights that may be whole steps: `declared` are metres of a step and metres at 0. The heightmap's voids
/// are kept.
pub fn cut_steps(heightmap: &Heightmap, declared: Option<[f64; 2]>, options: &Options) -> Vec<u8> {
    let samples = [heightmap.columns(), heightmap.rows()];
    let rows = || heightmap.heights_m().chunks(samples[0] as usize);
    let mut scan = Scan::new(samples, heightmap.spacing_m(), declared, options).expect("options that can be streamed");
    rows().for_each(|row_m| scan.push(row_m));
    heightmap.voids().into_iter().for_each(|mask| scan.set_voids(mask));
    let mut cutter = Cutter::new(scan.finish());
    let mut bytes = vec![0; cutter.file_bytes() as usize];
    let mut put = |(at, piece): Piece| bytes[at as usize..][..piece.len()].copy_from_slice(&piece);
    put((0, cutter.header_bytes()));
    if let Some(mask) = heightmap.voids() {
        put(cutter.cut_voids(mask).expect("the voids of the scan"));
    }
    for row_m in rows() {
        if cutter.push(row_m).is_some() {
            cutter.cut().expect("the rows of the scan").into_iter().for_each(&mut put);
        }
    }
    bytes
}
