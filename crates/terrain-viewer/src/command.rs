//! What a user can ask for: keys, panel, and scripts all say it in these words.

use std::path::PathBuf;

use egui::Key;
use terrain_lod::Run;
use terrain_renderer::Submission;

use crate::run_text;

/// One of the two panes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    Left,
    Right,
}

/// What the terrain is coloured by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mode {
    #[default]
    Shaded,
    Level,
    Patch,
    /// The unit that a method loads.
    Cell,
    /// Draw call by draw call.
    Draw,
    /// How far the mesh is from the DEM, in pixels.
    Error,
    /// How far the two methods' pictures are apart.
    Difference,
}

impl Mode {
    pub const ALL: [Self; 7] =
        [Self::Shaded, Self::Level, Self::Patch, Self::Cell, Self::Draw, Self::Error, Self::Difference];

    pub fn name(self) -> &'static str {
        match self {
            Self::Shaded => "shaded",
            Self::Level => "level",
            Self::Patch => "patch",
            Self::Cell => "cell",
            Self::Draw => "draw",
            Self::Error => "error",
            Self::Difference => "difference",
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    Help,
    Panel,
    Hud,
    Map,
    /// Both sides, the left one alone, the right one alone.
    Flip,
    Mode(Mode),
    NextMode,
    Wireframe,
    Normals,
    /// Mark what is drawn for an older view.
    Stale,
    /// A box around each patch.
    Boxes,
    Freeze,
    AboveGround,
    Orbit,
    Record,
    Play,
    /// By frames of the flight, which pauses.
    Step(i32),
    Scrub(u32),
    /// To this file, or to a name with a number.
    Screenshot(Option<PathBuf>),
    CopyCamera,
    Method(Side, Box<Run>),
    /// As a share of the window's width.
    Divider(f64),
    /// As [`Rig::link`](crate::camera::Rig::link).
    Camera(String),
    OpenDem(String),
    OpenFlight(String),
    /// Heading and height above the horizon in degrees.
    Sun([f64; 2]),
    /// Times the DEM's own heights.
    Exaggeration(f64),
    /// Pixels that are red in mode error.
    ErrorScale(f64),
    Submission(Submission),
    /// The device is destroyed, and its loss is told as a driver's would be: for tests.
    LoseDevice,
    Quit,
}

/// A key, what it does, and how the help says it.
pub struct KeyBinding {
    pub key: Key,
    pub command: fn() -> Command,
    pub says: &'static str,
}

const fn key(key: Key, command: fn() -> Command, says: &'static str) -> KeyBinding {
    KeyBinding { key, command, says }
}

/// The keys that ask for something once; those that fly are in [`FLYING`].
pub static KEYS: [KeyBinding; 27] = [
    key(Key::Tab, || Command::Flip, "both methods, the left one, the right one"),
    key(Key::M, || Command::NextMode, "next mode"),
    key(Key::Num1, || Command::Mode(Mode::Shaded), "shaded"),
    key(Key::Num2, || Command::Mode(Mode::Level), "colour by level"),
    key(Key::Num3, || Command::Mode(Mode::Patch), "colour by patch"),
    key(Key::Num4, || Command::Mode(Mode::Error), "error in pixels"),
    key(Key::Num5, || Command::Mode(Mode::Difference), "difference of the two pictures"),
    key(Key::Num6, || Command::Mode(Mode::Cell), "colour by cell"),
    key(Key::Num7, || Command::Mode(Mode::Draw), "colour by draw call"),
    key(Key::T, || Command::Stale, "mark stale patches"),
    key(Key::B, || Command::Boxes, "a box around each patch"),
    key(Key::X, || Command::Wireframe, "wireframe"),
    key(Key::N, || Command::Normals, "normals per pixel or per vertex"),
    key(Key::F, || Command::Freeze, "freeze the level of detail, and fly on"),
    key(Key::G, || Command::AboveGround, "stay above the ground, or not"),
    key(Key::C, || Command::Orbit, "circle the point in the middle, or fly"),
    key(Key::R, || Command::Record, "record a flight, or end it: a TOML file"),
    key(Key::P, || Command::Play, "play the flight, or pause"),
    key(Key::Comma, || Command::Step(-1), "one frame of the flight back"),
    key(Key::Period, || Command::Step(1), "one frame of the flight on"),
    key(Key::F12, || Command::Screenshot(None), "screenshot, with the camera's link beside it"),
    key(Key::L, || Command::CopyCamera, "copy the camera as text for --camera"),
    key(Key::O, || Command::Panel, "panel"),
    key(Key::U, || Command::Hud, "numbers"),
    key(Key::J, || Command::Map, "map"),
    key(Key::H, || Command::Help, "this help"),
    key(Key::F10, || Command::Quit, "quit"),
];

/// Keys and gestures that fly.
pub static FLYING: [(&str, &str); 8] = [
    ("W A S D", "forward, left, back, right"),
    ("Q E", "down, up"),
    ("Shift", "five times as fast"),
    ("Arrows", "turn"),
    ("Drag", "look around, or circle"),
    ("Wheel", "speed; in orbit nearer and farther"),
    ("Ctrl + wheel", "field of view"),
    ("Double click", "jump to the point"),
];

impl Command {
    /// A command in a script: its name, and its value where it takes one.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let value = value.trim();
        let simple = match name {
            "help" => Self::Help,
            "panel" => Self::Panel,
            "hud" => Self::Hud,
            "map" => Self::Map,
            "flip" => Self::Flip,
            "wireframe" => Self::Wireframe,
            "normals" => Self::Normals,
            "stale" => Self::Stale,
            "boxes" => Self::Boxes,
            "freeze" => Self::Freeze,
            "above-ground" => Self::AboveGround,
            "orbit" => Self::Orbit,
            "record" => Self::Record,
            "play" => Self::Play,
            "lose-device" => Self::LoseDevice,
            "quit" => Self::Quit,
            _ => return Self::parse_valued(name, value),
        };
        if value.is_empty() { Ok(simple) } else { Err(format!("{name}: unexpected '{value}'")) }
    }

