//! Uniform decimation: every n-th column and row, every frame, one draw.
//!
//! The last column and row are always kept, so that the outline is the DEM's whatever the step:
//!
//! ```text
//!   step 2 over 6 x 4 samples      o a vertex, . a sample that is left out
//!
//!   o-.-o-.-o-o
//!   . . . . . .
//!   o-.-o-.-o-o
//!   o-.-o-.-o-o     the last column and row follow at what distance is left
//! ```
//!
//! It stands for what anyone does first who finds a DEM too large, and is the full grid in all but the step: static,
//! one draw, nothing culled, no work on the CPU. Blocks would let it cull, but then two things would differ from the
//! full grid, and the cost of one draw is what decimation has to offer. What a coarser DEM costs elsewhere, in error,
//! the bench measures against all samples of the original.

use terrain_core::{BufferSizes, FramePlan, Heightmap, LodMethod, View};

use crate::error::BaselineError;
use crate::static_grid::StaticGrid;

/// A DEM with fewer rows and columns: static vertices, static indices, nothing culled.
pub struct Decimated(StaticGrid);

impl Decimated {
    /// Keeps every `step`-th column and row (1 to [`Heightmap::MAX_SIDE`]; 1 keeps all), and the last of each.
    pub fn new(heightmap: &Heightmap, step: u32) -> Result<Self, BaselineError> {
        if !(1..=Heightmap::MAX_SIDE).contains(&step) {
            return Err(BaselineError::Step(step));
        }
        let [columns, rows] = [heightmap.columns(), heightmap.rows()].map(|side| kept(side, step));
        Ok(Self(StaticGrid::new(heightmap, &columns, &rows)))
    }
}

/// The columns of `side` columns that are kept.
fn kept(side: u32, step: u32) -> Vec<u32> {
    let last = side - 1;
    (0..last).step_by(step as usize).chain([last]).collect()
}

impl LodMethod for Decimated {
    fn name(&self) -> &'static str {
        "decimated"
    }

    fn buffers(&self) -> BufferSizes {
        self.0.buffers()
    }

    fn set_culling(&mut self, _culling: bool) {
        // One draw: all or nothing.
    }

    fn plan(&mut self, _view: &View, plan: &mut FramePlan) {
        self.0.plan(plan);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_column_is_kept_once() {
        assert_eq!(kept(6, 2), [0, 2, 4, 5]);
        assert_eq!(kept(5, 2), [0, 2, 4]);
        assert_eq!(kept(5, 1), [0, 1, 2, 3, 4]);
        assert_eq!(kept(2, 8), [0, 1]);
    }

    #[test]
    fn unusable_steps_are_refused() {
        let dem = Heightmap::new(2, 2, [1.0; 2], vec![0.0; 4]).unwrap();
        for step in [0, Heightmap::MAX_SIDE + 1] {
            let refused = Decimated::new(&dem, step).err().map(|error| error.to_string());
            assert_eq!(refused, Some(format!("step of {step}: expected 1 to 65535")));
        }
    }
}
