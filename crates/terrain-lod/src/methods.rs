//! The one place that names the methods: to add one, add it here.

use std::sync::Arc;

use clap::ValueEnum;
use htp_lod::Htp;
use lod_baselines::{Decimated, FullGrid, Geomipmap, Greedy, Rqt};
use serde::{Deserialize, Serialize};
use terrain_core::{Heightmap, LodMethod};
use tin_lod::{Nodes, Tin};

use crate::cells::Cells;
use crate::choices::{
    BatchingName, EdgePolicyName, IndexStoreName, LoadingName, MetricName, ScheduleName, SelectorName,
    TriangulatorName, name_of,
};
use crate::fault::Fault;
use crate::maps::Maps;
use crate::prepared::Prepared;

/// A method by its name on the command line, in suites and in tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MethodName {
    /// Runtime Delaunay patches (Bertilsson and Goswami 2016)
    Tin,
    /// Hierarchical triangular patches (after Lim and Choi 2008)
    Htp,
    /// The same with --batching instanced
    HtpInstanced,
    /// Every sample in one draw: the reference
    FullGrid,
    /// Every n-th row and column in one draw
    Decimated,
    /// Restricted quadtree by longest-edge bisection (Lindstrom and Pascucci 2002)
    Rqt,
    /// Blocks at levels of detail (de Boer 2000)
    Geomipmap,
    /// One irregular mesh for all views (Garland and Heckbert 1995): few triangles, made offline
    Greedy,
}

impl MethodName {
    /// The name as users write it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Tin => "tin",
            Self::Htp => "htp",
            Self::HtpInstanced => "htp-instanced",
            Self::FullGrid => "full-grid",
            Self::Decimated => "decimated",
            Self::Rqt => "rqt",
            Self::Geomipmap => "geomipmap",
            Self::Greedy => "greedy",
        }
    }
}

/// Settings of one run; each method takes those that it knows. Their defaults are those of the bench's flags.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// tin, rqt, geomipmap: the error in pixels that steers their selection; htp by error: its bound; greedy: its
    /// error at one distance.
    pub tolerance_px: f64,
    /// tin: side of a patch in grid intervals.
    pub patch: u32,
    /// tin: which samples are kept.
    pub selector: SelectorName,
    /// tin: largest distance between selected samples in grid intervals; half a patch without.
    pub max_spacing: Option<u32>,
    /// tin: side of the largest group in patches; without, the largest that the selector can have.
    pub group: Option<u32>,
    /// tin: tolerances by blocks in the patches near the eye.
    pub blocks: bool,
    /// tin: when patches are updated.
    pub schedule: ScheduleName,
    /// tin: what connects the selected samples.
    pub triangulator: TriangulatorName,
    /// tin: which edges follow a patch.
    pub edge_policy: EdgePolicyName,
    /// tin: how the patches share the index buffer.
    pub index_store: IndexStoreName,
    /// tin: seed of the paper's random offsets, if samples are moved.
    pub jitter: Option<u32>,
    /// tin: whether heights of selected samples are smoothed.
    pub smoothing: bool,
    /// htp: what decides which patches are split; by the batching without.
    pub metric: Option<MetricName>,
    /// htp: how patches become draws; per patch without.
    pub batching: Option<BatchingName>,
    /// htp by distance or box: longest screen length of a triangle's leg in pixels.
    pub leg_px: f64,
    /// htp: small triangles along a patch's side.
    pub k: u32,
    /// htp: number of layers; by the metric without.
    pub layers: Option<u32>,
    /// htp by distance, instanced: whether levels glide into one another.
    pub geomorph: bool,
    /// htp: MiB for the cells around the eye and all that is resident; without, the whole DEM is in memory.
    pub window_mib: Option<u32>,
    /// htp with a window: whether plans wait for their cells.
    pub loading: LoadingName,
    /// decimated: grid intervals between the columns, and the rows, that are kept.
    pub step: u32,
    /// greedy: metres from the camera at which the tolerance counts; half of the DEM's longer side without.
    pub distance_m: Option<f64>,
    /// Threads that a method may plan on.
    pub threads: usize,
}

