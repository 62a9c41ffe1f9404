//! Cells come and go as the eye moves (section 3, phase 2, and section 4.2): the window's cells, nearest first.
//!
//! A cell that arrives is one transfer: its heights go to the GPU and are not kept (phase 5); what is kept are height
//! ranges and errors. A cell that has not arrived, or cannot be read, is stood in for by its coarse levels, which are
//! always there: the restriction joins them to the finer ones as it does anywhere.

use terrain_core::{Buffer, FramePlan, HeightTiles, Streaming, View};

use crate::cells::{Cell, CellFile, CellsHeader, Resident};
use crate::closure;
use crate::errors::{ErrorTable, record_length};
use crate::failures::Failures;
use crate::grid::Grid;
use crate::in_sight;
use crate::levels::Levels;
use crate::loader::{Arrival, CELLS_WAITING, Loader};
use crate::options::{HtpError, LevelMetric, Options};
use crate::wishes;

/// A plan takes no further cell once it has taken so many bytes of heights. At 60 frames a second that is 120 MiB a second.
const BYTES_A_PLAN: usize = 2 << 20;

/// What loads the cells of one DEM.
pub(crate) struct Stream {
    loader: Loader,
    tiles: HeightTiles,
    /// Codes of the coarse grid, until they are sent.
    coarse: Vec<u8>,
    /// Metres along a cell.
    cell_m: [f64; 2],
    /// Plans so far.
    plans: u64,
    /// The eye's cell in the last plan.
    eye: Option<[u32; 2]>,
    /// Cells that have left the window, and of which nothing is drawn once the plan is made.
    leaving: Vec<[u32; 2]>,
    /// Whether other cells are wanted than before.
    reorder: bool,
    pub failures: Failures,
    loaded: u64,
    unloaded: u64,
    resident_bytes: u64,
}

impl Stream {
    /// For a window of so many cells; `coarse` are the codes of the coarse grid.
    pub fn new(file: CellFile, coarse: Vec<u8>, options: &Options, window: u32) -> std::io::Result<Self> {
        let header = file.header().clone();
        let tiles = header.tiles(window);
        Ok(Self {
            loader: Loader::new(file, options.loading)?,
            coarse,
            cell_m: header.spacing_m.map(|metres| metres * header.cell_side() as f64),
            plans: 0,
            eye: None,
            leaving: Vec::new(),
            reorder: true,
            failures: Failures::default(),
            loaded: 0,
            unloaded: 0,
            resident_bytes: Room::of(&header, options).bytes(window, tiles),
            tiles,
        })
    }

    /// Where the heights are.
    pub fn tiles(&self) -> HeightTiles {
        self.tiles
    }

    /// Bytes of all that is kept for the DEM, the GPU's heights and the cells on their way included.
    pub fn resident_bytes(&self) -> u64 {
        self.resident_bytes
    }

    /// Sends what never changes, once.
    pub fn initialise(&mut self, plan: &mut FramePlan) {
        plan.upload(Buffer::Heights, 0, &std::mem::take(&mut self.coarse));
    }

    /// Moves the window. Returns whether cells leave for which a plan is to wait: then all levels must follow before
    /// [`Self::free`].
    pub fn leave(&mut self, grid: &mut Grid, levels: &mut Levels, view: &View) -> bool {
        self.plans += 1;
        self.free(grid);
        let eye = self.eye_cell(grid, view);
        // Even without another cell to load, the nearest are others.
        self.reorder |= self.eye.replace(eye) != Some(eye);
        if grid.window.follow(eye) {
            self.leaving = grid.window.leaving();
            let (fewer, _) = grid.window.count_rings();
            levels.reconsider(grid, &fewer);
        }
        self.loader.is_blocking() && !self.leaving.is_empty()
    }

    /// Gives the places of the cells away that have left.
    pub fn free(&mut self, grid: &mut Grid) {
        self.reorder |= !self.leaving.is_empty();
        self.unloaded += self.leaving.len() as u64;
        self.leaving.drain(..).for_each(|cell| grid.window.free(cell));
    }

    /// Asks for what is wanted, and takes what has arrived.
    pub fn enter(
        &mut self,
        grid: &mut Grid,
        errors: Option<&mut ErrorTable>,
        levels: &mut Levels,
        view: &View,
        plan: &mut FramePlan,
    ) {
        if std::mem::take(&mut self.reorder) || self.failures.is_due(self.plans) {
            self.loader.want(self.wanted(grid, view));
        }
        let (before, limit) = (plan.bytes.len(), if self.loader.is_blocking() { usize::MAX } else { BYTES_A_PLAN });
        let (loaded, mut errors) = (self.loaded, errors);
        while plan.bytes.len() - before < limit {
            let Some(arrival) = self.loader.take() else { break };
            self.arrive(arrival, grid, errors.as_deref_mut(), plan);
        }
        if self.loaded > loaded {
            let (fewer, _) = grid.window.count_rings();
            levels.reconsider(grid, &fewer);
        }
    }

