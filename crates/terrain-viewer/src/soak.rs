//! Random input by a seed: keys, pointer, settings, DEMs, sizes of the window and lost devices, as no person would give them.

use std::path::Path;

use egui::{Event, Key, Pos2, pos2};
use terrain_core::SplitMix64;
use terrain_renderer::Submission;

use crate::apply::dropped;
use crate::command::{Command, KEYS, Mode, Side};
use crate::run_text;
use crate::script::{button, press, wheel};

/// All methods of the bench, in the variants that differ in code and not in numbers alone. Some are refused over some DEMs.
const RUNS: [&str; 24] = [
    "tin",
    "tin tolerance_px=0.5 selector=algorithm1 triangulator=spade",
    "tin tolerance_px=4 patch=16 schedule=blocking",
    "tin selector=algorithm1 triangulator=delaunator jitter=3 smoothing=true",
    "tin selector=algorithm1 edge_policy=paper index_store=fixed group=1 tolerance_px=1",
    "tin group=1 index_store=fixed threads=2",
    "tin blocks=true tolerance_px=1 threads=2",
    "htp",
    "htp leg_px=12 k=16",
    "htp metric=box",
    "htp metric=error tolerance_px=3",
    "htp batching=merged-cell leg_px=20",
    "htp-instanced tolerance_px=2",
    "htp-instanced metric=distance geomorph=true leg_px=16",
    "htp-instanced window_mib=4 layers=3",
    "htp-instanced window_mib=4 layers=3 loading=blocking",
    "rqt",
    "rqt tolerance_px=0.5",
    "geomipmap tolerance_px=3",
    "greedy tolerance_px=8",
    "greedy tolerance_px=4 distance_m=9000",
    "decimated step=4",
    "decimated step=16",
    "full-grid",
];

const DEMS: [&str; 5] =
    ["jacksboro", "synthetic:129x200:3", "synthetic:513x513:11", "synthetic:33x1025:5", "no-such-dem.tif"];
/// Dropped on the window: what there is of them depends on the folder.
const DROPPED: [&str; 5] = [
    "data/dem/jacksboro.png",
    "data/flights/low-and-slow.toml",
    "data/suites/smoke.toml",
    "README.md",
    "no-such-flight.toml",
];

pub struct RandomInput {
    random: SplitMix64,
    /// Of the window, in pixels: it starts so and never gets larger.
    largest: [u32; 2],
    size: [f64; 2],
    pointer: Pos2,
    is_down: bool,
    held: Option<Key>,
}

impl RandomInput {
    pub fn new(seed: u64, size_px: [u32; 2]) -> Self {
        Self {
            random: SplitMix64::new(seed),
            largest: size_px,
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
            13 => Command::OpenDem(DEMS[self.below(DEMS.len())].into()),
            14 => Command::OpenFlight(["fly-over", "turn", "stop-and-go"][self.below(3)].into()),
            15 => Command::LoseDevice,
            16..20 => Command::Mode(Mode::ALL[self.below(Mode::ALL.len())]),
            20..24 => Command::Divider(self.random.range(0.0, 1.0)),
            24 => Command::Camera("not a camera".into()),
            25 => dropped(Path::new(DROPPED[self.below(DROPPED.len())])),
            26 => Command::Sun([self.random.range(0.0, 360.0), self.random.range(0.0, 90.0)]),
            27 => Command::ErrorScale(self.random.range(0.1, 32.0)),
            28 => Command::Submission([Submission::Direct, Submission::MultiIndirect][self.below(2)]),
            29 => Command::Scrub(self.below(2000) as u32),
            30 => Command::Screenshot(Some(std::env::temp_dir().join("terrain-viewer-soak.png"))),
            31..33 => Command::Stale,
            33..35 => Command::Boxes,
            35..37 => Command::Freeze,
            _ => return Vec::new(),
        };
        vec![command]
    }

    /// Now and then another size of the window, down to a single row.
    pub fn resize(&mut self) -> Option<[u32; 2]> {
        if self.below(400) != 0 {
            return None;
        }
        let largest = self.largest.map(f64::from);
        let size = match self.below(4) {
            0 => self.largest,
            1 => largest.map(|side| self.random.range(1.0, 0.1 * side) as u32),
            _ => largest.map(|side| self.random.range(0.2, 1.0) * side).map(|side| side as u32),
        };
        let size = size.map(|side| side.max(1));
        self.size = size.map(f64::from);
        Some(size)
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

#[cfg(test)]
mod tests {
    use clap::ValueEnum;
    use terrain_lod::MethodName;

    use super::*;

    #[test]
    fn every_method_of_the_bench_gets_its_turn() {
        let methods = RUNS.map(|line| run_text::parse(line).unwrap_or_else(|reason| panic!("{line}: {reason}")).method);
        for method in MethodName::value_variants() {
            assert!(methods.contains(method), "{method:?}");
        }
    }

    #[test]
    fn a_window_keeps_a_pixel() {
        let mut input = RandomInput::new(1, [64, 1]);
        let sizes: Vec<[u32; 2]> = (0..20_000).filter_map(|_| input.resize()).collect();
        assert!(sizes.len() > 20 && sizes.iter().all(|[width, height]| (1..=64).contains(width) && *height == 1));
    }
}