    fn parse_valued(name: &str, value: &str) -> Result<Self, String> {
        match name {
            "mode" => {
                let mode = Mode::ALL.into_iter().find(|mode| mode.name() == value);
                mode.map(Self::Mode)
                    .ok_or_else(|| format!("mode '{value}': expected {}", Mode::ALL.map(Mode::name).join(", ")))
            }
            "left" => Ok(Self::Method(Side::Left, Box::new(run_text::parse(value)?))),
            "right" => Ok(Self::Method(Side::Right, Box::new(run_text::parse(value)?))),
            "step" => number(name, value, -1e6..=1e6).map(|frames| Self::Step(frames as i32)),
            "scrub" => number(name, value, 0.0..=1e6).map(|frame| Self::Scrub(frame as u32)),
            "divider" => number(name, value, 0.0..=1.0).map(Self::Divider),
            "exaggeration" => number(name, value, 0.1..=20.0).map(Self::Exaggeration),
            "error-scale" => number(name, value, 0.01..=1e3).map(Self::ErrorScale),
            "sun" => {
                let (heading, height) = value.split_once(',').ok_or("sun: expected HEADING,HEIGHT in degrees")?;
                Ok(Self::Sun([number(name, heading, 0.0..=360.0)?, number(name, height, 0.0..=90.0)?]))
            }
            "camera" => Ok(Self::Camera(value.into())),
            "dem" => Ok(Self::OpenDem(value.into())),
            "flight" => Ok(Self::OpenFlight(value.into())),
            "submission" if value == "direct" => Ok(Self::Submission(Submission::Direct)),
            "submission" if value == "multi" => Ok(Self::Submission(Submission::MultiIndirect)),
            "submission" => Err(format!("submission '{value}': expected direct or multi")),
            _ => Err(format!("unknown command '{name}'; the viewer's README section lists them")),
        }
    }
}

fn number(name: &str, text: &str, range: std::ops::RangeInclusive<f64>) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number| range.contains(number));
    number.ok_or_else(|| format!("{name} '{text}': expected a number from {} to {}", range.start(), range.end()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_bound_once() {
        for (i, binding) in KEYS.iter().enumerate() {
            assert!(KEYS[..i].iter().all(|other| other.key != binding.key), "{:?}", binding.key);
        }
    }

    #[test]
    fn scripts_name_commands_and_are_told_what_is_wrong() {
        assert_eq!(Command::parse("mode error"), Ok(Command::Mode(Mode::Error)));
        assert_eq!(Command::parse("sun 90,30"), Ok(Command::Sun([90.0, 30.0])));
        let refused = |text| Command::parse(text).unwrap_err();
        assert_eq!(refused("mode x"), "mode 'x': expected shaded, level, patch, cell, draw, error, difference");
        assert_eq!(refused("divider 2"), "divider '2': expected a number from 0 to 1");
        assert!(refused("fly").starts_with("unknown command 'fly'"));
        assert_eq!(refused("freeze now"), "freeze: unexpected 'now'");
    }
}
