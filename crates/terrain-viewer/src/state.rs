//! All that a user has set, as plain data: nothing here draws, loads or waits.

use terrain_core::View;
use terrain_renderer::{Colour, Look, Normals, Submission};

use crate::camera::Rig;
use crate::command::{Mode, Side};
use crate::flights::{Playback, Recorder};

/// Seconds that a message stays.
const MESSAGE_S: f64 = 8.0;

/// Which methods the window shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    #[default]
    Both,
    One(Side),
}

impl Shown {
    /// Both, left, right, both, ...
    pub fn next(self) -> Self {
        match self {
            Self::Both => Self::One(Side::Left),
            Self::One(Side::Left) => Self::One(Side::Right),
            Self::One(Side::Right) => Self::Both,
        }
    }

    /// The side that is shown alone.
    pub fn alone(self) -> Option<Side> {
        match self {
            Self::Both => None,
            Self::One(side) => Some(side),
        }
    }

    pub fn includes(self, side: Side) -> bool {
        self == Self::Both || self == Self::One(side)
    }
}

/// Which parts of the interface are there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(default)]
pub struct Open {
    pub panel: bool,
    pub hud: bool,
    pub map: bool,
    #[serde(skip)]
    pub help: bool,
}

impl Default for Open {
    fn default() -> Self {
        Self { panel: true, hud: true, map: true, help: false }
    }
}

/// A line for the user.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    pub text: String,
    pub is_fault: bool,
    /// On the viewer's clock.
    until_s: f64,
}

pub struct State {
    pub rig: Rig,
    /// Seconds since the start, as the caller counts them.
    pub now_s: f64,
    /// Where the left method ends, as a share of the window's width.
    pub divider: f64,
    pub shown: Shown,
    pub mode: Mode,
    pub wireframe: bool,
    pub normals: Normals,
    pub mark_stale: bool,
    pub boxes: bool,
    /// Pixels that are red in mode error.
    pub error_scale_px: f64,
    /// Heading and height above the horizon.
    pub sun_deg: [f64; 2],
    /// Times the DEM's own heights.
    pub exaggeration: f64,
    pub submission: Submission,
    /// The view that the methods keep to.
    pub frozen: Option<View>,
    pub open: Open,
    pub flight: Option<Playback>,
    pub recorder: Option<Recorder>,
    pub message: Option<Message>,
}

impl State {
    pub fn new(rig: Rig) -> Self {
        Self {
            rig,
            now_s: 0.0,
            divider: 0.5,
            shown: Shown::Both,
            mode: Mode::Shaded,
            wireframe: false,
            normals: Normals::PerPixel,
            mark_stale: false,
            boxes: false,
            error_scale_px: 2.0,
            sun_deg: [310.0, 35.0],
            exaggeration: 1.0,
            submission: Submission::Direct,
            frozen: None,
            open: Open::default(),
            flight: None,
            recorder: None,
            message: None,
        }
    }

    pub fn say(&mut self, text: impl Into<String>) {
        self.message = Some(Message { text: text.into(), is_fault: false, until_s: self.now_s + MESSAGE_S });
    }

    /// Says what went wrong; the next fault takes its place.
    pub fn say_fault(&mut self, text: impl Into<String>) {
        self.message = Some(Message { text: text.into(), is_fault: true, until_s: self.now_s + 2.0 * MESSAGE_S });
    }

    /// Lets the clock run.
    pub fn advance(&mut self, dt_s: f64) {
        self.now_s += dt_s;
        self.message.take_if(|message| message.until_s < self.now_s);
    }

    /// How the terrain looks.
    pub fn look(&self) -> Look {
        let [heading, height] = self.sun_deg.map(f64::to_radians);
        let to_sun = [heading.sin() * height.cos(), height.sin(), -heading.cos() * height.cos()];
        Look {
            colour: match self.mode {
                Mode::Shaded | Mode::Difference => Colour::Shaded,
                Mode::Level => Colour::ByLevel,
                Mode::Patch => Colour::ByPatch,
                Mode::Cell => Colour::ByCell,
                Mode::Draw => Colour::ByDraw,
                Mode::Error => Colour::ByError,
            },
            normals: self.normals,
            wireframe: self.wireframe,
            mark_stale: self.mark_stale,
            error_scale_px: self.error_scale_px as f32,
            to_sun: to_sun.map(|x| x as f32),
            ..Look::default()
        }
    }

    /// Whether both methods are drawn into one picture, with a divider between them.
    pub fn is_split(&self) -> bool {
        self.shown == Shown::Both && self.mode != Mode::Difference
    }
}

#[cfg(test)]
mod tests {
    use terrain_core::Heightmap;

    use super::*;

    fn state() -> State {
        State::new(Rig::over(&Heightmap::new(2, 2, [1.0; 2], vec![0.0; 4]).unwrap()))
    }

    #[test]
    fn three_flips_lead_back() {
        let mut shown = Shown::Both;
        let seen: Vec<[bool; 2]> = (0..4)
            .map(|_| {
                let sides = [Side::Left, Side::Right].map(|side| shown.includes(side));
                shown = shown.next();
                sides
            })
            .collect();
        assert_eq!(seen, [[true, true], [true, false], [false, true], [true, true]]);
    }

    #[test]
    fn messages_go_after_a_while() {
        let mut state = state();
        state.say("there");
        state.advance(MESSAGE_S - 0.1);
        assert!(state.message.is_some());
        state.advance(0.2);
        assert_eq!(state.message, None);
    }

    #[test]
    fn the_sun_stands_where_its_angles_say() {
        let mut state = state();
        state.sun_deg = [90.0, 0.0];
        let [east, up, south] = state.look().to_sun;
        assert!((east - 1.0).abs() < 1e-6 && up.abs() < 1e-6 && south.abs() < 1e-6);
    }
}
