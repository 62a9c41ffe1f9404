//! Kinds of synthetic ground.

use terrain_core::SplitMix64;

use super::{MOUNTAIN_SAMPLES, height_m, noise, smooth};

/// Height of the highest hill in metres.
const HILL_M: f64 = 600.0;

/// Octaves of the hills: the finest wave is 8 samples long, so that no sample stands out.
const HILL_OCTAVES: u64 = 6;

/// Wavelength of the coasts in samples.
const COAST_SAMPLES: f64 = 200.0;

/// One sample in so many is a spike.
const SPIKE_SAMPLES: u64 = 997;
const SPIKE_M: f64 = 300.0;

/// The first layers of noise of the kinds, beyond those of the mountains.
const HILLS: u64 = 32;
const COAST: u64 = 48;
const SPIKES: u64 = 49;

/// What the ground is like. All heights are 0 to 2,600 m.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Mountains with sharp crests, valleys, and flat lakes: the finest detail is on the crests.
    Ridged,
    /// Smooth hills: little detail, the same everywhere.
    Hills,
    /// Hills and mountains in a sea that is flat at 0 m: much of the ground has no detail at all.
    Coast,
    /// A gentle plain with single samples that stand out by as much as 300 m: the worst for any method that must not
    /// lose a sample.
    Spikes,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Ridged, Self::Hills, Self::Coast, Self::Spikes];

    /// The heights of the first samples of a row, in metres.
    pub fn fill_row(self, seed: u64, row: u32, row_m: &mut [f32]) {
        for (column, sample_m) in row_m.iter_mut().enumerate() {
            *sample_m = self.height_m(seed, column as u32, row) as f32;
        }
    }

    fn height_m(self, seed: u64, column: u32, row: u32) -> f64 {
        let (x, z) = (column as f64, row as f64);
        match self {
            Self::Ridged => height_m(seed, x, z),
            Self::Hills => HILL_M * hills(seed, x, z),
            Self::Coast => land(seed, x, z) * height_m(seed, x, z),
            Self::Spikes => 0.1 * HILL_M * hills(seed, x / 4.0, z / 4.0) + spike_m(seed, column, row),
        }
    }
}

/// 0 to 1; each octave half as high as the one before.
fn hills(seed: u64, x: f64, z: f64) -> f64 {
    let (mut sum, mut total, mut amplitude, mut samples) = (0.0, 0.0, 1.0, MOUNTAIN_SAMPLES);
    for octave in 0..HILL_OCTAVES {
        sum += amplitude * noise(seed, HILLS + octave, x / samples, z / samples);
        total += amplitude;
        (amplitude, samples) = (amplitude * 0.5, samples * 0.5);
    }
    (0.5 + 0.5 * sum / total).clamp(0.0, 1.0)
}

/// 0 at sea, 1 inland.
fn land(seed: u64, x: f64, z: f64) -> f64 {
    smooth(noise(seed, COAST, x / COAST_SAMPLES, z / COAST_SAMPLES) * 4.0 + 0.3)
}

/// 0 nearly everywhere.
fn spike_m(seed: u64, column: u32, row: u32) -> f64 {
    let hash = SplitMix64::mix(SplitMix64::mix(seed ^ SplitMix64::mix(SPIKES)) ^ ((column as u64) << 32 | row as u64));
    let height_m = SPIKE_M * ((hash >> 32) as u32 as f64 / u32::MAX as f64);
    if (hash as u32 as u64).is_multiple_of(SPIKE_SAMPLES) { height_m } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The heights of a square.
    fn heights_m(kind: Kind, seed: u64, side: usize) -> Vec<f32> {
        let mut heights_m = vec![0.0; side * side];
        let rows = heights_m.chunks_mut(side).enumerate();
        rows.for_each(|(row, row_m)| kind.fill_row(seed, row as u32, row_m));
        heights_m
    }

    #[test]
    fn heights_never_change() {
        let checksum = |kind| {
            let bits = heights_m(kind, 7, 90).into_iter().map(|height_m| height_m.to_bits() as u64);
            bits.fold(0, |sum, bits| SplitMix64::mix(sum ^ bits))
        };
        let expected = [
            10_507_147_322_727_244_688,
            17_413_212_962_052_129_018,
            13_909_870_160_527_405_047,
            11_869_694_445_408_894_695,
        ];
        assert_eq!(Kind::ALL.map(checksum), expected);
    }

    #[test]
    fn kinds_are_what_their_names_say() {
        let high_steps = |heights_m: &[f32]| {
            let high = heights_m.windows(2).filter(|two| (two[1] - two[0]).abs() > 20.0).count();
            high as f64 / heights_m.len() as f64
        };
        for seed in 0..2 {
            let [ridged, hills, coast, spikes] = Kind::ALL.map(|kind| heights_m(kind, seed, 500));
            let at_sea = coast.iter().filter(|height_m| **height_m == 0.0).count() as f64 / coast.len() as f64;
            assert!((0.1..0.9).contains(&at_sea), "seed {seed}: {at_sea} at sea");
            // The steps from one row to the next are high ones in any case.
            assert!(high_steps(&hills) < 0.003 && high_steps(&ridged) > 0.05, "seed {seed}");
            // Up and down again.
            assert!((0.001..0.003).contains(&high_steps(&spikes)), "seed {seed}");
            for (kind, heights_m) in Kind::ALL.iter().zip([ridged, hills, coast, spikes]) {
                assert!(heights_m.iter().all(|height_m| (0.0..=2600.0).contains(height_m)), "{kind:?}, seed {seed}");
            }
        }
    }
}
