//! Restricted quadtree, as right-triangulated refinement with nested errors: P. Lindstrom and V. Pascucci, "Terrain
//! simplification simplified: a general framework for view-dependent out-of-core visualization", IEEE TVCG 8(3), 2002;
//! W. Evans, D. Kirkpatrick and G. Townsend, "Right-triangulated irregular networks", Algorithmica 30, 2001.
//!
//! ```text
//!   +-------+-------+      A triangle is split at the middle of its longest edge, together with the one
//!   | \   / |     / |      on the edge's other side. Whether it is, is asked of the vertex there:
//!   |   +   |   /   |      is its error, at its nearest point, more than the tolerance allows?
//!   | /   \ | /     |      A vertex's error and bounds include those of all vertices below it, so
//!   +---+---+       |      that a vertex is never wanted without those above, and nothing tears.
//!   | \ | / | \     |
//!   +---+---+   \   |
//!   | / | \ |     \ |
//!   +---+---+-------+
//! ```
//!
//! **The tolerance is a bound.** The error of a vertex is the largest distance between the triangles that it splits, or
//! any below, and *all* samples that these cover; its bounds hold all those samples. So a triangle that is drawn is
//! within the tolerance at each of its samples.
//!
//! The height by which a vertex lifts the middle of its edge would be quicker to find, but it says only how far a mesh
//! is from the next finer one: such steps add up over the levels. With it, nested in the same way, the error on Puget
//! Sound is up to 2.07 times the tolerance, for 6 to 10 % fewer triangles (`examples/views.rs`, 1 px).
//!
//! Deviation: bounds are boxes where the paper has spheres (`hierarchy.rs` says why).
//!
//! Deviation: a triangle list where the paper makes one long strip. It is made anew in every frame, as there, and sent
//! whole in every frame in which it differs from the last one.
//!
//! Deviation: DEMs of any size (`hierarchy.rs`). No geomorphs, no paging.

mod hierarchy;
mod refine;

use terrain_core::{
    BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Growth, Heightmap, IndexFormat, LodMethod, PatchTag, VertexKind,
    View,
};

use crate::error::{BaselineError, check_tolerance};
use hierarchy::Hierarchy;
use refine::Refinement;

/// View-dependent right triangles in one draw, made anew each frame.
pub struct Rqt {
    hierarchy: Hierarchy,
    tolerance_px: f64,
    columns: u32,
    culling: bool,
    /// What the first plan uploads; empty afterwards.
    vertices: Vec<BakedVertex>,
    vertex_bytes: u64,
    /// What the index buffer holds.
    uploaded: Vec<u32>,
    /// The triangles of this frame, kept for its memory.
    indices: Vec<u32>,
    /// Indices that the index buffer has room for.
    room: u64,
}

impl Rqt {
    /// Measures the errors of all vertices over a DEM. `tolerance_px` is the allowed screen-space error, finite and
    /// above 0.
    pub fn new(heightmap: &Heightmap, tolerance_px: f64) -> Result<Self, BaselineError> {
        check_tolerance(tolerance_px)?;
        let vertices = BakedVertex::whole_dem(heightmap);
        Ok(Self {
            hierarchy: Hierarchy::new(heightmap),
            tolerance_px,
            columns: heightmap.columns(),
            culling: true,
            vertex_bytes: size_of_val(&vertices[..]) as u64,
            vertices,
            uploaded: Vec::new(),
            indices: Vec::new(),
            room: 6,
        })
    }

    fn refine(&mut self, view: &View) {
        self.indices.clear();
        let Self { hierarchy, tolerance_px, columns, indices, .. } = self;
        let mut refinement = Refinement { hierarchy, view, tolerance_px: *tolerance_px, columns: *columns, indices };
        refinement.run(self.culling);
    }

    /// Replaces what the index buffer holds, where it differs. The buffer grows by a quarter more than it takes.
    fn upload(&mut self, plan: &mut FramePlan) {
        if self.indices.is_empty() || self.indices == self.uploaded {
            return;
        }
        let needed = self.indices.len() as u64;
        if needed > self.room {
            self.room = needed + needed / 4;
            plan.growths.push(Growth { buffer: Buffer::Indices, bytes: 4 * self.room });
        }
        plan.upload(Buffer::Indices, 0, &self.indices);
        self.uploaded.clone_from(&self.indices);
    }
}

impl LodMethod for Rqt {
    fn name(&self) -> &'static str {
        "rqt"
    }

    fn buffers(&self) -> BufferSizes {
        BufferSizes {
            vertex_kind: VertexKind::Baked,
            index_format: IndexFormat::U32,
            vertices: self.vertex_bytes,
            indices: 4 * self.room,
            instances: 0,
            heights: None,
            cell_side: None,
        }
    }

    fn set_culling(&mut self, culling: bool) {
        self.culling = culling;
    }

    fn plan(&mut self, view: &View, plan: &mut FramePlan) {
        plan.clear();
        plan.upload(Buffer::Vertices, 0, &std::mem::take(&mut self.vertices));
        self.refine(view);
        self.upload(plan);
        let count = u32::try_from(self.indices.len()).expect("a draw names at most 2^32 indices");
        if count > 0 {
            plan.draws.push(Draw::baked(0..count, 0, PatchTag { patch: 0, level: 0 }));
        }
    }
}
