//! What a method wants the GPU to do in one frame: plain data, replayed by the renderer and by the mirror.

use std::ops::Range;
use std::time::Duration;

use crate::{HeightTiles, Morph};

/// One of the buffers of a method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Buffer {
    /// [`BakedVertex`](crate::BakedVertex) or [`LocalVertex`](crate::LocalVertex), as the method's [`VertexKind`] says.
    Vertices,
    /// Indices as wide as the method's [`IndexFormat`], three a triangle.
    Indices,
    /// [`PatchInstance`](crate::PatchInstance); only with [`VertexKind::Displaced`].
    Instances,
    /// Codes of heights, laid out as the method's [`HeightTiles`] say; only where it brings its heights along.
    Heights,
}

/// Where a vertex gets its height from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexKind {
    /// The vertex holds its sample coordinate and its height ([`BakedVertex`](crate::BakedVertex)).
    /// `Draw::instances` is then `tag..tag + 1` with a [`PatchTag`].
    Baked,
    /// The vertex holds a local coordinate ([`LocalVertex`](crate::LocalVertex)), the instance maps it to a sample
    /// ([`PatchInstance`](crate::PatchInstance)), the height comes from the DEM, or from the method's
    /// [`HeightTiles`] where it has such.
    Displaced,
}

/// Width of the indices in an index buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IndexFormat {
    /// `u16`
    U16,
    /// `u32`
    U32,
}

impl IndexFormat {
    /// Bytes of one index.
    pub fn bytes(self) -> u64 {
        match self {
            Self::U16 => 2,
            Self::U32 => 4,
        }
    }
}

/// Sizes in bytes of a method's buffers, and what is in them. Plans may enlarge them ([`FramePlan::growths`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BufferSizes {
    /// Where a vertex gets its height from.
    pub vertex_kind: VertexKind,
    /// Width of an index.
    pub index_format: IndexFormat,
    /// Bytes of the vertex buffer.
    pub vertices: u64,
    /// Bytes of the index buffer.
    pub indices: u64,
    /// Bytes of the instance buffer; 0 with [`VertexKind::Baked`].
    pub instances: u64,
    /// Where displaced vertices find their heights in [`Buffer::Heights`], and its size; none where the DEM's are used.
    pub heights: Option<HeightTiles>,
    /// Sample intervals along a cell, the unit that the method loads, for pictures; none where it has no cells.
    pub cell_side: Option<u32>,
}

impl BufferSizes {
    /// Applies one growth of a plan. Panics for [`Buffer::Heights`], whose tiles stay where they are.
    pub fn grow(&mut self, growth: &Growth) {
        let bytes = match growth.buffer {
            Buffer::Vertices => &mut self.vertices,
            Buffer::Indices => &mut self.indices,
            Buffer::Instances => &mut self.instances,
            Buffer::Heights => unreachable!("height tiles keep their size"),
        };
        *bytes = growth.bytes;
    }
}

/// A buffer that becomes larger. What it holds stays.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Growth {
    /// The buffer to enlarge.
    pub buffer: Buffer,
    /// Its new size, a multiple of 4.
    pub bytes: u64,
}

/// A write of `FramePlan::bytes[bytes]` to a buffer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Upload {
    /// The buffer to write.
    pub buffer: Buffer,
    /// Byte offset in that buffer, a multiple of 4.
    pub offset: u64,
    /// The bytes in [`FramePlan::bytes`], their number a multiple of 4.
    pub bytes: Range<usize>,
}

/// One indexed draw: exactly the arguments of an indexed-indirect draw.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draw {
    /// Range of indices (not bytes) in the index buffer.
    pub indices: Range<u32>,
    /// Added to every index.
    pub base_vertex: i32,
    /// Range of instances; with baked vertices it carries a [`PatchTag`].
    pub instances: Range<u32>,
}

impl Draw {
    /// A draw of baked vertices, tagged for the pictures that colour by patch or by level.
    pub fn baked(indices: Range<u32>, base_vertex: i32, tag: PatchTag) -> Self {
        let tag = tag.to_instance();
        Self { indices, base_vertex, instances: tag..tag + 1 }
    }

    /// The same draw of baked vertices, marked as drawn for an older view.
    pub fn stale(self) -> Self {
        let tag = self.instances.start | PatchTag::STALE;
        Self { instances: tag..tag + 1, ..self }
    }

    /// Triangles that this draw sends to the GPU, degenerate ones included.
    pub fn triangles(&self) -> u64 {
        (self.indices.len() / 3) as u64 * self.instances.len() as u64
    }
}

/// What a triangle belongs to. With baked vertices it travels as the draw's instance index and costs no buffer, with
/// displaced ones in the [`PatchInstance`](crate::PatchInstance).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PatchTag {
    /// Number of the patch, below 2^27.
    pub patch: u32,
    /// Level of detail, 0 = finest, below [`Self::LEVELS`].
    pub level: u32,
}

