//! Counts of lengths on the screen, for percentiles and bins.

use std::ops::Range;

/// Lengths in pixels of many samples, of one frame or of all frames of a flight.
///
/// The maximum is exact. The histogram is over the leading bits of the floats: percentiles are rounded up by at most
/// 0.1 %, a flight of any length needs the same memory, and the result does not depend on order.
#[derive(Clone)]
pub struct PixelHistogram {
    samples: u64,
    max_px: f32,
    /// Lengths of 0 (or below the smallest normal float), which are many.
    zeros: u64,
    /// By key; nothing outside of `used`.
    counts: Vec<u64>,
    /// The keys from the smallest to the largest so far: a frame touches few of all there are.
    used: Range<usize>,
}

/// Bits of an f32 that are left out of the key: 10 bits of the mantissa stay.
const DROPPED_BITS: u32 = 13;
/// Keys of positive, finite floats.
const KEYS: usize = key(f32::INFINITY) + 1;
/// Empty, and the neutral element of taking the smaller start and the larger end.
const NOTHING: Range<usize> = Range { start: KEYS, end: 0 };

const fn key(px: f32) -> usize {
    (px.to_bits() >> DROPPED_BITS) as usize
}

impl Default for PixelHistogram {
    /// No samples.
    fn default() -> Self {
        Self { samples: 0, max_px: 0.0, zeros: 0, counts: vec![0; KEYS], used: NOTHING }
    }
}

impl PixelHistogram {
    /// Adds one sample's length, 0 or more.
    pub fn add(&mut self, px: f32) {
        self.samples += 1;
        self.max_px = self.max_px.max(px);
        match key(px) {
            0 => self.zeros += 1,
            key => {
                self.counts[key] += 1;
                self.used = self.used.start.min(key)..self.used.end.max(key + 1);
            }
        }
    }

    /// Adds all samples of another histogram.
    pub fn merge(&mut self, other: &Self) {
        self.samples += other.samples;
        self.max_px = self.max_px.max(other.max_px);
        self.zeros += other.zeros;
        self.used = self.used.start.min(other.used.start)..self.used.end.max(other.used.end);
        if let Some(theirs) = other.counts.get(other.used.clone()) {
            self.counts[other.used.clone()].iter_mut().zip(theirs).for_each(|(ours, theirs)| *ours += theirs);
        }
    }

    /// Forgets all samples and keeps the memory.
    pub fn clear(&mut self) {
        (self.samples, self.max_px, self.zeros) = (0, 0.0, 0);
        if let Some(counts) = self.counts.get_mut(self.used.clone()) {
            counts.fill(0);
        }
        self.used = NOTHING;
    }

    /// Samples so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The largest length in pixels; 0 without samples.
    pub fn max_px(&self) -> f32 {
        self.max_px
    }

    /// The length in pixels that a `share` of the samples (0 to 1) does not exceed; 0 without samples.
    pub fn percentile_px(&self, share: f64) -> f32 {
        let wanted = ((share * self.samples as f64).ceil() as u64).max(1);
        let mut seen = self.zeros;
        if seen >= wanted {
            return 0.0;
        }
        for key in self.used.clone() {
            seen += self.counts[key];
            if seen >= wanted {
                return upper_end(key).min(self.max_px);
            }
        }
        self.max_px
    }

    /// Samples of `from_px` or more and less than `to_px`; exact where both ends are 0, infinite, or have at most 10
    /// bits after the leading one.
    pub fn count(&self, from_px: f32, to_px: f32) -> u64 {
        let keys = key(from_px).max(self.used.start)..key(to_px).min(self.used.end);
        let counted: u64 = self.counts.get(keys).unwrap_or_default().iter().sum();
        counted + if from_px == 0.0 { self.zeros } else { 0 }
    }
}

/// The largest float of a key.
fn upper_end(key: usize) -> f32 {
    f32::from_bits((key as u32) << DROPPED_BITS | ((1 << DROPPED_BITS) - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    fn of(values: &[f32]) -> PixelHistogram {
        let mut histogram = PixelHistogram::default();
        values.iter().for_each(|px| histogram.add(*px));
        histogram
    }

    /// Random lengths, a tenth of them 0.
    fn lengths(count: usize) -> Vec<f32> {
        let mut random = SplitMix64::new(5);
        let mut length = || (random.range(-0.1, 1.0).max(0.0).powi(4) * 30.0) as f32;
        (0..count).map(|_| length()).collect()
    }

    #[test]
    fn percentiles_are_rounded_up_by_a_thousandth_at_most() {
        let mut values = lengths(9_999);
        let whole = of(&values);
        let mut halves = PixelHistogram::default();
        values.chunks(5_000).for_each(|half| halves.merge(&of(half)));
        values.sort_by(f32::total_cmp);
        for share in [0.0, 0.001, 0.05, 0.5, 0.95, 0.99, 0.999, 1.0] {
            let exact = values[((share * 9_999.0_f64).ceil() as usize).max(1) - 1];
            let found = whole.percentile_px(share);
            assert!(found >= exact && found <= exact * 1.001, "{share}: {found} for {exact}");
            assert_eq!(found, halves.percentile_px(share));
        }
        assert_eq!((whole.samples(), whole.max_px()), (9_999, values[9_998]));
    }

    #[test]
    fn counts_between_powers_of_two_are_exact() {
        let values = [lengths(5_000), vec![0.125, 0.25, 8.0]].concat();
        let histogram = of(&values);
        for (from_px, to_px) in [(0.0, 0.125), (0.125, 0.25), (0.25, 8.0), (8.0, f32::INFINITY), (64.0, 128.0)] {
            let expected = values.iter().filter(|px| (from_px..to_px).contains(*px)).count();
            assert_eq!(histogram.count(from_px, to_px), expected as u64, "{from_px} to {to_px}");
        }
    }

    #[test]
    fn what_is_cleared_is_forgotten() {
        let mut histogram = of(&lengths(100));
        histogram.clear();
        assert_eq!((histogram.samples(), histogram.max_px(), histogram.percentile_px(0.5)), (0, 0.0, 0.0));
        assert_eq!(histogram.count(0.0, f32::INFINITY), 0);
        histogram.merge(&PixelHistogram::default());
        histogram.add(2.0);
        assert_eq!((histogram.percentile_px(0.5), histogram.count(1.0, 4.0)), (2.0, 1));
    }
}
