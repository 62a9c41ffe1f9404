//! What repeats say: a median with an interval, and whether two of them differ.
//!
//! The frames of a flight depend on each other: a slow spell of the machine lasts for many of them. So frames are never
//! resampled, only whole repeats, each with its own value of a statistic (`frame_times.rs`). The interval is the percentile
//! bootstrap of the median over repeats. Resampling n values understates their spread by sqrt((n - 1) / n) and knows
//! nothing of how uncertain a spread of few values is, so the interval is widened by sqrt(n / (n - 1)) and by Student's t
//! over the normal quantile, as Hesterberg proposes ("What teachers should know about the bootstrap", The American
//! Statistician 2015, section 3.2).

use serde::{Deserialize, Serialize};
use terrain_core::SplitMix64;

/// Draws of a bootstrap: the ends of the interval then move by less than a twentieth of its width from seed to seed.
const DRAWS: usize = 2_000;
const SEED: u64 = 5;
/// The normal distribution's 97.5 % quantile.
const NORMAL: f64 = 1.959_964;
/// Student's, for 1 to 10 degrees of freedom.
const STUDENT: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];
/// A ratio this close to 1 is the same for everyone, however sure we are of it.
const NOBODY_CARES: f64 = 1.01;

/// An estimate and the ends of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    pub estimate: f64,
    pub low: f64,
    pub high: f64,
}

impl Interval {
    /// Of the median over repeats, of values that are not negative. One repeat has no interval.
    pub fn of_median(repeats: &[f64]) -> Option<Self> {
        let widen = widening(repeats.len(), repeats.len().checked_sub(1)?)?;
        let mut random = SplitMix64::new(SEED);
        let draws = (0..DRAWS).map(|_| median_of_draw(repeats, &mut random)).collect();
        Some(Self::percentiles(median(repeats)?, draws).widened(widen))
    }

    /// Of the median of `b` over that of `a`, of positive values; each side is resampled by itself.
    pub fn of_ratio(a: &[f64], b: &[f64]) -> Option<Self> {
        let fewer = a.len().min(b.len());
        let widen = widening(fewer, (a.len() + b.len()).checked_sub(2)?)?;
        let mut random = SplitMix64::new(SEED);
        let draws = (0..DRAWS).map(|_| median_of_draw(b, &mut random) / median_of_draw(a, &mut random)).collect();
        Some(Self::percentiles(median(b)? / median(a)?, draws).widened(widen))
    }

    /// The middle 95 % of the draws.
    fn percentiles(estimate: f64, mut draws: Vec<f64>) -> Self {
        draws.sort_by(f64::total_cmp);
        let [low, high] = [0.025, 0.975].map(|share| draws[(share * (DRAWS - 1) as f64).round() as usize]);
        Self { estimate, low, high }
    }

    /// The ends further away by a factor, as logarithms: times and ratios are not negative, and vary by factors.
    fn widened(self, factor: f64) -> Self {
        let Self { estimate, low, high } = self;
        let [low, high] =
            [low, high].map(|end| if estimate > 0.0 { estimate * (end / estimate).powf(factor) } else { end });
        Self { estimate, low, high }
    }

    /// What the ratio of `b` to this may be, from the ends of both; `None` where one of them is not positive.
    pub fn ratio_to(&self, b: &Self) -> Option<Self> {
        if [self.low, b.low].iter().any(|low| *low <= 0.0) {
            return None;
        }
        let estimate = b.estimate / self.estimate;
        // Independent, so in logarithms the distances to the ends add up like the sides of a right angle.
        let below = (b.estimate / b.low).ln().hypot((self.high / self.estimate).ln());
        let above = (b.high / b.estimate).ln().hypot((self.estimate / self.low).ln());
        Some(Self { estimate, low: estimate * (-below).exp(), high: estimate * above.exp() })
    }

    /// Of one over it.
    pub fn inverse(&self) -> Self {
        Self { estimate: 1.0 / self.estimate, low: 1.0 / self.high, high: 1.0 / self.low }
    }

    /// What a ratio says of which the smaller is the better.
    pub fn verdict(&self) -> Verdict {
        if self.low > NOBODY_CARES {
            Verdict::Worse
        } else if self.high < 1.0 / NOBODY_CARES {
            Verdict::Better
        } else {
            Verdict::Same
        }
    }
}

/// What became of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    Better,
    Worse,
    /// Equal, or not different beyond noise.
    Same,
    /// A has it and B does not.
    Lost,
    /// B has it and A does not.
    New,
}

impl Verdict {
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Worse => "worse",
            Self::Same => "same",
            Self::Lost => "lost",
            Self::New => "new",
        }
    }
}

