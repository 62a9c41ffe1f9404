//! One draw a cell: the patches of a cell merged into one index list.
//!
//! Deviation: the paper draws one patch at a time. Its cells are the units of loading and of transfer; here they are
//! those of drawing and culling, too. A visible cell's list is written when levels in the cell or beyond its sides have
//! changed since it was written last. It holds all patches of the cell, those out of sight among them, so that turning
//! the camera writes no list twice.

use crate::blocks::Blocks;
use crate::cell_vertices::CellVertices;
use crate::grid::{Grid, Square, TAG_NUMBERS};
use crate::leaves::{self, Leaf};
use crate::levels::Levels;
use crate::rooms::Rooms;
use crate::sight::Culling;
use std::ops::Range;
use terrain_core::{Buffer, Draw, FramePlan, Growth, PatchTag};

pub(crate) struct MergedCell {
    /// Row by row.
    cells: Vec<Cell>,
    rooms: Rooms,
    /// Bytes of the index buffer.
    bytes: u64,
    visible: Vec<Square>,
    /// Of one cell, on their way to the plan.
    leaves: Vec<Leaf>,
    indices: Vec<u32>,
}

#[derive(Clone, Copy, Default)]
struct Cell {
    /// Indices in its list.
    length: u32,
    /// Whether the list says what is to be drawn.
    is_current: bool,
}

impl MergedCell {
    /// No list is written.
    pub fn new(grid: &Grid) -> Self {
        let cells = vec![Cell::default(); grid.squares(grid.top()).count()];
        Self {
            rooms: Rooms::new(cells.len()),
            cells,
            bytes: size_of::<u32>() as u64,
            visible: Vec::new(),
            leaves: Vec::new(),
            indices: Vec::new(),
        }
    }

    /// Bytes of the index buffer.
    pub fn index_bytes(&self) -> u64 {
        self.bytes
    }

    /// Phase 4, continued: the cells in sight, and the lists that are out of date.
    pub fn select(&mut self, grid: &Grid, levels: &Levels, culling: Culling) {
        for square in levels.changed(grid) {
            self.cells[grid.index(grid.cell_of(square))].is_current = false;
        }
        self.visible.clear();
        culling.cells_in_sight(grid, |cell, culling| {
            self.visible.extend(culling.inside(grid, cell).map(|_| cell.square));
        });
    }

    /// Phase 6: one draw a cell, once its list is up to date: one transfer a cell.
    pub fn draw(
        &mut self,
        grid: &Grid,
        levels: &Levels,
        blocks: &Blocks,
        vertices: &CellVertices,
        plan: &mut FramePlan,
    ) {
        for cell in std::mem::take(&mut self.visible) {
            let number = grid.index(cell);
            if !self.cells[number].is_current {
                self.merge_cell(grid, levels, blocks, vertices, cell);
                self.rooms.reserve(number, self.indices.len() as u32);
                self.cells[number] = Cell { length: self.indices.len() as u32, is_current: true };
                plan.upload(Buffer::Indices, self.rooms.start(number) as u64 * size_of::<u32>() as u64, &self.indices);
            }
            plan.draws.push(self.draw_of(number));
        }
        self.grow(plan);
    }

    /// Collects the index list of a cell.
    fn merge_cell(&mut self, grid: &Grid, levels: &Levels, blocks: &Blocks, vertices: &CellVertices, cell: Square) {
        self.leaves.clear();
        leaves::collect(grid, levels, grid.spot(cell), Culling::OFF, &mut self.leaves);
        self.indices.clear();
        for Leaf { patch, mask } in &self.leaves {
            let Range { start, end } = blocks.ranges[*mask as usize];
            let base_vertex = vertices.base_vertex(grid, *patch);
            self.indices.extend(blocks.indices[start as usize..end as usize].iter().map(|index| base_vertex + index));
        }
    }

    /// Growths are carried out before uploads, wherever they stand in the plan.
    fn grow(&mut self, plan: &mut FramePlan) {
        let needed = self.rooms.end() as u64 * size_of::<u32>() as u64;
        if needed > self.bytes {
            self.bytes = needed;
            plan.growths.push(Growth { buffer: Buffer::Indices, bytes: needed });
        }
    }

    /// Its tag tells cells apart; a cell has patches of many levels.
    fn draw_of(&self, number: usize) -> Draw {
        let start = self.rooms.start(number);
        let tag = PatchTag { patch: number as u32 % TAG_NUMBERS, level: 0 };
        Draw::baked(start..start + self.cells[number].length, 0, tag)
    }
}
