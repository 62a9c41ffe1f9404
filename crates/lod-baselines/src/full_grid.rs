//! Every sample, every frame, one draw.

use terrain_core::{BufferSizes, FramePlan, Heightmap, LodMethod, View};

use crate::static_grid::StaticGrid;

/// The whole DEM at full resolution: static vertices, static indices, nothing culled.
pub struct FullGrid(StaticGrid);

impl FullGrid {
    /// Builds the two static buffers: `2 * (columns - 1) * (rows - 1)` triangles.
    ///
    /// Panics above 26,754 x 26,754 samples, where the indices are more than a 32-bit draw can name.
    pub fn new(heightmap: &Heightmap) -> Self {
        let [columns, rows] = [heightmap.columns(), heightmap.rows()].map(|side| (0..side).collect::<Vec<u32>>());
        Self(StaticGrid::new(heightmap, &columns, &rows))
    }
}

impl LodMethod for FullGrid {
    fn name(&self) -> &'static str {
        "full-grid"
    }

    fn buffers(&self) -> BufferSizes {
        self.0.buffers()
    }

    fn set_culling(&mut self, _culling: bool) {
        // One draw: all or nothing.
    }

    fn plan(&mut self, _view: &View, plan: &mut FramePlan) {
        self.0.plan(plan);
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
