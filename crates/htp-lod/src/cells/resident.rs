//! What stays resident, put together from its records: those of the whole DEM, row by row, without what lies beyond it.

use super::bytes::Part;
use super::file::{CellSource, CellsError};
use super::{Cell, CellsHeader, Resident, local};
use crate::errors::record_length;

/// Reads a row of cells at a time.
pub(super) fn read(source: &dyn CellSource, header: &CellsHeader) -> Result<Resident, CellsError> {
    let part = Part::resident(header);
    let mut resident = empty(header);
    let [columns, rows] = header.cells();
    let mut bytes = vec![0; columns as usize * part.record()];
    for row in 0..rows {
        source.read_at(part.offset([0, row]), &mut bytes)?;
        for (column, bytes) in bytes.chunks(part.record()).enumerate() {
            let cell = [column as u32, row];
            let found = part.parse(cell, bytes)?;
            if !is_sound(header, &found) {
                return Err(CellsError::damaged(format_args!("resident part, cell ({column}, {row})")));
            }
            put(header, &mut resident, cell, &found);
        }
    }
    Ok(resident)
}

/// Whether heights are finite and ranges ordered, as a cutter writes them: nobody asks after this.
fn is_sound(header: &CellsHeader, part: &Cell) -> bool {
    let is_range = |[low, high]: &[f32; 2]| low.is_finite() && high.is_finite() && low <= high;
    let code = header.format.bytes() as usize;
    let mut heights_m = part.heights.chunks_exact(code).map(|code| header.format.decode(code));
    heights_m.all(f32::is_finite) && part.ranges_m.iter().all(is_range)
}

/// All that is resident, not yet filled.
fn empty(header: &CellsHeader) -> Resident {
    let [columns, rows] = header.coarse_size().map(|samples| samples as usize);
    let heights = (columns * rows * header.format.bytes() as usize).next_multiple_of(4);
    let levels = header.streamed..header.layers;
    let squares = levels.map(|level| level_size(header, level).iter().product::<usize>());
    Resident {
        heights: vec![0; heights],
        ranges_m: squares.clone().map(|squares| vec![[0.0; 2]; squares]).collect(),
        errors: squares.map(|squares| vec![0; squares * record_length(header.k)]).collect(),
    }
}

/// Columns and rows of the squares of a level.
fn level_size(header: &CellsHeader, level: u32) -> [usize; 2] {
    let side = header.k.pow(level + 1);
    header.samples.map(|samples| (samples - 1).div_ceil(side) as usize)
}

/// Puts what is resident of one cell into its place.
fn put(header: &CellsHeader, resident: &mut Resident, cell: [u32; 2], part: &Cell) {
    let (code, side) = (header.format.bytes() as usize, (header.cell_side() / header.coarse_step()) as usize);
    let size = header.coarse_size().map(|samples| samples as usize);
    let unpadded = &part.heights[..(side + 1).pow(2) * code];
    place(&mut resident.heights, size, code, unpadded, [side, side + 1], cell);
    let (mut ranges_m, mut errors) = (part.ranges_m.as_slice(), part.errors.as_slice());
    for (i, level) in (header.streamed..header.layers).enumerate() {
        let (size, side, record) = (level_size(header, level), local::squares(header, level), record_length(header.k));
        let (range_m, error);
        (range_m, ranges_m) = ranges_m.split_at(side * side);
        (error, errors) = errors.split_at(side * side * record);
        place(&mut resident.ranges_m[i], size, 1, range_m, [side; 2], cell);
        place(&mut resident.errors[i], size, record, error, [side; 2], cell);
    }
}

/// Copies a square of records into a grid of `size` records, each `record` long; what is beyond the grid is dropped.
/// The squares of cells begin `side[0]` records apart and have `side[1]` of them a row.
fn place<T: Copy>(grid: &mut [T], size: [usize; 2], record: usize, from: &[T], side: [usize; 2], cell: [u32; 2]) {
    let [column, row] = cell.map(|at| at as usize * side[0]);
    let columns = side[1].min(size[0] - column) * record;
    let rows = grid.chunks_mut(size[0] * record).take(size[1]).skip(row);
    for (to, from) in rows.zip(from.chunks(side[1] * record)) {
        to[column * record..][..columns].copy_from_slice(&from[..columns]);
    }
}
