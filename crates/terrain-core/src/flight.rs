//! Scripted cameras: keyframes in TOML, indexed by frame at a fixed time step and never by the clock.
//!
//! ```toml
//! name = "over-the-ridge"
//! fov_y_deg = 60                    # vertical field of view, 1 to 170; 60 if left out
//! steps_per_second = 60             # frames a second of flight; 60 if left out
//! allow_outside = false             # may the camera leave the DEM?
//! allow_below_ground = false        # may it go below the ground?
//!
//! [[key]]
//! time_s = 0
//! at = [0.1, 0.5]                   # shares of the DEM's extent in x and z ...
//! above_ground_m = 100              # ... and a height above ground: metres, or
//!                                   # above_ground_share = 0.05 of the DEM's shorter side
//! look_at = [0.5, 0.5]              # shares again ...
//! look_at_above_ground_m = 20       # ... and metres above ground; 0 if left out
//!
//! [[key]]                           # another one: a flight has at least two keys
//! time_s = 10
//! at = [0.9, 0.5]
//! above_ground_m = 100
//! look_at = [0.5, 0.5]
//! ```
//!
//! A position can also be `position_m = [x, y, z]` in world metres; a direction `look_at_m = [x, y, z]`, or
//! `heading_deg` (clockwise from north, not wrapped: 0 to 360 is one full turn) with `pitch_deg` (90 is up). All keys of
//! a flight use one kind of position and one kind of direction.
//!
//! [`Flight::parse`] reads and checks the text, which needs no DEM; [`FlightPath::new`] lays the flight over one.

mod key;
mod parse;
mod path;
mod spline;

pub use path::FlightPath;

use crate::source::{LineColumn, SourceError, SourceText};
use key::Key;

/// Why a flight is refused: one line, `FILE:LINE:COLUMN: reason; expected ...`.
pub type FlightError = SourceError;

/// The most frames in one flight: more than four hours at 60 a second.
pub const MAX_FRAMES: u32 = 1_000_000;

/// Name and text of the flights that come with the program. They fit any DEM.
pub const BUILT_IN: [(&str, &str); 5] = [
    ("ground-level", include_str!("../../../data/flights/ground-level.toml")),
    ("low-and-slow", include_str!("../../../data/flights/low-and-slow.toml")),
    ("fly-over", include_str!("../../../data/flights/fly-over.toml")),
    ("turn", include_str!("../../../data/flights/turn.toml")),
    ("stop-and-go", include_str!("../../../data/flights/stop-and-go.toml")),
];

/// A flight as its author wrote it, checked: at least two keys, times that rise, finite numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    source_name: String,
    name: String,
    fov_y: f64,
    steps_per_second: f64,
    allow_outside: bool,
    allow_below_ground: bool,
    keys: Vec<Key>,
}

impl Flight {
    /// Reads a flight from TOML; `source_name` is the file's name in messages.
    pub fn parse(source_name: &str, toml_text: &str) -> Result<Self, FlightError> {
        parse::flight(&SourceText { name: source_name, text: toml_text })
    }

    /// One of the flights in [`BUILT_IN`].
    pub fn built_in(name: &str) -> Option<Self> {
        let (name, text) = BUILT_IN.iter().find(|(built_in, _)| *built_in == name)?;
        Some(Self::parse(&format!("{name}.toml"), text).expect("a test parses every built-in flight"))
    }

    /// The flight's own name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Vertical field of view in radians.
    pub fn fov_y(&self) -> f64 {
        self.fov_y
    }

    /// Seconds from the first key to the last.
    pub fn duration_s(&self) -> f64 {
        self.keys[self.keys.len() - 1].time_s - self.keys[0].time_s
    }

    /// Frames at the flight's own time step: one at either end, `steps_per_second` in every second between.
    pub fn default_frames(&self) -> u32 {
        (self.duration_s() * self.steps_per_second).round() as u32 + 1
    }

    fn error_at(&self, position: LineColumn, reason: String) -> FlightError {
        SourceError { source_name: self.source_name.clone(), position, reason }
    }
}

#[cfg(test)]
mod tests;
