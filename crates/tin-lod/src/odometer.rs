//! How far the eye has come: what holds until it has moved so far need not be looked at before.

use terrain_core::View;

/// The way of the eye, and what a metre of distance allows: both decide about levels, and nothing else of a view does.
#[derive(Default)]
pub(crate) struct Odometer {
    last: Option<Box<View>>,
    /// Since the beginning; but for rounding never less than the distance between any two places of the eye.
    metres: f64,
}

impl Odometer {
    /// Goes on to the next view. Returns whether distances still mean what they did.
    pub fn advance(&mut self, view: &View) -> bool {
        let Some(last) = &mut self.last else {
            self.last = Some(Box::new(view.clone()));
            return false;
        };
        let is_same_lens = last.metres(1.0, 1.0) == view.metres(1.0, 1.0);
        self.metres += last.eye_world.distance(view.eye_world);
        **last = view.clone();
        is_same_lens
    }

    pub fn metres(&self) -> f64 {
        self.metres
    }
}