impl PatchTag {
    /// So many levels have a place in a tag.
    pub const LEVELS: usize = 16;
    /// Set in the instance index of what is drawn for an older view ([`Draw::stale`]): for pictures alone.
    pub const STALE: u32 = 1 << 31;

    /// `patch * 16 + level`; `shaders/terrain.wgsl` takes it apart again.
    pub fn to_instance(self) -> u32 {
        debug_assert!(self.level < 16 && self.patch < 1 << 27, "{self:?}");
        self.patch << 4 | self.level
    }

    /// The inverse of [`Self::to_instance`].
    pub fn from_instance(tag: u32) -> Self {
        Self { patch: (tag & !Self::STALE) >> 4, level: tag & 15 }
    }
}

/// How long a stage of planning took, for the statistics. Any two are equal: a plan is what it makes the GPU do, however long
/// that took to find out.
#[derive(Clone, Copy, Debug, Default)]
pub struct StageTime(pub Duration);

impl PartialEq for StageTime {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// One finished round of updates, for the statistics: nothing is decided from it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WorkReport {
    /// Patches, or groups of such, that were triangulated anew.
    pub patches: u32,
    /// Triangles that were made.
    pub triangles: u64,
    /// Time spent selecting samples, summed over all threads.
    pub select: Duration,
    /// Time spent triangulating, summed over all threads.
    pub triangulate: Duration,
    /// Duration of the whole update (Bertilsson and Goswami 2016, Table 2).
    pub update: Duration,
    /// From asking for the update to the plan that draws it; 0 where the plan made it.
    pub latency: Duration,
}

/// What a method that loads its DEM piece by piece has done so far, and what it lacks in this frame. All 0 for others.
/// Where a cell is loaded for each level by itself, it counts once for each, but in `cells_missing`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Streaming {
    /// Cells that were loaded, from the beginning.
    pub cells_loaded: u64,
    /// Cells that made room for others, from the beginning.
    pub cells_unloaded: u64,
    /// Reads that failed, from the beginning.
    pub reads_failed: u64,
    /// Reads that were asked for again after a failure, from the beginning.
    pub retries: u64,
    /// Cells that are still to be loaded for this view; those that wait for another attempt after a failure are not among
    /// them.
    pub cells_due: u64,
    /// Cells in view that are drawn coarser than the view asks for, since they or their neighbours are not loaded.
    pub cells_missing: u64,
    /// Bytes of the DEM in memory, the GPU's included.
    pub resident_bytes: u64,
    /// By level below the coarse one: column and row of the first cell of its window
    /// ([`HeightTiles::windows`](crate::HeightTiles::windows)).
    pub first_cells: [[u32; 2]; HeightTiles::MAX_LEVELS],
}

/// Everything that a method wants the GPU to do this frame. Reused from frame to frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FramePlan {
    /// Buffers to enlarge, before the uploads.
    pub growths: Vec<Growth>,
    /// Applied in order, before the draws.
    pub uploads: Vec<Upload>,
    /// The bytes that the uploads refer to.
    pub bytes: Vec<u8>,
    /// Executed in order.
    pub draws: Vec<Draw>,
    /// Updates that finished since the last frame.
    pub work: Vec<WorkReport>,
    /// Patches (or groups of such that are drawn as one) drawn for an older view than this frame's, since their updates
    /// have not finished.
    pub stale_patches: u32,
    /// Moves the DEM's heights under displaced vertices; none where they are drawn as they are.
    pub morph: Option<Morph>,
    /// 0 where the method holds what it promises; otherwise how many pixels the worst of what is drawn too coarsely
    /// counts, in view or not, for lack of the data to do better. Infinite where the eye is within the bounds of such a
    /// place.
    pub unheld_px: f64,
    /// How the loading of the DEM goes on.
    pub streaming: Streaming,
    /// Finding out what is in view, of methods where that is a step of its own; 0 for the others.
    pub cull: StageTime,
}

impl FramePlan {
    /// Empties the plan and keeps its memory.
    pub fn clear(&mut self) {
        self.growths.clear();
        self.uploads.clear();
        self.bytes.clear();
        self.draws.clear();
        self.work.clear();
        self.stale_patches = 0;
        self.morph = None;
        self.unheld_px = 0.0;
        self.streaming = Streaming::default();
        self.cull = StageTime::default();
    }

    /// Adds a write of plain values at a byte offset. Nothing is added for an empty slice.
    pub fn upload<T: bytemuck::NoUninit>(&mut self, buffer: Buffer, offset: u64, values: &[T]) {
        if values.is_empty() {
            return;
        }
        let start = self.bytes.len();
        self.bytes.extend_from_slice(bytemuck::cast_slice(values));
        self.uploads.push(Upload { buffer, offset, bytes: start..self.bytes.len() });
    }

    /// The bytes of one upload.
    pub fn bytes_of(&self, upload: &Upload) -> &[u8] {
        &self.bytes[upload.bytes.clone()]
    }
}
