//! The viewer without a window: a script presses keys, waits, and takes pictures, on the same code.
//!
//! ```text
//! # one step a line
//! do left tin tolerance_px=2       # a command, as in command.rs
//! key Tab                          # a key, pressed and released
//! hold W 30                        # a key, held for 30 frames
//! drag 640,360 400,360             # the pointer; also: move X,Y  click X,Y  double-click X,Y  wheel NOTCHES
//! wait 10                          # frames, each a sixtieth of a second of flight
//! wait converged                   # until both methods are there, have caught up with the camera, and are measured
//! screenshot picture.png           # what the window would show
//! numbers numbers.toml             # what the HUD says, and the camera
//! soak 60 7                        # random input for 60 seconds, by seed 7
//! ```

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, RawInput, Rect, pos2, vec2};
use serde::Serialize;
use terrain_lod::{Cause, Fault};
use terrain_renderer::{AdapterChoice, Gpu, RenderError, Target};

use crate::command::Command;
use crate::hud::Numbers;
use crate::soak;
use crate::viewer::Viewer;

/// Seconds of flight from one frame to the next.
const STEP_S: f64 = 1.0 / 60.0;
/// The longest wait for methods to converge.
const PATIENCE: Duration = Duration::from_secs(300);
/// Devices that may be lost one after the other before the script gives up.
const MOST_LOST: u32 = 3;

/// A line of a script.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Do(Command),
    Key(Key),
    Hold(Key, u32),
    Move(Pos2),
    Click(Pos2, u32),
    Drag([Pos2; 2]),
    Wheel(f32),
    Wait(u32),
    WaitConverged,
    Screenshot(PathBuf),
    Numbers(PathBuf),
    Soak { seconds: u64, seed: u64 },
}

/// Steps with their line numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Script {
    name: String,
    steps: Vec<(usize, Step)>,
}

impl Script {
    /// Reads all lines before the first is done.
    pub fn parse(name: &str, text: &str) -> Result<Self, Fault> {
        let mut steps = Vec::new();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split_once('#').map_or(line, |(line, _)| line).trim();
            if !line.is_empty() {
                let refuse = |reason| Fault::new(Cause::BadInput, format_args!("{name}:{number}: {reason}"));
                steps.push((number, step(line).map_err(refuse)?));
            }
        }
        Ok(Self { name: name.into(), steps })
    }
}

fn step(line: &str) -> Result<Step, String> {
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let rest = rest.trim();
    let words: Vec<&str> = rest.split_whitespace().collect();
    match (word, words.as_slice()) {
        ("do", [_, ..]) => Command::parse(rest).map(Step::Do),
        ("key", [name]) => key(name).map(Step::Key),
        ("hold", [name, frames]) => Ok(Step::Hold(key(name)?, whole(frames)? as u32)),
        ("move", [at]) => point(at).map(Step::Move),
        ("click", [at]) => Ok(Step::Click(point(at)?, 1)),
        ("double-click", [at]) => Ok(Step::Click(point(at)?, 2)),
        ("drag", [from, to]) => Ok(Step::Drag([point(from)?, point(to)?])),
        ("wheel", [notches]) => notches.parse().map(Step::Wheel).map_err(|_| format!("'{notches}': expected a number")),
        ("wait", ["converged"]) => Ok(Step::WaitConverged),
        ("wait", [frames]) => Ok(Step::Wait(whole(frames)? as u32)),
        ("screenshot", [path]) => Ok(Step::Screenshot(path.into())),
        ("numbers", [path]) => Ok(Step::Numbers(path.into())),
        ("soak", [seconds, seed]) => Ok(Step::Soak { seconds: whole(seconds)?, seed: whole(seed)? }),
        _ => Err(format!(
            "'{line}': expected do COMMAND, key NAME, hold NAME FRAMES, move, click or double-click X,Y, drag X,Y X,Y, \
             wheel NOTCHES, wait FRAMES or converged, screenshot FILE, numbers FILE, or soak SECONDS SEED"
        )),
    }
}

fn key(name: &str) -> Result<Key, String> {
    Key::from_name(name).ok_or_else(|| format!("key '{name}': expected a name such as Tab, W, F12 or Comma"))
}

fn whole(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|number| *number <= 1_000_000).ok_or_else(|| format!("'{text}': expected a whole number"))
}

fn point(text: &str) -> Result<Pos2, String> {
    let numbers = text.split_once(',').and_then(|(x, y)| Some(pos2(x.parse().ok()?, y.parse().ok()?)));
    numbers.ok_or_else(|| format!("'{text}': expected X,Y in pixels"))
}

