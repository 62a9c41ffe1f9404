//! Cells come and go as the eye moves (section 3, phase 2, and section 4.2): the sheets in the windows, first those in
//! sight, the nearest first.
//!
//! A sheet that arrives is one transfer: its heights go to the GPU and are not kept (phase 5); what is kept are height
//! ranges and errors. A cell that has not arrived, or cannot be read, is stood in for by its coarse levels, which are
//! always there: the restriction joins them to the finer ones as it does anywhere.

use std::cmp::Reverse;

use terrain_core::{Buffer, FramePlan, HeightTiles, Streaming, View};

use crate::budget::Budget;
use crate::cells::{Cell, CellFile, CellsHeader, Resident};
use crate::errors::ErrorTable;
use crate::failures::Failures;
use crate::grid::{Grid, Square};
use crate::levels::Levels;
use crate::loader::{Arrival, Loader};
use crate::options::{HtpError, LevelMetric, Options};
use crate::window::Sheet;

/// A plan takes no further sheet once it has taken so many bytes of heights. At 60 frames a second that is 120 MiB a second.
const BYTES_A_PLAN: usize = 2 << 20;

/// A cell out of sight waits like one that is so many times as far away.
const OUT_OF_SIGHT: f64 = 4.0;

/// While sheets are on their way their order follows the eye's turning once in so many plans.
const PLANS_AN_ORDER: u64 = 16;

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
    /// Sheets that have left their windows, and of which nothing is drawn once the plan is made.
    leaving: Vec<Sheet>,
    /// Whether other sheets are wanted than before.
    reorder: bool,
    pub failures: Failures,
    loaded: u64,
    unloaded: u64,
    resident_bytes: u64,
}

