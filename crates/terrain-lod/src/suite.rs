//! What a bench flies: a suite, which is a TOML file, and the flags that override it.

mod bench;

use std::ops::RangeInclusive;
use std::path::Path;

use regex_lite::Regex;
use serde::{Deserialize, Serialize};
use terrain_core::Heightmap;
use terrain_core::source::SourceText;

use crate::choices::{
    BatchingName, EdgePolicyName, IndexStoreName, LoadingName, MetricName, ScheduleName, SelectorName, TriangulatorName,
};
use crate::cli::{BenchArgs, MethodArgs};
use crate::fault::{Cause, Fault};
use crate::methods::{MethodName, Run, Settings};
use crate::pivot::Pivot;

pub use bench::Bench;

/// The suites in `data/suites`.
const BUILT_IN: [(&str, &str); 5] = [
    ("htp", include_str!("../../../data/suites/htp.toml")),
    ("htp-window", include_str!("../../../data/suites/htp-window.toml")),
    ("live", include_str!("../../../data/suites/live.toml")),
    ("quick", include_str!("../../../data/suites/quick.toml")),
    ("smoke", include_str!("../../../data/suites/smoke.toml")),
];

/// What lengths on the screen can mean anything.
pub const PIXELS: RangeInclusive<f64> = 1e-6..=1e6;
/// Pixels along one side of the picture.
pub const SIDE_PX: RangeInclusive<u32> = 1..=16_384;
/// Frames of one flight.
pub const FRAMES: RangeInclusive<u32> = 1..=1_000_000;
/// Grid intervals between the rows that decimation keeps.
pub const STEPS: RangeInclusive<u32> = 1..=Heightmap::MAX_SIDE;
/// Flights of each run in the speed pass.
pub const REPEATS: RangeInclusive<u32> = 1..=1_000;
/// Parts of a whole, where something is to be narrower or to differ by more than that.
pub const SHARES: RangeInclusive<f64> = 1e-4..=10.0;
/// Threads of a method.
pub const THREADS: RangeInclusive<u32> = 1..=256;

/// A suite file. What it leaves out has the default of the flag with the same name.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Suite {
    /// For people.
    pub description: String,
    /// As `--dem`.
    pub dem: String,
    /// As `--flight`.
    pub flight: String,
    /// As `--methods`.
    pub methods: Vec<MethodName>,
    /// As `--filter`.
    pub filter: Option<String>,
    /// As `--tolerance`.
    pub tolerance_px: Vec<f64>,
    /// As `--selector`.
    pub selector: Vec<SelectorName>,
    /// As `--patch`.
    pub patch: Vec<u32>,
    /// As `--leg-px`.
    pub leg_px: Vec<f64>,
    /// As `--step`.
    pub step: Vec<u32>,
    /// As `--distance`.
    pub distance_m: Option<f64>,
    /// As `--max-spacing`.
    pub max_spacing: Option<u32>,
    /// As `--group`.
    pub group: Option<u32>,
    /// As `--blocks`.
    pub blocks: bool,
    /// As `--schedule`.
    pub schedule: Vec<ScheduleName>,
    /// As `--triangulator`.
    pub triangulator: Vec<TriangulatorName>,
    /// As `--index-store`.
    pub index_store: IndexStoreName,
    /// As `--edge-policy`.
    pub edge_policy: EdgePolicyName,
    /// As `--jitter`.
    pub jitter: Option<u32>,
    /// As `--smoothing`.
    pub smoothing: bool,
    /// As `--metric`; empty: by the batching.
    pub metric: Vec<MetricName>,
    /// As `--batching`; empty: by the method's name.
    pub batching: Vec<BatchingName>,
    /// As `--k`.
    pub k: Vec<u32>,
    /// As `--layers`.
    pub layers: Option<u32>,
    /// As `--geomorph`.
    pub geomorph: bool,
    /// As `--window-mib`; empty: the whole DEM is in memory.
    pub window_mib: Vec<u32>,
    /// As `--loading`.
    pub loading: LoadingName,
    /// As `--threads`.
    pub threads: u16,
    /// As `--size`.
    pub size_px: [u32; 2],
    /// As `--frames`: evenly over the flight; without it as many as the flight has at its own steps a second.
    pub frames: Option<u32>,
    /// As `--repeats`.
    pub repeats: u32,
    /// As `--until-ci`: the width of an interval as a share of its median.
    pub until_ci: Option<f64>,
    /// As `--max-repeats`.
    pub max_repeats: u32,
    /// As `--aa`.
    pub aa: bool,
    /// Frames at the start of each flight of the speed pass that are not counted.
    pub warm_up: u32,
    /// Tables after the one of all runs.
    pub tables: Vec<Pivot>,
}