    fn arrive(&mut self, arrival: Arrival, grid: &mut Grid, errors: Option<&mut ErrorTable>, plan: &mut FramePlan) {
        let Arrival { cell, content } = arrival;
        self.failures.note(cell, content.as_ref().err(), self.plans);
        let Ok(Cell { heights, ranges_m, errors: records }) = content else { return };
        if !grid.window.lacks(cell) {
            return; // the window has moved on
        }
        grid.window.enter(cell);
        grid.put(cell, &ranges_m);
        if let Some(errors) = errors {
            errors.put(grid, cell, &records);
        }
        plan.upload(Buffer::Heights, self.tiles.tile(cell) * self.tiles.format.bytes(), &heights);
        self.loaded += 1;
    }

    /// The cells to load, row by row.
    fn lacking(&self, grid: &Grid) -> impl Iterator<Item = [u32; 2]> {
        let lacks = |cell: &[u32; 2]| grid.window.lacks(*cell) && self.failures.may_read(*cell, self.plans);
        grid.window.inside().filter(lacks)
    }

    /// The cells to load, nearest first.
    fn wanted(&self, grid: &Grid, view: &View) -> Vec<[u32; 2]> {
        let mut wanted: Vec<_> = self.lacking(grid).collect();
        let away_m = |cell: &[u32; 2]| {
            let axes = [(0, view.eye_world.x), (1, view.eye_world.z)];
            let [x_m, z_m] = axes.map(|(axis, eye_m)| {
                let first_m = cell[axis] as f64 * self.cell_m[axis];
                eye_m - eye_m.clamp(first_m, first_m + self.cell_m[axis])
            });
            x_m.hypot(z_m)
        };
        wanted.sort_by(|a, b| away_m(a).total_cmp(&away_m(b)));
        wanted
    }

    /// The cell that the eye is above, or nearest to.
    fn eye_cell(&self, grid: &Grid, view: &View) -> [u32; 2] {
        let cells = grid.layers[grid.top() as usize].size;
        [(0, view.eye_world.x), (1, view.eye_world.z)].map(|(axis, eye_m)| {
            let at = (eye_m / self.cell_m[axis]).floor().clamp(0.0, (cells[axis] - 1) as f64);
            at as u32
        })
    }

    /// What plans say of the loading; `missing` cells are in view and drawn more coarsely than asked for.
    pub fn report(&self, grid: &Grid, missing: u64) -> Streaming {
        Streaming {
            cells_due: self.lacking(grid).count() as u64,
            cells_loaded: self.loaded,
            cells_unloaded: self.unloaded,
            reads_failed: self.failures.reads.sum(),
            retries: self.failures.retries,
            cells_missing: missing,
            resident_bytes: self.resident_bytes,
        }
    }
}

/// Bytes that are kept for a DEM.
///
/// | for each square | bytes |
/// |---|---|
/// | height range | 8 |
/// | places of its two patches (`slots`) | 8 |
/// | above level 0: error record, by [`LevelMetric::Error`] | `4 (3k + 4)` |
/// | above level 0: wishes and their deadline, split patches of this and the last view, sight | 13 |
/// | above level 0: when its patches' blocks are judged again | 16 |
struct Room {
    /// Of the resident levels.
    resident: u64,
    /// Of each cell in the window, without its heights.
    cell: u64,
    /// Of each cell on its way.
    waiting: u64,
    cells: [u32; 2],
}

impl Room {
    fn of(header: &CellsHeader, options: &Options) -> Self {
        let record = if options.metric == LevelMetric::Error { 2 * record_length(header.k) as u64 } else { 0 };
        let above = record + wishes::BYTES_A_SQUARE + 2 + closure::BYTES_A_SQUARE + in_sight::BYTES_A_SQUARE;
        let square = |level: u32| 16 + if level > 0 { above } else { 0 };
        let squares = |samples: u32, level: u32| (samples - 1).div_ceil(header.k.pow(level + 1)) as u64;
        let all = |level: u32| header.samples.map(|samples| squares(samples, level)).iter().product::<u64>();
        let of_cell = |level: u32| squares(header.cell_side() + 1, level).pow(2);
        let bytes = |levels: std::ops::Range<u32>, count: &dyn Fn(u32) -> u64| -> u64 {
            levels.map(|level| square(level) * count(level)).sum()
        };
        let heights = (header.cell_side() as u64 + 1).pow(2) * header.format.bytes();
        let content = (0..header.streamed).map(|level| of_cell(level) * (8 + record)).sum::<u64>();
        Self {
            resident: bytes(header.streamed..header.layers, &all),
            cell: bytes(0..header.streamed, &of_cell),
            waiting: heights + content,
            cells: header.cells(),
        }
    }

