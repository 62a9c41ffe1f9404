//! Every sample, every frame, one draw.

use terrain_core::{
    BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Heightmap, IndexFormat, LodMethod, PatchTag, VertexKind, View,
};

/// The whole DEM at full resolution: static vertices, static indices, nothing culled.
pub struct FullGrid {
    /// What the first plan uploads; empty afterwards.
    vertices: Vec<BakedVertex>,
    indices: Vec<u32>,
    sizes: BufferSizes,
    index_count: u32,
}

impl FullGrid {
    /// Builds the two static buffers: `2 * (columns - 1) * (rows - 1)` triangles.
    ///
    /// Panics above 26,754 x 26,754 samples, where the indices are more than a 32-bit draw can name.
    pub fn new(heightmap: &Heightmap) -> Self {
        let vertices = BakedVertex::whole_dem(heightmap);
        let indices = indices(heightmap.columns(), heightmap.rows());
        let sizes = BufferSizes {
            vertex_kind: VertexKind::Baked,
            index_format: IndexFormat::U32,
            vertices: size_of_val(&vertices[..]) as u64,
            indices: size_of_val(&indices[..]) as u64,
            instances: 0,
        };
        let index_count = u32::try_from(indices.len()).expect("a full grid needs at most 2^32 indices");
        Self { vertices, indices, sizes, index_count }
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

impl LodMethod for FullGrid {
    fn name(&self) -> &'static str {
        "full-grid"
    }

    fn buffers(&self) -> BufferSizes {
        self.sizes
    }

    fn set_culling(&mut self, _culling: bool) {
        // One draw: all or nothing.
    }

    fn plan(&mut self, _view: &View, plan: &mut FramePlan) {
        plan.clear();
        plan.upload(Buffer::Vertices, 0, &std::mem::take(&mut self.vertices));
        plan.upload(Buffer::Indices, 0, &std::mem::take(&mut self.indices));
        plan.draws.push(Draw::baked(0..self.index_count, 0, PatchTag { patch: 0, level: 0 }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::contract;

    #[test]
    fn keeps_the_contract() {
        for (columns, rows) in [(2, 2), (2, 9), (33, 31)] {
            let heights = (0..columns * rows).map(|i| (i * 7 % 13) as f32).collect();
            let dem = Heightmap::new(columns, rows, [30.0, 20.0], heights).unwrap();
            contract::check(&dem, |_| Box::new(FullGrid::new(&dem)), 1, 200);
        }
    }
}
