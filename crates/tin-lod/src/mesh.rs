//! What is the same for both selectors: patches that go out of date, and updates that are drawn as a whole.
//!
//! Algorithm 2 of the paper without its thread. The triangulations that one update returns fit each other and all that
//! came before: what is drawn is watertight after every update.

use terrain_core::{Aabb, Heightmap, View, WorkReport};

use crate::algorithm1_mesh::Algorithm1Mesh;
use crate::bounded_mesh::BoundedMesh;
use crate::ladder::level_of;
use crate::options::{Options, Selector};
use crate::patches::{PatchGrid, PatchId};

/// Patches and edges as of their last updates.
pub(crate) enum Mesh {
    Algorithm1(Algorithm1Mesh),
    Bounded(BoundedMesh),
}

/// One patch of an update.
pub(crate) struct Triangulated {
    pub patch: PatchId,
    /// The tolerance in metres that it is selected for.
    pub tolerance_m: f64,
    /// Its new triangles, as indices from the patch's first vertex on; none where those that it has stay right.
    pub indices: Option<Vec<u32>>,
}

impl Triangulated {
    pub fn triangles(&self) -> u64 {
        self.indices.as_ref().map_or(0, |indices| indices.len() as u64 / 3)
    }
}

/// The result of one update: it is drawn as a whole or not at all.
pub(crate) struct Update {
    pub triangulated: Vec<Triangulated>,
    pub report: WorkReport,
}

impl Mesh {
    /// The coarsest mesh. Every update starts from a whole, watertight DEM.
    pub fn coarsest(heightmap: &Heightmap, options: &Options, grid: PatchGrid) -> (Self, Update) {
        match options.selector {
            Selector::Algorithm1 => {
                let (mesh, update) = Algorithm1Mesh::coarsest(heightmap, options, grid);
                (Self::Algorithm1(mesh), update)
            }
            Selector::Bounded => {
                let (mesh, update) = BoundedMesh::coarsest(heightmap, options, grid);
                (Self::Bounded(mesh), update)
            }
        }
    }

    pub fn bounds_world(&self, patch: PatchId) -> &Aabb {
        match self {
            Self::Algorithm1(mesh) => mesh.bounds_world(patch),
            Self::Bounded(mesh) => mesh.bounds_world(patch),
        }
    }

    fn tolerance_m(&self, patch: PatchId) -> f64 {
        match self {
            Self::Algorithm1(mesh) => mesh.tolerance_m(patch),
            Self::Bounded(mesh) => mesh.tolerance_m(patch),
        }
    }

    /// The patches among `visible` that an update for this view would select anew, nearest first.
    pub fn outdated(&self, options: &Options, view: &View, visible: &[PatchId]) -> Vec<PatchId> {
        let is_outdated = |p: &PatchId| is_outdated(self.bounds_world(*p), self.tolerance_m(*p), options, view);
        let mut outdated: Vec<PatchId> = visible.iter().copied().filter(is_outdated).collect();
        let distance_m = |patch: &PatchId| view.distance_m(self.bounds_world(*patch));
        outdated.sort_by(|a, b| distance_m(a).total_cmp(&distance_m(b)));
        outdated
    }

    /// Selects these patches for a view, and triangulates them and the neighbours of edges that changed.
    pub fn update(&mut self, heightmap: &Heightmap, options: &Options, view: &View, patches: &[PatchId]) -> Update {
        match self {
            Self::Algorithm1(mesh) => mesh.update(heightmap, options, view, patches),
            Self::Bounded(mesh) => mesh.update(heightmap, options, view, patches),
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
