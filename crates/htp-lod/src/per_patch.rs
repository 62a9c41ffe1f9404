//! As published: every patch of every layer has vertices of its own, and every visible patch is one draw.
//!
//! The vertex buffer consists of equal slots, one a cell. A slot holds the patches of all layers of its cell, so that
//! a cell is one transfer: the paper's vertex-buffer merger (section 3, phase 5).
//!
//! ```text
//!  | cell 0                                            | cell 1 ...
//!  | level 0                 | level 1      | level 2  |
//!  | NW SE | NW SE | NW SE ..| NW SE | NW ..| NW SE    |    square by square, row by row
//!    10 vertices each, for k = 3
//! ```
//!
//! `base_vertex` picks the patch, the range of indices its matching block (phase 6). In a cell at the DEM's rim,
//! squares that do not exist keep their room, so that all slots are equal; only a DEM that is narrower than a cell
//! has narrower slots.

use crate::blocks::{Blocks, local_vertices, vertices_per_patch};
use crate::grid::{Grid, Half, Patch, Square};
use crate::leaves::Leaf;
use crate::options::HtpError;
use std::sync::Arc;
use terrain_core::{BakedVertex, Buffer, Draw, FramePlan, Heightmap, LocalVertex, PatchTag};

pub(crate) struct PerPatch {
    heightmap: Arc<Heightmap>,
    local: Vec<LocalVertex>,
    slot: Slot,
    /// Cells whose vertices are still to be sent.
    entering: Vec<Square>,
    /// Vertices of one cell, on their way to the plan.
    merged: Vec<BakedVertex>,
}

impl PerPatch {
    pub fn new(heightmap: Arc<Heightmap>, grid: &Grid) -> Result<Self, HtpError> {
        let entering: Vec<Square> = grid.squares(grid.top()).collect();
        let slot = Slot::new(grid);
        check_patches(grid.k, slot.patches * entering.len() as u64)?;
        Ok(Self { heightmap, local: local_vertices(grid.k), slot, entering, merged: Vec::new() })
    }

    /// Bytes of the vertex buffer.
    pub fn vertex_bytes(&self, grid: &Grid) -> u64 {
        grid.squares(grid.top()).count() as u64 * self.slot_bytes()
    }

    fn slot_bytes(&self) -> u64 {
        self.slot.patches * (self.local.len() * size_of::<BakedVertex>()) as u64
    }

    /// Phase 5, vertex-buffer merger: each entering cell is one transfer.
    pub fn merge_vertex_buffers(&mut self, grid: &Grid, plan: &mut FramePlan) {
        for cell in std::mem::take(&mut self.entering) {
            self.merge_cell(grid, cell);
            plan.upload(Buffer::Vertices, grid.index(cell) as u64 * self.slot_bytes(), &self.merged);
        }
    }

    fn merge_cell(&mut self, grid: &Grid, cell: Square) {
        self.merged.clear();
        for (level, layer) in self.slot.layers.iter().enumerate() {
            for square in layer.squares(level as u32, cell) {
                for half in Half::BOTH {
                    self.merged.extend(baked(&self.heightmap, &self.local, grid, square.half(half)));
                }
            }
        }
    }

    /// Phase 6, rendering: each patch with its plain list or its matching block.
    pub fn draw(&self, grid: &Grid, blocks: &Blocks, leaves: &[Leaf], plan: &mut FramePlan) {
        for Leaf { patch, mask } in leaves {
            let base_vertex = (self.slot.patch_number(grid, *patch) as usize * self.local.len()) as i32;
            let tag = self.slot.tag(grid, *patch);
            plan.draws.push(Draw::baked(blocks.ranges[*mask as usize].clone(), base_vertex, tag));
        }
    }
}

/// A patch's tag has 27 bits for its number.
const MAX_PATCHES: u64 = 1 << 27;

/// `base_vertex` is a signed 32-bit number, and a patch's tag is short.
fn check_patches(k: u32, patches: u64) -> Result<(), HtpError> {
    let limit = (i32::MAX as u64 / vertices_per_patch(k) as u64).min(MAX_PATCHES);
    if patches > limit { Err(HtpError::Patches { patches, limit }) } else { Ok(()) }
}

