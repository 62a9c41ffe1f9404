//! One cell as a small DEM of its own: squares have the same rim, ranges and errors as in the whole one, because
//! nothing of a cell depends on the samples beyond it.

use terrain_core::Heightmap;

use super::CellsHeader;
use crate::grid::Grid;

/// Columns and rows of the samples that a cell has; fewer than `side + 1` where the DEM ends in it.
pub(super) fn size(header: &CellsHeader, cell: [u32; 2]) -> [u32; 2] {
    let side = header.cell_side();
    [0, 1].map(|axis| (header.samples[axis] - 1 - cell[axis] * side).min(side) + 1)
}

/// The small DEM; `row_m` gives the first samples of its rows, at least as many as it has columns.
///
/// `None` if a height is not finite.
pub(super) fn heightmap<'a>(
    header: &CellsHeader,
    cell: [u32; 2],
    row_m: impl Fn(u32) -> &'a [f32],
) -> Option<Heightmap> {
    let [columns, rows] = size(header, cell);
    let heights_m = (0..rows).flat_map(|row| &row_m(row)[..columns as usize]).copied().collect();
    Heightmap::new(columns, rows, header.spacing_m, heights_m).ok()
}

/// Squares of a level along a cell.
pub(super) fn squares(header: &CellsHeader, level: u32) -> usize {
    header.k.pow(header.layers - 1 - level) as usize
}

/// Ranges of the squares of a level, those beyond the DEM included.
pub(super) fn ranges_m(header: &CellsHeader, grid: &Grid, level: u32) -> Vec<[f32; 2]> {
    padded(&grid.ranges_m(level), grid.layers[level as usize].size, squares(header, level), 1)
}

/// `record` numbers a square, row by row over the squares that exist, as `side` x `side` squares; zeros beyond.
pub(super) fn padded<T: Copy + Default>(numbers: &[T], size: [u32; 2], side: usize, record: usize) -> Vec<T> {
    let columns = size[0] as usize;
    let mut all = vec![T::default(); side * side * record];
    for (to, from) in all.chunks_mut(side * record).zip(numbers.chunks(columns * record)) {
        to[..from.len()].copy_from_slice(from);
    }
    all
}
