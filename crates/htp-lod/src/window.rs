//! Which cells of a streamed DEM are loaded, where what is kept of them has its place, and what may be split for it
//! (section 4.2).
//!
//! What is kept of streamed levels has room for a window of `side` x `side` cells, a torus: cell (column, row) has the
//! place (column mod `side`, row mod `side`) from when it is loaded until it has left. When the window moves, a row of
//! cells that enters takes the places of one that leaves, and nothing else moves:
//!
//! ```text
//!   cells        4  5  6  7 | 8      the window moves from 4..8 to 5..9:
//!   places       0  1  2  3 | 0      cell 8 takes the place of cell 4
//! ```
//!
//! A cell leaves in two steps, since what is drawn of it has to go first: when it leaves the window nothing in it may be
//! split any more, and when all levels have followed its place is given away.
//!
//! *What may be split.* A patch of the coarsest streamed level's parents needs the samples of its own cell. One that is
//! finer also has neighbours to be restricted, which may lie in the next cell, and whose neighbours are to be restricted
//! in turn: for every level that it is finer, one more ring of cells has to be loaded. So what the restriction asks for
//! may always be split, and look-ups on streamed levels never leave the loaded cells.
//!
//! Deviation: the paper loads the cells in the frustum, further 2 rows and columns in the background, and takes 4 more as
//! candidates for right levels at the rim. Here the window lies around the eye, since the eye turns faster than disks
//! read; the 2 rows and columns are those by which it may lie off the middle before it moves, so that an eye that
//! crosses a border to and fro loads nothing; the candidates are the rings.

/// The cells of a DEM, and which of them are loaded.
pub(crate) struct Window {
    /// Levels below this one are streamed; 0 for a DEM in memory.
    pub streamed: u32,
    /// Cells along the window.
    side: u32,
    /// Columns and rows of cells of the DEM.
    cells: [u32; 2],
    /// Column and row of its first cell; none before the first view.
    first: Option<[u32; 2]>,
    /// By cell, row by row over the DEM.
    states: Vec<State>,
    /// By place: the cell that has it.
    held: Vec<Option<[u32; 2]>>,
}

#[derive(Clone, Copy, Default)]
struct State {
    /// Whether the cell has its place.
    held: bool,
    /// 0 if the cell is not loaded or leaves; otherwise one more than the rings of loaded cells around it, `streamed` at
    /// most. A ring is what is beyond the sides of the cells within.
    depth: u8,
}

impl Window {
    /// For a DEM in memory: everything may be split.
    pub fn everything() -> Self {
        Self { streamed: 0, side: 0, cells: [0; 2], first: None, states: Vec::new(), held: Vec::new() }
    }

    /// Nothing is loaded.
    pub fn new(streamed: u32, side: u32, cells: [u32; 2]) -> Self {
        let states = vec![State::default(); cells[0] as usize * cells[1] as usize];
        Self { streamed, side, cells, first: None, states, held: vec![None; (side * side) as usize] }
    }

    /// Cells along the window.
    pub fn side(&self) -> u32 {
        self.side
    }

    fn index(&self, [column, row]: [u32; 2]) -> usize {
        row as usize * self.cells[0] as usize + column as usize
    }

    fn place(&self, cell: [u32; 2]) -> usize {
        let [column, row] = cell.map(|at| at % self.side);
        (row * self.side + column) as usize
    }

    /// Whether a patch of a level may be split in a cell.
    pub fn may_split(&self, level: u32, cell: [u32; 2]) -> bool {
        level > self.streamed || self.states[self.index(cell)].depth as u32 > self.streamed - level
    }

    /// Whether a cell has its place.
    pub fn holds(&self, cell: [u32; 2]) -> bool {
        self.states[self.index(cell)].held
    }

    /// The cell that has a place.
    pub fn holder(&self, [column, row]: [u32; 2]) -> [u32; 2] {
        self.held[(row * self.side + column) as usize].expect("a place that is in use")
    }

