//! The vertex buffer: every sample of the DEM, in strips that let a patch's indices be small.
//!
//! ```text
//!    strip 0        strip 1        A strip is as wide as the largest node, with both of its border columns, row by row.
//!   0  1  2  3     24 25 26 27     So a vertex of a node is found by a small number that is the same for all nodes,
//!   4  5  6  7     28 29 30 31     row * (width of a strip) + column within the node, and the node's first vertex,
//!   8  9 10 11     32 33 34 35     which the draw adds. The columns between two strips are stored twice; the last
//!     ...            ...           strip repeats the DEM's last column.
//! ```
//!
//! One strip as wide as the DEM is the plain vertex buffer of the paper, sample `i` in vertex `i`.

use terrain_core::{BakedVertex, Heightmap, Sample};

use crate::patches::PatchArea;

/// Where a node's samples are in a vertex buffer: at `first_index + row * row_stride + column`.
#[derive(Clone, Copy)]
pub(crate) struct VertexPlace {
    pub first_index: u32,
    pub row_stride: u32,
}

impl VertexPlace {
    pub fn in_whole_dem(heightmap: &Heightmap, area: PatchArea) -> Self {
        Self { first_index: heightmap.index(area.first), row_stride: heightmap.columns() }
    }
}

/// Which vertex holds which sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VertexStrips {
    columns: u32,
    rows: u32,
    /// Grid intervals across a strip.
    side: u32,
}

impl VertexStrips {
    /// Strips of `side` grid intervals.
    pub fn new(heightmap: &Heightmap, side: u32) -> Self {
        Self { columns: heightmap.columns(), rows: heightmap.rows(), side }
    }

    /// One strip for the whole DEM.
    pub fn one(heightmap: &Heightmap) -> Self {
        Self::new(heightmap, heightmap.columns() - 1)
    }

    /// Where the samples of any node are, from its first vertex on.
    pub fn place(&self) -> VertexPlace {
        VertexPlace { first_index: 0, row_stride: self.row_stride() }
    }

    fn row_stride(&self) -> u32 {
        self.side + 1
    }

    /// Number of vertices.
    pub fn vertices(&self) -> u64 {
        self.strips() as u64 * self.rows as u64 * self.row_stride() as u64
    }

    fn strips(&self) -> u32 {
        (self.columns - 1).div_ceil(self.side)
    }

    /// The vertex of a node's north-western corner. The node must not reach into the next strip.
    pub fn first_vertex(&self, area: PatchArea) -> u32 {
        debug_assert!(area.first.column % self.side + area.width <= self.side, "a node in two strips");
        self.inner_vertex(area.first)
    }

    /// The vertex of a sample inside a node. On the border between two strips there is another one in the western strip.
    pub fn inner_vertex(&self, Sample { column, row }: Sample) -> u32 {
        (column / self.side * self.rows + row) * self.row_stride() + column % self.side
    }

    /// The whole buffer.
    pub fn fill(&self, heightmap: &Heightmap) -> Vec<BakedVertex> {
        let mut vertices = Vec::with_capacity(self.vertices() as usize);
        for first in (0..self.strips()).map(|strip| strip * self.side) {
            for row in 0..self.rows {
                let columns = (first..=first + self.side).map(|column| column.min(self.columns - 1));
                vertices.extend(columns.map(|column| BakedVertex::of(heightmap, Sample { column, row })));
            }
        }
        vertices
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patches::PatchGrid;

    #[test]
    fn every_sample_of_every_patch_is_where_its_index_says() {
        for (columns, rows) in [(2, 2), (9, 17), (10, 30), (50, 41)] {
            let heights_m = (0..columns * rows).map(|i| i as f32).collect();
            let dem = Heightmap::new(columns, rows, [1.0; 2], heights_m).unwrap();
            let grid = PatchGrid::new(&dem, 8);
            for strips in [VertexStrips::new(&dem, 8), VertexStrips::new(&dem, 32), VertexStrips::one(&dem)] {
                let vertices = strips.fill(&dem);
                assert_eq!(vertices.len() as u64, strips.vertices());
                for area in (0..grid.patches()).map(|patch| grid.area(patch)) {
                    for (x, z) in (0..=area.depth).flat_map(|z| (0..=area.width).map(move |x| (x, z))) {
                        let sample = Sample { column: area.first.column + x, row: area.first.row + z };
                        let vertex = strips.first_vertex(area) + z * strips.row_stride() + x;
                        assert_eq!(vertices[vertex as usize], BakedVertex::of(&dem, sample));
                    }
                }
            }
        }
    }
}