impl Default for Suite {
    fn default() -> Self {
        use MethodName::{FullGrid, Htp, HtpInstanced, Tin};
        Self {
            description: String::new(),
            dem: "jacksboro".into(),
            flight: "ground-level".into(),
            methods: vec![Tin, Htp, HtpInstanced, FullGrid],
            filter: None,
            tolerance_px: vec![1.0],
            selector: vec![SelectorName::default()],
            patch: vec![32],
            leg_px: vec![8.0],
            step: vec![2, 4, 8],
            distance_m: None,
            max_spacing: None,
            group: None,
            blocks: true,
            schedule: vec![ScheduleName::default()],
            triangulator: vec![TriangulatorName::default()],
            index_store: IndexStoreName::default(),
            edge_policy: EdgePolicyName::default(),
            jitter: None,
            smoothing: false,
            metric: Vec::new(),
            batching: Vec::new(),
            k: vec![3],
            layers: None,
            geomorph: false,
            window_mib: Vec::new(),
            loading: LoadingName::default(),
            threads: 1,
            size_px: [640, 360],
            frames: None,
            repeats: 3,
            until_ci: None,
            max_repeats: 30,
            aa: false,
            warm_up: 10,
            tables: Vec::new(),
        }
    }
}

impl Suite {
    fn named(name: &str) -> Result<Self, Fault> {
        let (place, text) = match BUILT_IN.iter().find(|suite| suite.0 == name) {
            Some((name, text)) => (name.to_string(), text.to_string()),
            None => {
                let built_in: Vec<&str> = BUILT_IN.iter().map(|suite| suite.0).collect();
                let expected = &format!("a suite file, or one of the built-in suites {}", built_in.join(", "));
                let text = std::fs::read_to_string(name).map_err(|e| Fault::read(Path::new(name), &e, expected))?;
                (name.into(), text)
            }
        };
        let source = SourceText { name: &place, text: &text };
        source.parse().map_err(|error| Fault::new(Cause::BadInput, error))
    }

    /// The suite that the command line names, with the command line's own choices.
    pub fn from_args(args: &BenchArgs) -> Result<Self, Fault> {
        let mut suite = Self::named(&args.suite)?;
        override_with(&mut suite.dem, &args.dem.dem);
        override_with(&mut suite.flight, &args.flight);
        override_with(&mut suite.methods, &args.methods);
        override_with(&mut suite.tolerance_px, &args.tolerance);
        override_with(&mut suite.selector, &args.selector);
        override_with(&mut suite.patch, &args.patch);
        override_with(&mut suite.leg_px, &args.leg_px);
        override_with(&mut suite.schedule, &args.schedule);
        override_with(&mut suite.triangulator, &args.triangulator);
        override_with(&mut suite.metric, &args.metric);
        override_with(&mut suite.batching, &args.batching);
        override_with(&mut suite.k, &args.k);
        override_with(&mut suite.window_mib, &args.window_mib);
        override_with(&mut suite.step, &args.step);
        override_with(&mut suite.size_px, &args.size);
        override_with(&mut suite.repeats, &args.repeats);
        override_with(&mut suite.max_repeats, &args.max_repeats);
        suite.filter = args.filter.clone().or(suite.filter);
        suite.until_ci = args.until_ci.or(suite.until_ci);
        suite.aa |= args.aa;
        suite.frames = args.frames.or(suite.frames);
        suite.tolerance_px = without_repeats(suite.tolerance_px);
        suite.override_settings(&args.method);
        Ok(suite)
    }