/// One method with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Which one.
    pub method: MethodName,
    /// Of which it takes those that it knows.
    pub settings: Settings,
}

impl Run {
    /// Makes the method for a DEM, with what was prepared. Threshold maps that are not there it computes itself.
    pub fn build(&self, heightmap: &Arc<Heightmap>, prepared: &Prepared) -> Result<Box<dyn LodMethod>, Fault> {
        let heightmap = heightmap.clone();
        let Settings { tolerance_px, step, .. } = self.settings;
        let method: Box<dyn LodMethod> = match self.method {
            MethodName::Tin => self.build_tin(heightmap, &prepared.maps)?,
            MethodName::Htp | MethodName::HtpInstanced => Box::new(self.build_htp(heightmap, &prepared.cells)?),
            MethodName::FullGrid => Box::new(FullGrid::new(&heightmap)),
            MethodName::Decimated => Box::new(Decimated::new(&heightmap, step).map_err(Fault::usage)?),
            MethodName::Rqt => Box::new(Rqt::new(&heightmap, tolerance_px).map_err(Fault::usage)?),
            MethodName::Geomipmap => Box::new(Geomipmap::new(&heightmap, tolerance_px).map_err(Fault::usage)?),
            MethodName::Greedy => {
                let distance_m = self.settings.distance_m.unwrap_or_else(|| Greedy::usual_distance_m(&heightmap));
                Box::new(Greedy::new(heightmap, tolerance_px, distance_m).map_err(Fault::usage)?)
            }
        };
        debug_assert!(self.method.as_str().starts_with(method.name()));
        Ok(method)
    }

    /// Refuses settings that the method would refuse.
    pub fn validate(&self) -> Result<(), Fault> {
        match self.method {
            MethodName::Tin => self.tin_options().validate().map_err(Fault::usage),
            MethodName::Htp | MethodName::HtpInstanced => match self.streamed() {
                Some(options) => options.validate_streamed().map_err(Fault::usage),
                None => self.htp_options().validate().map_err(Fault::usage),
            },
            // The suite keeps steps and tolerances within their ranges.
            _ => Ok(()),
        }
    }

    fn build_tin(&self, heightmap: Arc<Heightmap>, maps: &Maps) -> Result<Box<dyn LodMethod>, Fault> {
        let options = self.tin_options();
        let tin = match self.nodes(&heightmap).and_then(|nodes| maps.get(&nodes)) {
            Some(maps) => Tin::with_maps(heightmap, options, maps),
            None => Tin::new(heightmap, options),
        };
        Ok(Box::new(tin.map_err(Fault::usage)?))
    }

    /// With a window the DEM itself is not the method's any more.
    fn build_htp(&self, heightmap: Arc<Heightmap>, cells: &Cells) -> Result<Htp, Fault> {
        let Some(options) = self.streamed() else {
            return Htp::new(heightmap, self.htp_options()).map_err(Fault::usage);
        };
        let (file, resident) = cells.open(&options)?;
        Htp::stream(file, resident, options).map_err(Fault::usage)
    }

    /// The options of HTP with a window of cells.
    pub fn streamed(&self) -> Option<htp_lod::Options> {
        let is_htp = matches!(self.method, MethodName::Htp | MethodName::HtpInstanced);
        (is_htp && self.settings.window_mib.is_some()).then(|| self.htp_options())
    }

    /// The patches and groups that the bounded TIN needs threshold maps of.
    pub fn nodes(&self, heightmap: &Heightmap) -> Option<Nodes> {
        let options = self.tin_options();
        self.needs_maps().then(|| Nodes::new(heightmap, options.patch, options.group()))
    }

    /// Whether it is the bounded TIN.
    pub fn needs_maps(&self) -> bool {
        self.method == MethodName::Tin && self.settings.selector == SelectorName::Bounded
    }

