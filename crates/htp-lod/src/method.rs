//! The method: one plan a frame, in the phases of the paper's section 3.

use crate::blocks::{Blocks, local_vertices};
use crate::budget;
use crate::cell_vertices::CellVertices;
use crate::cells::{CellFile, Resident};
use crate::errors::ErrorTable;
use crate::failures::FailedReads;
use crate::geomorph;
use crate::grid::Grid;
use crate::instanced::Instanced;
use crate::levels::Levels;
use crate::merged_cell::MergedCell;
use crate::options::{Batching, HtpError, LevelMetric, Loading, Options};
use crate::per_patch::PerPatch;
use crate::rule::Rule;
use crate::sight::Culling;
use crate::stream::{self, Stream};
use std::sync::Arc;
use std::time::Instant;

use terrain_core::{
    Buffer, BufferSizes, FramePlan, Heightmap, IndexFormat, LocalVertex, LodMethod, StageTime, VertexKind, View,
};

/// Hierarchical triangular patches with their matching blocks.
pub struct Htp {
    options: Options,
    grid: Grid,
    errors: Option<ErrorTable>,
    blocks: Blocks,
    levels: Levels,
    culling: bool,
    rendering: Rendering,
    /// Where not all is in memory.
    stream: Option<Stream>,
    initialised: bool,
}

enum Rendering {
    PerPatch(CellVertices, PerPatch),
    MergedCell(CellVertices, MergedCell),
    Instanced(Box<Instanced>),
}

impl Htp {
    /// Builds the hierarchy over a DEM of any size, and for [`LevelMetric::Error`] measures all patches and blocks, on
    /// the threads of the current rayon pool. The heights are kept for vertices alone, which
    /// [`Batching::Instanced`] does without.
    pub fn new(heightmap: Arc<Heightmap>, options: Options) -> Result<Self, HtpError> {
        options.validate()?;
        let grid = Grid::new(&heightmap, &options);
        let errors = (options.metric == LevelMetric::Error).then(|| ErrorTable::new(&heightmap, &grid));
        let rendering = match options.batching {
            Batching::PerPatch => Rendering::PerPatch(CellVertices::new(heightmap, &grid)?, PerPatch::default()),
            Batching::MergedCell => Rendering::MergedCell(CellVertices::new(heightmap, &grid)?, MergedCell::new(&grid)),
            Batching::Instanced => Rendering::Instanced(Box::new(Instanced::new(&grid))),
        };
        Ok(Self::over(options, grid, errors, rendering, None))
    }

    /// Nothing is drawn yet.
    fn over(
        options: Options,
        grid: Grid,
        errors: Option<ErrorTable>,
        rendering: Rendering,
        stream: Option<Stream>,
    ) -> Self {
        let (blocks, levels) = (Blocks::new(options.k), Levels::new(&grid));
        Self { options, blocks, levels, culling: true, errors, grid, rendering, stream, initialised: false }
    }

    /// The hierarchy over a DEM of which only the coarse levels are in memory; cells are loaded around the eye, as
    /// [`Options::loading`] and [`Options::window_mib`] say. For [`Batching::Instanced`].
    pub fn stream(file: CellFile, resident: Resident, options: Options) -> Result<Self, HtpError> {
        options.validate_streamed()?;
        stream::check(file.header(), &options)?;
        let sides = budget::sides(file.header(), &options)?;
        Self::stream_windows(file, resident, options, &sides)
    }

    /// With so many cells along the window of each streamed level.
    fn stream_windows(file: CellFile, resident: Resident, options: Options, sides: &[u32]) -> Result<Self, HtpError> {
        let (coarse, grid, errors) = stream::tables(file.header(), resident, &options, sides);
        let stream = Stream::new(file, coarse, &options, sides).map_err(|error| HtpError::Thread(error.to_string()))?;
        let rendering = Rendering::Instanced(Box::new(Instanced::new(&grid)));
        Ok(Self::over(options, grid, errors, rendering, Some(stream)))
    }

    /// Bytes of all that is kept of a streamed DEM, those on the GPU included; 0 for one in memory.
    pub fn resident_bytes(&self) -> u64 {
        self.stream.as_ref().map_or(0, Stream::resident_bytes)
    }

    /// Cells along the window of each streamed level, from 0 up; none for a DEM in memory.
    pub fn window_cells(&self) -> Vec<u32> {
        (0..self.grid.window.streamed).map(|level| self.grid.window.side(level)).collect()
    }

    /// Reads of cells that failed.
    pub fn failed_reads(&self) -> FailedReads {
        self.stream.as_ref().map_or_else(FailedReads::default, |stream| stream.failures.reads)
    }

    /// Bytes of the errors that are kept for [`LevelMetric::Error`].
    pub fn error_bytes(&self) -> u64 {
        self.errors.as_ref().map_or(0, ErrorTable::bytes)
    }

    /// Phase 1: what never changes, sent once. The 8 index lists, and the one patch that all instances share.
    ///
    /// Deviation: no threads are created, but the one that reads cells ([`Htp::stream`]). Levels and all else are computed by whoever calls `plan`, and only where the
    /// view has changed them.
    fn initialise(&mut self, plan: &mut FramePlan) {
        if std::mem::replace(&mut self.initialised, true) {
            return;
        }
        if let Some(stream) = &mut self.stream {
            stream.initialise(plan);
        }
        match self.rendering {
            Rendering::PerPatch(..) => plan.upload(Buffer::Indices, 0, &self.blocks.indices),
            Rendering::MergedCell(..) => {}
            Rendering::Instanced(_) => {
                plan.upload(Buffer::Indices, 0, &self.blocks.indices);
                plan.upload(Buffer::Vertices, 0, &local_vertices(self.grid.k));
            }
        }
    }

