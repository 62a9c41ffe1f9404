//! Errors of many samples, gathered.

use crate::histogram::PixelHistogram;

/// Errors of many samples: of one frame, or of all frames of a flight.
///
/// Maxima and RMS are exact, percentiles as [`PixelHistogram`] says.
#[derive(Clone)]
pub struct ErrorDistribution {
    errors: PixelHistogram,
    displacements: PixelHistogram,
    pub(super) uncovered: u64,
    pub(super) voids: u64,
    max_m: f32,
    sum_of_squares_px: f64,
    /// Tolerances in pixels, and how many errors are above each.
    over: Vec<(f32, u64)>,
}

impl ErrorDistribution {
    /// An empty distribution that counts the samples above each of these tolerances (in pixels).
    pub fn new(tolerances_px: &[f32]) -> Self {
        Self {
            errors: PixelHistogram::default(),
            displacements: PixelHistogram::default(),
            uncovered: 0,
            voids: 0,
            max_m: 0.0,
            sum_of_squares_px: 0.0,
            over: tolerances_px.iter().map(|tolerance| (*tolerance, 0)).collect(),
        }
    }

    /// Adds one sample's error, by the usual formula and as a displacement on the screen.
    pub fn add(&mut self, error_m: f32, error_px: f32, displacement_px: f32) {
        self.errors.add(error_px);
        self.displacements.add(displacement_px);
        self.max_m = self.max_m.max(error_m);
        self.sum_of_squares_px += error_px as f64 * error_px as f64;
        for (tolerance_px, count) in &mut self.over {
            *count += (error_px > *tolerance_px) as u64;
        }
    }

    /// Adds another distribution over the same tolerances.
    pub fn merge(&mut self, other: &Self) {
        self.errors.merge(&other.errors);
        self.displacements.merge(&other.displacements);
        self.uncovered += other.uncovered;
        self.voids += other.voids;
        self.max_m = self.max_m.max(other.max_m);
        self.sum_of_squares_px += other.sum_of_squares_px;
        for (ours, theirs) in self.over.iter_mut().zip(&other.over) {
            debug_assert_eq!(ours.0, theirs.0, "distributions over different tolerances");
            ours.1 += theirs.1;
        }
    }

    /// Forgets all samples, keeps the tolerances and the memory.
    pub fn clear(&mut self) {
        self.errors.clear();
        self.displacements.clear();
        (self.uncovered, self.voids, self.max_m, self.sum_of_squares_px) = (0, 0, 0.0, 0.0);
        self.over.iter_mut().for_each(|(_, count)| *count = 0);
    }

    /// Samples that were measured.
    pub fn samples(&self) -> u64 {
        self.errors.samples()
    }

    /// Samples in view that no triangle covers.
    pub fn uncovered(&self) -> u64 {
        self.uncovered
    }

    /// Voids in view, which are not measured.
    pub fn voids(&self) -> u64 {
        self.voids
    }

    /// Largest error in pixels.
    pub fn max_px(&self) -> f32 {
        self.errors.max_px()
    }

    /// Largest error in metres.
    pub fn max_m(&self) -> f32 {
        self.max_m
    }

    /// Root of the mean squared error in pixels; 0 without samples.
    pub fn rms_px(&self) -> f64 {
        (self.sum_of_squares_px / self.samples().max(1) as f64).sqrt()
    }

    /// Share of the samples above the `i`-th tolerance, 0 to 1.
    pub fn over_share(&self, i: usize) -> f64 {
        self.over[i].1 as f64 / self.samples().max(1) as f64
    }

    /// The error in pixels that a `share` of the samples (0 to 1) does not exceed.
    pub fn percentile_px(&self, share: f64) -> f32 {
        self.errors.percentile_px(share)
    }

    /// The same errors as displacements on the screen.
    pub fn displacements(&self) -> &PixelHistogram {
        &self.displacements
    }
}
