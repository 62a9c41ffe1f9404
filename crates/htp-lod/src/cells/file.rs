//! Cells out of a file: each by itself, none unchecked.

use std::fmt::Display;
use std::io;
use std::sync::Arc;

use terrain_core::VoidMask;

use super::bytes::Part;
use super::header::{MAGIC, VERSION};
use super::{Cell, CellsHeader, Resident, codes, local, resident, voids};
use crate::grid::Grid;
use crate::options::Options;

/// Bytes that can be read anywhere, from several threads at once: a file, or a copy in memory.
pub trait CellSource: Send + Sync {
    /// In bytes.
    fn len(&self) -> io::Result<u64>;

    /// Whether there is nothing.
    fn is_empty(&self) -> io::Result<bool> {
        Ok(self.len()? == 0)
    }

    /// Fills `into` with the bytes from `at` on; an error if there are not so many.
    fn read_at(&self, at: u64, into: &mut [u8]) -> io::Result<()>;
}

impl CellSource for [u8] {
    fn len(&self) -> io::Result<u64> {
        Ok(self.len() as u64)
    }

    fn read_at(&self, at: u64, into: &mut [u8]) -> io::Result<()> {
        let from = usize::try_from(at).ok().and_then(|at| self.get(at..)?.get(..into.len()));
        into.copy_from_slice(from.ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(())
    }
}

impl CellSource for Vec<u8> {
    fn len(&self) -> io::Result<u64> {
        CellSource::len(self.as_slice())
    }

    fn read_at(&self, at: u64, into: &mut [u8]) -> io::Result<()> {
        self.as_slice().read_at(at, into)
    }
}

/// Why cells cannot be had from a file.
#[derive(Debug, thiserror::Error)]
pub enum CellsError {
    /// The operating system failed.
    #[error("cannot read cells: {0}")]
    Io(#[from] io::Error),
    /// Something else altogether.
    #[error("no file of cells; expected one that `terrain-lod dem cells` has written")]
    NoCells,
    /// Cells of another version of this program.
    #[error("cells of version {found}; expected version {VERSION}: cut them again", VERSION = VERSION)]
    Version {
        /// In the file.
        found: u32,
    },
    /// Cut short, or longer than it should be.
    #[error("{found} bytes; expected {expected} by the file's header: copy or cut it again")]
    Length {
        /// Bytes of the file.
        found: u64,
        /// Bytes that its header makes it have.
        expected: u64,
    },
    /// Bytes that do not have their checksum.
    #[error("damaged: {part}; expected bytes with their checksum: copy or cut it again")]
    Damaged {
        /// What is damaged.
        part: String,
    },
    /// A whole cell in the wrong place.
    #[error("cell ({}, {}) in place of cell ({}, {}); expected each in its own: copy or cut it again",
        found[0], found[1], expected[0], expected[1])]
    WrongCell {
        /// Column and row of the cell that belongs there.
        expected: [u32; 2],
        /// Column and row of the one that is there.
        found: [u32; 2],
    },
}

impl CellsError {
    pub(super) fn damaged(part: impl Display) -> Self {
        Self::Damaged { part: part.to_string() }
    }
}

/// A file of cells whose header has been read and agrees with its length.
pub struct CellFile {
    source: Arc<dyn CellSource>,
    header: CellsHeader,
    /// Of the streamed levels, from 0.
    levels: Vec<Part>,
}

impl CellFile {
    /// Whether the first bytes of a file say that it is one of cells.
    pub fn is_one(start: &[u8]) -> bool {
        start.starts_with(&MAGIC)
    }

    /// Reads the header and what stays resident.
    pub fn open(source: Arc<dyn CellSource>) -> Result<(Self, Resident), CellsError> {
        let header = CellsHeader::read(&*source)?;
        let mut levels = Part::all(&header).split_off(1);
        levels.reverse();
        let (found, expected) = (source.len()?, levels[0].end() + voids::length(&header));
        if found != expected {
            return Err(CellsError::Length { found, expected });
        }
        let resident = resident::read(&*source, &header)?;
        Ok((Self { source, header, levels }, resident))
    }

    /// What all cells have in common.
    pub fn header(&self) -> &CellsHeader {
        &self.header
    }

    /// Bytes that are read for one cell, all its levels together.
    pub fn cell_bytes(&self) -> u64 {
        self.levels.iter().map(|level| level.record() as u64).sum()
    }

    /// The byte after each level's records.
    #[cfg(test)]
    pub(crate) fn level_ends(&self) -> Vec<u64> {
        self.levels.iter().map(Part::end).collect()
    }

    /// Bytes that are read by [`Self::open`].
    pub fn resident_bytes(&self) -> u64 {
        self.levels.last().expect("a streamed level").offset([0, 0])
    }

    /// Reads and checks a streamed level of the cell at a column and row. Panics if there is none.
    pub fn read(&self, level: u32, cell: [u32; 2]) -> Result<Cell, CellsError> {
        let [columns, rows] = self.header.cells();
        assert!(cell[0] < columns && cell[1] < rows, "cell {cell:?} of {columns} x {rows}");
        let part = &self.levels[level as usize];
        let mut bytes = vec![0; part.record()];
        self.source.read_at(part.offset(cell), &mut bytes)?;
        let mut found = part.parse(cell, &bytes)?;
        if level == 0 {
            found.ranges_m = ranges_of(&self.header, cell, &found.heights)?;
        }
        Ok(found)
    }

    /// Reads and checks the samples that have no heights, if there are any.
    pub fn voids(&self) -> Result<Option<VoidMask>, CellsError> {
        voids::read(&*self.source, &self.header, self.levels[0].end())
    }

    /// The heights in metres of one row of cells, row by row over the DEM: those of a cell's last row belong to the next
    /// row of cells, if there is one.
    pub fn heights_m(&self, cell_row: u32) -> Result<Vec<f32>, CellsError> {
        let CellsHeader { samples, format, .. } = self.header;
        let side = self.header.cell_side() as usize;
        let is_last = cell_row + 1 == self.header.cells()[1];
        let rows = local::size(&self.header, [0, cell_row])[1] as usize - !is_last as usize;
        let mut heights_m = vec![0.0; rows * samples[0] as usize];
        for column in 0..self.header.cells()[0] {
            let cell = [column, cell_row];
            let found = self.read(0, cell)?;
            let cell_m = codes::decode(format, &found.heights);
            let (first, columns) = (column as usize * side, local::size(&self.header, cell)[0] as usize);
            for (to, from) in heights_m.chunks_mut(samples[0] as usize).zip(cell_m.chunks(side + 1)) {
                to[first..first + columns].copy_from_slice(&from[..columns]);
            }
        }
        Ok(heights_m)
    }
}

/// The ranges of a cell's squares of level 0 as they were when it was cut.
fn ranges_of(header: &CellsHeader, cell: [u32; 2], heights: &[u8]) -> Result<Vec<[f32; 2]>, CellsError> {
    let heights_m = codes::decode(header.format, heights);
    let side = header.cell_side() as usize + 1;
    let row_m = |row: u32| &heights_m[row as usize * side..];
    let not_finite = || CellsError::damaged(format_args!("the heights of cell ({}, {})", cell[0], cell[1]));
    let heightmap = local::heightmap(header, cell, row_m).ok_or_else(not_finite)?;
    let grid = Grid::new(&heightmap, &Options { layers: 1, ..header.options() });
    Ok(local::ranges_m(header, &grid, 0))
}