    fn bytes(&self, window: u32, tiles: HeightTiles) -> u64 {
        let HeightTiles { format, .. } = tiles;
        let coarse = tiles.coarse_codes() * format.bytes();
        let cell = self.cell + tiles.tile_codes() * format.bytes();
        // One is read, one is being read.
        self.resident + coarse + window as u64 * window as u64 * cell + (CELLS_WAITING as u64 + 2) * self.waiting
    }
}

/// Cells along the largest window that fits; at most what it takes to hold the whole DEM.
pub(crate) fn window_side(header: &CellsHeader, options: &Options) -> Result<u32, HtpError> {
    let room = Room::of(header, options);
    let largest = room.cells[0].max(room.cells[1]);
    let fits = |window: &u32| room.bytes(*window, header.tiles(*window)) <= (options.window_mib as u64) << 20;
    let needed_mib = room.bytes(1, header.tiles(1)).div_ceil(1 << 20);
    (1..=largest).rev().find(fits).ok_or(HtpError::WindowMib { window_mib: options.window_mib, needed_mib })
}

/// Refuses options that are not those of the file.
pub(crate) fn check(header: &CellsHeader, options: &Options) -> Result<(), HtpError> {
    let (found, expected) = ([header.k, header.layers], [options.k, options.layers]);
    if found != expected {
        return Err(HtpError::OtherCells { found, expected });
    }
    Ok(())
}

/// What of the resident part goes where: the coarse heights, and the tables of the coarse levels.
pub(crate) fn tables(
    header: &CellsHeader,
    resident: Resident,
    options: &Options,
    window: u32,
) -> (Vec<u8>, Grid, Option<ErrorTable>) {
    let grid = Grid::streamed(header, resident.ranges_m, options, window);
    let is_bounded = options.metric == LevelMetric::Error;
    let errors = is_bounded.then(|| ErrorTable::streamed(header, resident.errors, &grid));
    (resident.heights, grid, errors)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::cut;
    use crate::{Batching, Htp};
    use std::sync::Arc;
    use terrain_core::Heightmap;

    fn open(options: &Options) -> (CellFile, Resident) {
        let heights_m = (0..500 * 460).map(|i| (i % 83) as f32).collect();
        let heightmap = Heightmap::new(500, 460, [30.0; 2], heights_m).unwrap();
        CellFile::open(Arc::new(cut(&heightmap, options))).unwrap()
    }

    #[test]
    fn what_cannot_be_streamed_is_refused_in_one_line() {
        let options = Options { layers: 3, ..Options::bounded() };
        let refuse = |options: Options| {
            let (file, resident) = open(&Options { layers: 3, ..Options::bounded() });
            Htp::stream(file, resident, options).err().unwrap().to_string()
        };
        let batching = "cells that are loaded one by one are drawn by instances alone";
        assert_eq!(refuse(Options { batching: Batching::PerPatch, ..options }), batching);
        let other = "cells of k 3 with 3 layers: expected k 3 with 4 layers; cut them again or change the settings";
        assert_eq!(refuse(Options { layers: 4, ..options }), other);
        assert_eq!(
            refuse(Options { window_mib: 0, ..options }),
            "window of 0 MiB: expected at least 1 for these cells"
        );
    }

    /// The largest window that fits: one more cell along it would not.
    #[test]
    fn the_window_fills_its_cap_and_no_more() {
        for (k, layers, window_mib) in [(3, 3, 1), (2, 3, 1), (2, 4, 2), (4, 2, 1), (3, 3, 64)] {
            let options = Options { k, layers, window_mib, ..Options::bounded() };
            let (file, resident) = open(&options);
            let header = file.header().clone();
            let method = Htp::stream(file, resident, options).unwrap();
            let (side, cap) = (method.window_cells(), (window_mib as u64) << 20);
            assert!(method.resident_bytes() <= cap, "{options:?}");
            let tiles = HeightTiles { window: side + 1, ..terrain_core::LodMethod::buffers(&method).heights.unwrap() };
            let larger = Room::of(&header, &options).bytes(side + 1, tiles);
            let all = header.cells().into_iter().max().unwrap();
            assert!(side == all || larger > cap, "{options:?}: {side} cells, {larger} bytes for one more");
        }
    }
}
