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
use terrain_core::odometer::{Odometer, PASSED};
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
    odometer: Odometer,
    /// Of each root when it is to be looked at again.
    deadlines_m: Vec<f64>,
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
            odometer: Odometer::default(),
            deadlines_m: vec![PASSED; nodes.roots().len()],
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
    pub fn outdated(&mut self, options: &Options, view: &View, visible: &[u32]) -> Vec<NodeId> {
        if !self.odometer.advance(view) {
            self.deadlines_m.fill(PASSED);
        }
        let mut roots: Vec<NodeId> = visible.iter().map(|patch| self.nodes().root_of(*patch)).collect();
        roots.sort_unstable();
        roots.dedup();
        roots.retain(|root| self.is_outdated(*root, options, view));
        roots
    }

    /// Looks at a root unless the eye has not moved far enough since the last time.
    fn is_outdated(&mut self, root: NodeId, options: &Options, view: &View) -> bool {
        let place = (root - self.nodes().roots().start) as usize;
        if !self.odometer.has_passed(self.deadlines_m[place]) {
            return false;
        }
        let mut least_slack_m = f64::INFINITY;
        for node in self.maps.nodes().tree(root) {
            let (levels, slack_m) = self.boxes.levels_and_slack_m(node, view, options.tolerance_px);
            if self.levels[node as usize] != levels {
                return true;
            }
            least_slack_m = least_slack_m.min(slack_m);
        }
        self.deadlines_m[place] = self.odometer.deadline_m(least_slack_m);
        false
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

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::{Camera, Lens, SplitMix64};
    use terrain_dem::synthetic;

    fn mesh(heightmap: &Heightmap, options: &Options) -> BoundedMesh {
        let nodes = Nodes::new(heightmap, options.patch, options.group());
        let boxes = Arc::new(Boxes::new(heightmap, &nodes, options.blocks));
        BoundedMesh::coarsest(heightmap, options, Arc::new(NodeMaps::build(heightmap, nodes)), boxes).0
    }

    /// Small steps, a jump now and then, and another picture size once.
    fn views(heightmap: &Heightmap) -> impl Iterator<Item = View> {
        let [width_m, depth_m] = heightmap.extent_m();
        let (mut random, mut eye_world) = (SplitMix64::new(11), [width_m / 2.0, 900.0, depth_m / 2.0]);
        (0..400).map(move |frame| {
            let step_m = if frame % 90 == 89 { 400.0 } else { 0.5 };
            eye_world = eye_world.map(|metres| metres + random.range(-step_m, step_m));
            let lens = Lens { fov_y: 1.0, size_px: [640, if frame < 200 { 360 } else { 365 }], near_m: 0.5 };
            View::new(&Camera { eye_world: eye_world.into(), heading: 0.0, pitch: 0.0 }, &lens).unwrap()
        })
    }

    #[test]
    fn a_root_is_looked_at_again_before_it_is_outdated_and_not_much_earlier() {
        let dem = synthetic::generate(190, 247, 7);
        for blocks in [false, true] {
            let options = Options { patch: 16, group: Some(4), blocks, tolerance_px: 2.0, ..Default::default() };
            let mut mesh = mesh(&dem, &options);
            let all: Vec<u32> = (0..mesh.nodes().patches().patches()).collect();
            let (mut skipped, mut looked_at) = (0, 0);
            for (frame, view) in views(&dem).enumerate() {
                let levels = |node| mesh.boxes.levels(node, &view, options.tolerance_px);
                let is_outdated =
                    |root: &NodeId| mesh.nodes().tree(*root).any(|n| mesh.levels[n as usize] != levels(n));
                let expected: Vec<NodeId> = mesh.nodes().roots().filter(is_outdated).collect();
                let deadlines_m = mesh.deadlines_m.clone();
                assert_eq!(mesh.outdated(&options, &view, &all), expected, "blocks {blocks}, frame {frame}");
                for deadline_m in deadlines_m {
                    *(if mesh.odometer.has_passed(deadline_m) { &mut looked_at } else { &mut skipped }) += 1;
                }
                mesh.update(&dem, &options, &view, &expected);
            }
            assert!(skipped > looked_at, "blocks {blocks}: {looked_at} looked at, {skipped} skipped");
        }
    }
}
