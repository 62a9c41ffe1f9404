//! The cells of one streamed level that have a place.
//!
//! What is kept of the level has room for `side` x `side` cells, a torus: cell (column, row) has the place
//! (column mod `side`, row mod `side`) from when it is loaded until it has left. When the window moves, a row of cells
//! that enters takes the places of one that leaves, and nothing else moves:
//!
//! ```text
//!   cells        4  5  6  7 | 8      the window moves from 4..8 to 5..9:
//!   places       0  1  2  3 | 0      cell 8 takes the place of cell 4
//! ```

/// A window, and the cells that have their places in it.
pub(super) struct Torus {
    /// Cells along the window.
    pub side: u32,
    /// Columns and rows of cells of the DEM.
    cells: [u32; 2],
    /// Column and row of its first cell; none before the first view.
    first: Option<[u32; 2]>,
    /// By place: the cell that has it.
    held: Vec<Option<[u32; 2]>>,
}

impl Torus {
    /// Nothing is loaded.
    pub fn new(side: u32, cells: [u32; 2]) -> Self {
        Self { side, cells, first: None, held: vec![None; (side * side) as usize] }
    }

    fn place(&self, cell: [u32; 2]) -> usize {
        let [column, row] = cell.map(|at| at % self.side);
        (row * self.side + column) as usize
    }

    /// The cell that has a place, given by column and row.
    pub fn holder(&self, place: [u32; 2]) -> Option<[u32; 2]> {
        self.held[self.place(place)]
    }

    /// All cells that have their place.
    pub fn held(&self) -> impl Iterator<Item = [u32; 2]> {
        self.held.iter().flatten().copied()
    }

    /// The window's first cell.
    pub fn first(&self) -> [u32; 2] {
        self.first.unwrap_or_default()
    }

    fn end(&self) -> [u32; 2] {
        let first = self.first();
        [0, 1].map(|axis| (first[axis] + self.side).min(self.cells[axis]))
    }

    /// The cells in the window, row by row.
    pub fn inside(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let (first, end) = (self.first(), self.end());
        (first[1]..end[1]).flat_map(move |row| (first[0]..end[0]).map(move |column| [column, row]))
    }

    pub fn is_inside(&self, cell: [u32; 2]) -> bool {
        let (first, end) = (self.first(), self.end());
        self.first.is_some() && (0..2).all(|axis| (first[axis]..end[axis]).contains(&cell[axis]))
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

    /// Gives a cell its place.
    pub fn enter(&mut self, cell: [u32; 2]) {
        let place = self.place(cell);
        assert_eq!(self.held[place], None, "the place of cell {cell:?} is not free");
        self.held[place] = Some(cell);
    }

    /// Takes a cell's place away.
    pub fn free(&mut self, cell: [u32; 2]) {
        let place = self.place(cell);
        assert_eq!(self.held[place].take(), Some(cell));
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
}
