//! One rule for borders: **a border sample is kept if any of the nodes that touch it needs it.**
//!
//! ```text
//!   +---------------+-------+      A node needs the samples that its own map keeps at its own level, and its corners.
//!   |               |   b   |      Where two nodes meet, the smaller one's whole side is shared. What either needs of
//!   |       a       x---+---+      it is kept, and the shared side's ends (x): both nodes come to the same set, so the
//!   |               | c | d |      mesh is watertight whatever their sizes and levels.
//!   +---------------+---+---+
//! ```
//!
//! Nodes of one size have one map: at the finer level the larger of two nested sets is kept, and it is sound. The maps
//! of two sizes know nothing of each other. A sample that only one of them needs can move the straight pieces away from
//! other samples of the side: those are added, until no sample of the side is farther away than the tolerance of the
//! finer level.

use terrain_core::Heightmap;

use crate::ladder::{Level, tolerance_m};
use crate::nodes::{NodeId, Nodes, Owners};
use crate::patches::{EdgeRun, PatchGrid};
use crate::select::{Mask, inner_bits};
use crate::threshold_map::{ThresholdMap, farthest_from_chord};

/// What a draw may cost in triangles.
///
/// Measured without culling, patch 32, group 2 (triangles and draws; 104,477 and 1,024, 34,243 and 4,096 without groups):
///
/// | price | 0 | 8 | 32 |
/// |---|---|---|---|
/// | Puget Sound, low over the middle, 1 px | 104,505, 808 | 105,515, 577 | 108,197, 355 |
/// | Death Valley, the same, 2 px | 31,050, 1,681 | 31,876, 1,102 | 32,344, 1,048 |
const DRAW_TRIANGLES: u32 = 8;

/// Nodes of all sizes, each size with its threshold map.
pub struct NodeMaps {
    nodes: Nodes,
    /// Of each layer.
    maps: Vec<ThresholdMap>,
}

impl NodeMaps {
    /// Computes the maps on the threads of the current rayon pool; the result does not depend on them.
    pub fn build(heightmap: &Heightmap, nodes: Nodes) -> Self {
        Self::build_with_progress(heightmap, nodes, &|_, _| {})
    }

    /// The same. `progress` is told how many of how many nodes are done, by any thread, not always in order.
    pub fn build_with_progress(heightmap: &Heightmap, nodes: Nodes, progress: &(dyn Fn(usize, usize) + Sync)) -> Self {
        let mut before = 0;
        let map = |grid: &PatchGrid| {
            let map = ThresholdMap::build(heightmap, grid, &|done, _| progress(before + done, nodes.len()));
            before += grid.patches() as usize;
            map
        };
        let maps = nodes.grids().map(map).collect();
        Self { nodes, maps }
    }

    pub(crate) fn new(nodes: Nodes, maps: Vec<ThresholdMap>) -> Self {
        Self { nodes, maps }
    }

    /// The codes of all maps, one after the other.
    pub(crate) fn codes(&self) -> impl Iterator<Item = &[u8]> {
        self.maps.iter().flat_map(ThresholdMap::codes)
    }

    /// The nodes.
    pub fn nodes(&self) -> &Nodes {
        &self.nodes
    }

    /// The inner samples of a side (0 to 3: north, south, west, east) that a node needs at a level.
    pub(crate) fn side(&self, node: NodeId, side: usize, level: Level) -> Mask {
        self.maps[self.nodes.place(node).0].edge_mask(self.nodes.edges_of(node)[side], level)
    }

    /// The samples inside a node that it needs at a level, a mask for each inner row.
    pub(crate) fn interior(&self, node: NodeId, level: Level, rows: &mut Vec<Mask>) {
        let (layer, number) = self.nodes.place(node);
        let inner_rows = self.nodes.area(node).depth as usize - 1;
        self.maps[layer].interior_masks(number, inner_rows, level, rows);
    }

    /// Appends the nodes of the best cut through a node at these levels (of all nodes): itself if that costs no more
    /// than its members do. Returns the cost in triangles, without those that nodes around it cause.
    pub fn cut(&self, node: NodeId, levels: &[Level], chosen: &mut Vec<NodeId>) -> u32 {
        let (own, before) = (self.triangles(node, levels[node as usize]) + DRAW_TRIANGLES, chosen.len());
        let of_members = self.nodes.members(node).map(|member| self.cut(member, levels, chosen)).sum();
        if chosen.len() > before && of_members < own {
            return of_members;
        }
        chosen.truncate(before);
        chosen.push(node);
        own
    }

