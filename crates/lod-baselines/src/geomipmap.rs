//! Geometrical mipmaps: W. H. de Boer, "Fast terrain rendering using geometrical mipmapping", 2000.
//!
//! ```text
//!   +-------+-------+-------+      Blocks of 32 x 32 intervals, each drawn at one level: every sample,
//!   |       |       |       |      every second, every fourth, ... down to its corners. One draw a block,
//!   |   2   |   1   |   0   |      from index lists that all blocks share. Where a neighbour is coarser,
//!   |       |       |       |      another list drops the vertices of the border that it lacks.
//!   +-------+-------+-------+
//!   |   2   |   1   |   1   |
//! ```
//!
//! A block takes the coarsest level whose largest vertical distance from the DEM's samples is within the tolerance at
//! the nearest point of its box. Errors are nested: that of a level is no less than that of a finer one.
//!
//! **Neighbours differ by one level at most**, which makes 16 lists a level; any difference would make 1296 for level
//! 0 alone. Where two differ by more, the coarser one gives way and becomes finer than it need be.
//!
//! **The tolerance is a bound**, at the joined sides too. A border without every other vertex is the neighbour's
//! border, and within the neighbour's error. But the triangles between it and the first inner row may be farther from
//! the samples below them than those of the plain strip. So the error of each joined strip is stored beside the plain
//! ones, and where it is too large, the neighbour gives way. Without that the error is up to 1.26 times the tolerance
//! on Puget Sound and 1.20 times on Death Valley (`examples/views.rs`, 1 to 4 px); with it there are up to 0.3 % more
//! triangles.
//!
//! Deviation: de Boer takes the error at the vertices that a level drops, and simplifies the projection for a camera
//! that looks level. Here all samples count, and the distance in space.
//!
//! Deviation: DEMs of any size (`lists.rs`); every block's box is tested against the view, where he descends a
//! quadtree; no trilinear blending of levels.

mod blocks;
mod levels;
mod lists;

use std::time::Instant;

use terrain_core::{
    BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Heightmap, IndexFormat, LodMethod, PatchTag, StageTime,
    VertexKind, View,
};

use crate::error::{BaselineError, check_tolerance};
use blocks::Blocks;
use levels::Levels;
use lists::Lists;

/// Blocks at levels of detail, one draw each; static buffers.
pub struct Geomipmap {
    blocks: Blocks,
    lists: Lists,
    levels: Levels,
    tolerance_px: f64,
    columns: u32,
    culling: bool,
    /// What the first plan uploads; empty afterwards.
    vertices: Vec<BakedVertex>,
    sizes: BufferSizes,
}

impl Geomipmap {
    /// Measures the errors of all levels of all blocks. `tolerance_px` is the allowed screen-space error, finite and
    /// above 0.
    ///
    /// Panics above 2^31 samples, which a draw's base vertex cannot name.
    pub fn new(heightmap: &Heightmap, tolerance_px: f64) -> Result<Self, BaselineError> {
        check_tolerance(tolerance_px)?;
        let blocks = Blocks::new(heightmap);
        let lists = Lists::new(&blocks.shapes, heightmap.columns());
        let vertices = BakedVertex::whole_dem(heightmap);
        let sizes = BufferSizes {
            vertex_kind: VertexKind::Baked,
            index_format: IndexFormat::U32,
            vertices: size_of_val(&vertices[..]) as u64,
            indices: size_of_val(&lists.indices[..]) as u64,
            instances: 0,
            heights: None,
            cell_side: None,
        };
        let (levels, columns) = (Levels::default(), heightmap.columns());
        Ok(Self { blocks, lists, levels, tolerance_px, columns, culling: true, vertices, sizes })
    }

    /// What never changes, sent once.
    fn initialise(&mut self, plan: &mut FramePlan) {
        if !self.vertices.is_empty() {
            plan.upload(Buffer::Vertices, 0, &std::mem::take(&mut self.vertices));
            plan.upload(Buffer::Indices, 0, &self.lists.indices);
        }
    }

    fn draw(&self, number: usize) -> Draw {
        let block = &self.blocks.blocks[number];
        let (level, joined) = self.levels.of(&self.blocks, number);
        let first = block.area.first.row as u64 * self.columns as u64 + block.area.first.column as u64;
        let base_vertex = i32::try_from(first).expect("a base vertex is below 2^31");
        let tag = PatchTag { patch: number as u32, level: level as u32 };
        Draw::baked(self.lists.range(block.shape, level, joined), base_vertex, tag)
    }
}

impl LodMethod for Geomipmap {
    fn name(&self) -> &'static str {
        "geomipmap"
    }

    fn buffers(&self) -> BufferSizes {
        self.sizes
    }

    fn set_culling(&mut self, culling: bool) {
        self.culling = culling;
    }

    fn plan(&mut self, view: &View, plan: &mut FramePlan) {
        plan.clear();
        self.initialise(plan);
        self.levels.choose(&self.blocks, view, self.tolerance_px);
        let start = Instant::now();
        let is_drawn = |number: &usize| !self.culling || view.sees(&self.blocks.blocks[*number].bounds_world);
        plan.draws.extend((0..self.blocks.blocks.len()).filter(is_drawn).map(|number| self.draw(number)));
        plan.cull = StageTime(start.elapsed());
    }
}