    fn tin_options(&self) -> tin_lod::Options {
        let Settings { patch, tolerance_px, max_spacing, group, blocks, jitter, smoothing, threads, .. } =
            self.settings;
        tin_lod::Options {
            patch,
            tolerance_px,
            max_spacing,
            group,
            blocks,
            selector: self.settings.selector.into(),
            schedule: self.settings.schedule.into(),
            edge_policy: self.settings.edge_policy.into(),
            triangulator: self.settings.triangulator.into(),
            index_store: self.settings.index_store.into(),
            jitter: jitter.map(u64::from),
            smoothing,
            threads,
        }
    }

    fn htp_options(&self) -> htp_lod::Options {
        let Settings { k, leg_px, tolerance_px, .. } = self.settings;
        htp_lod::Options {
            k,
            layers: self.layers(),
            metric: self.metric().into(),
            leg_px,
            tolerance_px,
            batching: self.batching().into(),
            geomorph: self.settings.geomorph,
            window_mib: self.settings.window_mib.unwrap_or(htp_lod::Options::default().window_mib),
            loading: self.settings.loading.into(),
        }
    }

    /// htp's: the name htp-instanced says it, whatever the flag.
    fn batching(&self) -> BatchingName {
        match self.method {
            MethodName::HtpInstanced => BatchingName::Instanced,
            _ => self.settings.batching.unwrap_or(BatchingName::PerPatch),
        }
    }

    /// htp's: as published for the draws of the paper, and bounded where all is drawn at once.
    fn metric(&self) -> MetricName {
        let by_batching = match self.batching() {
            BatchingName::Instanced => MetricName::Error,
            BatchingName::PerPatch | BatchingName::MergedCell => MetricName::Distance,
        };
        self.settings.metric.unwrap_or(by_batching)
    }

    /// htp's: the paper's 3; by error, one more saves triangles at tolerances of 2 px and above.
    fn layers(&self) -> u32 {
        let by_metric = if self.metric() == MetricName::Error { 4 } else { 3 };
        self.settings.layers.unwrap_or(by_metric)
    }

    /// Whether a thread works behind the plans, so that what is drawn depends on the clock.
    pub fn is_live(&self) -> bool {
        match self.method {
            MethodName::Tin => self.settings.schedule == ScheduleName::Live,
            MethodName::Htp | MethodName::HtpInstanced => {
                self.settings.window_mib.is_some() && self.settings.loading == LoadingName::Live
            }
            _ => false,
        }
    }

    /// The same, with every plan waiting for its updates and cells: what the error pass and the pictures show.
    pub fn converged(mut self) -> Self {
        self.settings.schedule = ScheduleName::Blocking;
        self.settings.loading = LoadingName::Blocking;
        self
    }

    /// Whether the tolerance in pixels is a setting of this method. To the others it is a yardstick only.
    pub fn takes_tolerance(&self) -> bool {
        match self.method {
            MethodName::Tin | MethodName::Rqt | MethodName::Geomipmap | MethodName::Greedy => true,
            MethodName::Htp | MethodName::HtpInstanced => self.metric() == MetricName::Error,
            MethodName::FullGrid | MethodName::Decimated => false,
        }
    }

