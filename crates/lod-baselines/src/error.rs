//! Settings that no method can work with.

use terrain_core::Heightmap;

/// A setting out of its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BaselineError {
    /// The step of [`Decimated`](crate::Decimated) is 0, or longer than any DEM.
    #[error("step of {0}: expected 1 to {max}", max = Heightmap::MAX_SIDE)]
    Step(u32),
    /// The tolerance is no positive number.
    #[error("tolerance of {0} px: expected a finite number above 0")]
    Tolerance(f64),
}

/// Refuses a tolerance in pixels that is not finite or not above 0.
pub(crate) fn check_tolerance(tolerance_px: f64) -> Result<(), BaselineError> {
    let usable = tolerance_px > 0.0 && tolerance_px.is_finite();
    if usable { Ok(()) } else { Err(BaselineError::Tolerance(tolerance_px)) }
}
