//! Which cells of a streamed DEM are loaded, where what is kept of them has its place, and what may be split for it
//! (section 4.2).
//!
//! What is loaded of a cell for one level is a *sheet*. Every streamed level has a window of its own around the eye
//! (`torus`): coarser levels are wanted farther out, and take less room, so that theirs are wider (`budget`).
//!
//! A sheet leaves in two steps, since what is drawn of it has to go first: when its cell leaves the level's window
//! nothing may be split into the level any more, and when all levels have followed its place is given away.
//!
//! *What may be split.* To split a patch takes the sheet of its cell for the next finer level. The restriction then asks
//! for patches one level coarser than the patch, which may lie in the next cell; for these it asks in turn. So in a cell
//! may be split, from the coarsest streamed level's parents down:
//!
//! ```text
//!   level n + 1, if the sheets of levels n and above are there, and level n + 2 may be split
//!                in the cell and in those beyond its four sides
//! ```
//!
//! Then what the restriction asks for may always be split, and look-ups on streamed levels never leave the loaded sheets.
//! Where all windows are as wide, a cell may be split as deep as it has rings of loaded cells around it.
//!
//! Deviation: the paper loads the cells in the frustum, further 2 rows and columns in the background, and takes 4 more as
//! candidates for right levels at the rim. Here the windows lie around the eye, since the eye turns faster than disks
//! read, and those in the frustum come first (`stream`); the 2 rows and columns are those by which it may lie off the middle before they move, so that an eye that
//! crosses a border to and fro loads nothing; the candidates are the cells beyond the sides.

mod torus;

use terrain_core::HeightTiles;

use torus::Torus;

/// What is loaded of a cell for one streamed level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Sheet {
    pub level: u32,
    /// Column and row.
    pub cell: [u32; 2],
}

/// The cells of a DEM, and for which levels they are loaded.
pub(crate) struct Window {
    /// Levels below this one are streamed; 0 for a DEM in memory.
    pub streamed: u32,
    /// Columns and rows of cells of the DEM.
    cells: [u32; 2],
    /// By streamed level.
    levels: Vec<Torus>,
    /// By cell, row by row over the DEM.
    states: Vec<State>,
}

#[derive(Clone, Copy, Default)]
struct State {
    /// The levels whose sheets have their place: a bit each.
    held: u8,
    /// Levels that may be split, counted from the parents of the coarsest streamed one down.
    depth: u8,
}

impl Window {
    /// For a DEM in memory: everything may be split.
    pub fn everything() -> Self {
        Self { streamed: 0, cells: [0; 2], levels: Vec::new(), states: Vec::new() }
    }

    /// By level: so many cells along its window. Nothing is loaded.
    pub fn new(sides: &[u32], cells: [u32; 2]) -> Self {
        let states = vec![State::default(); cells[0] as usize * cells[1] as usize];
        let levels = sides.iter().map(|side| Torus::new(*side, cells)).collect();
        Self { streamed: sides.len() as u32, cells, levels, states }
    }

    /// Cells along a level's window.
    pub fn side(&self, level: u32) -> u32 {
        self.levels[level as usize].side
    }

    fn index(&self, [column, row]: [u32; 2]) -> usize {
        row as usize * self.cells[0] as usize + column as usize
    }

    /// Whether a patch of a level may be split in a cell.
    pub fn may_split(&self, level: u32, cell: [u32; 2]) -> bool {
        level > self.streamed || self.states[self.index(cell)].depth as u32 > self.streamed - level
    }

    /// Whether a sheet has its place.
    pub fn holds(&self, level: u32, cell: [u32; 2]) -> bool {
        self.states[self.index(cell)].held >> level & 1 == 1
    }

    /// The cell whose sheet has a place.
    pub fn holder(&self, level: u32, place: [u32; 2]) -> [u32; 2] {
        self.levels[level as usize].holder(place).expect("a place that is in use")
    }

    /// By level: the first cell of its window.
    pub fn first_cells(&self) -> [[u32; 2]; HeightTiles::MAX_LEVELS] {
        std::array::from_fn(|level| self.levels.get(level).map_or([0; 2], Torus::first))
    }

