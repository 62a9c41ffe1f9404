//! The method as the renderer sees it: a static vertex buffer, and for each patch a fixed region of the index buffer.

use std::sync::Arc;
use std::time::Instant;

use terrain_core::{
    Aabb, BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Heightmap, LodMethod, PatchTag, VertexKind, View,
};

use crate::cull::PatchTree;
use crate::mesh::{Mesh, Update, is_outdated};
use crate::options::{Options, Schedule, TinError};
use crate::patches::{PatchGrid, PatchId};
use crate::worker::{Finished, Worker, Workshop};

/// View-dependent irregular mesh over a DEM in memory.
pub struct Tin {
    heightmap: Arc<Heightmap>,
    options: Options,
    culling: bool,
    grid: PatchGrid,
    tree: Arc<PatchTree>,
    /// What the buffers hold of each patch.
    drawn: Vec<DrawnPatch>,
    updates: Updates,
    /// What the first plan uploads beside the vertices.
    coarsest: Option<Update>,
    /// The patches in view, kept for its memory.
    visible: Vec<PatchId>,
}

#[derive(Clone)]
struct DrawnPatch {
    indices: u32,
    /// The tolerance in metres that its triangles were selected for.
    tolerance_m: f64,
}

/// Who updates the mesh.
enum Updates {
    /// Each plan does, and waits.
    InPlan { mesh: Mesh, pool: rayon::ThreadPool },
    /// The worker does.
    Behind(Worker),
}

impl Tin {
    /// Prepares the patches of a DEM and their coarsest triangulation.
    pub fn new(heightmap: Arc<Heightmap>, options: Options) -> Result<Self, TinError> {
        Self::with_delays(heightmap, options, || {})
    }

    /// As [`Tin::new`], with something that the worker does before it hands an update over.
    pub(crate) fn with_delays(
        heightmap: Arc<Heightmap>,
        options: Options,
        before_hand_over: fn(),
    ) -> Result<Self, TinError> {
        options.validate()?;
        let fault =
            |error: &dyn std::fmt::Display| TinError::Threads { threads: options.threads, reason: error.to_string() };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(options.threads)
            .thread_name(|i| format!("tin-lod {i}"))
            .build()
            .map_err(|error| fault(&error))?;
        let grid = PatchGrid::new(&heightmap, options.patch);
        let (mesh, coarsest) = pool.install(|| Mesh::coarsest(&heightmap, &options, grid));
        let bounds_world: Vec<Aabb> = (0..grid.patches()).map(|p| *mesh.bounds_world(p)).collect();
        let tree = Arc::new(PatchTree::new(&grid, bounds_world));
        let updates = match options.schedule {
            Schedule::Blocking => Updates::InPlan { mesh, pool },
            Schedule::Live => {
                let (heightmap, tree) = (heightmap.clone(), tree.clone());
                let workshop = Workshop { heightmap, options, pool, tree, mesh, before_hand_over };
                let worker = Worker::start(workshop).map_err(|error| fault(&error))?;
                Updates::Behind(worker)
            }
        };
        let drawn = vec![DrawnPatch { indices: 0, tolerance_m: f64::INFINITY }; grid.patches() as usize];
        Ok(Self {
            heightmap,
            options,
            culling: true,
            grid,
            tree,
            drawn,
            updates,
            coarsest: Some(coarsest),
            visible: Vec::new(),
        })
    }

    /// Room for a fully refined patch: the triangulation of all its samples has two triangles a quad.
    fn region_indices(&self) -> u32 {
        6 * self.options.patch * self.options.patch
    }

    /// Static buffers, once: the DEM's vertices, and the coarsest triangles of every patch.
    fn initialise(&mut self, plan: &mut FramePlan) {
        if let Some(coarsest) = self.coarsest.take() {
            plan.upload(Buffer::Vertices, 0, &BakedVertex::whole_dem(&self.heightmap));
            self.map_to_index_buffer(coarsest, plan);
        }
    }

    fn update(&mut self, view: &View, plan: &mut FramePlan) {
        let updates: Vec<Update> = match &mut self.updates {
            Updates::InPlan { mesh, pool } => {
                let outdated = mesh.outdated(&self.options, view, &self.visible);
                let update = || mesh.update(&self.heightmap, &self.options, view, &outdated);
                (!outdated.is_empty()).then(|| pool.install(update)).into_iter().collect()
            }
            Updates::Behind(worker) => {
                worker.show(view, self.culling);
                let now = Instant::now();
                let arrived = |finished: Finished| {
                    let mut update = finished.update;
                    update.report.latency = now - finished.asked;
                    update
                };
                worker.finished().map(arrived).collect()
            }
        };
        updates.into_iter().for_each(|update| self.map_to_index_buffer(update, plan));
    }

    /// The last step of Algorithm 2: the triangles of each patch into the patch's region.
    fn map_to_index_buffer(&mut self, update: Update, plan: &mut FramePlan) {
        for made in update.triangulated {
            let first = made.patch as u64 * self.region_indices() as u64;
            let drawn = &mut self.drawn[made.patch as usize];
            drawn.tolerance_m = made.tolerance_m;
            if let Some(indices) = made.indices {
                drawn.indices = indices.len() as u32;
                plan.upload(Buffer::Indices, first * size_of::<u32>() as u64, &indices);
            }
        }
        plan.work.push(update.report);
    }

    fn draw(&self, patch: PatchId) -> Draw {
        let first = patch * self.region_indices();
        let indices = self.drawn[patch as usize].indices;
        // How many times the triangles would halve on the way from the fully refined patch: for the pictures.
        let level = (self.region_indices() / indices).ilog2().min(15);
        Draw::baked(first..first + indices, 0, PatchTag { patch, level })
    }

    fn is_stale(&self, patch: PatchId, view: &View) -> bool {
        is_outdated(self.tree.bounds_world(patch), self.drawn[patch as usize].tolerance_m, &self.options, view)
    }
}

impl LodMethod for Tin {
    fn name(&self) -> &'static str {
        "tin"
    }

    fn buffers(&self) -> BufferSizes {
        let samples = self.heightmap.heights_m().len() as u64;
        BufferSizes {
            vertex_kind: VertexKind::Baked,
            vertices: samples * size_of::<BakedVertex>() as u64,
            indices: self.grid.patches() as u64 * self.region_indices() as u64 * size_of::<u32>() as u64,
            instances: 0,
        }
    }

    fn set_culling(&mut self, culling: bool) {
        self.culling = culling;
    }

    fn plan(&mut self, view: &View, plan: &mut FramePlan) {
        plan.clear();
        self.initialise(plan);
        self.tree.visible(view, self.culling, &mut self.visible);
        self.update(view, plan);
        plan.draws.extend(self.visible.iter().map(|patch| self.draw(*patch)));
        plan.stale_patches = self.visible.iter().filter(|patch| self.is_stale(**patch, view)).count() as u32;
    }
}
