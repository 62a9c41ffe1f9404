//! Heights that a method brings along, for DEMs of which only a part is in memory: square tiles around the eye at full
//! resolution, and a coarse grid of the whole DEM.
//!
//! ```text
//!  | coarse grid: every step-th sample, row by row | tile 0 | tile 1 | ... |      tile: (side + 1) x (side + 1) codes,
//!                                                                               both rims included, row by row
//! ```
//!
//! A tile belongs to a cell of `side` x `side` sample intervals. Cell (column, row) has the tile
//! `row % window * window + column % window`: as the window moves, a cell that enters takes the tile of one that left,
//! and nothing else moves.

use crate::{LocalVertex, PatchInstance, PatchTag, Sample};

/// How a height is kept in a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeightFormat {
    /// The height itself, in metres.
    F32,
    /// A code: the height is `offset_m + code * scale_m`, computed in f64 and rounded once.
    U16 {
        /// Metres of one step.
        scale_m: f64,
        /// Metres at code 0.
        offset_m: f64,
    },
}

impl HeightFormat {
    /// Bytes of one height.
    pub fn bytes(self) -> u64 {
        match self {
            Self::F32 => 4,
            Self::U16 { .. } => 2,
        }
    }

    /// The height in metres that a code stands for: 4 bytes of an f32, or 2 of a u16, little-endian.
    pub fn decode(self, code: &[u8]) -> f32 {
        match self {
            Self::F32 => f32::from_le_bytes(code.try_into().expect("4 bytes")),
            Self::U16 { scale_m, offset_m } => {
                let code = u16::from_le_bytes(code.try_into().expect("2 bytes"));
                (offset_m + code as f64 * scale_m) as f32
            }
        }
    }
}

/// Where the height of a vertex lies in the heights that its plans upload.
/// `shaders/terrain.wgsl` computes the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightTiles {
    /// How a height is kept.
    pub format: HeightFormat,
    /// Columns and rows of the DEM.
    pub samples: [u32; 2],
    /// Patches of this level and above read the coarse grid, those below the tiles.
    pub coarse_level: u32,
    /// Sample intervals between neighbours in the coarse grid, whose last column and row are the DEM's.
    pub coarse_step: u32,
    /// Sample intervals along a cell.
    pub cell_side: u32,
    /// Cells along the window.
    pub window: u32,
}

impl HeightTiles {
    /// Columns and rows of the coarse grid.
    pub fn coarse_size(&self) -> [u32; 2] {
        self.samples.map(|samples| (samples - 1).div_ceil(self.coarse_step) + 1)
    }

    /// Codes of the coarse grid, rounded up to a multiple of 4 bytes: where the tiles begin.
    pub fn coarse_codes(&self) -> u64 {
        let [columns, rows] = self.coarse_size();
        (columns as u64 * rows as u64).next_multiple_of(2)
    }

    /// Codes of a tile, rounded up to a multiple of 4 bytes.
    pub fn tile_codes(&self) -> u64 {
        let side = self.cell_side as u64 + 1;
        (side * side).next_multiple_of(2)
    }

    /// The first code of a cell's tile.
    pub fn tile(&self, cell: [u32; 2]) -> u64 {
        let [column, row] = cell.map(|at| (at % self.window) as u64);
        self.coarse_codes() + (row * self.window as u64 + column) * self.tile_codes()
    }

    /// Bytes of the whole buffer.
    pub fn bytes(&self) -> u64 {
        (self.coarse_codes() + self.window as u64 * self.window as u64 * self.tile_codes()) * self.format.bytes()
    }

    /// The cell that a patch lies in.
    pub fn cell_of(&self, instance: &PatchInstance) -> [u32; 2] {
        // Legs that point to the west or north begin at the far corner, which may be the next cell's.
        let turned = (instance.leg_v[0] < 0) as i32;
        instance.origin.map(|at| ((at - turned) as u32) / self.cell_side)
    }

    /// The code of a vertex's height, by its position in the buffer.
    pub fn code_of(&self, instance: &PatchInstance, vertex: LocalVertex) -> u64 {
        let Sample { column, row } = instance.sample(vertex, self.samples[0], self.samples[1]);
        if PatchTag::from_instance(instance.tag).level >= self.coarse_level {
            let [column, row] = [column, row].map(|at| at.div_ceil(self.coarse_step) as u64);
            return row * self.coarse_size()[0] as u64 + column;
        }
        let cell = self.cell_of(instance);
        let [column, row] = [column - cell[0] * self.cell_side, row - cell[1] * self.cell_side].map(u64::from);
        self.tile(cell) + row * (self.cell_side as u64 + 1) + column
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILES: HeightTiles = HeightTiles {
        format: HeightFormat::U16 { scale_m: 0.1, offset_m: -5.0 },
        samples: [50, 41],
        coarse_level: 1,
        coarse_step: 3,
        cell_side: 9,
        window: 2,
    };

    #[test]
    fn every_sample_of_a_cell_has_its_own_code_in_the_tile_of_the_cell() {
        let (first, end) = (TILES.tile([3, 2]), TILES.tile([3, 2]) + TILES.tile_codes());
        let level_0 = PatchTag { patch: 0, level: 0 }.to_instance();
        let north_west = PatchInstance { origin: [27, 18], leg_u: [0, 1], leg_v: [1, 0], tag: level_0 };
        let south_east = PatchInstance { origin: [36, 27], leg_u: [0, -1], leg_v: [-1, 0], tag: level_0 };
        for uv in (0..10).flat_map(|u| (0..10).map(move |v| [u, v])) {
            let code = TILES.code_of(&north_west, LocalVertex { uv });
            assert_eq!(code, TILES.code_of(&south_east, LocalVertex { uv: uv.map(|at| 9 - at) }));
            assert_eq!(code, first + 10 * uv[0] as u64 + uv[1] as u64);
            assert!(code < end);
        }
        assert_eq!(TILES.tile([1, 0]), TILES.tile([3, 2]), "the tile of the cell two to the west and north");
        assert_eq!(TILES.bytes(), 2 * (TILES.coarse_codes() + 4 * TILES.tile_codes()));
    }

    #[test]
    fn coarse_patches_read_the_coarse_grid_which_ends_on_the_rim() {
        let tag = PatchTag { patch: 0, level: 1 }.to_instance();
        let patch = PatchInstance { origin: [45, 36], leg_u: [0, 3], leg_v: [3, 0], tag };
        assert_eq!(TILES.coarse_size(), [18, 15]);
        assert_eq!(TILES.code_of(&patch, LocalVertex { uv: [0, 0] }), 12 * 18 + 15);
        assert_eq!(TILES.code_of(&patch, LocalVertex { uv: [3, 3] }), 14 * 18 + 17, "clamped to sample (49, 40)");
    }

    #[test]
    fn codes_become_heights() {
        assert_eq!(TILES.format.decode(&[0x2c, 0x01]), 25.0);
        assert_eq!(HeightFormat::F32.decode(&1.5_f32.to_le_bytes()), 1.5);
    }
}