    /// What the column `setting` says, by the names of the flags; the tolerance has a column of its own.
    pub fn setting(&self) -> String {
        let Settings { patch, max_spacing, jitter, smoothing, leg_px, k, step, threads, .. } = self.settings;
        match self.method {
            MethodName::Tin => {
                let of_selector = match self.settings.selector {
                    SelectorName::Algorithm1 => format!("max-spacing={}", max_spacing.unwrap_or(patch / 2)),
                    SelectorName::Bounded => {
                        format!("group={} blocks={}", self.tin_options().group(), self.settings.blocks)
                    }
                };
                let (selector, triangulator) = (name_of(self.settings.selector), name_of(self.settings.triangulator));
                let (edges, schedule) = (name_of(self.settings.edge_policy), name_of(self.settings.schedule));
                let store = name_of(self.settings.index_store);
                let jitter = jitter.map_or_else(String::new, |seed| format!(" jitter={seed}"));
                let smoothing = if smoothing { " smoothing=true" } else { "" };
                let threads = if threads == 1 { String::new() } else { format!(" threads={threads}") };
                format!(
                    "selector={selector} patch={patch} {of_selector} triangulator={triangulator} edge-policy={edges} \
                     schedule={schedule} index-store={store}{jitter}{smoothing}{threads}"
                )
            }
            MethodName::Htp | MethodName::HtpInstanced => {
                let leg = if self.takes_tolerance() { String::new() } else { format!(" leg-px={leg_px}") };
                let (metric, batching) = (name_of(self.metric()), name_of(self.batching()));
                let geomorph = if self.settings.geomorph { " geomorph=true" } else { "" };
                let window = self.settings.window_mib.map_or_else(String::new, |mib| {
                    format!(" window-mib={mib} loading={}", name_of(self.settings.loading))
                });
                format!("metric={metric}{leg} k={k} layers={} batching={batching}{geomorph}{window}", self.layers())
            }
            MethodName::FullGrid => "step=1".into(),
            MethodName::Decimated => format!("step={step}"),
            MethodName::Rqt | MethodName::Geomipmap => String::new(),
            MethodName::Greedy => {
                format!("distance={}", self.settings.distance_m.map_or("half-the-dem".into(), |m| format!("{m}-m")))
            }
        }
    }

    /// The run in a line: what `--filter` looks at and `--dry-run` lists.
    pub fn title(&self) -> String {
        let tolerance = self.takes_tolerance().then(|| format!("  tolerance {} px", self.settings.tolerance_px));
        format!("{}  {}{}", self.method.as_str(), self.setting(), tolerance.unwrap_or_default())
    }

    /// Side of a patch in grid intervals, for the methods that have one to choose.
    pub fn patch(&self) -> Option<u32> {
        (self.method == MethodName::Tin).then_some(self.settings.patch)
    }

    /// tin's settings that are seldom not the default, where they are not, for [`Self::file_stem`].
    fn rare_tin_settings(&self) -> String {
        let Settings { group, blocks, edge_policy, index_store, threads, .. } = self.settings;
        let group = group.map(|group| format!("-group{group}"));
        let edges = (edge_policy != EdgePolicyName::default()).then(|| format!("-{}-edges", name_of(edge_policy)));
        let store = (index_store != IndexStoreName::default()).then(|| format!("-{}", name_of(index_store)));
        let threads = (threads != 1).then(|| format!("-threads{threads}"));
        let blocks = (!blocks).then(|| "-no-blocks".to_owned());
        [group, blocks, edges, store, threads].into_iter().flatten().collect()
    }

    /// A short unique name for files: letters, digits, dots and dashes.
    pub fn file_stem(&self) -> String {
        let Settings { tolerance_px, patch, leg_px, k, step, .. } = self.settings;
        let name = self.method.as_str();
        match self.method {
            MethodName::Tin => {
                let (selector, triangulator) = (name_of(self.settings.selector), name_of(self.settings.triangulator));
                let schedule = name_of(self.settings.schedule);
                let rest = self.rare_tin_settings();
                format!("{name}-{selector}-{tolerance_px}px-patch{patch}-{triangulator}-{schedule}{rest}")
            }
            MethodName::Htp | MethodName::HtpInstanced => {
                let px = if self.takes_tolerance() { format!("{tolerance_px}px") } else { format!("leg{leg_px}px") };
                let (metric, batching) = (name_of(self.metric()), name_of(self.batching()));
                let geomorph = if self.settings.geomorph { "-geomorph" } else { "" };
                let window = self
                    .settings
                    .window_mib
                    .map_or_else(String::new, |mib| format!("-window{mib}-{}", name_of(self.settings.loading)));
                format!("{name}-{metric}-{px}-k{k}-l{}-{batching}{geomorph}{window}", self.layers())
            }
            MethodName::FullGrid => name.into(),
            MethodName::Decimated => format!("{name}-step{step}"),
            MethodName::Rqt | MethodName::Geomipmap | MethodName::Greedy => format!("{name}-{tolerance_px}px"),
        }
    }
}
