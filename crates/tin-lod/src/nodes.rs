//! What is triangulated as a unit: patches, and groups of 2 x 2 and 4 x 4 patches. Integers only.
//!
//! ```text
//!   layer 0: patches       layer 1: 2 x 2        layer 2: 4 x 4, the roots
//!   +--+--+--+--+--+       +-----+-----+--+      +-----------+--+      A root is a tree of nodes. The mesh is a cut
//!   |  |  |  |  |  |       |     |     |  |      |           |  |      through each: every patch lies in one node of
//!   +--+--+--+--+--+       |     |     |  |      |           |  |      it. A node at the rim may hold fewer patches,
//!   |  |  |  |  |  |       +-----+-----+--+      |           |  |      down to one.
//!   +--+--+--+--+--+       |     |     |  |      |           |  |
//! ```
//!
//! Each layer is a grid of patches of its own, of twice the side of the layer before. Nodes are numbered through: the
//! patches first, by their own numbers, then the groups of 2 x 2, then those of 4 x 4.

use std::ops::Range;

use terrain_core::Heightmap;

use crate::patches::{EdgeId, PatchArea, PatchGrid, PatchId};

/// Number of a node: that of a patch, or a larger one for a group.
pub type NodeId = u32;

/// The nodes over a DEM.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Nodes {
    /// Patches first, roots last.
    layers: Vec<Layer>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layer {
    grid: PatchGrid,
    /// Number of its first node.
    first: NodeId,
}

impl Nodes {
    /// Patches of `patch` grid intervals, and groups of up to `group` x `group` of them: 1 (none), 2 or 4.
    ///
    /// # Panics
    ///
    /// If the side of the largest group is above 64 intervals.
    pub fn new(heightmap: &Heightmap, patch: u32, group: u32) -> Self {
        assert!(patch * group <= 64, "{group} x {group} patches of {patch} intervals: expected at most 64");
        let mut layers = vec![Layer { grid: PatchGrid::new(heightmap, patch), first: 0 }];
        // A group that holds one node alone is the same as that node.
        while let Some(below) = layers.last()
            && layers.len() <= group.ilog2() as usize
            && below.grid.patches() > 1
        {
            let grid = PatchGrid::new(heightmap, patch << layers.len());
            layers.push(Layer { grid, first: below.first + below.grid.patches() });
        }
        Self { layers }
    }

    /// The grids of the layers, patches first.
    pub fn grids(&self) -> impl Iterator<Item = &PatchGrid> {
        self.layers.iter().map(|layer| &layer.grid)
    }

    /// The grid of the patches.
    pub fn patches(&self) -> &PatchGrid {
        &self.layers[0].grid
    }

    /// Side of the largest group in patches: 1, 2 or 4. A small DEM has none that is larger than itself.
    pub fn group(&self) -> u32 {
        1 << self.top()
    }

    /// Number of all nodes.
    pub fn len(&self) -> usize {
        self.roots().end as usize
    }

    /// Never: a DEM has a patch.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The nodes that lie in no other.
    pub fn roots(&self) -> Range<NodeId> {
        let top = self.layers[self.top()];
        top.first..top.first + top.grid.patches()
    }

    fn top(&self) -> usize {
        self.layers.len() - 1
    }

    /// The layer of a node, and its number in the layer's grid.
    pub fn place(&self, node: NodeId) -> (usize, PatchId) {
        let layer = self.layers.iter().rposition(|layer| layer.first <= node).expect("the first layer starts at 0");
        (layer, node - self.layers[layer].first)
    }

    /// The samples of a node.
    pub fn area(&self, node: NodeId) -> PatchArea {
        let (layer, number) = self.place(node);
        self.layers[layer].grid.area(number)
    }

    /// The four sides of a node as edges of its layer's grid: north, south, west, east.
    pub fn edges_of(&self, node: NodeId) -> [EdgeId; 4] {
        let (layer, number) = self.place(node);
        self.layers[layer].grid.edges_of(number).all()
    }

    /// The grid of a node's layer.
    pub fn grid_of(&self, node: NodeId) -> &PatchGrid {
        &self.layers[self.place(node).0].grid
    }

