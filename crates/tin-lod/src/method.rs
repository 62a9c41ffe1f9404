//! The method as the renderer sees it: a static vertex buffer, and for each patch a room in the index buffer.

use std::sync::Arc;

use terrain_core::{
    Aabb, BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Growth, Heightmap, IndexFormat, LodMethod, PatchTag,
    VertexKind, View,
};

use crate::cull::PatchTree;
use crate::index_store::Rooms;
use crate::mesh::{Mesh, Update, is_outdated};
use crate::options::{IndexStore, Options, Schedule, TinError};
use crate::patches::{PatchGrid, PatchId};
use crate::vertices::VertexStrips;
use crate::worker::{HandOver, Worker, Workshop};

/// View-dependent irregular mesh over a DEM in memory.
pub struct Tin {
    heightmap: Arc<Heightmap>,
    options: Options,
    culling: bool,
    grid: PatchGrid,
    tree: Arc<PatchTree>,
    strips: VertexStrips,
    rooms: Rooms,
    /// Of each patch the tolerance in metres that its triangles in the buffer were selected for.
    drawn_tolerances_m: Vec<f64>,
    updates: Updates,
    /// What the first plan uploads beside the vertices.
    coarsest: Option<Update>,
    /// The patches in view, kept for its memory.
    visible: Vec<PatchId>,
    /// The 2-byte indices of one patch, kept for its memory.
    narrow: Vec<u16>,
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
        Self::with_hand_over(heightmap, options, |update, pass_on| pass_on(update))
    }

    /// As [`Tin::new`], with another way for the worker to hand its updates over.
    pub(crate) fn with_hand_over(
        heightmap: Arc<Heightmap>,
        options: Options,
        hand_over: HandOver,
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
                let workshop = Workshop { heightmap, options, pool, tree, mesh, hand_over };
                let worker = Worker::start(workshop).map_err(|error| fault(&error))?;
                Updates::Behind(worker)
            }
        };
        let rooms = match options.index_store {
            IndexStore::Fixed => Rooms::fixed(grid.patches(), full_patch_indices(&options)),
            IndexStore::Packed => Rooms::packed(grid.patches()),
        };
        Ok(Self {
            strips: options.vertex_strips(&heightmap),
            heightmap,
            options,
            culling: true,
            grid,
            tree,
            rooms,
            drawn_tolerances_m: vec![f64::INFINITY; grid.patches() as usize],
            updates,
            coarsest: Some(coarsest),
            visible: Vec::new(),
            narrow: Vec::new(),
        })
    }

    /// Static buffers, once: the DEM's vertices, and the coarsest triangles of every patch.
    fn initialise(&mut self, plan: &mut FramePlan) {
        if let Some(coarsest) = self.coarsest.take() {
            plan.upload(Buffer::Vertices, 0, &self.strips.fill(&self.heightmap));
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
                worker.finished()
            }
        };
        updates.into_iter().for_each(|update| self.map_to_index_buffer(update, plan));
    }

    /// The last step of Algorithm 2: the triangles of each patch into the patch's room.
    fn map_to_index_buffer(&mut self, update: Update, plan: &mut FramePlan) {
        for made in update.triangulated {
            self.drawn_tolerances_m[made.patch as usize] = made.tolerance_m;
            if let Some(indices) = made.indices {
                self.upload(made.patch, &indices, plan);
            }
        }
        plan.work.push(update.report);
    }

    fn upload(&mut self, patch: PatchId, indices: &[u32], plan: &mut FramePlan) {
        let first = self.rooms.place(patch, indices.len() as u32).start as u64;
        match self.index_format() {
            IndexFormat::U32 => plan.upload(Buffer::Indices, first * 4, indices),
            IndexFormat::U16 => {
                self.narrow.clear();
                self.narrow.extend(indices.iter().map(|index| *index as u16));
                if self.narrow.len() % 2 == 1 {
                    self.narrow.push(0); // Uploads are multiples of 4 bytes, and so are rooms.
                }
                plan.upload(Buffer::Indices, first * 2, &self.narrow);
            }
        }
    }

    /// A patch has at most 65 x 65 samples, so strips make every index small.
    fn index_format(&self) -> IndexFormat {
        match self.options.index_store {
            IndexStore::Fixed => IndexFormat::U32,
            IndexStore::Packed => IndexFormat::U16,
        }
    }

    fn index_bytes(&self) -> u64 {
        self.rooms.capacity() as u64 * self.index_format().bytes()
    }

    fn draw(&self, patch: PatchId) -> Draw {
        let indices = self.rooms.of(patch);
        // How many times the triangles would halve on the way from the fully refined patch: for the pictures.
        let level = (full_patch_indices(&self.options) / indices.len() as u32).ilog2().min(15);
        let base_vertex = self.strips.first_vertex(self.grid.area(patch)) as i32;
        Draw::baked(indices, base_vertex, PatchTag { patch, level })
    }

    fn is_stale(&self, patch: PatchId, view: &View) -> bool {
        is_outdated(self.tree.bounds_world(patch), self.drawn_tolerances_m[patch as usize], &self.options, view)
    }
}

/// The triangulation of all samples of a patch has two triangles a quad.
fn full_patch_indices(options: &Options) -> u32 {
    6 * options.patch * options.patch
}

impl LodMethod for Tin {
    fn name(&self) -> &'static str {
        "tin"
    }

    fn buffers(&self) -> BufferSizes {
        BufferSizes {
            vertex_kind: VertexKind::Baked,
            index_format: self.index_format(),
            vertices: self.strips.vertices() * size_of::<BakedVertex>() as u64,
            indices: self.index_bytes(),
            instances: 0,
        }
    }

    fn set_culling(&mut self, culling: bool) {
        self.culling = culling;
    }

    fn plan(&mut self, view: &View, plan: &mut FramePlan) {
        plan.clear();
        let index_bytes = self.index_bytes();
        self.initialise(plan);
        self.tree.visible(view, self.culling, &mut self.visible);
        self.update(view, plan);
        if self.index_bytes() > index_bytes {
            plan.growths.push(Growth { buffer: Buffer::Indices, bytes: self.index_bytes() });
        }
        plan.draws.extend(self.visible.iter().map(|patch| self.draw(*patch)));
        plan.stale_patches = self.visible.iter().filter(|patch| self.is_stale(**patch, view)).count() as u32;
    }
}
