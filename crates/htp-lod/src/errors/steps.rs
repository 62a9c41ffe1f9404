//! A number of steps in one byte, rounded up by less than a sixteenth.
//!
//! Up to 16 steps a byte is the number itself. Above, each further doubling has 16 bytes, `(16 + low) << (high - 1)`
//! from its two halves:
//!
//! ```text
//!  byte    0  1 ... 15 | 16 17 ... 31 | 32 33 ... 47 | ... | 192 ........... 207 | 208
//!  steps   0  1 ... 15 | 16 17 ... 31 | 32 34 ... 62 | ... | 32768 ....... 63488 | 65535
//! ```

/// Leading bits that are kept.
const KEPT: u32 = 5;

/// The smallest byte that stands for no less.
pub(super) fn to_byte(steps: u16) -> u8 {
    let steps = u32::from(steps);
    let dropped = (u32::BITS - steps.leading_zeros()).saturating_sub(KEPT);
    let kept = steps.div_ceil(1 << dropped);
    // One that is rounded up to the next doubling is the first one there.
    (16 * dropped + kept) as u8
}

/// The steps that a byte stands for.
pub(super) fn from_byte(byte: u8) -> u16 {
    let [high, low] = [byte / 16, byte % 16].map(u32::from);
    let steps = if high == 0 { low } else { (16 + low) << (high - 1) };
    steps.min(u16::MAX.into()) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_rounded_up_by_less_than_a_sixteenth_to_the_next_byte() {
        let all: Vec<u16> = (0..=208).map(from_byte).collect();
        assert!(all.is_sorted_by(|a, b| a < b));
        for steps in 0..=u16::MAX {
            let next = all.partition_point(|of_byte| *of_byte < steps);
            assert_eq!(usize::from(to_byte(steps)), next, "{steps}");
            assert!(f64::from(all[next]) <= f64::from(steps) * (1.0 + 1.0 / 16.0), "{steps}");
        }
    }
}
