//! The mesh of bounded selections: the levels of nodes, a cut through them, and one update of both.
//!
//! A node has the level of its distance. A root in view is updated as a whole: of each group and its members that which
//! costs less is in the cut, so the cut is a function of the view that the root was last updated for. Where a node
//! changes, those around it are selected anew in the same update. A root out of view keeps what it had: that can make a
//! border finer than it need be, never coarser than the node in view allows.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use terrain_core::{Heightmap, View, WorkReport};

use crate::border::Cut;
use crate::bounded::BoundedMesher;
use crate::ladder::COARSEST;
use crate::levels::{Boxes, NodeLevels};
use crate::mesh::{SelectedFor, Triangulated, Update};
use crate::node_maps::NodeMaps;
use crate::nodes::{NodeId, Nodes, Owners};
use crate::options::Options;
use crate::selection::Selection;
use crate::vertices::VertexPlace;

/// Nodes as of their last updates.
pub(crate) struct BoundedMesh {
    maps: Arc<NodeMaps>,
    place: VertexPlace,
    boxes: Arc<Boxes>,
    /// Of all nodes, those that are not in the cut too.
    levels: Vec<NodeLevels>,
    owners: Owners,
    /// What the triangles of each node in the cut are made of; nothing before the first.
    selections: Vec<Option<Selection>>,
}

/// What an update changes in the cut.
#[derive(Default)]
struct Change {
    /// Nodes that are new in the cut, or have other levels.
    made: Vec<NodeId>,
    /// Nodes that are no longer in it.
    retired: Vec<NodeId>,
}

/// What became of one node.
struct Made {
    selection: Selection,
    indices: Option<Vec<u32>>,
    select: Duration,
    triangulate: Duration,
}

impl BoundedMesh {
    /// All nodes at the coarsest level, the roots in the cut.
    pub fn coarsest(
        heightmap: &Heightmap,
        options: &Options,
        maps: Arc<NodeMaps>,
        boxes: Arc<Boxes>,
    ) -> (Self, Update) {
        let nodes = maps.nodes();
        let mut mesh = Self {
            place: options.vertex_strips(heightmap).place(),
            boxes,
            levels: vec![NodeLevels::Uniform(COARSEST); nodes.len()],
            owners: Owners::roots(nodes),
            selections: vec![None; nodes.len()],
            maps,
        };
        let roots = mesh.nodes().roots().collect();
        let update = mesh.remake(heightmap, roots, Vec::new(), Instant::now());
        (mesh, update)
    }

    fn nodes(&self) -> &Nodes {
        self.maps.nodes()
    }

    pub fn boxes(&self) -> &Boxes {
        &self.boxes
    }

    /// The roots of the patches in view that an update for this view would change.
    pub fn outdated(&self, options: &Options, view: &View, visible: &[u32]) -> Vec<NodeId> {
        let mut roots: Vec<NodeId> = visible.iter().map(|patch| self.nodes().root_of(*patch)).collect();
        roots.sort_unstable();
        roots.dedup();
        let levels = |node| self.boxes.levels(node, view, options.tolerance_px);
        roots.retain(|root| self.nodes().tree(*root).any(|node| self.levels[node as usize] != levels(node)));
        roots
    }

    /// Gives these roots the levels and the cuts of a view, and makes what changes and the nodes around it anew.
    pub fn update(&mut self, heightmap: &Heightmap, options: &Options, view: &View, roots: &[NodeId]) -> Update {
        let (start, mut change) = (Instant::now(), Change::default());
        for root in roots {
            self.cut_anew(*root, options, view, &mut change);
        }
        let Change { made: mut batch, retired } = change;
        for node in &batch {
            self.owners.give(self.maps.nodes(), *node);
        }
        let nodes = self.maps.nodes();
        let beyond = |node: NodeId| (0..4).flat_map(move |side| nodes.patches_beyond(node, side));
        let around: Vec<NodeId> = batch.iter().copied().flat_map(beyond).map(|patch| self.owners.of(patch)).collect();
        batch.extend(around);
        batch.sort_unstable();
        batch.dedup();
        self.remake(heightmap, batch, retired, start)
    }

    /// Gives a root the levels of a view, and adds what that changes in its cut.
    fn cut_anew(&mut self, root: NodeId, options: &Options, view: &View, change: &mut Change) {
        let (mut before, mut after) = (Vec::new(), Vec::new());
        self.owners.of_all(self.nodes().patches_of(root), &mut before);
        let before: Vec<_> = before.into_iter().map(|node| (node, self.levels[node as usize])).collect();
        let nodes = self.maps.nodes();
        for node in nodes.tree(root) {
            self.levels[node as usize] = self.boxes.levels(node, view, options.tolerance_px);
        }
        self.maps.cut(root, &self.levels, &mut after);
        change.made.extend(after.iter().filter(|node| !before.contains(&(**node, self.levels[**node as usize]))));
        change.retired.extend(before.into_iter().map(|(node, _)| node).filter(|node| !after.contains(node)));
    }

    /// Selects and triangulates these nodes as the cut and the levels are now.
    fn remake(&mut self, heightmap: &Heightmap, batch: Vec<NodeId>, retired: Vec<NodeId>, start: Instant) -> Update {
        let made: Vec<Made> = batch.par_iter().map(|node| self.make(heightmap, *node)).collect();
        let mut report = WorkReport::default();
        let mut triangulated = Vec::with_capacity(batch.len());
        for node in &retired {
            self.selections[*node as usize] = None;
        }
        for (node, made) in batch.into_iter().zip(made) {
            report.select += made.select;
            report.triangulate += made.triangulate;
            self.selections[node as usize] = Some(made.selection);
            let selected_for = SelectedFor::Levels(self.levels[node as usize]);
            triangulated.push(Triangulated { node, selected_for, indices: made.indices });
        }
        report.patches = triangulated.iter().filter(|t| t.indices.is_some()).count() as u32;
        report.triangles = triangulated.iter().map(Triangulated::triangles).sum();
        report.update = start.elapsed();
        Update { triangulated, retired, vertices: Vec::new(), report }
    }

    fn make(&self, heightmap: &Heightmap, node: NodeId) -> Made {
        thread_local!(static MESHER: RefCell<BoundedMesher> = RefCell::default());
        let start = Instant::now();
        let cut = Cut { heightmap, maps: &self.maps, owners: &self.owners, levels: &self.levels };
        let mut selection = Selection::default();
        selection.select(&cut, node);
        let (select, start) = (start.elapsed(), Instant::now());
        let last = self.selections[node as usize].as_ref();
        let stays = last.is_some_and(|last| selection.gives_the_mesh_of(last));
        let indices = (!stays).then(|| {
            let mut indices = Vec::new();
            let area = self.nodes().area(node);
            let at = self.place;
            MESHER.with_borrow_mut(|mesher| mesher.triangulate_at(heightmap, area, &selection, at, &mut indices));
            indices
        });
        Made { selection, indices, select, triangulate: start.elapsed() }
    }
}
