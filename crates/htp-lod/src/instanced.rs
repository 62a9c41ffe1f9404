//! One patch of vertices, drawn as many times as there are visible patches: at most 8 draws a frame.
//!
//! Deviation: the paper draws one patch at a time, and saves draws by making patches large. Since the index lists are
//! the same for every orientation (section 4.1, Figure 3), so can the vertices be: an instance says where the patch
//! stands, and the height comes from the DEM. Instances are sorted by mask, one draw a mask:
//!
//! ```text
//!  instances  | mask 0 ............ | mask 1 .. | mask 2 ... | ... | mask 6 |
//!  draws      | plain list          | block 1   | block 2    | ... | block 6|
//! ```

use crate::blocks::{Blocks, MASKS};
use crate::grid::Grid;
use crate::leaves::Leaf;
use terrain_core::{Buffer, Draw, FramePlan, PatchInstance};

pub(crate) struct Instanced {
    /// What the instance buffer begins with.
    uploaded: Vec<PatchInstance>,
    /// What this frame needs.
    instances: Vec<PatchInstance>,
}

impl Instanced {
    pub fn new() -> Self {
        Self { uploaded: Vec::new(), instances: Vec::new() }
    }

    /// Bytes of the instance buffer: room for all patches of the finest layer. A leaf stands for at least one of
    /// them; at the rim, where a south-east half may have none, both halves of a square together stand for two.
    pub fn instance_bytes(&self, grid: &Grid) -> u64 {
        2 * grid.squares(0).count() as u64 * size_of::<PatchInstance>() as u64
    }

    /// Phase 6, rendering: one draw for the plain list and for each matching block in use.
    pub fn draw(&mut self, grid: &Grid, blocks: &Blocks, leaves: &[Leaf], plan: &mut FramePlan) {
        let mut ends = [0; MASKS];
        leaves.iter().for_each(|leaf| ends[leaf.mask as usize] += 1);
        let mut start = 0;
        for (end, indices) in ends.iter_mut().zip(&blocks.ranges) {
            let instances = start..start + *end;
            *end = start;
            start = instances.end;
            if !instances.is_empty() {
                plan.draws.push(Draw { indices: indices.clone(), base_vertex: 0, instances });
            }
        }
        self.sort_by_mask(grid, leaves, ends);
        if self.instances != self.uploaded {
            plan.upload(Buffer::Instances, 0, &self.instances);
            std::mem::swap(&mut self.instances, &mut self.uploaded);
        }
    }

    /// `next` holds, for each mask, the place of its next instance.
    fn sort_by_mask(&mut self, grid: &Grid, leaves: &[Leaf], mut next: [u32; MASKS]) {
        self.instances.clear();
        self.instances.resize(leaves.len(), bytemuck::Zeroable::zeroed());
        for leaf in leaves {
            let place = &mut next[leaf.mask as usize];
            self.instances[*place as usize] = grid.instance(leaf.patch);
            *place += 1;
        }
    }
}