/// The mean of the two in the middle where there are two.
pub fn median(numbers: &[f64]) -> Option<f64> {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        n if n % 2 == 1 => Some(sorted[half]),
        _ => Some((sorted[half - 1] + sorted[half]) / 2.0),
    }
}

fn median_of_draw(values: &[f64], random: &mut SplitMix64) -> f64 {
    let mut one = || values[random.below(values.len() as u64) as usize];
    let drawn: Vec<f64> = (0..values.len()).map(|_| one()).collect();
    median(&drawn).expect("a draw is as long as its values, which are some")
}

/// How much wider than the bootstrap's percentiles the interval must be. One value has no spread.
fn widening(values: usize, freedom: usize) -> Option<f64> {
    let n = values as f64;
    (values > 1).then(|| (n / (n - 1.0)).sqrt() * student(freedom) / NORMAL)
}

/// Student's 97.5 % quantile, beyond the table by the first terms of its series (within 0.2 %).
fn student(freedom: usize) -> f64 {
    let nu = freedom as f64;
    STUDENT.get(freedom.max(1) - 1).copied().unwrap_or_else(|| NORMAL + 2.37 / nu + 2.82 / (nu * nu))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIALS: u64 = 400;

    /// The values of one statistic in some repeats: noise of 2 %, and where `rough` is set one repeat of eight with up to
    /// 40 % more, as a busy machine has them.
    fn repeats(count: usize, level: f64, rough: bool, random: &mut SplitMix64) -> Vec<f64> {
        // The sum of twelve uniform numbers has a variance of 1 and is near enough to normal.
        let normal = |random: &mut SplitMix64| (0..12).map(|_| random.range(-0.5, 0.5)).sum::<f64>();
        let spell = |random: &mut SplitMix64| if rough && random.below(8) == 0 { random.range(0.0, 0.4) } else { 0.0 };
        (0..count).map(|_| level * (0.02 * normal(random)).exp() * (1.0 + spell(random))).collect()
    }

    /// The share of trials that find A and B the same, where B is slower by `shift`.
    fn share_of_same(count: usize, shift: f64, rough: bool) -> f64 {
        let is_same = |seed: &u64| {
            let mut random = SplitMix64::new(*seed);
            let a = repeats(count, 10.0, rough, &mut random);
            let b = repeats(count, 10.0 * (1.0 + shift), rough, &mut random);
            Interval::of_ratio(&a, &b).unwrap().verdict() == Verdict::Same
        };
        (0..TRIALS).filter(is_same).count() as f64 / TRIALS as f64
    }

    #[test]
    fn the_same_twice_is_the_same_in_19_of_20_trials() {
        for count in [2, 3, 5, 10] {
            for rough in [false, true] {
                let same = share_of_same(count, 0.0, rough);
                assert!(same >= 0.95, "{count} repeats, rough {rough}: same in {same} of seeds 0 to {TRIALS}");
            }
        }
    }

    #[test]
    fn ten_percent_in_two_percent_of_noise_are_found() {
        for (count, missed) in [(3, 0.3), (5, 0.05), (10, 0.01)] {
            let same = share_of_same(count, 0.1, false);
            assert!(same <= missed, "{count} repeats: missed in {same} of seeds 0 to {TRIALS}");
        }
    }

    #[test]
    fn intervals_hold_the_median_about_as_often_as_they_say() {
        for count in [3, 5, 10] {
            let holds = |seed: &u64| {
                let found = Interval::of_median(&repeats(count, 10.0, false, &mut SplitMix64::new(*seed))).unwrap();
                found.low <= 10.0 && 10.0 <= found.high
            };
            let share = (0..TRIALS).filter(holds).count() as f64 / TRIALS as f64;
            assert!((0.9..=0.99).contains(&share), "{count} repeats: {share} of seeds 0 to {TRIALS}");
        }
    }

    #[test]
    fn equal_repeats_have_an_interval_without_width_and_one_repeat_has_none() {
        let equal = Interval::of_median(&[3.0; 4]).unwrap();
        assert_eq!((equal.estimate, equal.low, equal.high), (3.0, 3.0, 3.0));
        assert_eq!(Interval::of_median(&[3.0]), None);
        assert_eq!(Interval::of_median(&[]), None);
        assert_eq!(Interval::of_ratio(&[1.0], &[1.0, 2.0]), None);
        assert_eq!(Interval::of_ratio(&[2.0; 3], &[1.0; 3]).unwrap().verdict(), Verdict::Better);
    }

    #[test]
    fn medians_and_quantiles() {
        assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0]), median(&[])), (Some(2.0), Some(2.5), None));
        for (freedom, expected) in [(1, 12.706), (10, 2.228), (11, 2.201), (20, 2.086), (58, 2.002)] {
            assert!((student(freedom) / expected - 1.0).abs() < 2e-3, "{freedom}: {}", student(freedom));
        }
    }
}