    /// The sheets in the windows, level by level, row by row.
    pub fn inside(&self) -> impl Iterator<Item = Sheet> {
        (0..).zip(&self.levels).flat_map(|(level, torus)| torus.inside().map(move |cell| Sheet { level, cell }))
    }

    pub fn is_inside(&self, sheet: Sheet) -> bool {
        self.levels[sheet.level as usize].is_inside(sheet.cell)
    }

    /// Whether a sheet in its window could be loaded now: it is not, and its place is free.
    pub fn lacks(&self, sheet: Sheet) -> bool {
        self.is_inside(sheet) && self.levels[sheet.level as usize].holder(sheet.cell).is_none()
    }

    /// Moves the windows to an eye in a cell. Returns whether any has moved.
    pub fn follow(&mut self, eye: [u32; 2]) -> bool {
        self.levels.iter_mut().fold(false, |moved, torus| torus.follow(eye) | moved)
    }

    /// The sheets that have their place and are not in the window any more.
    pub fn leaving(&self) -> Vec<Sheet> {
        let held =
            (0..).zip(&self.levels).flat_map(|(level, torus)| torus.held().map(move |cell| Sheet { level, cell }));
        held.filter(|sheet| !self.is_inside(*sheet)).collect()
    }

    /// Gives a sheet its place.
    pub fn enter(&mut self, Sheet { level, cell }: Sheet) {
        self.levels[level as usize].enter(cell);
        let index = self.index(cell);
        self.states[index].held |= 1 << level;
    }

    /// Takes a sheet's place away.
    pub fn free(&mut self, Sheet { level, cell }: Sheet) {
        assert!(!self.may_split(level + 1, cell), "cell {cell:?} has not left the window of level {level}");
        self.levels[level as usize].free(cell);
        let index = self.index(cell);
        self.states[index].held &= !(1 << level);
    }

    /// Decides anew what may be split, after sheets have entered or the windows have moved. Returns the cells in which it
    /// is less than before, and whether it is more in any.
    pub fn count_depths(&mut self) -> (Vec<[u32; 2]>, bool) {
        let Some(coarsest) = self.levels.last() else { return (Vec::new(), false) };
        let held: Vec<[u32; 2]> = coarsest.held().collect();
        let before: Vec<u8> = held.iter().map(|cell| self.states[self.index(*cell)].depth).collect();
        for cell in &held {
            let index = self.index(*cell);
            self.states[index].depth = coarsest.is_inside(*cell) as u8;
        }
        for depth in 1..self.streamed as u8 {
            let level = self.streamed - 1 - depth as u32;
            let has_sheet = |cell: &[u32; 2]| self.holds(level, *cell) && self.levels[level as usize].is_inside(*cell);
            let deeper = held.iter().filter(|cell| has_sheet(cell) && self.is_surrounded(**cell, depth));
            let deeper: Vec<usize> = deeper.map(|cell| self.index(*cell)).collect();
            deeper.into_iter().for_each(|index| self.states[index].depth = depth + 1);
        }
        let now = held.iter().map(|cell| self.states[self.index(*cell)].depth);
        let changes: Vec<_> = now.zip(before).zip(&held).collect();
        let fewer = changes.iter().filter(|((now, before), _)| now < before).map(|(_, cell)| **cell).collect();
        (fewer, changes.iter().any(|((now, before), _)| now > before))
    }

    /// Whether a cell and all beyond its sides have a depth.
    fn is_surrounded(&self, [column, row]: [u32; 2], depth: u8) -> bool {
        let sides =
            [(column.wrapping_sub(1), row), (column + 1, row), (column, row.wrapping_sub(1)), (column, row + 1)];
        let exists = |(column, row): &(u32, u32)| *column < self.cells[0] && *row < self.cells[1];
        let mut beyond = sides.into_iter().filter(exists).chain([(column, row)]);
        beyond.all(|(column, row)| self.states[self.index([column, row])].depth >= depth)
    }
}

#[cfg(test)]
mod tests;
