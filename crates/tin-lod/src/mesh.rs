//! What is the same for both selectors: patches that go out of date, and updates that are drawn as a whole.
//!
//! Algorithm 2 of the paper without its thread. The triangulations that one update returns fit each other and all that
//! came before: what is drawn is watertight after every update.

use std::sync::Arc;

use terrain_core::{Aabb, Heightmap, View, WorkReport};

use crate::algorithm1_mesh::{self, Algorithm1Mesh};
use crate::bounded_mesh::BoundedMesh;
use crate::levels::{Boxes, NodeLevels};
use crate::node_maps::NodeMaps;
use crate::nodes::{NodeId, Nodes};
use crate::options::{Options, Selector};
use crate::patches::PatchId;
use crate::smoothing::VertexRun;

/// Patches, groups and edges as of their last updates. Algorithm 1 has no groups.
pub(crate) enum Mesh {
    Algorithm1(Algorithm1Mesh),
    Bounded(BoundedMesh),
}

/// One patch or group of an update.
pub(crate) struct Triangulated {
    pub node: NodeId,
    pub selected_for: SelectedFor,
    /// Its new triangles, as indices from the node's first vertex on; none where those that it has stay right.
    pub indices: Option<Vec<u32>>,
}

/// All that must be known of the view that a patch or group was selected for, to see whether it is outdated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SelectedFor {
    /// Algorithm 1: the tolerance in metres; infinite before the first selection.
    ToleranceM(f64),
    /// Bounded.
    Levels(NodeLevels),
}

impl SelectedFor {
    /// Whether another selection is needed for this view.
    pub fn is_outdated(&self, boxes: &Boxes, node: NodeId, options: &Options, view: &View) -> bool {
        match self {
            Self::ToleranceM(then_m) => algorithm1_mesh::is_outdated(boxes.of(node), *then_m, options, view),
            Self::Levels(levels) => boxes.levels(node, view, options.tolerance_px) != *levels,
        }
    }
}

impl Triangulated {
    pub fn triangles(&self) -> u64 {
        self.indices.as_ref().map_or(0, |indices| indices.len() as u64 / 3)
    }
}

/// The result of one update: it is drawn as a whole or not at all.
#[derive(Default)]
pub(crate) struct Update {
    /// In ascending order. A node that was not in the mesh takes the place of all nodes that had its patches.
    pub triangulated: Vec<Triangulated>,
    /// Nodes that are no longer in the mesh.
    pub retired: Vec<NodeId>,
    /// Vertices that change; with smoothing alone.
    pub vertices: Vec<VertexRun>,
    pub report: WorkReport,
}

impl Mesh {
    /// The coarsest mesh. Every update starts from a whole, watertight DEM. Without maps the bounded selector builds them.
    pub fn coarsest(
        heightmap: &Heightmap,
        options: &Options,
        nodes: &Nodes,
        boxes: Arc<Boxes>,
        maps: Option<Arc<NodeMaps>>,
    ) -> (Self, Update) {
        match options.selector {
            Selector::Algorithm1 => {
                let (mesh, update) = Algorithm1Mesh::coarsest(heightmap, options, *nodes.patches(), boxes);
                (Self::Algorithm1(mesh), update)
            }
            Selector::Bounded => {
                let maps = maps.unwrap_or_else(|| Arc::new(NodeMaps::build(heightmap, nodes.clone())));
                let (mesh, update) = BoundedMesh::coarsest(heightmap, options, maps, boxes);
                (Self::Bounded(mesh), update)
            }
        }
    }

    fn bounds_world(&self, node: NodeId) -> &Aabb {
        match self {
            Self::Algorithm1(mesh) => mesh.boxes().of(node),
            Self::Bounded(mesh) => mesh.boxes().of(node),
        }
    }

    /// What an update for this view would select anew for the patches in view, nearest first: patches (Algorithm 1) or
    /// roots (bounded).
    pub fn outdated(&mut self, options: &Options, view: &View, visible: &[PatchId]) -> Vec<NodeId> {
        let mut outdated = match self {
            Self::Algorithm1(mesh) => mesh.outdated(options, view, visible),
            Self::Bounded(mesh) => mesh.outdated(options, view, visible),
        };
        let distance_m = |node: &NodeId| view.distance_m(self.bounds_world(*node));
        outdated.sort_by(|a, b| distance_m(a).total_cmp(&distance_m(b)));
        outdated
    }

    /// Selects what is outdated for a view, and triangulates that and what borders on changes. It need not be all that
    /// is outdated.
    pub fn update(&mut self, heightmap: &Heightmap, options: &Options, view: &View, outdated: &[NodeId]) -> Update {
        match self {
            Self::Algorithm1(mesh) => mesh.update(heightmap, options, view, outdated),
            Self::Bounded(mesh) => mesh.update(heightmap, options, view, outdated),
        }
    }
}

/// The allowed error in pixels as metres at the point of the box that is nearest to the eye.
pub(crate) fn tolerance_m_at(bounds_world: &Aabb, options: &Options, view: &View) -> f64 {
    view.metres(options.tolerance_px, view.distance_m(bounds_world))
}
