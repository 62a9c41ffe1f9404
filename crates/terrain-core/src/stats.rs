//! The one place where a frame is counted.

use std::ops::Range;

use crate::{Draw, FramePlan, MeshMirror, PatchTag};

/// Counts of one frame, all from its plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameStats {
    /// Triangles sent to the GPU, degenerate ones included.
    pub triangles: u64,
    /// Draws in the plan; how many draw calls they become is the renderer's choice.
    pub draws: u64,
    /// Bytes written to the method's buffers.
    pub upload_bytes: u64,
    /// Indices that the draws read, each counted once.
    pub indices_used: u64,
    /// Patches triangulated anew in the updates that finished since the last frame.
    pub updated_patches: u64,
    /// Triangles that these updates made.
    pub updated_triangles: u64,
    /// Patches drawn for an older view than this frame's.
    pub stale_patches: u64,
}

impl FrameStats {
    /// Counts a plan.
    pub fn of(plan: &FramePlan) -> Self {
        Self {
            triangles: plan.draws.iter().map(Draw::triangles).sum(),
            draws: plan.draws.len() as u64,
            upload_bytes: plan.uploads.iter().map(|upload| upload.bytes.len() as u64).sum(),
            indices_used: union_length(plan.draws.iter().map(|draw| draw.indices.clone())),
            updated_patches: plan.work.iter().map(|work| work.patches as u64).sum(),
            updated_triangles: plan.work.iter().map(|work| work.triangles).sum(),
            stale_patches: plan.stale_patches.into(),
        }
    }
}

/// Triangles of the mirror's last plan by their level, degenerate ones included. What draws several levels at once, as merged
/// cells and one list for all do, says level 0 of them all.
pub fn triangles_by_level(mirror: &MeshMirror) -> [u64; PatchTag::LEVELS] {
    let mut levels = [0; PatchTag::LEVELS];
    mirror.tagged().for_each(|(tag, triangles)| levels[tag.level as usize] += triangles);
    levels
}

/// How many integers lie in at least one of the ranges.
fn union_length(ranges: impl Iterator<Item = Range<u32>>) -> u64 {
    let mut ranges: Vec<_> = ranges.collect();
    ranges.sort_unstable_by_key(|range| (range.start, range.end));
    let (mut covered_to, mut length) = (0, 0);
    for range in ranges {
        length += range.end.saturating_sub(range.start.max(covered_to)) as u64;
        covered_to = covered_to.max(range.end);
    }
    length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Buffer, WorkReport};

    #[test]
    fn counts_triangles_instances_uploads_and_shared_index_ranges() {
        let mut plan = FramePlan::default();
        plan.upload(Buffer::Indices, 0, &[0u32; 12]);
        plan.upload(Buffer::Vertices, 0, &[0u32; 5]);
        plan.draws.push(Draw { indices: 0..6, base_vertex: 0, instances: 7..8 });
        plan.draws.push(Draw { indices: 3..12, base_vertex: 4, instances: 0..10 });
        plan.draws.push(Draw { indices: 0..6, base_vertex: 9, instances: 8..9 });
        plan.stale_patches = 2;
        plan.work.push(WorkReport { patches: 3, triangles: 41, ..Default::default() });
        let expected = FrameStats {
            triangles: 34,
            draws: 3,
            upload_bytes: 68,
            indices_used: 12,
            updated_patches: 3,
            updated_triangles: 41,
            stale_patches: 2,
        };
        assert_eq!(FrameStats::of(&plan), expected);
    }
}
