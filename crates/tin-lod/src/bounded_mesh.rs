//! The mesh of bounded selections: levels of patches and edges, and one update of them.
//!
//! A patch has the level of its distance, an edge the finer one of its two patches. Where an update changes the level
//! of an edge, the patch on the other side is selected anew with it. A patch out of view keeps the level that it had:
//! that can make an edge finer than it need be, never coarser than the patch in view allows.

use std::cell::RefCell;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use terrain_core::{Aabb, Heightmap, View, WorkReport};

use crate::bounded::{BoundedMesher, Selection, VertexPlace, edge_levels};
use crate::ladder::{self, COARSEST, Level, level_of};
use crate::mesh::{Triangulated, Update, tolerance_m_at};
use crate::options::Options;
use crate::patches::{PatchGrid, PatchId};
use crate::threshold_map::ThresholdMap;

/// Patches and edges as of their last updates.
pub(crate) struct BoundedMesh {
    grid: PatchGrid,
    map: ThresholdMap,
    bounds_world: Vec<Aabb>,
    /// Of each patch.
    levels: Vec<Level>,
    /// What the triangles of each patch are made of; nothing before the first.
    selections: Vec<Option<Selection>>,
}

/// What became of one patch.
struct Made {
    selection: Selection,
    indices: Option<Vec<u32>>,
    select: Duration,
    triangulate: Duration,
}

impl BoundedMesh {
    /// Builds the threshold map; all patches at the coarsest level.
    pub fn coarsest(heightmap: &Heightmap, options: &Options, grid: PatchGrid) -> (Self, Update) {
        let map = ThresholdMap::build(heightmap, &grid, &|_, _| {});
        let bounds_world = |patch| heightmap.bounds_world(grid.area(patch).first, grid.area(patch).last());
        let all: Vec<PatchId> = (0..grid.patches()).collect();
        let mut mesh = Self {
            bounds_world: all.par_iter().map(|patch| bounds_world(*patch)).collect(),
            levels: vec![COARSEST; all.len()],
            selections: vec![None; all.len()],
            grid,
            map,
        };
        let update = mesh.remake(heightmap, options, all, Instant::now());
        (mesh, update)
    }

    pub fn bounds_world(&self, patch: PatchId) -> &Aabb {
        &self.bounds_world[patch as usize]
    }

    /// The tolerance in metres of the patch's level.
    pub fn tolerance_m(&self, patch: PatchId) -> f64 {
        ladder::tolerance_m(self.levels[patch as usize])
    }

    /// Gives these patches the levels of a view, and makes them and the neighbours of changed edges anew.
    pub fn update(&mut self, heightmap: &Heightmap, options: &Options, view: &View, patches: &[PatchId]) -> Update {
        let start = Instant::now();
        let edges: Vec<_> = patches.iter().flat_map(|patch| self.grid.edges_of(*patch).all()).collect();
        let before: Vec<Level> = edges.iter().map(|edge| self.edge_level(*edge)).collect();
        for patch in patches {
            let tolerance_m = tolerance_m_at(self.bounds_world(*patch), options, view);
            self.levels[*patch as usize] = level_of(tolerance_m);
        }
        let changed = edges.iter().zip(before).filter(|(edge, before)| self.edge_level(**edge) != *before);
        let neighbours = changed.flat_map(|(edge, _)| self.grid.patches_of(*edge).into_iter().flatten());
        let mut batch: Vec<PatchId> = patches.iter().copied().chain(neighbours).collect();
        batch.sort_unstable();
        batch.dedup();
        self.remake(heightmap, options, batch, start)
    }

    /// The finer level of the patches on both sides.
    fn edge_level(&self, edge: u32) -> Level {
        let beside = self.grid.patches_of(edge).into_iter().flatten();
        beside.map(|patch| self.levels[patch as usize]).min().expect("an edge has a patch")
    }

    /// Selects and triangulates these patches at the levels that they and their edges have now.
    fn remake(&mut self, heightmap: &Heightmap, options: &Options, batch: Vec<PatchId>, start: Instant) -> Update {
        let row_stride = options.vertex_strips(heightmap).row_stride();
        let made: Vec<Made> = batch.par_iter().map(|patch| self.make(heightmap, row_stride, *patch)).collect();
        let mut report = WorkReport::default();
        let mut triangulated = Vec::with_capacity(batch.len());
        for (patch, made) in batch.into_iter().zip(made) {
            report.select += made.select;
            report.triangulate += made.triangulate;
            self.selections[patch as usize] = Some(made.selection);
            triangulated.push(Triangulated { patch, tolerance_m: self.tolerance_m(patch), indices: made.indices });
        }
        report.patches = triangulated.iter().filter(|t| t.indices.is_some()).count() as u32;
        report.triangles = triangulated.iter().map(Triangulated::triangles).sum();
        report.update = start.elapsed();
        Update { triangulated, report }
    }

    fn make(&self, heightmap: &Heightmap, row_stride: u32, patch: PatchId) -> Made {
        thread_local!(static MESHER: RefCell<BoundedMesher> = RefCell::default());
        let start = Instant::now();
        let mut selection = Selection::default();
        let edges = edge_levels(&self.grid, patch, &self.levels);
        selection.select(&self.map, &self.grid, patch, self.levels[patch as usize], edges);
        let (select, start) = (start.elapsed(), Instant::now());
        let last = self.selections[patch as usize].as_ref();
        let stays = last.is_some_and(|last| selection.gives_the_mesh_of(last));
        let indices = (!stays).then(|| {
            let mut indices = Vec::new();
            let area = self.grid.area(patch);
            let place = VertexPlace { first_index: 0, row_stride };
            MESHER.with_borrow_mut(|mesher| mesher.triangulate_at(heightmap, area, &selection, place, &mut indices));
            indices
        });
        Made { selection, indices, select, triangulate: start.elapsed() }
    }
}
