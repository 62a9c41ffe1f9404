//! Vertices as published: every patch of every layer has its own. The buffer consists of equal slots, one a cell, so
//! that a cell is one transfer: the paper's vertex-buffer merger (section 3, phase 5). The order in a slot is that of
//! `cell_layout`, with 10 vertices a patch for k = 3.

use crate::blocks::{local_vertices, vertices_per_patch};
use crate::cell_layout::CellLayout;
use crate::grid::{Grid, Patch, Square};
use crate::options::HtpError;
use std::sync::Arc;
use terrain_core::{BakedVertex, Buffer, FramePlan, Heightmap, LocalVertex};

pub(crate) struct CellVertices {
    heightmap: Arc<Heightmap>,
    local: Vec<LocalVertex>,
    layout: CellLayout,
    /// Cells whose vertices are still to be sent.
    entering: Vec<Square>,
    /// Vertices of one cell, on their way to the plan.
    merged: Vec<BakedVertex>,
}

impl CellVertices {
    pub fn new(heightmap: Arc<Heightmap>, grid: &Grid) -> Result<Self, HtpError> {
        let entering: Vec<Square> = grid.squares(grid.top()).collect();
        let layout = CellLayout::new(grid);
        check_patches(grid.k, layout.patches * entering.len() as u64)?;
        Ok(Self { heightmap, local: local_vertices(grid.k), layout, entering, merged: Vec::new() })
    }

    /// Bytes of the vertex buffer.
    pub fn bytes(&self, grid: &Grid) -> u64 {
        grid.squares(grid.top()).count() as u64 * self.slot_bytes()
    }

    fn slot_bytes(&self) -> u64 {
        self.layout.patches * (self.local.len() * size_of::<BakedVertex>()) as u64
    }

    /// Each entering cell is one transfer.
    pub fn merge(&mut self, grid: &Grid, plan: &mut FramePlan) {
        for cell in std::mem::take(&mut self.entering) {
            self.merged.clear();
            for patch in self.layout.patches_of(cell) {
                self.merged.extend(baked(&self.heightmap, &self.local, grid, patch));
            }
            plan.upload(Buffer::Vertices, grid.index(cell) as u64 * self.slot_bytes(), &self.merged);
        }
    }

    /// Where the vertices of a patch begin.
    pub fn base_vertex(&self, grid: &Grid, patch: Patch) -> u32 {
        self.layout.patch_number(grid, patch) as u32 * self.local.len() as u32
    }
}

/// `base_vertex` is a signed 32-bit number.
fn check_patches(k: u32, patches: u64) -> Result<(), HtpError> {
    let limit = i32::MAX as u64 / vertices_per_patch(k) as u64;
    if patches > limit { Err(HtpError::Patches { patches, limit }) } else { Ok(()) }
}

/// The vertices of one patch.
fn baked(heightmap: &Heightmap, local: &[LocalVertex], grid: &Grid, patch: Patch) -> impl Iterator<Item = BakedVertex> {
    let instance = grid.instance(patch);
    let sample = move |vertex: &LocalVertex| instance.sample(*vertex, heightmap.columns(), heightmap.rows());
    local.iter().map(move |vertex| BakedVertex::of(heightmap, sample(vertex)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_do_not_fit_are_refused() {
        assert_eq!(check_patches(2, 357_913_941), Ok(()));
        let error = check_patches(2, 357_913_942).unwrap_err().to_string();
        let expected = "357913942 patches with vertices of their own: expected at most 357913941; use instances";
        assert_eq!(error, expected);
        assert_eq!(check_patches(255, 65_281), Err(HtpError::Patches { patches: 65_281, limit: 65_280 }));
    }
}
