//! One update, the paper's Algorithm 2 without its thread: find the outdated patches in view, select, triangulate.
//!
//! Each edge is selected once, for both of its patches. Where an update changes an edge, the patch on the other side
//! is triangulated anew in the same update, with the interior that it had: no frame sees two versions of an edge.
//!
//! Deviation: an edge is selected for its own distance, which is never less than that of either patch: its box lies in
//! theirs. The decided reading turns the tolerance into metres at the patch's distance, of which an edge has two.
//!
//! Deviation: the paper leaves a border as it is until both of its patches are updated; here the neighbour follows at
//! once, so that a border is never older than the younger of its patches.

use std::time::{Duration, Instant};

use rayon::prelude::*;
use terrain_core::{Aabb, Heightmap, View, WorkReport};

use crate::options::Options;
use crate::patches::{EdgeId, PatchGrid, PatchId};
use crate::select::{Border, Mask, select_edge, select_interior};
use crate::triangulate::KeptSamples;

/// The state of all patches and edges, as of their last updates.
pub(crate) struct Mesh {
    grid: PatchGrid,
    patches: Vec<Patch>,
    edges: Vec<Edge>,
}

struct Patch {
    bounds_world: Aabb,
    /// The tolerance in metres of the last selection; `None` before the first. It holds all that a later update must
    /// know of the view back then.
    tolerance_m: Option<f64>,
    interior: Vec<Mask>,
    /// Whether an edge has changed since the last triangulation.
    edge_changed: bool,
    /// Indices of the last triangulation.
    indices: u32,
}

struct Edge {
    bounds_world: Aabb,
    kept: Mask,
}

/// New triangles of one patch.
pub(crate) struct Triangulated {
    pub patch: PatchId,
    pub indices: Vec<u32>,
}

impl Mesh {
    pub fn new(heightmap: &Heightmap, grid: PatchGrid) -> Self {
        let patch = |patch| {
            let area = grid.area(patch);
            let bounds_world = heightmap.bounds_world(area.first, area.last());
            Patch { bounds_world, tolerance_m: None, interior: Vec::new(), edge_changed: false, indices: 0 }
        };
        let edge = |edge| {
            let run = grid.run(edge);
            Edge { bounds_world: heightmap.bounds_world(run.first, run.sample(run.length)), kept: 0 }
        };
        let patches = (0..grid.patches()).map(patch).collect();
        Self { grid, patches, edges: (0..grid.edges()).map(edge).collect() }
    }

    pub fn bounds_world(&self, patch: PatchId) -> &Aabb {
        &self.patches[patch as usize].bounds_world
    }

    /// Indices of the patch's last triangulation.
    pub fn indices(&self, patch: PatchId) -> u32 {
        self.patches[patch as usize].indices
    }

    /// Brings the visible patches up to date with a view. The new triangulations come nearest first.
    pub fn update(
        &mut self,
        heightmap: &Heightmap,
        options: &Options,
        view: &View,
        visible: &[PatchId],
    ) -> Option<(Vec<Triangulated>, WorkReport)> {
        let outdated: Vec<_> = visible.iter().copied().filter(|p| self.is_outdated(*p, options, view)).collect();
        let late = |p: &PatchId| self.patches[*p as usize].edge_changed;
        if outdated.is_empty() && !visible.iter().any(late) {
            return None;
        }
        let start = Instant::now();
        let select = self.select(heightmap, options, view, &outdated);
        let (triangulated, triangulate) = self.triangulate(heightmap, options, view, visible, &outdated);
        let report = WorkReport {
            patches: triangulated.len() as u32,
            triangles: triangulated.iter().map(|t| t.indices.len() as u64 / 3).sum(),
            select,
            triangulate,
            update: start.elapsed(),
        };
        Some((triangulated, report))
    }

