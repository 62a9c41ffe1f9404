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
    /// The distance of [`Greedy`](crate::Greedy) is no positive number.
    #[error("distance of {0} m: expected a finite number above 0")]
    Distance(f64),
    /// The DEM is too large for [`Greedy`](crate::Greedy).
    #[error("{0} samples along a side: greedy insertion takes at most {max}", max = crate::GreedyInsertion::MAX_SIDE)]
    Side(u32),
}

/// Refuses a tolerance in pixels that is not finite or not above 0.
pub(crate) fn check_tolerance(tolerance_px: f64) -> Result<(), BaselineError> {
    let usable = tolerance_px > 0.0 && tolerance_px.is_finite();
    if usable { Ok(()) } else { Err(BaselineError::Tolerance(tolerance_px)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unusable_tolerances_are_refused_in_one_line() {
        assert_eq!(check_tolerance(0.5), Ok(()));
        for tolerance_px in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let refused = check_tolerance(tolerance_px).unwrap_err().to_string();
            assert_eq!(refused, format!("tolerance of {tolerance_px} px: expected a finite number above 0"));
        }
    }
}
