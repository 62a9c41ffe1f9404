//! What nodes of all sizes need, each size by a threshold map of its own, and the cut through them that costs least.

use terrain_core::Heightmap;

use crate::levels::NodeLevels;
use crate::nodes::{NodeId, Nodes};
use crate::patches::PatchGrid;
use crate::select::Mask;
use crate::threshold_map::ThresholdMap;

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

    /// The inner samples of a side (0 to 3: north, south, west, east) that a node needs at its levels.
    pub(crate) fn side(&self, node: NodeId, side: usize, levels: &NodeLevels) -> Mask {
        let ((layer, _), edges) = (self.nodes.place(node), self.nodes.edges_of(node));
        self.maps[layer].edge_mask(edges[side], &levels.side(self.nodes.area(node), side))
    }

    /// The samples inside a node that it needs at its levels, a mask for each inner row.
    pub(crate) fn interior(&self, node: NodeId, levels: &NodeLevels) -> impl Iterator<Item = Mask> {
        let (layer, number) = self.nodes.place(node);
        self.maps[layer].interior_masks(number, self.nodes.area(node).depth - 1, levels)
    }

    /// Appends the nodes of the best cut through a node at these levels (of all nodes): itself if that costs no more
    /// than its members do. Returns the cost in triangles, without those that nodes around it cause.
    pub fn cut(&self, node: NodeId, levels: &[NodeLevels], chosen: &mut Vec<NodeId>) -> u32 {
        let (own, before) = (self.triangles(node, &levels[node as usize]) + DRAW_TRIANGLES, chosen.len());
        let of_members = self.nodes.members(node).map(|member| self.cut(member, levels, chosen)).sum();
        if chosen.len() > before && of_members < own {
            return of_members;
        }
        chosen.truncate(before);
        chosen.push(node);
        own
    }

    /// Triangles of a node at its levels, if all nodes around it need no more than it does.
    fn triangles(&self, node: NodeId, levels: &NodeLevels) -> u32 {
        let count = |mask: Mask| mask.count_ones();
        let border: u32 = (0..4).map(|side| count(self.side(node, side, levels))).sum();
        let interior: u32 = self.interior(node, levels).map(count).sum();
        // Of n points, h of them on the outline: 2 n - 2 - h triangles.
        2 * interior + border + 2
    }
}
