//! The ladder of tolerances: levels in place of metres, a byte each.
//!
//! ```text
//!   level           0      1       2       3              9             254
//!   tolerance_m     0    0.05  0.05453 0.05946    ...    0.1    ...   1.6e8      a step is 2^(1/8), about 9 %
//!               all kept
//! ```
//!
//! A tolerance is rounded down to a rung, for a patch and for an edge by one function: of two patches the edge between
//! them takes the smaller level, and both agree on it because it is an integer. Below the first rung is level 0, where
//! every sample is kept.

/// Number of a tolerance on the ladder, 0 to [`COARSEST`]: 0 is the finest.
pub type Level = u8;

/// The level at which every sample is kept; its tolerance is 0.
pub const FULL: Level = 0;

/// The level of all tolerances of 160,000 km and more.
pub const COARSEST: Level = 254;

/// Tolerance of level 1 in metres.
pub const FLOOR_M: f64 = 0.05;

/// 2^(i/8), as literals: powers of floats differ from machine to machine.
const STEPS: [f64; 8] = [
    1.0,
    1.090_507_732_665_257_7,
    1.189_207_115_002_721,
    1.296_839_554_651_009_6,
    std::f64::consts::SQRT_2,
    1.542_210_825_407_940_7,
    1.681_792_830_507_429,
    1.834_008_086_409_342_4,
];

/// Tolerances of all levels. An octave is an exact doubling of the octave before.
static TOLERANCES_M: [f64; COARSEST as usize + 1] = {
    let mut tolerances_m = [0.0; COARSEST as usize + 1];
    let mut level = 1;
    while level < tolerances_m.len() {
        let (octave, step) = ((level - 1) / 8, (level - 1) % 8);
        tolerances_m[level] = FLOOR_M * STEPS[step] * (1u64 << octave) as f64;
        level += 1;
    }
    tolerances_m
};

/// The largest level whose tolerance does not exceed `tolerance_m`.
pub fn level_of(tolerance_m: f64) -> Level {
    // Level 0 stands for all that is below the ladder, for NaN too.
    TOLERANCES_M.partition_point(|rung_m| *rung_m <= tolerance_m).saturating_sub(1) as Level
}

/// Tolerance of a level in metres.
///
/// # Panics
///
/// If the level is above [`COARSEST`].
pub fn tolerance_m(level: Level) -> f64 {
    TOLERANCES_M[level as usize]
}

/// How many levels a deviation exceeds: it is too large at a level exactly if the code is larger than the level.
pub(crate) fn code_of(deviation_m: f64) -> u8 {
    TOLERANCES_M.partition_point(|rung_m| *rung_m < deviation_m) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::SplitMix64;

    #[test]
    fn rungs_are_exact() {
        for level in 1..=COARSEST {
            let rung_m = tolerance_m(level);
            assert_eq!(level_of(rung_m), level);
            assert_eq!(level_of(rung_m.next_down()), level - 1);
            assert_eq!((code_of(rung_m), code_of(rung_m.next_up())), (level, level + 1), "at the rung is within it");
            let exact = 0.05 * 2f64.powf((level - 1) as f64 / 8.0);
            assert!((rung_m / exact - 1.0).abs() < 1e-15, "level {level}: {rung_m} for {exact}");
            if level > 8 {
                assert_eq!(rung_m, 2.0 * tolerance_m(level - 8));
            }
        }
        assert_eq!((tolerance_m(FULL), tolerance_m(1), tolerance_m(9)), (0.0, 0.05, 0.1));
    }

    #[test]
    fn levels_never_fall_as_tolerances_rise() {
        let mut random = SplitMix64::new(1);
        let mut tolerances_m: Vec<f64> = (0..10_000).map(|_| random.range(-5.0, 30.0).exp2()).collect();
        tolerances_m.sort_by(f64::total_cmp);
        assert!(tolerances_m.windows(2).all(|two| level_of(two[0]) <= level_of(two[1])));
        for found_m in tolerances_m {
            let level = level_of(found_m);
            assert!(tolerance_m(level) <= found_m && (level == COARSEST || found_m < tolerance_m(level + 1)));
            assert!((0..=COARSEST).all(|level| (code_of(found_m) > level) == (found_m > tolerance_m(level))));
        }
    }

    #[test]
    fn what_is_no_tolerance_keeps_everything() {
        for tolerance_m in [0.0, -0.0, 0.049_999, -1.0, f64::NAN, f64::NEG_INFINITY] {
            assert_eq!(level_of(tolerance_m), FULL);
        }
        assert_eq!((level_of(f64::INFINITY), level_of(1e300), code_of(f64::INFINITY)), (COARSEST, COARSEST, 255));
    }
}
