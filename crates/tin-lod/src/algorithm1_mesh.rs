//! The mesh of Algorithm 1: its patches and edges, and one update of them.
//!
//! Each edge is selected once, for both of its patches. Where an update changes an edge, the patch on the other side
//! is triangulated anew in the same update, with the interior that it had. So the triangulations that one update
//! returns fit each other and all that came before: what is drawn is watertight after every update.
//!
//! Deviation: an edge is selected for its own distance, which is never less than that of either patch: its box lies in
//! theirs. The decided reading turns the tolerance into metres at the patch's distance, of which an edge has two.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use terrain_core::{Aabb, Heightmap, View, WorkReport};

use crate::levels::Boxes;
use crate::mesh::{SelectedFor, Triangulated, Update, tolerance_m_at};
use crate::options::{EdgePolicy, Options};
use crate::patches::{EdgeId, PatchGrid, PatchId};
use crate::select::{Border, Mask, select_edge, select_interior};
use crate::smoothing::{VertexRun, smoothed_rows};
use crate::triangulate::KeptSamples;
use crate::vertices::VertexPlace;

/// Patches and edges as of their last updates.
pub(crate) struct Algorithm1Mesh {
    grid: PatchGrid,
    place: VertexPlace,
    boxes: Arc<Boxes>,
    patches: Vec<Patch>,
    edges: Vec<Edge>,
}

struct Patch {
    /// The tolerance in metres of the last selection. It holds all that a later update must know of the view back
    /// then; infinite before the first.
    tolerance_m: f64,
    interior: Vec<Mask>,
}

struct Edge {
    bounds_world: Aabb,
    kept: Mask,
}

impl Algorithm1Mesh {
    /// The coarsest mesh: what is always kept, and nothing else. Every update starts from a whole, watertight DEM.
    pub fn coarsest(heightmap: &Heightmap, options: &Options, grid: PatchGrid, boxes: Arc<Boxes>) -> (Self, Update) {
        let patch = |_| Patch { tolerance_m: f64::INFINITY, interior: Vec::new() };
        let edge = |edge| {
            let run = grid.run(edge);
            let kept = select_edge(heightmap, run, f64::INFINITY, options.max_spacing());
            Edge { bounds_world: heightmap.bounds_world(run.first, run.sample(run.length)), kept }
        };
        let all: Vec<PatchId> = (0..grid.patches()).collect();
        let patches = all.iter().map(patch).collect();
        let edges = (0..grid.edges()).into_par_iter().map(edge).collect();
        let mut mesh = Self { grid, boxes, place: options.vertex_strips(heightmap).place(), patches, edges };
        let (start, tolerances) = (Instant::now(), vec![f64::INFINITY; all.len()]);
        let select = mesh.select_interiors(heightmap, options, &all, &tolerances);
        let update = mesh.triangulate(heightmap, options, all, start, select);
        (mesh, update)
    }

    pub fn boxes(&self) -> &Boxes {
        &self.boxes
    }

    /// The patches in view that an update for this view would select anew.
    pub fn outdated(&self, options: &Options, view: &View, visible: &[PatchId]) -> Vec<PatchId> {
        let is_outdated = |patch: &PatchId| {
            is_outdated(self.boxes.of(*patch), self.patches[*patch as usize].tolerance_m, options, view)
        };
        visible.iter().copied().filter(is_outdated).collect()
    }

    /// Selects these patches and their edges for a view, and triangulates them and the neighbours of changed edges.
    pub fn update(&mut self, heightmap: &Heightmap, options: &Options, view: &View, patches: &[PatchId]) -> Update {
        let start = Instant::now();
        let (mut batch, mut select) = self.select_edges(heightmap, options, view, patches);
        let tolerance_m = |p: &PatchId| tolerance_m_at(self.boxes.of(*p), options, view);
        let tolerances: Vec<f64> = patches.iter().map(tolerance_m).collect();
        select += self.select_interiors(heightmap, options, patches, &tolerances);
        batch.extend(patches);
        batch.sort_unstable();
        batch.dedup();
        self.triangulate(heightmap, options, batch, start, select)
    }

    /// Selects the edges that the policy lets follow these patches. Returns the patches of all edges that changed, and
    /// the time summed over all threads.
    fn select_edges(
        &mut self,
        heightmap: &Heightmap,
        options: &Options,
        view: &View,
        patches: &[PatchId],
    ) -> (Vec<PatchId>, Duration) {
        let mut edges: Vec<EdgeId> = patches.iter().flat_map(|p| self.grid.edges_of(*p).all()).collect();
        edges.sort_unstable();
        if options.edge_policy == EdgePolicy::Paper {
            edges = edges_with_all_patches(&self.grid, &edges);
        }
        edges.dedup();
        let selected = self.parallel(&edges, |mesh, edge| {
            let tolerance_m = tolerance_m_at(&mesh.edges[edge as usize].bounds_world, options, view);
            select_edge(heightmap, mesh.grid.run(edge), tolerance_m, options.max_spacing())
        });
        let (mut changed, mut time) = (Vec::new(), Duration::ZERO);
        for (edge, (kept, spent)) in edges.into_iter().zip(selected) {
            if std::mem::replace(&mut self.edges[edge as usize].kept, kept) != kept {
                changed.extend(self.grid.patches_of(edge).into_iter().flatten());
            }
            time += spent;
        }
        (changed, time)
    }