    /// The root that a patch lies in.
    pub fn root_of(&self, patch: PatchId) -> NodeId {
        let (top, across) = (self.top(), self.across(0));
        let (column, row) = (patch % across, patch / across);
        self.layers[top].first + (row >> top) * self.across(top) + (column >> top)
    }

    /// The nodes of the layer below that a node consists of; none of a patch.
    pub fn members(&self, node: NodeId) -> impl Iterator<Item = NodeId> {
        let (layer, number) = self.place(node);
        self.block(layer, number, layer.saturating_sub(1)).filter(move |member| *member != node)
    }

    /// The patches that a node consists of, row by row.
    pub fn patches_of(&self, node: NodeId) -> impl Iterator<Item = PatchId> {
        let (layer, number) = self.place(node);
        self.block(layer, number, 0)
    }

    /// A node and all nodes in it.
    pub fn tree(&self, node: NodeId) -> impl Iterator<Item = NodeId> {
        let (layer, number) = self.place(node);
        (0..=layer).rev().flat_map(move |below| self.block(layer, number, below))
    }

    /// The patches beyond a side of a node (0 to 3: north, south, west, east), from west to east or north to south;
    /// none at the rim.
    pub fn patches_beyond(&self, node: NodeId, side: usize) -> impl Iterator<Item = PatchId> {
        let (layer, number) = self.place(node);
        let [columns, rows] = self.span(layer, number, 0);
        let [across, down] = self.layers[0].grid.size();
        let (columns, rows) = match side {
            0 => (columns, rows.start.wrapping_sub(1)..rows.start),
            1 => (columns, rows.end..rows.end + 1),
            2 => (columns.start.wrapping_sub(1)..columns.start, rows),
            _ => (columns.end..columns.end + 1, rows),
        };
        let is_inside = columns.start < across && rows.start < down;
        let rows = if is_inside { rows } else { 0..0 };
        rows.flat_map(move |row| columns.clone().map(move |column| row * across + column))
    }

    fn across(&self, layer: usize) -> u32 {
        self.layers[layer].grid.size()[0]
    }

    /// Columns and rows of the nodes of a layer that a node of the same or a higher layer consists of.
    fn span(&self, layer: usize, number: PatchId, below: usize) -> [Range<u32>; 2] {
        let (column, row, steps) = (number % self.across(layer), number / self.across(layer), layer - below);
        let [across, down] = self.layers[below].grid.size();
        let span = |at: u32, size: u32| (at << steps)..((at + 1) << steps).min(size);
        [span(column, across), span(row, down)]
    }

    fn block(&self, layer: usize, number: PatchId, below: usize) -> impl Iterator<Item = NodeId> + use<> {
        let ([columns, rows], Layer { grid, first }) = (self.span(layer, number, below), self.layers[below]);
        let across = grid.size()[0];
        rows.flat_map(move |row| columns.clone().map(move |column| first + row * across + column))
    }

    /// A node's places among those of all patches. Those of a root's patches lie side by side in the order of a Z curve,
    /// so that a group has those of its members for its own.
    pub(crate) fn places(&self, node: NodeId) -> Range<u32> {
        let ((layer, number), top) = (self.place(node), self.top());
        let [columns, rows] = self.span(layer, number, 0);
        let (column, row) = (columns.start, rows.start);
        let root = (row >> top) * self.across(top) + (column >> top);
        let bits = |i: usize| (column >> i & 1 | (row >> i & 1) << 1) << (2 * i);
        let first = (0..top).fold(root << (2 * top), |place, i| place | bits(i));
        first..first + (1 << (2 * layer))
    }
}

/// A cut: the node that each patch lies in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Owners {
    nodes: Vec<NodeId>,
}

impl Owners {
    /// The coarsest cut: every patch lies in its root.
    pub fn roots(nodes: &Nodes) -> Self {
        Self { nodes: (0..nodes.patches().patches()).map(|patch| nodes.root_of(patch)).collect() }
    }

    /// The node that a patch lies in.
    pub fn of(&self, patch: PatchId) -> NodeId {
        self.nodes[patch as usize]
    }

    /// Gives a node all of its patches. Until the other patches of the nodes that had them are given away too, this is
    /// no cut.
    pub fn give(&mut self, nodes: &Nodes, node: NodeId) {
        for patch in nodes.patches_of(node) {
            self.nodes[patch as usize] = node;
        }
    }

