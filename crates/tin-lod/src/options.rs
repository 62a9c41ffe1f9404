//! What a user may choose.

use crate::triangulate::Triangulator;

/// Options of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Side of a patch in grid intervals: 8, 16, 32 or 64. Default 32, the paper's best (its Table 2).
    pub patch: u32,
    /// The allowed error in pixels ("pixel error" in the paper), above 0. Default 1.
    ///
    /// It steers the selection; it is **not** a bound of the error on the screen.
    pub tolerance_px: f64,
    /// Largest distance between selected samples in grid intervals, 1 to `patch`. Default (`None`) half a patch.
    pub max_spacing: Option<u32>,
    /// What connects the selected samples. Default [`Triangulator::Spade`]. The selection does not depend on it.
    pub triangulator: Triangulator,
    /// Threads that triangulate, 1 or more. Default 1. The result does not depend on it.
    pub threads: usize,
}

impl Default for Options {
    fn default() -> Self {
        let triangulator = Triangulator::default();
        Self { patch: 32, tolerance_px: 1.0, max_spacing: None, triangulator, threads: 1 }
    }
}

/// An option out of its range, or threads that could not be started.
#[derive(Debug, thiserror::Error)]
pub enum TinError {
    /// The patch size is none of the four.
    #[error("patch of {0} intervals: expected 8, 16, 32 or 64")]
    Patch(u32),
    /// The tolerance is no positive number.
    #[error("tolerance of {0} px: expected a finite number above 0")]
    Tolerance(f64),
    /// The spacing does not fit the patch.
    #[error("maximum spacing of {found} intervals: expected 1 to {patch}, the side of a patch")]
    MaxSpacing {
        /// The spacing given.
        found: u32,
        /// The side of a patch.
        patch: u32,
    },
    /// No thread at all.
    #[error("0 threads: expected 1 or more")]
    NoThreads,
    /// The thread pool could not be started.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// The number asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}

impl Options {
    /// Refuses options out of their range.
    pub fn validate(&self) -> Result<(), TinError> {
        if ![8, 16, 32, 64].contains(&self.patch) {
            return Err(TinError::Patch(self.patch));
        }
        if !(self.tolerance_px > 0.0 && self.tolerance_px.is_finite()) {
            return Err(TinError::Tolerance(self.tolerance_px));
        }
        if self.threads == 0 {
            return Err(TinError::NoThreads);
        }
        match self.max_spacing {
            Some(found) if found == 0 || found > self.patch => Err(TinError::MaxSpacing { found, patch: self.patch }),
            _ => Ok(()),
        }
    }

    /// [`Options::max_spacing`] with its default.
    pub(crate) fn max_spacing(&self) -> u32 {
        self.max_spacing.unwrap_or(self.patch / 2)
    }
}
