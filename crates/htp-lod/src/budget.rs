//! What each byte is for that is kept of a streamed DEM, and the windows that a number of MiB has room for.
//!
//! | for each square that is stored | bytes |
//! |---|---|
//! | height range | 8 |
//! | places of its two patches (`slots`) | 8 |
//! | above level 0: error record (`errors`), by [`LevelMetric::Error`] | `2 (3k + 5)` |
//! | above level 0: wishes and their deadline (`wishes`) | 5 |
//! | above level 0: split patches of this view and the last (`levels`) | 2 |
//! | above level 0: when its patches' blocks are judged again (`deadlines`) | 8 |
//! | above level 0: sight (`in_sight`) | 2 |
//! | above level 1: whether its children are asked (`wishes`) | 1 |
//! | above the streamed levels: the worst of its children (`errors`), by [`LevelMetric::Error`] | 2 |
//!
//! All squares of the resident levels are stored, and those of the streamed levels in the windows. The heights are on the
//! GPU: the coarse grid, and a tile a sheet. Further there is who has each place in the windows, and the sheets that wait
//! or are being read. What is drawn (`slots`, the queues of `deadlines`) goes by the view and not by the DEM: it is not
//! counted here.
//!
//! *Sides.* A level's window is `k` times as wide as that of the next finer one, until it holds the whole DEM: on rough
//! ground errors grow with the step, and with them the distance out to which a level is wanted.

use crate::cells::CellsHeader;
use crate::closure;
use crate::errors::{self, record_length};
use crate::in_sight;
use crate::options::{HtpError, LevelMetric, Options};
use crate::wishes;

/// Bytes of what is kept of a streamed DEM.
pub(crate) struct Budget {
    k: u32,
    /// Of the resident levels, and of what is known of each cell.
    fixed: u64,
    /// By level: of a sheet in the window.
    sheets: Vec<u64>,
    /// Of the largest sheet on its way.
    waiting: u64,
    /// Of one that is being read.
    reading: u64,
    /// Cells along the longer side of the DEM.
    largest_side: u32,
    /// All that may be kept.
    cap: u64,
}

/// Of who has a place in a window.
const PLACE: u64 = size_of::<Option<[u32; 2]>>() as u64;
/// Of which sheets of a cell are there.
const CELL: u64 = size_of::<[u8; 2]>() as u64;
/// Lowest and highest sample of a square.
const RANGE: u64 = size_of::<[f32; 2]>() as u64;
/// Places of the two patches of a square.
const SLOTS: u64 = 2 * size_of::<u32>() as u64;
/// Whether they are split, now and in the last view.
const SPLIT: u64 = 2 * size_of::<u8>() as u64;

impl Budget {
    pub fn of(header: &CellsHeader, options: &Options) -> Self {
        let record = if options.metric == LevelMetric::Error { record_length(header.k) as u64 } else { 0 };
        let content = |level: u32| RANGE + if level > 0 { record } else { 0 };
        let above = wishes::BYTES_A_SQUARE + SPLIT + closure::BYTES_A_SQUARE + in_sight::BYTES_A_SQUARE;
        let worst_child = if options.metric == LevelMetric::Error { errors::BYTES_OF_WORST_CHILD } else { 0 };
        let of_children = |level: u32| {
            let worst_child = if level > header.streamed { worst_child } else { 0 };
            worst_child + if level > 1 { wishes::BYTES_A_PARENT } else { 0 }
        };
        let square = |level: u32| content(level) + SLOTS + if level > 0 { above } else { 0 } + of_children(level);
        let squares = |samples: u32, level: u32| (samples - 1).div_ceil(header.k.pow(level + 1)) as u64;
        // Above the top layer there is no parent whose children would be stored together.
        let brood = |level: u32| if level + 1 < header.layers { header.k as u64 } else { 1 };
        let stored = |samples: u32, level: u32| squares(samples, level).next_multiple_of(brood(level));
        let of_dem = |level: u32| header.samples.map(|samples| stored(samples, level)).iter().product::<u64>();
        let of_cell = |level: u32| squares(header.cell_side() + 1, level).pow(2);
        let tiles = header.tiles(&[]);
        let heights = |level: u32| tiles.tile_codes(level) * header.format.bytes();
        let levels = 0..header.streamed;
        let resident: u64 = (header.streamed..header.layers).map(|level| square(level) * of_dem(level)).sum();
        let cells = header.cells();
        let samples = (header.cell_side() as u64 + 1).pow(2);
        Self {
            k: header.k,
            fixed: resident + tiles.coarse_codes() * header.format.bytes() + CELL * cells[0] as u64 * cells[1] as u64,
            sheets: levels.clone().map(|level| square(level) * of_cell(level) + heights(level) + PLACE).collect(),
            waiting: levels.map(|level| content(level) * of_cell(level) + heights(level)).max().unwrap_or(0),
            // The record, and for its ranges all samples twice in metres.
            reading: heights(0) + 2 * size_of::<f32>() as u64 * samples,
            largest_side: cells[0].max(cells[1]),
            cap: (options.window_mib as u64) << 20,
        }
    }