    /// Triangles of a node at a level, if all nodes around it need no more than it does.
    fn triangles(&self, node: NodeId, level: Level) -> u32 {
        let (layer, number) = self.nodes.place(node);
        let inner_rows = self.nodes.area(node).depth as usize - 1;
        let border: u32 = (0..4).map(|side| self.side(node, side, level).count_ones()).sum();
        let interior = self.maps[layer].count_interior(number, inner_rows, level);
        // Of n points, h of them on the outline: 2 n - 2 - h triangles.
        2 * interior + border + 2
    }
}

/// A mesh in the making: which nodes it consists of, and at which levels.
#[derive(Clone, Copy)]
pub struct Cut<'a> {
    /// The DEM.
    pub heightmap: &'a Heightmap,
    /// What each node needs.
    pub maps: &'a NodeMaps,
    /// The nodes of the mesh.
    pub owners: &'a Owners,
    /// Levels of all nodes; those of nodes that are not in the mesh are not read.
    pub levels: &'a [Level],
}

impl Cut<'_> {
    /// The level of a node.
    pub fn level(&self, node: NodeId) -> Level {
        self.levels[node as usize]
    }

    /// The inner samples of a side that the node itself needs.
    pub(crate) fn needed(&self, node: NodeId, side: usize) -> Mask {
        self.maps.side(node, side, self.level(node))
    }

    /// The inner samples of a side (0 to 3: north, south, west, east) that are kept, given those that the node needs.
    pub(crate) fn kept(&self, node: NodeId, side: usize, needed: Mask) -> Mask {
        let (mut kept, mut last) = (needed, None);
        for patch in self.maps.nodes().patches_beyond(node, side) {
            let beyond = self.owners.of(patch);
            if last.replace(beyond) != Some(beyond) {
                kept |= self.kept_between(node, beyond, side, needed);
            }
        }
        kept
    }

    /// What is kept where a side of a node meets the node beyond, with the ends of the shared piece.
    fn kept_between(&self, node: NodeId, beyond: NodeId, side: usize, needed: Mask) -> Mask {
        let (level, level_beyond) = (self.level(node), self.level(beyond));
        let needed_beyond = || self.needed(beyond, side ^ 1);
        if self.maps.nodes().place(node).0 == self.maps.nodes().place(beyond).0 {
            return if level_beyond < level { needed_beyond() } else { needed };
        }
        let (run, run_beyond) = (self.run(node, side), self.run(beyond, side ^ 1));
        let shared = if run_beyond.length < run.length { run_beyond } else { run };
        let union = shifted(needed, run, shared) | shifted(needed_beyond(), run_beyond, shared);
        let limit_m = tolerance_m(level.min(level_beyond));
        let kept = straightened(self.heightmap, shared, union & inner_bits(shared.length), limit_m);
        shifted(kept | 1 | 1u64.unbounded_shl(shared.length), shared, run) & inner_bits(run.length)
    }

    fn run(&self, node: NodeId, side: usize) -> EdgeRun {
        let nodes = self.maps.nodes();
        nodes.grid_of(node).run(nodes.edges_of(node)[side])
    }
}

/// A mask of one run as a mask of another one on the same line.
fn shifted(mask: Mask, from: EdgeRun, to: EdgeRun) -> Mask {
    let start = |run: EdgeRun| if run.along_x { run.first.column } else { run.first.row };
    match start(from) as i32 - start(to) as i32 {
        right @ 0.. => mask.unbounded_shl(right as u32),
        left => mask.unbounded_shr(left.unsigned_abs()),
    }
}

/// Adds samples of a run to those that are kept, until none is farther than a limit from the straight pieces between.
fn straightened(heightmap: &Heightmap, run: EdgeRun, mut kept: Mask, limit_m: f64) -> Mask {
    let mut from = 0;
    while from < run.length {
        // The mask has no bit for the run's end.
        let to = from + 1 + kept.unbounded_shr(from + 1).trailing_zeros().min(run.length - from - 1);
        match farthest_from_chord(heightmap, run, from, to) {
            Some((worst, deviation_m)) if deviation_m > limit_m => kept |= 1 << worst,
            _ => from = to,
        }
    }
    kept
}
