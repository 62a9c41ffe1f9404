//! Heights that a method brings along, for DEMs of which only a part is in memory: square tiles around the eye at full
//! resolution, and a coarse grid of the whole DEM.
//!
//! ```text
//!  | coarse grid: every k^n-th sample, row by row | tiles of level 0 | ... | tiles of level n - 1 |
//!
//!  a tile of level m: (side / k^m + 1) x (side / k^m + 1) codes, both rims included, row by row
//! ```
//!
//! A tile belongs to a cell of `side` x `side` sample intervals, and to a level: every `k^m`-th sample is all that patches
//! of level `m` need. Each level has a window of its own, in which cell (column, row) has the tile
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
    /// Each level needs every `k`-th sample of the next finer one.
    pub k: u32,
    /// Patches of this level and above read the coarse grid, those below the tiles of their level.
    pub coarse_level: u32,
    /// Sample intervals along a cell.
    pub cell_side: u32,
    /// By level: cells along its window; 0 from `coarse_level` on.
    pub windows: [u32; Self::MAX_LEVELS],
}

impl HeightTiles {
    /// Levels that tiles can be for.
    pub const MAX_LEVELS: usize = 6;

    /// Sample intervals between neighbours in the tiles of a level. The last column and row are the DEM's.
    pub fn step(&self, level: u32) -> u32 {
        self.k.pow(level)
    }

    /// Sample intervals between neighbours in the coarse grid, whose last column and row are the DEM's.
    pub fn coarse_step(&self) -> u32 {
        self.step(self.coarse_level)
    }

    /// Columns and rows of the coarse grid.
    pub fn coarse_size(&self) -> [u32; 2] {
        self.samples.map(|samples| (samples - 1).div_ceil(self.coarse_step()) + 1)
    }

    /// Codes of the coarse grid, rounded up to a multiple of 4 bytes: where the tiles begin.
    pub fn coarse_codes(&self) -> u64 {
        let [columns, rows] = self.coarse_size();
        (columns as u64 * rows as u64).next_multiple_of(2)
    }

    /// Codes along a tile.
    fn tile_side(&self, level: u32) -> u64 {
        (self.cell_side / self.step(level)) as u64 + 1
    }

    /// Codes of a tile, rounded up to a multiple of 4 bytes.
    pub fn tile_codes(&self, level: u32) -> u64 {
        self.tile_side(level).pow(2).next_multiple_of(2)
    }

    /// The first code of a level's tiles: that after the last one of the next finer level's.
    pub fn first_tile(&self, level: u32) -> u64 {
        let codes = |level: u32| (self.windows[level as usize] as u64).pow(2) * self.tile_codes(level);
        self.coarse_codes() + (0..level).map(codes).sum::<u64>()
    }

    /// The first code of a cell's tile for a level.
    pub fn tile(&self, level: u32, cell: [u32; 2]) -> u64 {
        let window = self.windows[level as usize];
        let [column, row] = cell.map(|at| (at % window) as u64);
        self.first_tile(level) + (row * window as u64 + column) * self.tile_codes(level)
    }

    /// Bytes of the whole buffer.
    pub fn bytes(&self) -> u64 {
        self.first_tile(self.coarse_level) * self.format.bytes()
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
        let level = PatchTag::from_instance(instance.tag).level;
        if level >= self.coarse_level {
            let [column, row] = [column, row].map(|at| at.div_ceil(self.coarse_step()) as u64);
            return row * self.coarse_size()[0] as u64 + column;
        }
        let cell = self.cell_of(instance);
        let inside = [column - cell[0] * self.cell_side, row - cell[1] * self.cell_side];
        let [column, row] = inside.map(|at| at.div_ceil(self.step(level)) as u64);
        self.tile(level, cell) + row * self.tile_side(level) + column
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TILES: HeightTiles = HeightTiles {
        format: HeightFormat::U16 { scale_m: 0.1, offset_m: -5.0 },
        samples: [50, 41],
        k: 3,
        coarse_level: 2,
        cell_side: 27,
        windows: [2, 3, 0, 0, 0, 0],
    };

    /// Two patches that fill a cell, which lies inside the DEM.
    fn halves(tiles: &HeightTiles, level: u32, cell: [u32; 2]) -> [PatchInstance; 2] {
        let (tag, step) = (PatchTag { patch: 0, level }.to_instance(), tiles.step(level) as i16);
        let corner = |at: u32| cell.map(|cell| ((cell + at) * tiles.cell_side) as i32);
        [(0, step), (1, -step)].map(|(at, step)| PatchInstance {
            origin: corner(at),
            leg_u: [0, step],
            leg_v: [step, 0],
            tag,
        })
    }

    #[test]
    fn every_sample_of_a_cell_has_its_own_code_in_the_tile_of_its_level() {
        let tiles = HeightTiles { samples: [500, 500], ..TILES };
        for (level, along) in [(0, 28), (1, 10)] {
            let (first, end) = (tiles.tile(level, [4, 5]), tiles.tile(level, [4, 5]) + tiles.tile_codes(level));
            let [north_west, south_east] = halves(&tiles, level, [4, 5]);
            for uv in (0..along).flat_map(|u| (0..along).map(move |v| [u, v])) {
                let code = tiles.code_of(&north_west, LocalVertex { uv });
                assert_eq!(code, tiles.code_of(&south_east, LocalVertex { uv: uv.map(|at| along - 1 - at) }));
                assert_eq!(code, first + along as u64 * uv[0] as u64 + uv[1] as u64);
                assert!(code < end);
            }
        }
    }

    #[test]
    fn each_level_has_its_own_window() {
        assert_eq!((TILES.tile_codes(0), TILES.tile_codes(1)), (28 * 28, 10 * 10));
        assert_eq!(TILES.tile(0, [1, 0]), TILES.tile(0, [3, 2]), "the tile of the cell two to the west and north");
        assert_eq!(TILES.tile(1, [1, 0]), TILES.tile(1, [4, 3]), "three, in the wider window");
        assert_eq!(TILES.tile(1, [0, 0]), TILES.coarse_codes() + 4 * TILES.tile_codes(0));
        assert_eq!(TILES.bytes(), 2 * (TILES.tile(1, [0, 0]) + 9 * TILES.tile_codes(1)));
    }

    #[test]
    fn coarser_patches_end_on_the_rim_in_the_coarse_grid_and_in_tiles() {
        let patch = |level, leg: i16| {
            let tag = PatchTag { patch: 0, level }.to_instance();
            PatchInstance { origin: [45, 36], leg_u: [0, leg], leg_v: [leg, 0], tag }
        };
        assert_eq!(TILES.coarse_size(), [7, 6]);
        assert_eq!(TILES.code_of(&patch(2, 9), LocalVertex { uv: [0, 0] }), 4 * 7 + 5);
        assert_eq!(TILES.code_of(&patch(2, 9), LocalVertex { uv: [3, 3] }), 5 * 7 + 6, "clamped to sample (49, 40)");
        // Cell (1, 1) begins at sample (27, 27); (49, 40) lies between the level's samples.
        let clamped = TILES.code_of(&patch(1, 3), LocalVertex { uv: [3, 3] });
        assert_eq!(clamped, TILES.tile(1, [1, 1]) + 5 * 10 + 8);
    }

    #[test]
    fn codes_become_heights() {
        assert_eq!(TILES.format.decode(&[0x2c, 0x01]), 25.0);
        assert_eq!(HeightFormat::F32.decode(&1.5_f32.to_le_bytes()), 1.5);
    }
}
