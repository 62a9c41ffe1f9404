//! What is the same for both selectors: patches that go out of date, and updates that are drawn as a whole.
//!
//! Algorithm 2 of the paper without its thread. The triangulations that one update returns fit each other and all that
//! came before: what is drawn is watertight after every update.

use std::sync::Arc;

use terrain_core::{Aabb, Heightmap, View, WorkReport};

use crate::algorithm1_mesh::Algorithm1Mesh;
use crate::border::NodeMaps;
use crate::bounded_mesh::BoundedMesh;
use crate::ladder::level_of;
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
    /// The tolerance in metres that it is selected for.
    pub tolerance_m: f64,
    /// Its new triangles, as indices from the node's first vertex on; none where those that it has stay right.
    pub indices: Option<Vec<u32>>,
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
        maps: Option<Arc<NodeMaps>>,
    ) -> (Self, Update) {
        match options.selector {
            Selector::Algorithm1 => {
                let (mesh, update) = Algorithm1Mesh::coarsest(heightmap, options, *nodes.patches());
                (Self::Algorithm1(mesh), update)
            }
            Selector::Bounded => {
                let maps = maps.unwrap_or_else(|| Arc::new(NodeMaps::build(heightmap, nodes.clone())));
                let (mesh, update) = BoundedMesh::coarsest(heightmap, options, maps);
                (Self::Bounded(mesh), update)
            }
        }
    }

    pub fn bounds_world(&self, node: NodeId) -> &Aabb {
        match self {
            Self::Algorithm1(mesh) => mesh.bounds_world(node),
            Self::Bounded(mesh) => mesh.bounds_world(node),
        }
    }

    /// What an update for this view would select anew for the patches in view, nearest first: patches (Algorithm 1) or
    /// roots (bounded).
    pub fn outdated(&self, options: &Options, view: &View, visible: &[PatchId]) -> Vec<NodeId> {
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

/// Whether a patch that was selected for `then_m` needs another selection.
///
/// Algorithm 1: where the largest height difference in the box, projected, has changed by more than the tolerance
/// (section 4). In units of the tolerance, a difference `d` is `d / tolerance_m`. Bounded: where the level has changed.
pub(crate) fn is_outdated(bounds_world: &Aabb, then_m: f64, options: &Options, view: &View) -> bool {
    let now_m = tolerance_m_at(bounds_world, options, view);
    let difference_m = bounds_world.max[1] - bounds_world.min[1];
    match options.selector {
        // Both infinite where the eye was and is in the box: not a number, so not more.
        Selector::Algorithm1 => (difference_m / now_m - difference_m / then_m).abs() > 1.0,
        Selector::Bounded => level_of(now_m) != level_of(then_m),
    }
}

/// The allowed error in pixels as metres at the point of the box that is nearest to the eye.
pub(crate) fn tolerance_m_at(bounds_world: &Aabb, options: &Options, view: &View) -> f64 {
    view.metres(options.tolerance_px, view.distance_m(bounds_world))
}
