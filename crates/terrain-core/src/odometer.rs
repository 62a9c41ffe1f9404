//! How far the eye has moved, so that decisions can say how long they hold.
//!
//! A decision compares the distance between the eye and a box with a length. When the eye moves by a metre, that
//! distance changes by a metre at most, whatever the direction. So a decision with some slack between distance and
//! length stands until the eye has moved that far: until the odometer shows its *deadline*. That is exact, and turning
//! the camera costs nothing.

use glam::DVec3;

use crate::View;

/// The way of the eye so far, in metres.
#[derive(Default)]
pub struct Odometer {
    /// Where the eye was, and how many pixels a metre had at a metre.
    previous: Option<(DVec3, f64)>,
    reading_m: f64,
}

/// A deadline that has passed before the first plan.
pub const PASSED: f64 = f64::NEG_INFINITY;
/// The deadline of what no movement changes.
pub const NEVER: f64 = f64::INFINITY;

/// Subtracted from all slack: more than sums and distances lose by rounding on the longest way.
const MARGIN_M: f64 = 1e-3;
/// After so long a way the reading begins again.
const LONGEST_M: f64 = 1e6;

impl Odometer {
    /// Adds the way to a new view. Returns false where all decisions must be made anew, whatever their deadlines.
    pub fn advance(&mut self, view: &View) -> bool {
        let scale = view.pixels(1.0, 1.0);
        let previous = self.previous.replace((view.eye_world, scale));
        // With another lens lengths on the screen are others at the same distance.
        let Some((eye_world, _)) = previous.filter(|previous| previous.1 == scale) else {
            self.reading_m = 0.0;
            return false;
        };
        self.reading_m += eye_world.distance(view.eye_world);
        if self.reading_m > LONGEST_M {
            self.reading_m = 0.0;
            return false;
        }
        true
    }

    /// Whether a deadline has come.
    pub fn has_passed(&self, deadline_m: f64) -> bool {
        deadline_m <= self.reading_m
    }

    /// When a decision with that much slack is to be made anew.
    pub fn deadline_m(&self, slack_m: f64) -> f64 {
        self.reading_m + (slack_m - MARGIN_M).max(0.0)
    }
}

/// A deadline in half the memory, and never later: on the longest way by less than 13 cm sooner.
pub fn rounded_down(deadline_m: f64) -> f32 {
    let nearest_m = deadline_m as f32;
    if f64::from(nearest_m) > deadline_m { nearest_m.next_down() } else { nearest_m }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    #[test]
    fn a_deadline_in_half_the_memory_is_the_next_one_that_is_no_later() {
        let mut random = SplitMix64::new(1);
        for deadline_m in (0..10_000).map(|_| random.range(0.0, 2.0 * LONGEST_M)) {
            let rounded_m = rounded_down(deadline_m);
            assert!(f64::from(rounded_m) <= deadline_m && f64::from(rounded_m.next_up()) > deadline_m);
            assert!(deadline_m - f64::from(rounded_m) < 0.125);
        }
        assert_eq!([NEVER, PASSED, 0.0, 0.5].map(rounded_down), [f32::INFINITY, f32::NEG_INFINITY, 0.0, 0.5]);
    }
}