    /// The window's first cell.
    pub fn first(&self) -> [u32; 2] {
        self.first.unwrap_or_default()
    }

    /// The cells in the window, row by row.
    pub fn inside(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let (first, end) = (self.first(), self.end());
        (first[1]..end[1]).flat_map(move |row| (first[0]..end[0]).map(move |column| [column, row]))
    }

    fn end(&self) -> [u32; 2] {
        let first = self.first();
        [0, 1].map(|axis| (first[axis] + self.side).min(self.cells[axis]))
    }

    pub fn is_inside(&self, cell: [u32; 2]) -> bool {
        let (first, end) = (self.first(), self.end());
        self.first.is_some() && (0..2).all(|axis| (first[axis]..end[axis]).contains(&cell[axis]))
    }

    /// Whether a cell in the window could be loaded now: it is not, and its place is free.
    pub fn lacks(&self, cell: [u32; 2]) -> bool {
        self.is_inside(cell) && self.held[self.place(cell)].is_none()
    }

    /// Moves the window to an eye in a cell. Returns whether it has moved.
    pub fn follow(&mut self, eye: [u32; 2]) -> bool {
        let before = self.first;
        self.first = Some([0, 1].map(|axis| {
            let first = before.map(|first| first[axis]);
            moved(first, eye[axis], self.side, self.cells[axis])
        }));
        self.first != before
    }

    /// The cells that have their place and are not in the window any more.
    pub fn leaving(&self) -> Vec<[u32; 2]> {
        self.held.iter().flatten().copied().filter(|cell| !self.is_inside(*cell)).collect()
    }

    /// Gives a cell its place.
    pub fn enter(&mut self, cell: [u32; 2]) {
        let (place, index) = (self.place(cell), self.index(cell));
        assert_eq!(self.held[place], None, "the place of cell {cell:?} is not free");
        self.held[place] = Some(cell);
        self.states[index].held = true;
    }

    /// Takes a cell's place away.
    pub fn free(&mut self, cell: [u32; 2]) {
        let (place, index) = (self.place(cell), self.index(cell));
        assert_eq!(self.held[place].take(), Some(cell));
        assert_eq!(self.states[index].depth, 0, "cell {cell:?} has not left");
        self.states[index].held = false;
    }

