//! Which cells a method has loaded, for the map: read off the heights that its plans upload, so that no method has to tell.

use terrain_core::{Buffer, FramePlan, HeightTiles};

/// The cells whose tiles are on the GPU, by level, the finest first.
pub struct LoadedCells {
    tiles: HeightTiles,
    /// By level and by the place of a tile: the cell that has it.
    holders: Vec<Vec<Option<[u32; 2]>>>,
    /// By level: the first cell of its window in the last plan.
    first_cells: [[u32; 2]; HeightTiles::MAX_LEVELS],
}

impl LoadedCells {
    /// Nothing is loaded yet.
    pub fn new(tiles: HeightTiles) -> Self {
        let places = tiles.windows[..tiles.coarse_level as usize].iter().map(|side| vec![None; side.pow(2) as usize]);
        Self { holders: places.collect(), tiles, first_cells: [[0; 2]; HeightTiles::MAX_LEVELS] }
    }

    /// Takes note of a plan. Every plan must be told, in order.
    pub fn follow(&mut self, plan: &FramePlan) {
        if self.first_cells != plan.streaming.first_cells {
            self.first_cells = plan.streaming.first_cells;
            self.forget_what_left();
        }
        for upload in plan.uploads.iter().filter(|upload| upload.buffer == Buffer::Heights) {
            if let Some((level, place)) = self.place(upload.offset / self.tiles.format.bytes()) {
                self.holders[level][place] = Some(self.cell_at(level, place as u32));
            }
        }
    }

    pub fn of_level(&self, level: usize) -> impl Iterator<Item = [u32; 2]> {
        self.holders[level].iter().flatten().copied()
    }

    /// A cell that comes back is loaded anew.
    fn forget_what_left(&mut self) {
        for (level, holders) in self.holders.iter_mut().enumerate() {
            let (side, first) = (self.tiles.windows[level], self.first_cells[level]);
            let is_inside =
                |cell: &[u32; 2]| (0..2).all(|axis| (first[axis]..first[axis] + side).contains(&cell[axis]));
            holders.iter_mut().for_each(|holder| *holder = holder.filter(is_inside));
        }
    }

    /// The level and the place of a tile that begins with this code; `None` for the coarse grid.
    fn place(&self, code: u64) -> Option<(usize, usize)> {
        let level = (0..self.tiles.coarse_level).rev().find(|level| code >= self.tiles.first_tile(*level))?;
        Some((level as usize, ((code - self.tiles.first_tile(level)) / self.tiles.tile_codes(level)) as usize))
    }

    /// The one cell of the window whose tile belongs there: a window is a torus.
    fn cell_at(&self, level: usize, place: u32) -> [u32; 2] {
        let (side, first) = (self.tiles.windows[level], self.first_cells[level]);
        let at = [place % side, place / side];
        std::array::from_fn(|axis| first[axis] + (at[axis] + side - first[axis] % side) % side)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use terrain_dem::ReadOptions;

    use super::*;
    use crate::camera::{Motion, Rig};
    use crate::pane::Ground;
    use crate::run_text;

    /// The method counts what it loads and unloads; the uploads must tell the same, also after cells have left and come back.
    #[test]
    fn uploads_tell_which_cells_are_loaded() {
        let spec = "synthetic:1025x1025:3";
        let ground = Arc::new(Ground::new(spec.into(), terrain_lod::open_dem(spec, &ReadOptions::default()).unwrap()));
        let run = run_text::parse("htp-instanced window_mib=4 layers=3 loading=blocking").unwrap();
        let mut method = ground.build(&run).unwrap();
        let mut loaded = LoadedCells::new(method.buffers().heights.unwrap());
        let (mut rig, mut plan) = (Rig::over(&ground.dem.heightmap), FramePlan::default());
        let count =
            |loaded: &LoadedCells| (0..loaded.holders.len()).map(|level| loaded.of_level(level).count()).sum::<usize>();
        let mut counts = std::collections::BTreeSet::new();
        for step in 0..40 {
            let forward = if step < 20 { 1.0 } else { -1.0 };
            rig.fly(&ground.dem.heightmap, &Motion { forward, ..Default::default() }, 2.0);
            // What leaves is given away by the next plan.
            for _ in 0..2 {
                method.plan(&rig.view([640, 360]).unwrap(), &mut plan);
                loaded.follow(&plan);
            }
            let streaming = &plan.streaming;
            assert_eq!(count(&loaded) as u64, streaming.cells_loaded - streaming.cells_unloaded, "step {step}");
            counts.insert(streaming.cells_unloaded);
        }
        assert!(counts.len() > 2, "{counts:?}: too little has moved");
    }
}
