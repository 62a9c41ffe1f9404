//! Heights that no planet has, among heights that ours has: leftovers of sensors and of programs.

use std::ops::RangeInclusive;

/// The deepest and highest places of this planet, with some room, in metres.
pub const PLAUSIBLE_M: RangeInclusive<f32> = -11_500.0..=9_500.0;

/// Metres beyond the range that must be empty. Other planets' mountains rise from their neighbours without a gap.
const GAP_M: f32 = 2_000.0;

/// One spike in so many samples at most: more of them are a wrong unit or another planet.
const RARE: u64 = 100;

/// What was found.
#[derive(Debug, PartialEq)]
pub struct Spikes {
    pub count: u64,
    /// The first one, and its place in the grid.
    pub height_m: f32,
    pub index: usize,
}

/// Heights beyond the planet, counted.
#[derive(Debug, Default)]
pub struct Census {
    /// Below and above it, however far.
    beyond: [u64; 2],
    /// Whether some of them are near.
    has_near: [bool; 2],
}

impl Census {
    /// NaN is nowhere.
    pub fn add(&mut self, heights_m: &[f32]) {
        for &height_m in heights_m {
            for (side, far_m) in [PLAUSIBLE_M.start() - height_m, height_m - PLAUSIBLE_M.end()].into_iter().enumerate()
            {
                if far_m > 0.0 {
                    self.beyond[side] += 1;
                    self.has_near[side] |= far_m < GAP_M;
                }
            }
        }
    }

    /// On which sides the heights beyond are spikes, and how many they are, if there are any.
    fn spikes(&self, found: u64) -> Option<([bool; 2], u64)> {
        let sides = [0, 1].map(|side| self.beyond[side] > 0 && !self.has_near[side]);
        let count = (0..2).filter(|side| sides[*side]).map(|side| self.beyond[side]).sum::<u64>();
        (count > 0 && count.saturating_mul(RARE) <= found).then_some((sides, count))
    }

    /// Whether some of `found` heights are spikes.
    pub fn has_spikes(&self, found: u64) -> bool {
        self.spikes(found).is_some()
    }
}

/// Makes spikes NaN.
pub fn strike(heights_m: &mut [f32], found: u64, [low, high]: [f32; 2]) -> Option<Spikes> {
    if PLAUSIBLE_M.contains(&low) && PLAUSIBLE_M.contains(&high) {
        return None;
    }
    let mut census = Census::default();
    census.add(heights_m);
    let ([is_low, is_high], count) = census.spikes(found)?;
    let is_spike = |height_m: &f32| is_low && height_m < PLAUSIBLE_M.start() || is_high && height_m > PLAUSIBLE_M.end();
    let index = heights_m.iter().position(is_spike)?;
    let height_m = heights_m[index];
    heights_m.iter_mut().filter(|height_m| is_spike(height_m)).for_each(|height_m| *height_m = f32::NAN);
    Some(Spikes { count, height_m, index })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn struck(odd: &[f32]) -> (Vec<f32>, Option<Spikes>) {
        let mut heights_m: Vec<f32> = (0..1000).map(|i| i as f32).collect();
        heights_m.extend(odd);
        let [low, high] = [f32::min, f32::max].map(|pick| heights_m.iter().copied().reduce(pick).unwrap());
        let found = heights_m.len() as u64;
        let spikes = strike(&mut heights_m, found, [low, high]);
        (heights_m, spikes)
    }

    #[test]
    fn a_few_heights_far_beyond_the_planet_are_spikes() {
        let (heights_m, spikes) = struck(&[5.0, 32_767.0, -20_000.0, 12_000.0, 6.0]);
        assert_eq!(spikes, Some(Spikes { count: 3, height_m: 32_767.0, index: 1001 }));
        let voids: Vec<usize> = (0..heights_m.len()).filter(|i| heights_m[*i].is_nan()).collect();
        assert_eq!(voids, [1001, 1002, 1003]);
    }

    #[test]
    fn other_planets_and_wrong_units_are_left_alone() {
        // Olympus Mons, without a gap below it.
        assert_eq!(struck(&[9_000.0, 10_000.0, 15_000.0, 21_229.0]).1, None);
        assert_eq!(struck(&[40_000.0; 11]).1, None, "too many");
        assert_eq!(struck(&[9_400.0, -11_400.0]).1, None);
        assert_eq!(struck(&[11_400.0]).1, None, "hardly beyond");
    }
}