    /// Takes the settings that are given on the command line.
    pub fn override_settings(&mut self, args: &MethodArgs) {
        override_with(&mut self.blocks, &args.blocks);
        override_with(&mut self.index_store, &args.index_store);
        override_with(&mut self.edge_policy, &args.edge_policy);
        override_with(&mut self.threads, &args.threads);
        self.distance_m = args.distance.or(self.distance_m);
        self.max_spacing = args.max_spacing.or(self.max_spacing);
        self.group = args.group.or(self.group);
        self.jitter = args.jitter.or(self.jitter);
        self.smoothing |= args.smoothing;
        self.geomorph |= args.geomorph;
        self.layers = args.layers.or(self.layers);
        override_with(&mut self.loading, &args.loading);
    }

    /// What the command line checks flag by flag, a suite file must keep as well.
    fn validate(&self) -> Result<(), String> {
        let within = |name: &str, value: u32, range: RangeInclusive<u32>| match range.contains(&value) {
            true => Ok(()),
            false => Err(format!("{name} = {value}; expected {} to {}", range.start(), range.end())),
        };
        let pixels = |name: &str, list: &[f64]| match list.iter().find(|px| !PIXELS.contains(*px)) {
            Some(px) => Err(format!("{name} = {px}; expected {:e} to {:e}", PIXELS.start(), PIXELS.end())),
            None if list.is_empty() => Err(format!("{name} is empty; expected at least one")),
            None => Ok(()),
        };
        let lists = [
            ("methods", self.methods.len()),
            ("selector", self.selector.len()),
            ("patch", self.patch.len()),
            ("k", self.k.len()),
            ("step", self.step.len()),
            ("schedule", self.schedule.len()),
            ("triangulator", self.triangulator.len()),
        ];
        if let Some((name, _)) = lists.iter().find(|(_, length)| *length == 0) {
            return Err(format!("{name} is empty; expected at least one"));
        }
        pixels("tolerance_px", &self.tolerance_px)?;
        pixels("leg_px", &self.leg_px)?;
        self.step.iter().try_for_each(|step| within("step", *step, STEPS))?;
        if let Some(distance_m) = self.distance_m.filter(|m| !(*m > 0.0 && m.is_finite())) {
            return Err(format!("distance_m = {distance_m}; expected a number above 0"));
        }
        within("size_px", self.size_px[0], SIDE_PX)?;
        within("size_px", self.size_px[1], SIDE_PX)?;
        within("frames", self.frames.unwrap_or(1), FRAMES)?;
        within("repeats", self.repeats, REPEATS)?;
        within("max_repeats", self.max_repeats, REPEATS)?;
        if let Some(share) = self.until_ci.filter(|share| !SHARES.contains(share)) {
            return Err(format!("until_ci = {share}; expected {} to {}", SHARES.start(), SHARES.end()));
        }
        within("threads", self.threads.into(), THREADS)?;
        self.tables.iter().try_for_each(Pivot::validate)
    }

    /// One run for each method and each value of its own settings, in the order of the lists.
    pub fn runs(&self) -> Result<Vec<Run>, Fault> {
        let filter = self.filter.as_deref().map(parse_filter).transpose()?;
        let asked_for = |run: &Run| filter.as_ref().is_none_or(|filter| filter.is_match(&run.title()));
        let mut runs: Vec<Run> = Vec::new();
        for method in &self.methods {
            for settings in self.all_settings() {
                let run = Run { method: *method, settings };
                run.validate()?;
                if !asked_for(&run) {
                    continue;
                }
                // Values of settings that the method does not have would only repeat it.
                if !runs.iter().any(|other| other.file_stem() == run.file_stem()) {
                    runs.push(run);
                }
            }
        }
        match (&self.filter, runs.is_empty()) {
            (Some(filter), true) => {
                Err(Fault::usage(format!("no run matches the filter '{filter}'; --dry-run lists them")))
            }
            _ => Ok(runs),
        }
    }

    /// The most flights of each run in the speed pass.
    pub fn most_repeats(&self) -> u32 {
        if self.until_ci.is_some() { self.repeats.max(self.max_repeats) } else { self.repeats }
    }