    /// Phase 2, cell loading: cells that come and go.
    fn load_cells(&mut self, view: &View, plan: &mut FramePlan) {
        let Some(stream) = &mut self.stream else { return };
        if stream.leave(&mut self.grid, &mut self.levels, view) {
            self.compute_levels(view);
            self.select_patches(view);
        }
        let Some(stream) = &mut self.stream else { return };
        if self.options.loading == Loading::Blocking {
            stream.free(&mut self.grid);
        }
        stream.enter(&mut self.grid, self.errors.as_mut(), &mut self.levels, view, plan);
    }

    /// What the plan lacks for want of cells.
    fn report(&self, view: &View, plan: &mut FramePlan) {
        let Some(stream) = &self.stream else { return };
        let rule = Rule::new(&self.options, &self.grid, self.errors.as_ref(), view);
        let mut missing = Vec::new();
        for (square, px) in self.levels.unheld(&rule) {
            plan.unheld_px = plan.unheld_px.max(px);
            missing.extend(rule.sees(square).then(|| self.grid.cell_number(square)));
        }
        missing.sort_unstable();
        missing.dedup();
        plan.streaming = stream.report(&self.grid, missing.len() as u64);
    }

    /// Phase 4: which patches are split.
    fn compute_levels(&mut self, view: &View) {
        let rule = Rule::new(&self.options, &self.grid, self.errors.as_ref(), view);
        self.levels.follow(&rule, view);
    }

    /// Phase 4, continued: the patch and the matching block of each place in sight.
    fn select_patches(&mut self, view: &View) {
        let (grid, levels, culling) =
            (&self.grid, &self.levels, if self.culling { Culling::new(view) } else { Culling::OFF });
        match &mut self.rendering {
            Rendering::PerPatch(_, per_patch) => per_patch.select(grid, levels, culling),
            Rendering::MergedCell(_, merged) => merged.select(grid, levels, culling),
            Rendering::Instanced(instanced) => instanced.select(grid, levels, culling),
        }
    }

    /// Phase 5: the vertices of the cells that enter, one transfer a cell. Instances have no vertices of their own.
    fn merge_vertex_buffers(&mut self, plan: &mut FramePlan) {
        match &mut self.rendering {
            Rendering::PerPatch(vertices, _) | Rendering::MergedCell(vertices, _) => vertices.merge(&self.grid, plan),
            Rendering::Instanced(_) => {}
        }
    }

    /// Phase 6: the plain patch or a matching block.
    fn render(&mut self, plan: &mut FramePlan) {
        let (grid, levels, blocks) = (&self.grid, &self.levels, &self.blocks);
        match &mut self.rendering {
            Rendering::PerPatch(vertices, per_patch) => per_patch.draw(grid, blocks, vertices, plan),
            Rendering::MergedCell(vertices, merged) => merged.draw(grid, levels, blocks, vertices, plan),
            Rendering::Instanced(instanced) => instanced.draw(blocks, plan),
        }
    }

    fn block_bytes(&self) -> u64 {
        size_of_val(self.blocks.indices.as_slice()) as u64
    }
}

impl LodMethod for Htp {
    fn name(&self) -> &'static str {
        "htp"
    }

    fn buffers(&self) -> BufferSizes {
        let cell_side = Some(self.grid.cell_side());
        let baked = |vertices: &CellVertices, indices: u64| BufferSizes {
            vertex_kind: VertexKind::Baked,
            index_format: IndexFormat::U32,
            vertices: vertices.bytes(&self.grid),
            indices,
            instances: 0,
            heights: None,
            cell_side,
        };
        match &self.rendering {
            Rendering::PerPatch(vertices, _) => baked(vertices, self.block_bytes()),
            Rendering::MergedCell(vertices, merged) => baked(vertices, merged.index_bytes()),
            Rendering::Instanced(instanced) => BufferSizes {
                vertex_kind: VertexKind::Displaced,
                index_format: IndexFormat::U32,
                vertices: (local_vertices(self.grid.k).len() * size_of::<LocalVertex>()) as u64,
                indices: self.block_bytes(),
                instances: instanced.bytes(),
                heights: self.stream.as_ref().map(Stream::tiles),
                cell_side,
            },
        }
    }

    fn set_culling(&mut self, culling: bool) {
        self.culling = culling;
    }

    /// The paper's phases. Phase 3, cell binding, is the grid's numbering.
    fn plan(&mut self, view: &View, plan: &mut FramePlan) {
        plan.clear();
        self.initialise(plan); // phase 1
        self.load_cells(view, plan); // phase 2, and of phase 5 the heights of the cells that enter
        self.compute_levels(view); // phase 4
        let start = Instant::now();
        self.select_patches(view);
        plan.cull = StageTime(start.elapsed());
        self.merge_vertex_buffers(plan); // phase 5
        self.render(plan); // phase 6
        plan.morph = self.options.geomorph.then(|| geomorph::morph(&self.options, &self.grid, view));
        self.report(view, plan);
    }

    /// Of cells that cannot be read: a line for each cell, level and kind of failure.
    fn take_messages(&mut self) -> Vec<String> {
        self.stream.as_mut().map_or_else(Vec::new, |stream| stream.failures.take_messages())
    }
}

#[cfg(test)]
mod bound_tests;
#[cfg(test)]
mod closure_tests;
#[cfg(test)]
mod fault_tests;
#[cfg(test)]
mod follow_tests;
#[cfg(test)]
mod glide_tests;
#[cfg(test)]
mod mesh_tests;
#[cfg(test)]
mod stream_tests;
