//! One patch of vertices, drawn as many times as there are visible patches: at most 7 draws a frame.
//!
//! Deviation: the paper draws one patch at a time, and saves draws by making patches large. Since the index lists are
//! the same for every orientation (section 4.1, Figure 3), so can the vertices be: an instance says where the patch
//! stands and which one it is, and the height comes from the DEM. Instances are sorted by mask, one draw a mask:
//!
//! ```text
//!  instances  | mask 0 ............ | mask 1 .. | mask 2 ... | ... | mask 6 |
//!  draws      | plain list          | block 1   | block 2    | ... | block 6|
//! ```

use crate::blocks::{Blocks, MASKS};
use crate::grid::{Grid, Patch};
use crate::leaves::Leaf;
use crate::per_patch::Slot;
use terrain_core::{Buffer, Draw, FramePlan, PatchInstance};

pub(crate) struct Instanced {
    /// Numbers the patches as if each had vertices of its own.
    slot: Slot,
    /// What the instance buffer begins with.
    uploaded: Vec<PatchInstance>,
    /// What this frame needs.
    instances: Vec<PatchInstance>,
}

impl Instanced {
    pub fn new(grid: &Grid) -> Self {
        Self { slot: Slot::new(grid), uploaded: Vec::new(), instances: Vec::new() }
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
            self.instances[*place as usize] = self.instance(grid, leaf.patch);
            *place += 1;
        }
    }

    /// A tag that is the same in every view, and the same that one draw a patch would have.
    fn instance(&self, grid: &Grid, patch: Patch) -> PatchInstance {
        PatchInstance { tag: self.slot.tag(grid, patch).to_instance(), ..grid.instance(patch) }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Batching, Htp, Options};
    use std::sync::Arc;
    use terrain_core::walk::RandomWalk;
    use terrain_core::{Buffer, Draw, FramePlan, Heightmap, LodMethod, PatchInstance};

    /// The start of the index list and the tag of each patch that a draw of baked vertices draws.
    fn as_published(draw: &Draw) -> (u32, u32) {
        (draw.indices.start, draw.instances.start)
    }

    #[test]
    fn both_batchings_tag_a_patch_alike_in_every_view() {
        let heights = (0..90 * 70).map(|i| (i % 17) as f32 * 40.0).collect();
        let heightmap = Arc::new(Heightmap::new(90, 70, [30.0; 2], heights).unwrap());
        let [mut published, mut instanced] = [Batching::PerPatch, Batching::Instanced]
            .map(|batching| Htp::new(heightmap.clone(), Options { batching, ..Options::default() }).unwrap());
        let (mut plan, mut buffer) = (FramePlan::default(), Vec::<PatchInstance>::new());
        for view in RandomWalk::new(3, &heightmap).take(40) {
            published.plan(&view, &mut plan);
            let mut expected: Vec<_> = plan.draws.iter().map(as_published).collect();
            instanced.plan(&view, &mut plan);
            if let Some(upload) = plan.uploads.iter().find(|upload| upload.buffer == Buffer::Instances) {
                buffer = bytemuck::pod_collect_to_vec(plan.bytes_of(upload));
            }
            let tags = |draw: &Draw| draw.instances.clone().map(|at| buffer[at as usize].tag).collect::<Vec<_>>();
            let tagged = |draw: &Draw| tags(draw).into_iter().map(|tag| (draw.indices.start, tag)).collect::<Vec<_>>();
            let mut found: Vec<_> = plan.draws.iter().flat_map(tagged).collect();
            expected.sort();
            found.sort();
            assert_eq!(found, expected);
        }
    }
}