    /// Whether the largest height difference of the patch, projected, has changed by more than the tolerance since
    /// the patch was last selected (section 4). In units of the tolerance, a difference `d` is `d / tolerance_m`.
    fn is_outdated(&self, patch: PatchId, options: &Options, view: &View) -> bool {
        let Patch { bounds_world, tolerance_m, .. } = &self.patches[patch as usize];
        let Some(then_m) = tolerance_m else { return true };
        let now_m = tolerance_m_at(bounds_world, options, view);
        let difference_m = bounds_world.max[1] - bounds_world.min[1];
        // Both infinite where the eye was and is in the box: not a number, so not more.
        (difference_m / now_m - difference_m / then_m).abs() > 1.0
    }

    /// Selects the edges of the outdated patches, then their interiors. Returns the time summed over all threads.
    fn select(&mut self, heightmap: &Heightmap, options: &Options, view: &View, outdated: &[PatchId]) -> Duration {
        let mut edges: Vec<EdgeId> = outdated.iter().flat_map(|p| self.grid.edges_of(*p).all()).collect();
        edges.sort_unstable();
        edges.dedup();
        let mut time = Duration::ZERO;
        for (edge, (kept, spent)) in edges.iter().zip(self.parallel(&edges, |mesh, edge| {
            let tolerance_m = tolerance_m_at(&mesh.edges[edge as usize].bounds_world, options, view);
            select_edge(heightmap, mesh.grid.run(edge), tolerance_m, options.max_spacing())
        })) {
            self.change_edge(*edge, kept);
            time += spent;
        }
        for (patch, ((tolerance_m, interior), spent)) in outdated.iter().zip(self.parallel(outdated, |mesh, patch| {
            let tolerance_m = tolerance_m_at(mesh.bounds_world(patch), options, view);
            let (area, border) = (mesh.grid.area(patch), mesh.border(patch));
            (tolerance_m, select_interior(heightmap, area, border, tolerance_m, options.max_spacing()))
        })) {
            let patch = &mut self.patches[*patch as usize];
            (patch.tolerance_m, patch.interior) = (Some(tolerance_m), interior);
            time += spent;
        }
        time
    }

    fn change_edge(&mut self, edge: EdgeId, kept: Mask) {
        if std::mem::replace(&mut self.edges[edge as usize].kept, kept) != kept {
            for patch in self.grid.patches_of(edge).into_iter().flatten() {
                self.patches[patch as usize].edge_changed = true;
            }
        }
    }

    /// Triangulates the outdated patches, and those in view that share a changed edge, nearest first.
    fn triangulate(
        &mut self,
        heightmap: &Heightmap,
        options: &Options,
        view: &View,
        visible: &[PatchId],
        outdated: &[PatchId],
    ) -> (Vec<Triangulated>, Duration) {
        let late = visible.iter().copied().filter(|p| self.patches[*p as usize].edge_changed);
        let mut batch: Vec<_> = outdated.iter().copied().chain(late).collect();
        batch.sort_unstable();
        batch.dedup();
        batch.sort_by(|a, b| {
            let distance = |p: &PatchId| view.distance_m(self.bounds_world(*p));
            distance(a).total_cmp(&distance(b))
        });
        let made = self.parallel(&batch, |mesh, patch| {
            let mut indices = Vec::new();
            options.triangulator.triangulate(&mesh.kept_samples(heightmap, patch), &mut indices);
            indices
        });
        let mut time = Duration::ZERO;
        let mut triangulated = Vec::with_capacity(batch.len());
        for (patch, (indices, spent)) in batch.into_iter().zip(made) {
            let state = &mut self.patches[patch as usize];
            (state.indices, state.edge_changed) = (indices.len() as u32, false);
            triangulated.push(Triangulated { patch, indices });
            time += spent;
        }
        (triangulated, time)
    }

    fn kept_samples(&self, heightmap: &Heightmap, patch: PatchId) -> KeptSamples<'_> {
        let area = self.grid.area(patch);
        KeptSamples {
            width: area.width,
            depth: area.depth,
            border: self.border(patch),
            interior: &self.patches[patch as usize].interior,
            first_index: heightmap.index(area.first),
            row_stride: heightmap.columns(),
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

/// The allowed error in pixels as metres at the point of the box that is nearest to the eye.
fn tolerance_m_at(bounds_world: &Aabb, options: &Options, view: &View) -> f64 {
    view.metres(options.tolerance_px, view.distance_m(bounds_world))
}
