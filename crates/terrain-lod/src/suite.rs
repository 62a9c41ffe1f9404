//! What a bench flies: a suite, which is a TOML file, and the flags that override it.

mod bench;
mod check;
mod file;
mod one_or_more;
mod runs;

use std::ops::RangeInclusive;
use std::path::Path;

use serde::{Deserialize, Serialize};
use terrain_core::Heightmap;

use crate::choices::{
    BatchingName, EdgePolicyName, IndexStoreName, LoadingName, MetricName, ScheduleName, SelectorName, TriangulatorName,
};
use crate::cli::{BenchArgs, MethodArgs};
use crate::dem_args::VoidsName;
use crate::equal_error::EqualError;
use crate::figures::Figure;
use crate::flight_curves::FlightCurves;
use crate::methods::{MethodName, Settings};
use crate::pivot::Pivot;
use crate::render_args::{NormalsName, SubmissionName};

pub use bench::{Bench, open_flight};
pub use file::{NamedSuite, SuiteFile, check_suite, is_folder_name};
use one_or_more::one_or_more;

/// The DEM of the TIN's paper, which the user has to bring along.
const PUGET: &str = "puget";

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

/// A suite file. What it leaves out has the default of the flag with the same name. Every combination of the lists is flown.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Suite {
    /// For people.
    pub description: String,
    /// As `--dem`.
    pub dem: String,
    /// With the DEM `puget`: what is flown over where `--puget` is not given; without, the bench is left out then.
    pub stand_in: Option<String>,
    /// As `--crop`: a part of the DEM, of the one that `--dem` names too.
    pub crop: Option<String>,
    /// As `--thin`; likewise.
    pub thin: Option<u32>,
    /// As `--voids`; likewise.
    pub voids: Option<VoidsName>,
    /// As `--spacing`, in x and z. This and the two that follow are about the suite's own DEM and not that of `--dem`.
    pub spacing_m: Option<[f64; 2]>,
    /// As `--scale`.
    pub scale: Option<f64>,
    /// As `--offset`.
    pub offset_m: Option<f64>,
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
    /// As `--group`; empty: by the patch.
    #[serde(deserialize_with = "one_or_more")]
    pub group: Vec<u32>,
    /// As `--blocks`.
    #[serde(deserialize_with = "one_or_more")]
    pub blocks: Vec<bool>,
    /// As `--schedule`.
    pub schedule: Vec<ScheduleName>,
    /// As `--triangulator`.
    pub triangulator: Vec<TriangulatorName>,
    /// As `--index-store`.
    #[serde(deserialize_with = "one_or_more")]
    pub index_store: Vec<IndexStoreName>,
    /// As `--edge-policy`.
    #[serde(deserialize_with = "one_or_more")]
    pub edge_policy: Vec<EdgePolicyName>,
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
    /// As `--layers`; empty: by the metric.
    #[serde(deserialize_with = "one_or_more")]
    pub layers: Vec<u32>,
    /// As `--geomorph`.
    #[serde(deserialize_with = "one_or_more")]
    pub geomorph: Vec<bool>,
    /// As `--window-mib`; empty: the whole DEM is in memory.
    pub window_mib: Vec<u32>,
    /// As `--loading`.
    pub loading: LoadingName,
    /// As `--threads`.
    #[serde(deserialize_with = "one_or_more")]
    pub threads: Vec<u16>,
    /// As `--submission`.
    pub submission: SubmissionName,
    /// As `--normals`.
    pub normals: NormalsName,
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
    /// Tables after the one of all runs; at the top of a file with benches, over the rows of all of them.
    pub tables: Vec<Pivot>,
    /// What families of runs cost at one measured error; at the top of the file alone.
    pub equal_error: Vec<EqualError>,
    /// Charts over the flight for `report`; at the top of the file alone.
    pub flight_curves: Vec<FlightCurves>,
    /// Pictures and drawings beside the tables; at the top of the file alone.
    #[serde(skip_serializing)]
    pub figures: Vec<Figure>,
    /// Several benches, each with a `name` and the fields in which it differs; see [`SuiteFile`]. Empty: the suite is one.
    #[serde(skip_serializing)]
    pub benches: Vec<toml::Table>,
}