/// Drives a viewer off-screen.
pub struct Runner {
    pub viewer: Viewer,
    choice: AdapterChoice,
    target: Target,
    frame: u64,
    last: Instant,
    lost: u32,
}

/// What `numbers` writes.
#[derive(Serialize)]
struct Said {
    camera: String,
    message: Option<String>,
    frame_ms_p50: f64,
    frame_ms_p99: f64,
    work_ms_p50: f64,
    work_ms_p99: f64,
    own_ms_p50: Option<f64>,
    own_ms_p99: Option<f64>,
    memory_bytes: Option<u64>,
    flight_frame: Option<u32>,
    left: Option<Numbers>,
    right: Option<Numbers>,
}

impl Runner {
    pub fn new(viewer: Viewer, choice: AdapterChoice, size_px: [u32; 2]) -> Result<Self, Fault> {
        let target = Target::new(&viewer.gpu, size_px)?;
        Ok(Self { viewer, choice, target, frame: 0, last: Instant::now(), lost: 0 })
    }

    /// Does all steps; fails at the first that fails.
    pub fn run(&mut self, script: &Script) -> Result<(), Fault> {
        for (line, step) in &script.steps {
            let at = |reason: &dyn Display| format!("{}:{line}: {reason}", script.name);
            self.step(step).map_err(|fault| Fault::new(fault.cause, at(&fault)))?;
            if self.viewer.wants_quit {
                break;
            }
        }
        Ok(())
    }

    fn step(&mut self, step: &Step) -> Result<(), Fault> {
        match step {
            Step::Do(command) => {
                self.apply(command.clone())?;
                self.frame(Vec::new())
            }
            Step::Key(key) => {
                self.frame(vec![press(*key, true)])?;
                self.frame(vec![press(*key, false)])
            }
            Step::Hold(key, frames) => {
                self.frame(vec![press(*key, true)])?;
                (1..*frames).try_for_each(|_| self.frame(Vec::new()))?;
                self.frame(vec![press(*key, false)])
            }
            Step::Move(at) => self.frame(vec![Event::PointerMoved(*at)]),
            Step::Click(at, times) => {
                self.frame(vec![Event::PointerMoved(*at)])?;
                (0..*times).try_for_each(|_| {
                    self.frame(vec![button(*at, true)])?;
                    self.frame(vec![button(*at, false)])
                })
            }
            Step::Drag([from, to]) => self.drag(*from, *to),
            Step::Wheel(notches) => self.frame(vec![wheel(*notches)]),
            Step::Wait(frames) => (0..*frames).try_for_each(|_| self.frame(Vec::new())),
            Step::WaitConverged => self.wait_converged(),
            Step::Screenshot(path) => Ok(self.target.save_png(&self.viewer.gpu, path)?),
            Step::Numbers(path) => self.write_numbers(path),
            Step::Soak { seconds, seed } => self.soak(*seconds, *seed),
        }
    }

    fn drag(&mut self, from: Pos2, to: Pos2) -> Result<(), Fault> {
        const STEPS: u16 = 8;
        self.frame(vec![Event::PointerMoved(from)])?;
        self.frame(vec![button(from, true)])?;
        for step in 1..=STEPS {
            let at = from.lerp(to, f32::from(step) / f32::from(STEPS));
            self.frame(vec![Event::PointerMoved(at)])?;
        }
        self.frame(vec![button(to, false)])?;
        // The interface answers in the next frame.
        self.frame(vec![Event::PointerGone])
    }

    /// One frame after another until nothing changes any more.
    fn wait_converged(&mut self) -> Result<(), Fault> {
        let start = Instant::now();
        loop {
            self.frame(Vec::new())?;
            if self.viewer.is_converged() {
                // What was measured is shown by the next one.
                return self.frame(Vec::new());
            }
            if start.elapsed() > PATIENCE {
                let message = format!("not converged after {} s", PATIENCE.as_secs());
                return Err(Fault::new(Cause::Failure, message));
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Draws one frame and waits for it.
    fn frame(&mut self, events: Vec<Event>) -> Result<(), Fault> {
        let drawn = self.try_frame(events);
        if drawn.is_ok() {
            self.lost = 0;
        }
        self.recover(drawn)
    }

    fn apply(&mut self, command: Command) -> Result<(), Fault> {
        let applied = self.viewer.apply(command);
        self.recover(applied)
    }

    /// Replaces a lost device.
    fn recover(&mut self, result: Result<(), RenderError>) -> Result<(), Fault> {
        match result {
            Err(error @ (RenderError::Gpu(_) | RenderError::Timeout { .. })) if self.lost < MOST_LOST => {
                self.lost += 1;
                let size_px = self.target.size_px();
                let gpu = Gpu::headless(&self.choice)?;
                self.target = Target::new(&gpu, size_px)?;
                self.viewer.move_to(gpu, Target::COLOUR_FORMAT)?;
                self.viewer.state.say_fault(format!("the device was lost and replaced: {error}"));
                Ok(())
            }
            result => Ok(result?),
        }
    }

    fn try_frame(&mut self, events: Vec<Event>) -> Result<(), RenderError> {
        let [width, height] = self.target.size_px().map(|side| side as f32);
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(width, height))),
            time: Some(self.frame as f64 * STEP_S),
            predicted_dt: STEP_S as f32,
            max_texture_side: Some(self.viewer.gpu.device.limits().max_texture_dimension_2d as usize),
            focused: true,
            events,
            ..Default::default()
        };
        self.frame += 1;
        let wall_s = std::mem::replace(&mut self.last, Instant::now()).elapsed().as_secs_f64();
        let planned = self.viewer.plan(input, self.target.size_px(), STEP_S)?;
        let (_, submission) = self.viewer.draw(planned, self.target.colour_view(), wall_s)?;
        self.viewer.gpu.wait(submission)
    }

