//! One patch of vertices, drawn as many times as there are visible patches: at most 7 draws a frame.
//!
//! Deviation: the paper draws one patch at a time, and saves draws by making patches large. Since the index lists are
//! the same for every orientation (section 4.1, Figure 3), so can the vertices be: an instance says where the patch
//! stands and which one it is, and the height comes from the DEM. Instances of one mask stand side by side, one draw a
//! mask, in slots that they keep (`slots`):
//!
//! ```text
//!  instances  | mask 0 ............ | mask 1 .. | mask 2 ... | ... | mask 6 |
//!  draws      | plain list          | block 1   | block 2    | ... | block 6|
//! ```

use crate::blocks::Blocks;
use crate::grid::Grid;
use crate::in_sight::InSight;
use crate::levels::Levels;
use crate::sight::Culling;
use crate::slots::Slots;
use terrain_core::FramePlan;

pub(crate) struct Instanced {
    in_sight: InSight,
    slots: Slots,
}

impl Instanced {
    /// Nothing is drawn.
    pub fn new(grid: &Grid) -> Self {
        Self { in_sight: InSight::new(grid), slots: Slots::new(grid.places()) }
    }

    /// Bytes of the instance buffer.
    pub fn bytes(&self) -> u64 {
        self.slots.bytes()
    }

    /// Phase 4, continued: the patch and the matching block of each place in sight.
    pub fn select(&mut self, grid: &Grid, levels: &Levels, culling: Culling) {
        self.in_sight.follow(grid, levels, culling, &mut self.slots);
    }

    /// Phase 6, rendering: one draw for the plain list and for each matching block in use.
    pub fn draw(&mut self, blocks: &Blocks, plan: &mut FramePlan) {
        self.slots.upload(plan);
        self.slots.draw(blocks, plan);
    }

    /// Collects all leaves anew where any level has changed, or never.
    #[cfg(test)]
    pub fn collect_anew(&mut self, always: bool) {
        self.in_sight.collect_anew(always);
    }

    /// Looks at every square in the next view.
    #[cfg(test)]
    pub fn forget(&mut self) {
        self.in_sight.mark_all();
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
    fn patches_have_the_same_tags_as_published_in_every_view() {
        let heights = (0..90 * 70).map(|i| (i % 17) as f32 * 40.0).collect();
        let heightmap = Arc::new(Heightmap::new(90, 70, [30.0; 2], heights).unwrap());
        let [mut published, mut instanced] = [Batching::PerPatch, Batching::Instanced]
            .map(|batching| Htp::new(heightmap.clone(), Options { batching, ..Options::default() }).unwrap());
        let mut mirror = vec![<PatchInstance as bytemuck::Zeroable>::zeroed(); 4096];
        let mut plan = FramePlan::default();
        for view in RandomWalk::new(3, &heightmap).take(40) {
            published.plan(&view, &mut plan);
            let mut expected: Vec<_> = plan.draws.iter().map(as_published).collect();
            instanced.plan(&view, &mut plan);
            for upload in plan.uploads.iter().filter(|upload| upload.buffer == Buffer::Instances) {
                let bytes = bytemuck::cast_slice_mut::<_, u8>(&mut mirror);
                bytes[upload.offset as usize..][..upload.bytes.len()].copy_from_slice(plan.bytes_of(upload));
            }
            let tags = |draw: &Draw| draw.instances.clone().map(|at| mirror[at as usize].tag).collect::<Vec<_>>();
            let tagged = |draw: &Draw| tags(draw).into_iter().map(|tag| (draw.indices.start, tag)).collect::<Vec<_>>();
            let mut found: Vec<_> = plan.draws.iter().flat_map(tagged).collect();
            expected.sort();
            found.sort();
            assert_eq!(found, expected);
        }
    }
}