impl Default for Suite {
    fn default() -> Self {
        use MethodName::{FullGrid, Htp, HtpInstanced, Tin};
        Self {
            description: String::new(),
            dem: "jacksboro".into(),
            stand_in: None,
            crop: None,
            thin: None,
            voids: None,
            spacing_m: None,
            scale: None,
            offset_m: None,
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
            group: Vec::new(),
            blocks: vec![true],
            schedule: vec![ScheduleName::default()],
            triangulator: vec![TriangulatorName::default()],
            index_store: vec![IndexStoreName::default()],
            edge_policy: vec![EdgePolicyName::default()],
            jitter: None,
            smoothing: false,
            metric: Vec::new(),
            batching: Vec::new(),
            k: vec![3],
            layers: Vec::new(),
            geomorph: vec![false],
            window_mib: Vec::new(),
            loading: LoadingName::default(),
            threads: vec![1],
            submission: SubmissionName::default(),
            normals: NormalsName::default(),
            size_px: [640, 360],
            frames: None,
            repeats: 3,
            until_ci: None,
            max_repeats: 30,
            aa: false,
            warm_up: 10,
            tables: Vec::new(),
            equal_error: Vec::new(),
            flight_curves: Vec::new(),
            figures: Vec::new(),
            benches: Vec::new(),
        }
    }
}

impl Default for Settings {
    fn default() -> Self {
        Suite::default().first_settings()
    }
}

impl Suite {
    /// Takes the command line's own choices.
    fn override_with_args(&mut self, args: &BenchArgs) {
        let suite = self;
        if let Some(dem) = &args.dem.dem {
            suite.fly_over(dem);
        }
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
        override_with(&mut suite.submission, &args.submission);
        override_with(&mut suite.normals, &args.normals);
        override_with(&mut suite.size_px, &args.size);
        override_with(&mut suite.repeats, &args.repeats);
        override_with(&mut suite.max_repeats, &args.max_repeats);
        suite.filter = args.filter.clone().or(suite.filter.take());
        suite.until_ci = args.until_ci.or(suite.until_ci);
        suite.aa |= args.aa;
        suite.frames = args.frames.or(suite.frames);
        suite.voids = args.dem.read.voids.or(suite.voids);
        suite.tolerance_px = without_repeats(&suite.tolerance_px);
        suite.override_settings(&args.method);
    }

    /// Another DEM than the suite's own: what the suite says of that does not hold for it.
    fn fly_over(&mut self, dem: &str) {
        self.dem = dem.into();
        (self.spacing_m, self.scale, self.offset_m) = (None, None, None);
    }

    /// Puts the file of `--puget` in the place of the DEM `puget`, or what stands in for it, and says the latter. What the
    /// suite says of Puget Sound holds unless the file has a sidecar. An error where there is neither.
    fn resolve_puget(&mut self, args: &BenchArgs) -> Result<Option<String>, String> {
        if self.dem != PUGET {
            return Ok(None);
        }
        match (&args.puget, self.stand_in.clone()) {
            (Some(file), _) if Path::new(file).with_extension("toml").is_file() => self.fly_over(file),
            (Some(file), _) => self.dem.clone_from(file),
            (None, None) => return Err("it needs Puget Sound; --puget FILE names it".into()),
            (None, Some(stand_in)) => {
                self.fly_over(&stand_in);
                return Ok(Some(format!("{stand_in} stands in for Puget Sound, which --puget FILE names")));
            }
        }
        Ok(None)
    }

    /// Takes the settings that are given on the command line.
    pub fn override_settings(&mut self, args: &MethodArgs) {
        override_with(&mut self.blocks, &args.blocks.map(|blocks| vec![blocks]));
        override_with(&mut self.index_store, &args.index_store.map(|store| vec![store]));
        override_with(&mut self.edge_policy, &args.edge_policy.map(|policy| vec![policy]));
        override_with(&mut self.threads, &args.threads.map(|threads| vec![threads]));
        override_with(&mut self.group, &args.group.map(|group| vec![group]));
        override_with(&mut self.layers, &args.layers.map(|layers| vec![layers]));
        override_with(&mut self.geomorph, &args.geomorph.then(|| vec![true]));
        self.distance_m = args.distance.or(self.distance_m);
        self.max_spacing = args.max_spacing.or(self.max_spacing);
        self.jitter = args.jitter.or(self.jitter);
        self.smoothing |= args.smoothing;
        override_with(&mut self.loading, &args.loading);
    }
}

/// The list with the first of each value.
fn without_repeats(list: &[f64]) -> Vec<f64> {
    let is_first = |(i, value): &(usize, &f64)| !list[..*i].contains(value);
    list.iter().enumerate().filter(is_first).map(|(_, value)| *value).collect()
}

/// Takes the flag's value where the flag is given.
pub fn override_with<T: Clone>(value: &mut T, flag: &Option<T>) {
    if let Some(flag) = flag {
        value.clone_from(flag);
    }
}
