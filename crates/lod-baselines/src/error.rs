//! Settings that no method can work with.

use terrain_core::Heightmap;

/// A setting out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BaselineError {
    /// The step of [`Decimated`](crate::Decimated) is 0, or longer than any DEM.
    #[error("step of {0}: expected 1 to {max}", max = Heightmap::MAX_SIDE)]
    Step(u32),
}
