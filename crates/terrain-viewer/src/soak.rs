//! Random input by a seed: keys, pointer, settings, DEMs and lost devices, as no person would give them.

use egui::{Event, Key, Pos2, pos2};
use terrain_core::SplitMix64;

use crate::command::{Command, KEYS, Mode, Side};
use crate::run_text;
use crate::script::{button, press, wheel};

/// Methods that are asked for, some of which are refused.
const RUNS: [&str; 12] = [
    "tin",
    "tin tolerance_px=0.5 selector=algorithm1 triangulator=spade",
    "tin tolerance_px=4 patch=16 schedule=blocking",
    "tin selector=algorithm1 triangulator=delaunator jitter=3 smoothing=true",
    "htp",
    "htp batching=merged-cell leg_px=20",
    "htp-instanced tolerance_px=2",
    "htp-instanced window_mib=4 layers=3",
    "rqt",
    "geomipmap tolerance_px=3",
    "decimated step=4",
    "full-grid",
];

pub struct RandomInput {
    random: SplitMix64,
    size: [f64; 2],
    pointer: Pos2,
    is_down: bool,
    held: Option<Key>,
}

impl RandomInput {
    pub fn new(seed: u64, size_px: [u32; 2]) -> Self {
        Self {
            random: SplitMix64::new(seed),
            size: size_px.map(f64::from),
            pointer: Pos2::ZERO,
            is_down: false,
            held: None,
        }
    }

    fn below(&mut self, end: usize) -> usize {
        (self.random.range(0.0, end as f64) as usize).min(end - 1)
    }

    /// Now and then something that takes a while.
    pub fn commands(&mut self) -> Vec<Command> {
        let side = if self.below(2) == 0 { Side::Left } else { Side::Right };
        let command = match self.below(600) {
            0..12 => {
                let line = RUNS[self.below(RUNS.len())];
                Command::Method(side, Box::new(run_text::parse(line).expect("these are runs")))
            }
            12 => Command::Exaggeration(self.random.range(0.5, 3.0)),
            13 => Command::OpenDem(["jacksboro", "synthetic:129x200:3", "no-such-dem.tif"][self.below(3)].into()),
            14 => Command::OpenFlight(["fly-over", "turn", "no-such-flight.toml"][self.below(3)].into()),
            15 => Command::LoseDevice,
            16..20 => Command::Mode(Mode::ALL[self.below(Mode::ALL.len())]),
            20..24 => Command::Divider(self.random.range(0.0, 1.0)),
            24 => Command::Camera("not a camera".into()),
            _ => return Vec::new(),
        };
        vec![command]
    }

    pub fn events(&mut self) -> Vec<Event> {
        let mut events = Vec::new();
        if self.below(4) == 0 {
            self.pointer =
                pos2(self.random.range(0.0, self.size[0]) as f32, self.random.range(0.0, self.size[1]) as f32);
            events.push(Event::PointerMoved(self.pointer));
        }
        if self.below(6) == 0 {
            self.is_down = !self.is_down;
            events.push(button(self.pointer, self.is_down));
        }
        if self.below(20) == 0 {
            events.push(wheel(self.random.range(-3.0, 3.0) as f32));
        }
        if self.below(8) == 0 {
            events.extend(self.held.take().map(|key| press(key, false)));
            let key = Key::ALL[self.below(Key::ALL.len())];
            let bound = KEYS[self.below(KEYS.len())].key;
            let key = if self.below(2) == 0 { key } else { bound };
            // Files would fill the folder.
            if !matches!(key, Key::F12 | Key::R) {
                events.push(press(key, true));
                self.held = Some(key);
            }
        }
        events
    }
}