    /// Fills `all` with the nodes of some patches, each once, in ascending order.
    pub fn of_all(&self, patches: impl Iterator<Item = PatchId>, all: &mut Vec<NodeId>) {
        all.clear();
        all.extend(patches.map(|patch| self.of(patch)));
        all.sort_unstable();
        all.dedup();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn each(mut check: impl FnMut(&Nodes)) {
        for (columns, rows) in [(2, 2), (9, 9), (10, 30), (97, 2), (50, 41), (65, 130)] {
            let dem = Heightmap::new(columns, rows, [1.0; 2], vec![0.0; (columns * rows) as usize]).unwrap();
            for (patch, group) in [(8, 1), (8, 2), (8, 4), (16, 4), (32, 2), (64, 1)] {
                check(&Nodes::new(&dem, patch, group));
            }
        }
    }

    #[test]
    fn members_and_patches_tile_their_node() {
        each(|nodes| {
            for node in 0..nodes.len() as NodeId {
                let size = |node| nodes.area(node).width * nodes.area(node).depth;
                assert_eq!(nodes.patches_of(node).map(size).sum::<u32>(), size(node));
                let members: Vec<NodeId> = nodes.members(node).collect();
                assert_eq!(members.is_empty(), nodes.place(node).0 == 0);
                assert!(members.is_empty() || members.iter().map(|m| size(*m)).sum::<u32>() == size(node));
                let patches: BTreeSet<_> = members.iter().flat_map(|m| nodes.patches_of(*m)).collect();
                assert!(members.is_empty() || patches == nodes.patches_of(node).collect());
                let tree: BTreeSet<_> = nodes.tree(node).collect();
                let below: BTreeSet<_> = members.iter().flat_map(|m| nodes.tree(*m)).chain([node]).collect();
                assert_eq!(tree, below);
            }
            let roots: Vec<_> = nodes.roots().flat_map(|root| nodes.patches_of(root).map(move |p| (p, root))).collect();
            assert_eq!(roots.len() as u32, nodes.patches().patches());
            assert!(roots.into_iter().all(|(patch, root)| nodes.root_of(patch) == root));
        });
    }

    /// The ends of a side: on which line, and from where to where.
    fn side_of(area: PatchArea, side: usize) -> (u32, Range<u32>) {
        let (first, last) = (area.first, area.last());
        let (along_x, along_z) = (first.column..last.column, first.row..last.row);
        [(first.row, along_x.clone()), (last.row, along_x), (first.column, along_z.clone()), (last.column, along_z)]
            [side]
            .clone()
    }

    #[test]
    fn patches_beyond_a_side_touch_all_of_it() {
        each(|nodes| {
            let whole = (nodes.area(0), nodes.area(nodes.patches().patches() - 1));
            for (node, side) in (0..nodes.len() as NodeId).flat_map(|node| [0, 1, 2, 3].map(|side| (node, side))) {
                let (line, run) = side_of(nodes.area(node), side);
                let rim = side_of(if side % 2 == 0 { whole.0 } else { whole.1 }, side).0;
                let mut at = run.start;
                for patch in nodes.patches_beyond(node, side) {
                    let (their_line, theirs) = side_of(nodes.area(patch), side ^ 1);
                    assert_eq!((their_line, theirs.start), (line, at), "node {node}, side {side}");
                    at = theirs.end;
                }
                assert_eq!(at, if line == rim { run.start } else { run.end }, "node {node}, side {side}");
            }
        });
    }

    #[test]
    fn the_places_of_a_group_are_those_of_its_members() {
        each(|nodes| {
            let patches: BTreeSet<u32> = (0..nodes.patches().patches()).map(|p| nodes.places(p).start).collect();
            assert_eq!(patches.len() as u32, nodes.patches().patches(), "two patches in one place");
            assert!(nodes.roots().map(|root| nodes.places(root).end).max() > patches.last().copied());
            for node in 0..nodes.len() as NodeId {
                assert!(nodes.patches_of(node).all(|patch| nodes.places(node).contains(&nodes.places(patch).start)));
            }
        });
    }
}