impl Stream {
    /// For windows of so many cells, by level; `coarse` are the codes of the coarse grid.
    pub fn new(file: CellFile, coarse: Vec<u8>, options: &Options, sides: &[u32]) -> std::io::Result<Self> {
        let header = file.header().clone();
        let (tiles, budget) = (header.tiles(sides), Budget::of(&header, options));
        Ok(Self {
            loader: Loader::new(file, options.loading, budget.sheets_waiting())?,
            coarse,
            cell_m: header.spacing_m.map(|metres| metres * header.cell_side() as f64),
            plans: 0,
            eye: None,
            leaving: Vec::new(),
            reorder: true,
            failures: Failures::default(),
            loaded: 0,
            unloaded: 0,
            resident_bytes: budget.bytes(sides),
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

    /// Moves the windows. Returns whether sheets leave for which a plan is to wait: then all levels must follow before
    /// [`Self::free`].
    pub fn leave(&mut self, grid: &mut Grid, levels: &mut Levels, view: &View) -> bool {
        self.plans += 1;
        self.free(grid);
        let eye = self.eye_cell(grid, view);
        // Even without another cell to load, the nearest are others.
        self.reorder |= self.eye.replace(eye) != Some(eye) || self.plans.is_multiple_of(PLANS_AN_ORDER);
        if grid.window.follow(eye) {
            self.leaving = grid.window.leaving();
            let (fewer, _) = grid.window.count_depths();
            levels.reconsider(grid, &fewer);
        }
        self.loader.is_blocking() && !self.leaving.is_empty()
    }

    /// Gives the places of the sheets away that have left.
    pub fn free(&mut self, grid: &mut Grid) {
        self.reorder |= !self.leaving.is_empty();
        self.unloaded += self.leaving.len() as u64;
        self.leaving.drain(..).for_each(|sheet| grid.window.free(sheet));
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
        if std::mem::take(&mut self.reorder) | self.failures.take_due(self.plans) {
            self.loader.want(self.wanted(grid, view));
        }
        let (before, limit) = (plan.bytes.len(), if self.loader.is_blocking() { usize::MAX } else { BYTES_A_PLAN });
        let (loaded, mut errors) = (self.loaded, errors);
        while plan.bytes.len() - before < limit {
            let Some(arrival) = self.loader.take() else { break };
            self.arrive(arrival, grid, errors.as_deref_mut(), plan);
        }
        if self.loaded > loaded {
            let (fewer, _) = grid.window.count_depths();
            levels.reconsider(grid, &fewer);
        }
    }

    fn arrive(&mut self, arrival: Arrival, grid: &mut Grid, errors: Option<&mut ErrorTable>, plan: &mut FramePlan) {
        let Arrival { sheet, content } = arrival;
        self.failures.note(sheet, content.as_ref().err(), self.plans);
        let Ok(Cell { heights, ranges_m, errors: records }) = content else { return };
        if !grid.window.lacks(sheet) {
            return; // the window has moved on
        }
        grid.window.enter(sheet);
        grid.put(sheet, &ranges_m);
        if let Some(errors) = errors {
            errors.put(grid, sheet, &records);
        }
        let tile = self.tiles.tile(sheet.level, sheet.cell);
        plan.upload(Buffer::Heights, tile * self.tiles.format.bytes(), &heights);
        self.loaded += 1;
    }

    /// The sheets to load, level by level, row by row.
    fn lacking<'a>(&'a self, grid: &'a Grid) -> impl Iterator<Item = Sheet> + 'a {
        let lacks = |sheet: &Sheet| grid.window.lacks(*sheet) && self.failures.may_read(*sheet, self.plans);
        grid.window.inside().filter(lacks)
    }

    /// The sheets to load: all windows fill from the eye to their rims at the same pace.
    fn wanted(&self, grid: &Grid, view: &View) -> Vec<Sheet> {
        let urgency = |Sheet { level, cell }: &Sheet| {
            let axes = [(0, view.eye_world.x), (1, view.eye_world.z)];
            let [x_m, z_m] = axes.map(|(axis, eye_m)| {
                let first_m = cell[axis] as f64 * self.cell_m[axis];
                eye_m - eye_m.clamp(first_m, first_m + self.cell_m[axis])
            });
            let share = x_m.hypot(z_m) / grid.window.side(*level) as f64;
            if self.is_needed_in_sight(grid, view, *cell) { share } else { share * OUT_OF_SIGHT }
        };
        let mut wanted: Vec<(f64, Sheet)> = self.lacking(grid).map(|sheet| (urgency(&sheet), sheet)).collect();
        // Of sheets as near, the coarser first: without it the finer one is of no use.
        wanted.sort_by(|(a, of_a), (b, of_b)| a.total_cmp(b).then(Reverse(of_a.level).cmp(&Reverse(of_b.level))));
        wanted.into_iter().map(|(_, sheet)| sheet).collect()
    }

    /// Whether a cell or one beside it is in sight: what may be split in a cell depends on those around it.
    fn is_needed_in_sight(&self, grid: &Grid, view: &View, cell: [u32; 2]) -> bool {
        let mut bounds = grid.bounds_world(Square { level: grid.top(), column: cell[0], row: cell[1] });
        for (axis, cell_m) in [(0, self.cell_m[0]), (2, self.cell_m[1])] {
            bounds.min[axis] -= cell_m;
            bounds.max[axis] += cell_m;
        }
        view.sees(&bounds)
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
            first_cells: grid.window.first_cells(),
        }
    }
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
    sides: &[u32],
) -> (Vec<u8>, Grid, Option<ErrorTable>) {
    let grid = Grid::streamed(header, resident.ranges_m, options, sides);
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
    use terrain_core::{Camera, Heightmap, Lens};

    fn open(options: &Options) -> (CellFile, Resident) {
        let heights_m = (0..500 * 460).map(|i| (i % 83) as f32).collect();
        let heightmap = Heightmap::new(500, 460, [30.0; 2], heights_m).unwrap();
        CellFile::open(Arc::new(cut(&heightmap, options))).unwrap()
    }

    /// An eye over the middle of a cell that looks north: rows of cells count southwards.
    #[test]
    fn what_is_in_sight_is_asked_for_before_what_is_as_near_behind() {
        let options = Options { layers: 3, ..Options::bounded() };
        let (file, resident) = open(&options);
        let header = file.header().clone();
        let sides = vec![9; header.streamed as usize];
        let stream = Stream::new(file, Vec::new(), &options, &sides).unwrap();
        let mut grid = tables(&header, resident, &options, &sides).1;
        grid.window.follow([9, 9]);
        let eye_world = [9.5 * stream.cell_m[0], 200.0, 9.5 * stream.cell_m[1]].into();
        let camera = Camera { eye_world, heading: 0.0, pitch: -0.2 };
        let view = View::new(&camera, &Lens { fov_y: 1.0, size_px: [320, 180], near_m: 1.0 }).unwrap();
        let wanted = stream.wanted(&grid, &view);
        assert_eq!(wanted.len(), 81 * sides.len());
        let at =
            |level: u32, row: u32| wanted.iter().position(|sheet| *sheet == Sheet { level, cell: [9, row] }).unwrap();
        for level in 0..header.streamed {
            let to_the_north: Vec<usize> = (5..=9).rev().map(|row| at(level, row)).collect();
            assert!(to_the_north.is_sorted(), "the nearest first: {to_the_north:?}");
            assert!(at(level, 5) < at(level, 11), "four cells ahead or two behind");
        }
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
}
