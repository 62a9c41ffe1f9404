//! A mesh that no view changes: a grid of some rows and columns of the DEM, uploaded once, one draw.

use terrain_core::{
    BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Heightmap, IndexFormat, PatchTag, Sample, VertexKind,
};

/// The two static buffers of a grid, and its draw.
pub(crate) struct StaticGrid {
    /// What the first plan uploads; empty afterwards.
    vertices: Vec<BakedVertex>,
    indices: Vec<u32>,
    sizes: BufferSizes,
    index_count: u32,
}

impl StaticGrid {
    /// The samples where the given columns and rows of the DEM cross; both ascend, from the first to the last.
    ///
    /// Panics above 26,754 x 26,754 vertices, where the indices are more than a 32-bit draw can name.
    pub fn new(heightmap: &Heightmap, columns: &[u32], rows: &[u32]) -> Self {
        let samples = rows.iter().flat_map(|row| columns.iter().map(|column| Sample { column: *column, row: *row }));
        let vertices: Vec<BakedVertex> = samples.map(|at| BakedVertex::of(heightmap, at)).collect();
        let indices = indices(columns.len() as u32, rows.len() as u32);
        let sizes = BufferSizes {
            vertex_kind: VertexKind::Baked,
            index_format: IndexFormat::U32,
            vertices: size_of_val(&vertices[..]) as u64,
            indices: size_of_val(&indices[..]) as u64,
            instances: 0,
            heights: None,
            cell_side: None,
        };
        let index_count = u32::try_from(indices.len()).expect("a grid needs at most 2^32 indices");
        Self { vertices, indices, sizes, index_count }
    }

    pub fn buffers(&self) -> BufferSizes {
        self.sizes
    }

    pub fn plan(&mut self, plan: &mut FramePlan) {
        plan.clear();
        plan.upload(Buffer::Vertices, 0, &std::mem::take(&mut self.vertices));
        plan.upload(Buffer::Indices, 0, &std::mem::take(&mut self.indices));
        plan.draws.push(Draw::baked(0..self.index_count, 0, PatchTag { patch: 0, level: 0 }));
    }
}

/// Two triangles a quad, all diagonals the same way:
///
/// ```text
///   0---1     (0, 2, 1) and (1, 2, 3),
///   | / |     counter-clockwise seen from above, north up
///   2---3
/// ```
fn indices(columns: u32, rows: u32) -> Vec<u32> {
    let mut indices = Vec::with_capacity(6 * (columns - 1) as usize * (rows - 1) as usize);
    for row in 0..rows - 1 {
        for column in 0..columns - 1 {
            let north_west = row * columns + column;
            let south_west = north_west + columns;
            indices.extend([north_west, south_west, north_west + 1]);
            indices.extend([north_west + 1, south_west, south_west + 1]);
        }
    }
    indices
}