    fn write_numbers(&self, path: &Path) -> Result<(), Fault> {
        let Viewer { state, times, memory, panes, .. } = &self.viewer;
        let ([frame_ms_p50, frame_ms_p99], [work_ms_p50, work_ms_p99]) = (times.frame_ms(), times.work_ms());
        let [left, right] = panes.each_ref().map(Numbers::of);
        let said = Said {
            camera: state.rig.link(),
            message: state.message.as_ref().map(|message| message.text.clone()),
            frame_ms_p50,
            frame_ms_p99,
            work_ms_p50,
            work_ms_p99,
            own_ms_p50: times.own_ms().map(|[p50, _]| p50),
            own_ms_p99: times.own_ms().map(|[_, p99]| p99),
            memory_bytes: memory.bytes(),
            flight_frame: state.flight.as_ref().map(|flight| flight.frame()),
            left,
            right,
        };
        let text = toml::to_string(&said).expect("numbers become TOML");
        std::fs::write(path, text).map_err(|error| Fault::write(path, error))
    }

    /// Random input, and what it did to the memory: a line every ten seconds.
    fn soak(&mut self, seconds: u64, seed: u64) -> Result<(), Fault> {
        let mut input = soak::RandomInput::new(seed, self.target.size_px());
        let (start, mut frames, mut said_s) = (Instant::now(), 0_u64, 0);
        while start.elapsed().as_secs() < seconds {
            for command in input.commands() {
                self.apply(command)?;
            }
            if let Some(size_px) = input.resize() {
                self.target = Target::new(&self.viewer.gpu, size_px)?;
            }
            self.frame(input.events())?;
            self.viewer.wants_quit = false;
            frames += 1;
            let now_s = start.elapsed().as_secs();
            if now_s >= said_s + 10 || now_s >= seconds {
                said_s = now_s;
                let mib = self.viewer.memory.bytes().unwrap_or(0) >> 20;
                println!("soak: {now_s} s, {frames} frames, {mib} MiB in memory");
            }
        }
        Ok(())
    }
}

pub fn press(key: Key, pressed: bool) -> Event {
    Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE }
}

pub fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

pub fn wheel(notches: f32) -> Event {
    Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: vec2(0.0, notches),
        phase: egui::TouchPhase::Move,
        source: egui::MouseWheelSource::Unknown,
        modifiers: Modifiers::NONE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Mode;

    #[test]
    fn a_script_is_read_whole() {
        let script =
            Script::parse("s", "# nothing\n\nkey Tab # flips\ndo mode error\nwait converged\ndrag 1,2 3,4\n").unwrap();
        let expected = [
            (3, Step::Key(Key::Tab)),
            (4, Step::Do(Command::Mode(Mode::Error))),
            (5, Step::WaitConverged),
            (6, Step::Drag([pos2(1.0, 2.0), pos2(3.0, 4.0)])),
        ];
        assert_eq!(script.steps, expected);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let refused = |text| Script::parse("s.txt", text).unwrap_err().to_string();
        assert!(refused("wait 3\nfly\n").starts_with("s.txt:2: 'fly': expected do COMMAND, key NAME"));
        assert_eq!(refused("key Tabb"), "s.txt:1: key 'Tabb': expected a name such as Tab, W, F12 or Comma");
        assert_eq!(refused("click 3"), "s.txt:1: '3': expected X,Y in pixels");
        assert_eq!(refused("wait -1"), "s.txt:1: '-1': expected a whole number");
        assert!(refused("do left tin patch=7").starts_with("s.txt:1: "));
    }
}