    /// Selects the interiors of these patches, each for its tolerance in metres. Returns the time summed over all threads.
    fn select_interiors(
        &mut self,
        heightmap: &Heightmap,
        options: &Options,
        patches: &[PatchId],
        tolerances_m: &[f64],
    ) -> Duration {
        // Masks are made in the memory of those before.
        let interior = |patch: &PatchId| std::mem::take(&mut self.patches[*patch as usize].interior);
        let mut interiors: Vec<Vec<Mask>> = patches.iter().map(interior).collect();
        let select = |(place, interior): (usize, &mut Vec<Mask>)| {
            let start = Instant::now();
            let (area, border) = (self.grid.area(patches[place]), self.border(patches[place]));
            select_interior(heightmap, area, border, tolerances_m[place], options.max_spacing(), interior);
            start.elapsed()
        };
        let time = interiors.par_iter_mut().enumerate().map(select).sum();
        for ((patch, tolerance_m), interior) in patches.iter().zip(tolerances_m).zip(interiors) {
            let patch = &mut self.patches[*patch as usize];
            (patch.tolerance_m, patch.interior) = (*tolerance_m, interior);
        }
        time
    }

    /// Triangulates these patches as they are selected now.
    fn triangulate(
        &self,
        heightmap: &Heightmap,
        options: &Options,
        batch: Vec<PatchId>,
        start: Instant,
        select: Duration,
    ) -> Update {
        let made = self.parallel(&batch, |mesh, patch| {
            let mut indices = Vec::new();
            options.triangulate(patch, &mesh.kept_samples(patch), &mut indices);
            indices
        });
        let triangulate = made.iter().map(|(_, spent)| *spent).sum();
        let vertices = if options.smoothing { self.smoothed(heightmap, &batch) } else { Vec::new() };
        let finish = |(patch, (indices, _)): (PatchId, (Vec<u32>, Duration))| Triangulated {
            node: patch,
            selected_for: SelectedFor::ToleranceM(self.patches[patch as usize].tolerance_m),
            indices: Some(indices),
        };
        let triangulated: Vec<Triangulated> = batch.into_iter().zip(made).map(finish).collect();
        let report = WorkReport {
            patches: triangulated.len() as u32,
            triangles: triangulated.iter().map(Triangulated::triangles).sum(),
            select,
            triangulate,
            update: start.elapsed(),
            ..Default::default()
        };
        Update { triangulated, retired: Vec::new(), vertices, report }
    }

    /// The vertices of these patches that smoothing changes.
    fn smoothed(&self, heightmap: &Heightmap, batch: &[PatchId]) -> Vec<VertexRun> {
        let runs = |p: &PatchId| smoothed_rows(heightmap, self.grid.area(*p).first, &self.kept_samples(*p));
        batch.par_iter().flat_map_iter(runs).collect()
    }

    fn kept_samples(&self, patch: PatchId) -> KeptSamples<'_> {
        let area = self.grid.area(patch);
        KeptSamples {
            width: area.width,
            depth: area.depth,
            border: self.border(patch),
            interior: &self.patches[patch as usize].interior,
            first_index: self.place.first_index,
            row_stride: self.place.row_stride,
        }
    }

    fn border(&self, patch: PatchId) -> Border {
        let edges = self.grid.edges_of(patch);
        let kept = |edge: EdgeId| self.edges[edge as usize].kept;
        Border { north: kept(edges.north), south: kept(edges.south), west: kept(edges.west), east: kept(edges.east) }
    }

    /// `work` for each number, on the threads of the current pool, with the time that each took; in order.
    fn parallel<T: Send>(&self, numbers: &[u32], work: impl Fn(&Self, u32) -> T + Sync) -> Vec<(T, Duration)> {
        let timed = |number: &u32| {
            let start = Instant::now();
            (work(self, *number), start.elapsed())
        };
        numbers.par_iter().map(timed).collect()
    }
}

/// Whether a patch that was selected for `then_m` needs another selection: where the largest height difference in its
/// box, projected, has changed by more than the tolerance (section 4). In units of the tolerance, a difference `d` is
/// `d / tolerance_m`.
pub(crate) fn is_outdated(bounds_world: &Aabb, then_m: f64, options: &Options, view: &View) -> bool {
    let now_m = tolerance_m_at(bounds_world, options, view);
    let difference_m = bounds_world.max[1] - bounds_world.min[1];
    // Both infinite where the eye was and is in the box: not a number, so not more.
    (difference_m / now_m - difference_m / then_m).abs() > 1.0
}

/// Of the sorted edges of some patches (an edge stands there once for each of its patches among them) those whose
/// patches are all among them: "the border points will remain in the same state until both patches that share that
/// border receive a new update request" (section 3.2).
fn edges_with_all_patches(grid: &PatchGrid, edges: &[EdgeId]) -> Vec<EdgeId> {
    let all = |same: &&[EdgeId]| same.len() == grid.patches_of(same[0]).iter().flatten().count();
    edges.chunk_by(|a, b| a == b).filter(all).map(|same| same[0]).collect()
}
