//! The method as the renderer sees it: a static vertex buffer, and for each patch a fixed region of the index buffer.

use std::sync::Arc;

use terrain_core::{
    BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Heightmap, LodMethod, PatchTag, VertexKind, View,
};

use crate::options::{Options, TinError};
use crate::patches::{PatchGrid, PatchId};
use crate::update::Mesh;

/// View-dependent irregular mesh over a DEM in memory.
pub struct Tin {
    heightmap: Arc<Heightmap>,
    options: Options,
    pool: rayon::ThreadPool,
    grid: PatchGrid,
    mesh: Mesh,
    culling: bool,
    vertices_uploaded: bool,
    /// The patches in view, kept for its memory.
    visible: Vec<PatchId>,
}

impl Tin {
    /// Prepares the patches of a DEM; nothing is triangulated before the first view.
    pub fn new(heightmap: Arc<Heightmap>, options: Options) -> Result<Self, TinError> {
        options.validate()?;
        let grid = PatchGrid::new(&heightmap, options.patch);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(options.threads)
            .thread_name(|i| format!("tin-lod {i}"))
            .build()
            .map_err(|error| TinError::Threads { threads: options.threads, reason: error.to_string() })?;
        let mesh = Mesh::new(&heightmap, grid);
        Ok(Self { heightmap, options, pool, grid, mesh, culling: true, vertices_uploaded: false, visible: Vec::new() })
    }

    /// Room for a fully refined patch: the triangulation of all its samples has two triangles a quad.
    fn region_indices(&self) -> u32 {
        6 * self.options.patch * self.options.patch
    }

    /// The frustum against every patch's box, as in the paper: there is no tree over the patches.
    fn find_visible(&mut self, view: &View) {
        let (culling, mesh) = (self.culling, &self.mesh);
        self.visible.clear();
        self.visible.extend((0..self.grid.patches()).filter(|p| !culling || view.sees(mesh.bounds_world(*p))));
    }

    fn update(&mut self, view: &View, plan: &mut FramePlan) {
        let Self { heightmap, options, pool, mesh, visible, .. } = self;
        let Some((triangulated, report)) = pool.install(|| mesh.update(heightmap, options, view, visible)) else {
            return;
        };
        for made in &triangulated {
            let first = made.patch as u64 * self.region_indices() as u64;
            plan.upload(Buffer::Indices, first * size_of::<u32>() as u64, &made.indices);
        }
        plan.work.push(report);
    }

    fn draw(&self, patch: PatchId) -> Draw {
        let first = patch * self.region_indices();
        let indices = self.mesh.indices(patch);
        // How many times the triangles would halve on the way from the fully refined patch: for the pictures.
        let level = (self.region_indices() / indices).ilog2().min(15);
        Draw::baked(first..first + indices, 0, PatchTag { patch, level })
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
        if !std::mem::replace(&mut self.vertices_uploaded, true) {
            plan.upload(Buffer::Vertices, 0, &BakedVertex::whole_dem(&self.heightmap));
        }
        self.find_visible(view);
        self.update(view, plan);
        plan.draws.extend(self.visible.iter().map(|patch| self.draw(*patch)));
    }
}
