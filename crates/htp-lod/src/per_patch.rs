//! As published: every visible patch is one draw (section 3, phase 6). `base_vertex` picks the patch among the vertices
//! of its cell, the range of indices its plain list or its matching block.

use crate::blocks::Blocks;
use crate::cell_vertices::CellVertices;
use crate::grid::Grid;
use crate::leaves::{self, Leaf};
use crate::levels::Levels;
use crate::sight::Culling;
use terrain_core::{Draw, FramePlan};

#[derive(Default)]
pub(crate) struct PerPatch {
    leaves: Vec<Leaf>,
}

impl PerPatch {
    /// Phase 4, continued: the patch and the matching block of each place in sight.
    pub fn select(&mut self, grid: &Grid, levels: &Levels, culling: Culling) {
        self.leaves.clear();
        culling.cells_in_sight(grid, |cell, culling| leaves::collect(grid, levels, cell, culling, &mut self.leaves));
    }

    /// Phase 6, rendering: each patch with its plain list or its matching block.
    pub fn draw(&self, grid: &Grid, blocks: &Blocks, vertices: &CellVertices, plan: &mut FramePlan) {
        for Leaf { patch, mask } in &self.leaves {
            let (indices, tag) = (blocks.ranges[*mask as usize].clone(), grid.tag(*patch));
            plan.draws.push(Draw::baked(indices, vertices.base_vertex(grid, *patch) as i32, tag));
        }
    }
}