    /// Every combination of the lists.
    fn all_settings(&self) -> Vec<Settings> {
        let all = vec![self.first_settings()];
        let all = with_each(all, &self.tolerance_px, |settings, px| settings.tolerance_px = px);
        let all = with_each(all, &self.selector, |settings, selector| settings.selector = selector);
        let all = with_each(all, &self.triangulator, |settings, name| settings.triangulator = name);
        let all = with_each(all, &self.schedule, |settings, schedule| settings.schedule = schedule);
        let all = with_each(all, &self.patch, |settings, patch| settings.patch = patch);
        let all = with_each(all, &self.leg_px, |settings, px| settings.leg_px = px);
        let all = with_each(all, &self.k, |settings, k| settings.k = k);
        let all = with_each_or_none(all, &self.batching, |settings, name| settings.batching = name);
        let all = with_each_or_none(all, &self.metric, |settings, name| settings.metric = name);
        let all = with_each_or_none(all, &self.window_mib, |settings, mib| settings.window_mib = mib);
        let mut all = with_each(all, &self.step, |settings, step| settings.step = step);
        // The bounded selector knows one triangulator. The others of a list are for algorithm 1.
        let has_grid = self.triangulator.contains(&TriangulatorName::Grid);
        let fits = |s: &Settings| s.selector != SelectorName::Bounded || s.triangulator == TriangulatorName::Grid;
        all.retain(|settings| fits(settings) || !has_grid);
        all
    }

    /// The first of each list.
    fn first_settings(&self) -> Settings {
        Settings {
            tolerance_px: self.tolerance_px[0],
            selector: self.selector[0],
            patch: self.patch[0],
            max_spacing: self.max_spacing,
            group: self.group,
            blocks: self.blocks,
            schedule: self.schedule[0],
            triangulator: self.triangulator[0],
            index_store: self.index_store,
            edge_policy: self.edge_policy,
            jitter: self.jitter,
            smoothing: self.smoothing,
            metric: None,
            batching: None,
            leg_px: self.leg_px[0],
            k: self.k[0],
            layers: self.layers,
            geomorph: self.geomorph,
            window_mib: None,
            loading: self.loading,
            step: self.step[0],
            distance_m: self.distance_m,
            threads: self.threads.into(),
        }
    }

    /// The tolerances that a run has a row for: its own, or all of them as yardsticks.
    pub fn tolerances_of(&self, run: &Run) -> Vec<f64> {
        if run.takes_tolerance() { vec![run.settings.tolerance_px] } else { self.tolerance_px.clone() }
    }
}

fn parse_filter(text: &str) -> Result<Regex, Fault> {
    let refuse = |error| Fault::usage(format!("filter '{text}': {}", format!("{error}").replace('\n', " ")));
    Regex::new(text).map_err(refuse)
}

/// The settings with each value of a list in turn.
fn with_each<T: Copy>(all: Vec<Settings>, list: &[T], set: fn(&mut Settings, T)) -> Vec<Settings> {
    let with = |mut settings: Settings, value: &T| {
        set(&mut settings, *value);
        settings
    };
    all.into_iter().flat_map(|settings| list.iter().map(move |value| with(settings, value))).collect()
}

/// Likewise; without any value, the settings as they are.
fn with_each_or_none<T: Copy>(all: Vec<Settings>, list: &[T], set: fn(&mut Settings, Option<T>)) -> Vec<Settings> {
    if list.is_empty() { all } else { with_each(all, &list.iter().map(|value| Some(*value)).collect::<Vec<_>>(), set) }
}

/// The list with the first of each value.
fn without_repeats(list: Vec<f64>) -> Vec<f64> {
    let is_first = |(i, value): &(usize, &f64)| !list[..*i].contains(value);
    list.iter().enumerate().filter(is_first).map(|(_, value)| *value).collect()
}

/// Takes the flag's value where the flag is given.
pub fn override_with<T: Clone>(value: &mut T, flag: &Option<T>) {
    if let Some(flag) = flag {
        value.clone_from(flag);
    }
}