    /// Sheets that may wait to be taken: a sixty-fourth of all that may be kept.
    pub fn sheets_waiting(&self) -> usize {
        (self.cap / 64 / self.waiting.max(1)).clamp(2, 16) as usize
    }

    /// All bytes with windows of so many cells, by level.
    pub fn bytes(&self, sides: &[u32]) -> u64 {
        let windows = sides.iter().zip(&self.sheets).map(|(side, sheet)| (*side as u64).pow(2) * sheet).sum::<u64>();
        // One is taken, one has been read and finds no room.
        self.fixed + windows + (self.sheets_waiting() as u64 + 2) * self.waiting + self.reading
    }

    /// The windows of a size: so many cells along that of the coarsest streamed level, unless the DEM has fewer.
    fn sides_of(&self, size: u32) -> Vec<u32> {
        let coarsest = self.sheets.len() as u32 - 1;
        (0..=coarsest).map(|level| size.div_ceil(self.k.pow(coarsest - level)).min(self.largest_side)).collect()
    }

    /// The widest windows that fit; at most what it takes to hold the whole DEM.
    pub fn sides(&self) -> Option<Vec<u32>> {
        let all = self.largest_side * self.k.pow(self.sheets.len() as u32 - 1);
        (1..=all).rev().map(|size| self.sides_of(size)).find(|sides| self.bytes(sides) <= self.cap)
    }
}

/// Cells along the window of each streamed level, or why there is no room for any.
pub(crate) fn sides(header: &CellsHeader, options: &Options) -> Result<Vec<u32>, HtpError> {
    let budget = Budget::of(header, options);
    let needed_mib = budget.bytes(&budget.sides_of(1)).div_ceil(1 << 20);
    budget.sides().ok_or(HtpError::WindowMib { window_mib: options.window_mib, needed_mib })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Htp;
    use crate::cells::{CellFile, cut};
    use crate::grid::Grid;
    use crate::levels::Levels;
    use std::sync::Arc;
    use terrain_core::Heightmap;

    fn terrain(columns: u32, rows: u32) -> Heightmap {
        let heights_m = (0..columns * rows).map(|i| (i % 83) as f32).collect();
        Heightmap::new(columns, rows, [30.0; 2], heights_m).unwrap()
    }

    /// The widest windows that fit: one more cell along the coarsest one's would not.
    #[test]
    fn the_windows_fill_their_cap_and_no_more() {
        for (k, layers, window_mib) in [(3, 3, 1), (2, 3, 1), (2, 4, 2), (4, 2, 1), (3, 3, 64)] {
            let options = Options { k, layers, window_mib, ..Options::bounded() };
            let (file, resident) = CellFile::open(Arc::new(cut(&terrain(500, 460), &options))).unwrap();
            let header = file.header().clone();
            let method = Htp::stream(file, resident, options).unwrap();
            let (sides, cap) = (method.window_cells(), (window_mib as u64) << 20);
            let budget = Budget::of(&header, &options);
            assert_eq!(method.resident_bytes(), budget.bytes(&sides));
            assert!(method.resident_bytes() <= cap, "{options:?}");
            let all = header.cells().into_iter().max().unwrap();
            let size = *sides.last().unwrap();
            let larger: Vec<u32> = sides.iter().map(|side| (side + 1).min(all)).collect();
            assert!(sides.iter().all(|side| *side == all) || budget.bytes(&larger) > cap, "{options:?}: {sides:?}");
            assert!(sides.is_sorted() && sides.iter().all(|side| side * k.pow(layers) >= size), "{sides:?}");
        }
    }

    /// The regression: half of 64 MiB went to deadlines and to cells that wait.
    #[test]
    fn at_64_mib_the_windows_of_a_large_dem_are_those_that_its_levels_want() {
        let options = Options { layers: 5, window_mib: 64, ..Options::bounded() };
        let (file, _) = CellFile::open(Arc::new(cut(&terrain(500, 460), &options))).unwrap();
        let header = CellsHeader { samples: [16385; 2], ..file.header().clone() };
        let of = |window_mib| sides(&header, &Options { window_mib, ..options }).unwrap();
        assert_eq!([64, 256].map(of), [[7, 19], [18, 52]]);
    }

    /// The table of this file against what there is.
    #[test]
    fn every_square_takes_the_bytes_that_are_counted() {
        let options = Options { k: 3, layers: 3, ..Options::bounded() };
        let (file, resident) = CellFile::open(Arc::new(cut(&terrain(82, 82), &options))).unwrap();
        let (header, budget) = (file.header().clone(), Budget::of(file.header(), &options));
        let grid = Grid::streamed(&header, resident.ranges_m, &options, &[1, 2]);
        let levels = Levels::new(&grid);
        let level_1 = grid.layers[1].squares_stored() as u64;
        let ranges = level_1 * size_of_val(&grid.ranges_m(1)[0]) as u64;
        let split = levels.split().0[1].len() as u64;
        let counted = RANGE + SLOTS + record_length(3) as u64 + 5 + 2 + 8 + 2;
        assert_eq!((ranges, split), (RANGE * level_1, level_1));
        let tile = header.tiles(&[]).tile_codes(1) * header.format.bytes();
        assert_eq!(budget.sheets[1], counted * level_1 / 4 + tile + PLACE);
    }
}
