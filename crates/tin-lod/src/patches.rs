//! The division of the DEM into patches, and the edges that they share. Integers only.
//!
//! Edges are numbered on their own, so that one selection serves both neighbours:
//!
//! ```text
//!        0       1                  across = 2, down = 2
//!    +-------+-------+
//!  6 | p0  7 | p1  8 |              horizontal edges: line * across + column
//!    +---2---+---3---+              vertical edges:   (down + 1) * across + row * (across + 1) + line
//!  9 | p2 10 | p3 11 |
//!    +---4---+---5---+              the last patch of a row or column is smaller where the
//!                                   DEM's intervals are no multiple of the patch
//! ```

use terrain_core::{Heightmap, Sample};

/// Number of a patch, row by row.
pub type PatchId = u32;
/// Number of an edge: the horizontal ones first.
pub type EdgeId = u32;

/// The grid of patches over a DEM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatchGrid {
    /// Samples of the DEM along x and z.
    columns: u32,
    rows: u32,
    /// Grid intervals along the side of a whole patch.
    side: u32,
    /// Patches along x and z.
    across: u32,
    down: u32,
}

/// The samples of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatchArea {
    /// The north-western sample.
    pub first: Sample,
    /// Grid intervals along x.
    pub width: u32,
    /// Grid intervals along z.
    pub depth: u32,
}

/// The samples of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeRun {
    /// The western or northern end.
    pub first: Sample,
    /// Grid intervals to the other end.
    pub length: u32,
    /// Whether it runs along x (else along z).
    pub along_x: bool,
}

/// The four edges of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatchEdges {
    /// First row.
    pub north: EdgeId,
    /// Last row.
    pub south: EdgeId,
    /// First column.
    pub west: EdgeId,
    /// Last column.
    pub east: EdgeId,
}

impl PatchEdges {
    /// North, south, west, east.
    pub fn all(self) -> [EdgeId; 4] {
        [self.north, self.south, self.west, self.east]
    }
}

impl PatchArea {
    /// The south-eastern sample.
    pub fn last(&self) -> Sample {
        Sample { column: self.first.column + self.width, row: self.first.row + self.depth }
    }
}

impl EdgeRun {
    /// The `i`-th sample from the first end.
    pub fn sample(&self, i: u32) -> Sample {
        let Sample { column, row } = self.first;
        if self.along_x { Sample { column: column + i, row } } else { Sample { column, row: row + i } }
    }
}

impl PatchGrid {
    /// Divides a DEM into patches of `side` grid intervals: 8, 16, 32 or 64.
    pub fn new(heightmap: &Heightmap, side: u32) -> Self {
        let (columns, rows) = (heightmap.columns(), heightmap.rows());
        Self { columns, rows, side, across: (columns - 1).div_ceil(side), down: (rows - 1).div_ceil(side) }
    }

    /// Grid intervals along the side of a whole patch.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Number of patches.
    pub fn patches(&self) -> u32 {
        self.across * self.down
    }

    /// Patches along x and z.
    pub fn size(&self) -> [u32; 2] {
        [self.across, self.down]
    }

    /// Number of edges.
    pub fn edges(&self) -> u32 {
        self.horizontal_edges() + self.down * (self.across + 1)
    }

    fn horizontal_edges(&self) -> u32 {
        (self.down + 1) * self.across
    }

    /// The samples of a patch.
    pub fn area(&self, patch: PatchId) -> PatchArea {
        let (column, row) = (patch % self.across * self.side, patch / self.across * self.side);
        PatchArea {
            first: Sample { column, row },
            width: self.side.min(self.columns - 1 - column),
            depth: self.side.min(self.rows - 1 - row),
        }
    }

    /// The edges around a patch.
    pub fn edges_of(&self, patch: PatchId) -> PatchEdges {
        let west = self.horizontal_edges() + patch / self.across * (self.across + 1) + patch % self.across;
        PatchEdges { north: patch, south: patch + self.across, west, east: west + 1 }
    }

    /// The samples of an edge.
    pub fn run(&self, edge: EdgeId) -> EdgeRun {
        let along_x = edge < self.horizontal_edges();
        let (column, row) = if along_x {
            (edge % self.across, edge / self.across)
        } else {
            let vertical = edge - self.horizontal_edges();
            (vertical % (self.across + 1), vertical / (self.across + 1))
        };
        let first =
            Sample { column: (column * self.side).min(self.columns - 1), row: (row * self.side).min(self.rows - 1) };
        let room = if along_x { self.columns - 1 - first.column } else { self.rows - 1 - first.row };
        EdgeRun { first, length: self.side.min(room), along_x }
    }

    /// The patches on the northern or western and on the southern or eastern side, where there are such.
    pub fn patches_of(&self, edge: EdgeId) -> [Option<PatchId>; 2] {
        if edge < self.horizontal_edges() {
            [edge.checked_sub(self.across), (edge < self.patches()).then_some(edge)]
        } else {
            let vertical = edge - self.horizontal_edges();
            let (line, row) = (vertical % (self.across + 1), vertical / (self.across + 1));
            let east = row * self.across + line;
            [(line > 0).then(|| east - 1), (line < self.across).then_some(east)]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_and_patches_agree_on_each_other() {
        for (columns, rows) in [(2, 2), (9, 9), (10, 30), (33, 2), (50, 41)] {
            let dem = Heightmap::new(columns, rows, [1.0; 2], vec![0.0; (columns * rows) as usize]).unwrap();
            let grid = PatchGrid::new(&dem, 8);
            let mut uses = vec![0; grid.edges() as usize];
            for patch in 0..grid.patches() {
                let (area, edges) = (grid.area(patch), grid.edges_of(patch));
                let corner = |c: u32, r: u32| Sample { column: area.first.column + c, row: area.first.row + r };
                let expected = [
                    (edges.north, corner(0, 0), area.width, true),
                    (edges.south, corner(0, area.depth), area.width, true),
                    (edges.west, corner(0, 0), area.depth, false),
                    (edges.east, corner(area.width, 0), area.depth, false),
                ];
                for (edge, first, length, along_x) in expected {
                    assert_eq!(grid.run(edge), EdgeRun { first, length, along_x }, "edge {edge}");
                    assert!(grid.patches_of(edge).contains(&Some(patch)), "edge {edge} of patch {patch}");
                    uses[edge as usize] += 1;
                }
            }
            for (edge, uses) in uses.into_iter().enumerate() {
                assert_eq!(grid.patches_of(edge as u32).iter().flatten().count(), uses, "edge {edge}");
            }
        }
    }

    #[test]
    fn rim_patches_end_at_the_rim() {
        let dem = Heightmap::new(50, 41, [1.0; 2], vec![0.0; 50 * 41]).unwrap();
        let grid = PatchGrid::new(&dem, 16);
        let last = grid.area(grid.patches() - 1);
        assert_eq!((last.width, last.depth), (1, 8));
        assert_eq!(last.last(), Sample { column: 49, row: 40 });
    }
}
