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
//! of two sizes know nothing of each other, nor does a set at the levels of blocks hold all that a map has at one level.
//! A sample that only one of them needs can move the straight pieces away from other samples of the side: those are
//! added, until no sample of the side is farther away than the tolerance of the finer level beside it.

use terrain_core::Heightmap;

use crate::ladder::{Level, tolerance_m};
use crate::levels::{BLOCK, NodeLevels};
use crate::node_maps::NodeMaps;
use crate::nodes::{NodeId, Owners};
use crate::patches::EdgeRun;
use crate::select::{Mask, inner_bits};
use crate::threshold_map::{deviations_m, farthest};

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
    pub levels: &'a [NodeLevels],
}

/// A side of a node.
#[derive(Clone, Copy)]
struct Side {
    /// Nodes of one layer have one map.
    layer: usize,
    run: EdgeRun,
    /// Of its runs of 8 samples.
    levels: [Level; 8],
}

impl Side {
    fn is_uniform(&self) -> bool {
        let runs = self.run.length.div_ceil(BLOCK) as usize;
        self.levels[1..runs].iter().all(|level| *level == self.levels[0])
    }

    /// The level of a sample of a piece of the side.
    fn level(&self, piece: EdgeRun, i: u32) -> Level {
        self.levels[((i as i32 + offset(piece, self.run)) as u32 / BLOCK) as usize]
    }
}

impl Cut<'_> {
    /// The levels of a node.
    pub(crate) fn levels(&self, node: NodeId) -> &NodeLevels {
        &self.levels[node as usize]
    }

    /// The inner samples of a side (0 to 3: north, south, west, east) that the node needs, and those that are kept.
    pub(crate) fn needed_and_kept(&self, node: NodeId, side: usize) -> (Mask, Mask) {
        let (here, needed) = (self.side(node, side), self.needed(node, side));
        let (mut kept, mut last) = (needed, None);
        for patch in self.maps.nodes().patches_beyond(node, side) {
            let beyond = self.owners.of(patch);
            if last.replace(beyond) != Some(beyond) {
                kept |= self.kept_between(&here, needed, beyond, side ^ 1);
            }
        }
        if last.is_none() && !here.is_uniform() {
            let limit_m = |i| tolerance_m(here.level(here.run, i));
            kept = straightened(self.heightmap, here.run, kept, limit_m);
        }
        (needed, kept)
    }

    /// What is kept where a side meets a side of the node beyond, with the ends of the shared piece.
    fn kept_between(&self, here: &Side, needed: Mask, beyond: NodeId, side_beyond: usize) -> Mask {
        let there = self.side(beyond, side_beyond);
        if here.layer == there.layer && here.is_uniform() && there.is_uniform() {
            let is_coarser = there.levels[0] >= here.levels[0];
            return if is_coarser { needed } else { self.needed(beyond, side_beyond) };
        }
        let shared = if there.run.length < here.run.length { there.run } else { here.run };
        let needed_beyond = shifted(self.needed(beyond, side_beyond), there.run, shared);
        let union = (shifted(needed, here.run, shared) | needed_beyond) & inner_bits(shared.length);
        let limit_m = |i| tolerance_m(here.level(shared, i).min(there.level(shared, i)));
        let kept = straightened(self.heightmap, shared, union, limit_m);
        shifted(kept | 1 | 1u64.unbounded_shl(shared.length), shared, here.run) & inner_bits(here.run.length)
    }

    fn needed(&self, node: NodeId, side: usize) -> Mask {
        self.maps.side(node, side, self.levels(node))
    }

    fn side(&self, node: NodeId, side: usize) -> Side {
        let nodes = self.maps.nodes();
        let run = nodes.grid_of(node).run(nodes.edges_of(node)[side]);
        Side { layer: nodes.place(node).0, run, levels: self.levels(node).side(nodes.area(node), side) }
    }
}

/// From the start of one run to the start of another one on the same line.
fn offset(run: EdgeRun, of: EdgeRun) -> i32 {
    let start = |run: EdgeRun| if run.along_x { run.first.column } else { run.first.row };
    start(run) as i32 - start(of) as i32
}

/// A mask of one run as a mask of another one on the same line.
fn shifted(mask: Mask, from: EdgeRun, to: EdgeRun) -> Mask {
    match offset(from, to) {
        right @ 0.. => mask.unbounded_shl(right as u32),
        left => mask.unbounded_shr(left.unsigned_abs()),
    }
}

/// Adds samples of a run to those that are kept, until none is farther than its limit from the straight pieces between.
fn straightened(heightmap: &Heightmap, run: EdgeRun, mut kept: Mask, limit_m: impl Fn(u32) -> f64) -> Mask {
    let mut from = 0;
    while from < run.length {
        // The mask has no bit for the run's end.
        let to = from + 1 + kept.unbounded_shr(from + 1).trailing_zeros().min(run.length - from - 1);
        let beyond = deviations_m(heightmap, run, from, to).filter(|(i, deviation_m)| *deviation_m > limit_m(*i));
        match farthest(beyond) {
            Some((worst, _)) => kept |= 1 << worst,
            None => from = to,
        }
    }
    kept
}
