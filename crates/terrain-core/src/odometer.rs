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