/// The vertices of one patch.
fn baked(heightmap: &Heightmap, local: &[LocalVertex], grid: &Grid, patch: Patch) -> impl Iterator<Item = BakedVertex> {
    let instance = grid.instance(patch);
    let sample = move |vertex: &LocalVertex| instance.sample(*vertex, heightmap.columns(), heightmap.rows());
    local.iter().map(move |vertex| BakedVertex::of(heightmap, sample(vertex)))
}

/// The order of the patches in a cell's slot, and with it the numbers of all patches.
pub(crate) struct Slot {
    /// By level.
    layers: Vec<SlotLayer>,
    /// Patches in a slot.
    patches: u64,
}

struct SlotLayer {
    /// Squares along one side of a cell.
    squares_per_cell: u32,
    /// Columns and rows of squares with room in the slot.
    size: [u32; 2],
    /// Number of the level's first patch in the slot.
    first_patch: u64,
}

impl SlotLayer {
    /// The squares with room in the slot of a cell, row by row.
    fn squares(&self, level: u32, cell: Square) -> impl Iterator<Item = Square> + use<> {
        let [columns, rows] = self.size;
        let first = [cell.column, cell.row].map(|at| at * self.squares_per_cell);
        let square =
            move |place: u32| Square { level, column: first[0] + place % columns, row: first[1] + place / columns };
        (0..columns * rows).map(square)
    }
}

impl Slot {
    pub fn new(grid: &Grid) -> Self {
        let mut slot = Self { layers: Vec::new(), patches: 0 };
        for (level, layer) in grid.layers.iter().enumerate() {
            let squares_per_cell = grid.k.pow(grid.top() - level as u32);
            let size = layer.size.map(|squares| squares.min(squares_per_cell));
            slot.layers.push(SlotLayer { squares_per_cell, size, first_patch: slot.patches });
            slot.patches += 2 * size[0] as u64 * size[1] as u64;
        }
        slot
    }

    /// Running number of a patch over all slots.
    fn patch_number(&self, grid: &Grid, patch: Patch) -> u64 {
        let Square { level, column, row } = patch.square;
        let SlotLayer { squares_per_cell: side, size, first_patch } = self.layers[level as usize];
        let cell = Square { level: grid.top(), column: column / side, row: row / side };
        let place = row % side * size[0] + column % side;
        grid.index(cell) as u64 * self.patches + first_patch + 2 * place as u64 + patch.half as u64
    }

    /// What both batchings say of a patch, in every view. Patches without vertices of their own may be so many that
    /// their numbers begin again.
    pub fn tag(&self, grid: &Grid, patch: Patch) -> PatchTag {
        PatchTag { patch: (self.patch_number(grid, patch) % MAX_PATCHES) as u32, level: patch.square.level }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use std::collections::BTreeSet;

    #[test]
    fn numbers_that_do_not_fit_are_refused() {
        assert_eq!(check_patches(2, 1 << 27), Ok(()));
        let error = check_patches(2, (1 << 27) + 1).unwrap_err().to_string();
        let expected = "134217729 patches with vertices of their own: expected at most 134217728; use instances";
        assert_eq!(error, expected);
        assert_eq!(check_patches(255, 65_281), Err(HtpError::Patches { patches: 65_281, limit: 65_280 }));
    }

    #[test]
    fn every_patch_has_its_own_number() {
        for (columns, rows, k) in [(60, 31, 3), (5, 200, 2), (3, 3, 7)] {
            let heights = vec![0.0; (columns * rows) as usize];
            let heightmap = Heightmap::new(columns, rows, [1.0; 2], heights).unwrap();
            let grid = Grid::new(&heightmap, &Options { k, ..Options::default() });
            let slot = Slot::new(&grid);
            let squares = || (0..=grid.top()).flat_map(|level| grid.squares(level));
            let number = |square: Square| Half::BOTH.map(|half| slot.patch_number(&grid, square.half(half)));
            let numbers: BTreeSet<u64> = squares().flat_map(number).collect();
            assert_eq!(numbers.len(), 2 * squares().count());
            let room = grid.squares(grid.top()).count() as u64 * slot.patches;
            assert!(numbers.iter().all(|number| *number < room));
        }
    }
}