    /// Counts the rings anew, after cells have entered or the window has moved. Returns the cells that have fewer than
    /// before, and whether any has more.
    pub fn count_rings(&mut self) -> (Vec<[u32; 2]>, bool) {
        let held: Vec<[u32; 2]> = self.held.iter().flatten().copied().collect();
        let before: Vec<u8> = held.iter().map(|cell| self.states[self.index(*cell)].depth).collect();
        for cell in &held {
            let index = self.index(*cell);
            self.states[index].depth = self.is_inside(*cell) as u8;
        }
        for depth in 1..self.streamed as u8 {
            let deeper: Vec<usize> =
                held.iter().filter(|cell| self.is_surrounded(**cell, depth)).map(|cell| self.index(*cell)).collect();
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

/// Where the window begins along one axis. It moves when the eye is farther off its middle than the slack, by as little
/// as it takes, and around the eye when that has jumped.
fn moved(first: Option<u32>, eye: u32, side: u32, cells: u32) -> u32 {
    let (slack, half) = (((side.saturating_sub(1)) / 3).min(2) as i64, (side / 2) as i64);
    let eye = eye as i64;
    let off = first.map_or(i64::MAX, |first| eye - (first as i64 + half));
    let first = match off {
        _ if off.abs() <= slack => eye - off - half,
        _ if off.abs() == slack + 1 => eye - slack * off.signum() - half,
        _ => eye - half,
    };
    first.clamp(0, (cells.saturating_sub(side)) as i64) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use terrain_core::SplitMix64;

    #[test]
    fn the_window_moves_late_and_no_more_than_it_must_but_follows_jumps() {
        let first = |first: Option<u32>, eye| moved(first, eye, 9, 50);
        assert_eq!([first(None, 20), first(None, 1), first(None, 49)], [16, 0, 41]);
        // The middle of 16..25 is 20: 18 to 22 keep it.
        assert_eq!([17, 18, 22, 23, 24, 40].map(|eye| first(Some(16), eye)), [15, 16, 16, 17, 20, 36]);
        // To and fro over a border.
        assert_eq!([first(Some(17), 22), first(Some(17), 23)], [17, 17]);
        assert_eq!([moved(None, 3, 1, 5), moved(Some(3), 4, 1, 5), moved(Some(0), 4, 9, 5)], [3, 4, 0]);
    }

    /// The rings around a cell, by their definition: no cell that is not loaded within so many steps over sides.
    fn depth(loaded: &BTreeSet<[u32; 2]>, streamed: u32, cells: [u32; 2], cell: [u32; 2]) -> u32 {
        let steps = |other: &[u32; 2]| cell[0].abs_diff(other[0]) + cell[1].abs_diff(other[1]);
        let all = (0..cells[1]).flat_map(|row| (0..cells[0]).map(move |column| [column, row]));
        let nearest = all.filter(|other| !loaded.contains(other)).map(|other| steps(&other)).min();
        nearest.unwrap_or(u32::MAX).min(streamed)
    }

    /// A random walk of window, arrivals and departures.
    #[test]
    fn what_may_be_split_is_what_the_loaded_cells_around_allow() {
        for seed in 0..60 {
            let mut random = SplitMix64::new(seed);
            let cells = [1 + random.below(9) as u32, 1 + random.below(9) as u32];
            let (streamed, side) = (1 + random.below(3) as u32, 1 + random.below(6) as u32);
            let side = side.min(cells[0].max(cells[1]));
            let (mut window, mut loaded) = (Window::new(streamed, side, cells), BTreeSet::new());
            for _ in 0..60 {
                window.leaving().into_iter().for_each(|cell| window.free(cell));
                window.follow(cells.map(|cells| random.below(cells as u64) as u32));
                loaded.retain(|cell| window.is_inside(*cell));
                let inside: Vec<_> = window.inside().collect();
                for cell in inside.into_iter().filter(|_| random.below(3) > 0) {
                    if window.lacks(cell) {
                        window.enter(cell);
                        loaded.insert(cell);
                    }
                }
                let allowed = |window: &Window, cell| (1..=4).filter(|level| window.may_split(*level, cell)).count();
                let all = || (0..cells[1]).flat_map(|row| (0..cells[0]).map(move |column| [column, row]));
                let before: Vec<_> = all().map(|cell| allowed(&window, cell)).collect();
                let (fewer, more) = window.count_rings();
                for (cell, before) in all().zip(before) {
                    let (found, expected) = (allowed(&window, cell), depth(&loaded, streamed, cells, cell));
                    assert_eq!(found as u32, 4 - streamed + expected, "seed {seed}, cell {cell:?}");
                    assert_eq!(fewer.contains(&cell), found < before, "seed {seed}, cell {cell:?}");
                    assert!(more || found <= before, "seed {seed}");
                }
            }
        }
    }

    #[test]
    fn a_place_is_given_away_once_its_cell_has_left() {
        let mut window = Window::new(2, 3, [9, 1]);
        window.follow([1, 0]);
        window.inside().collect::<Vec<_>>().into_iter().for_each(|cell| window.enter(cell));
        assert!(window.holds([0, 0]) && !window.lacks([0, 0]) && window.holder([0, 0]) == [0, 0]);
        window.follow([2, 0]);
        assert_eq!(window.leaving(), [[0, 0]]);
        assert!(window.is_inside([3, 0]) && !window.lacks([3, 0]), "its place is still that of cell 0");
        window.count_rings();
        window.free([0, 0]);
        assert!(window.lacks([3, 0]) && !window.holds([0, 0]));
    }
}
