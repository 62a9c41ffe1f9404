//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use terrain_renderer::{Colour, Look};

use crate::choices::{
    BatchingName, EdgePolicyName, IndexStoreName, LoadingName, MetricName, ScheduleName, SelectorName, TriangulatorName,
};
use crate::cmp_args::CmpArgs;
use crate::dem_args::{DemArgs, DemToolArgs};
use crate::fault::Fault;
use crate::methods::MethodName;
use crate::parse::{parse_percent, parse_pixels, parse_positive, parse_size, within};
use crate::render_args::{AdapterArgs, ColourName, NormalsName, SubmissionName};
use crate::suite::{FRAMES, REPEATS, STEPS};

/// Flies terrain level-of-detail methods over elevation data and compares them.
#[derive(Debug, Parser)]
#[command(name = "terrain-lod", bin_name = "cargo xtask", version, after_help = EXAMPLES)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

const EXAMPLES: &str = "\
Examples:
  cargo xtask bench
  cargo xtask bench --dem my.png --spacing 30 --scale 0.1 --flight fly-over --tolerance 0.5,1,2
  cargo xtask bench --dem synthetic:513x513:7 --methods tin,full-grid --no-gpu --out results/try
  cargo xtask bench --dem my.tif --voids error --unit foot
  cargo xtask bench --suite smoke --dry-run
  cargo xtask bench -m tin,htp -f 'tolerance 1 px' --until-ci 2% --aa
  cargo xtask bench --resume bench-results/2026-01-31T12-59-59Z-quick
  cargo xtask cmp results/before results/after --fail-on 5%
  cargo xtask report bench-results/2026-01-31T12-59-59Z-quick --svg figures
  cargo xtask dem info N44W122.hgt
  cargo xtask dem cells my.tif my.cells --k 3 --layers 5
  cargo xtask mesh --dem my.png --spacing 30 --method tin --tolerance 1 --flight turn --frame 40 --out mesh.ply

Exit codes: 0 ok, 1 failure, 2 usage, 3 regression found, 4 bad input data, 5 GPU or adapter, 6 I/O, 130 interrupted";

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Fly a DEM with every method, print the comparison, write a result folder
    #[command(after_help = EXAMPLES)]
    Bench(Box<BenchArgs>),
    /// Write the mesh of one frame, of the whole DEM, as PLY, OBJ, STL or binary glTF
    #[command(after_help = EXAMPLES)]
    Mesh(MeshArgs),
    /// Compare two result folders: counters exactly, times beyond noise
    #[command(after_help = EXAMPLES)]
    Cmp(CmpArgs),
    /// Make one HTML file of a result folder, which opens offline
    #[command(after_help = EXAMPLES)]
    Report(ReportArgs),
    /// Look at elevation files, cut them into cells, make them
    Dem(DemToolArgs),
    /// List the graphics adapters, * marks the one that is taken; exit code 5 where none would be
    Adapters(AdapterArgs),
}

/// Settings that each method takes from what it knows.
#[derive(Clone, Debug, Args)]
pub struct MethodArgs {
    /// tin: largest distance between selected samples in grid intervals [default: half a patch]
    #[arg(long, value_name = "N")]
    pub max_spacing: Option<u32>,
    /// tin: side of the largest group of patches, 1, 2 or 4 [default: the largest of at most 64 intervals]
    #[arg(long, value_name = "N")]
    pub group: Option<u32>,
    /// tin: tolerances by blocks of 8 x 8 samples in the patches near the eye [default: true]
    #[arg(long, value_name = "BOOL")]
    pub blocks: Option<bool>,
    /// tin: keep the threshold maps of the bounded selector in files beside the DEM's, and use those that are there
    #[arg(long)]
    pub keep_maps: bool,
    /// tin: which edges follow when a patch is selected anew [default: matched]
    #[arg(long)]
    pub edge_policy: Option<EdgePolicyName>,
    /// tin: how the patches share the index buffer [default: packed]
    #[arg(long)]
    pub index_store: Option<IndexStoreName>,
    /// tin: move selected samples at random before they are connected, as the paper does; with delaunator or spade
    #[arg(long, value_name = "SEED")]
    pub jitter: Option<u32>,
    /// tin: smooth the heights of selected samples inside patches; with algorithm1
    #[arg(long)]
    pub smoothing: bool,
    /// htp: layers of the hierarchy, 1 to 6 [default: 4 with the metric error, or else 3]
    #[arg(long, value_name = "N")]
    pub layers: Option<u32>,
    /// greedy: distance of the camera, in metres, at which the tolerance counts [default: half the DEM's longer side]
    #[arg(long, value_name = "METRES", value_parser = parse_positive)]
    pub distance: Option<f64>,
    /// htp: let levels glide into one another instead of popping; with the metric distance, instanced
    #[arg(long)]
    pub geomorph: bool,
    /// htp: whether plans wait for their cells; with --window-mib [default: blocking]
    #[arg(long)]
    pub loading: Option<LoadingName>,
    /// Threads that a method plans on; the result does not depend on it [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: Option<u16>,
}

#[derive(Debug, Args)]
pub struct BenchArgs {
    /// A suite in data/suites (quick, live, htp, htp-window, paper-tin, paper-htp, equal-error, ablation, scaling, smoke), or a TOML
    /// file; the flags below override it
    ///
    /// A suite file has the names of the flags as keys (tolerance_px, leg_px and distance_m with their units), lists where
    /// flags take lists and for group, blocks, layers, geomorph, edge_policy, index_store and threads; dem,
    /// crop, thin, voids, spacing_m, scale and offset_m; and tables. With `[[benches]]`, each a name and the keys in which it differs
    /// from the top of the file, it is several benches: each has its folder in the results, and the tables at the top are
    /// over all of them.
    #[arg(long, value_name = "NAME", default_value = "quick", verbatim_doc_comment)]
    pub suite: String,
    /// Of a suite of several benches only these, the optional ones among them too
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub benches: Option<Vec<String>>,
    /// Puget Sound, for the benches of a suite that fly over the DEM puget
    #[arg(long, value_name = "FILE", conflicts_with = "dem")]
    pub puget: Option<String>,
    #[command(flatten)]
    pub dem: DemArgs,
    /// A flight in data/flights (ground-level, low-and-slow, fly-over, turn, stop-and-go), or a TOML file
    #[arg(long, value_name = "FILE")]
    pub flight: Option<String>,
    /// Methods to compare
    #[arg(short, long, value_delimiter = ',', value_name = "NAMES")]
    pub methods: Option<Vec<MethodName>>,
    /// Only the runs whose line in --dry-run matches, such as 'htp.*k=3' or 'tolerance 2 px'
    #[arg(short, long, value_name = "REGEX")]
    pub filter: Option<String>,
    /// Allowed screen-space errors in pixels: a setting of tin, htp by error, rqt, geomipmap and greedy; everyone's yardstick
    #[arg(long, value_delimiter = ',', value_name = "PX", value_parser = parse_pixels)]
    pub tolerance: Option<Vec<f64>>,
    /// tin: which samples are kept [default: the suite's, or else bounded]
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub selector: Option<Vec<SelectorName>>,
    /// tin: when patches are updated; a live run flies one pass more, in the flight's own time [default: blocking]
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub schedule: Option<Vec<ScheduleName>>,
    /// tin: what connects the selected samples; bounded takes the grid of a list [default: grid]
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub triangulator: Option<Vec<TriangulatorName>>,
    /// tin: sides of a patch in grid intervals (8, 16, 32, 64)
    #[arg(long, value_delimiter = ',', value_name = "N")]
    pub patch: Option<Vec<u32>>,
    /// htp by distance or box: longest screen lengths of a triangle's leg in pixels
    #[arg(long, value_delimiter = ',', value_name = "PX", value_parser = parse_pixels)]
    pub leg_px: Option<Vec<f64>>,
    /// htp: what decides which patches are split [default: error where instanced, or else distance]
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub metric: Option<Vec<MetricName>>,
    /// htp: how the visible patches become draws; htp-instanced is htp with instanced [default: per-patch]
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub batching: Option<Vec<BatchingName>>,
    /// htp: small triangles along the side of a patch, 2 to 16 [default: the suite's, or else 3]
    #[arg(long, value_delimiter = ',', value_name = "N")]
    pub k: Option<Vec<u32>>,
    /// htp: cut the DEM into cells, and keep those around the eye in so many MiB; with instanced [default: all of the DEM]
    #[arg(long, value_delimiter = ',', value_name = "MIB", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub window_mib: Option<Vec<u32>>,
    /// decimated: grid intervals between the rows and columns that are kept [default: the suite's, or else 2,4,8]
    #[arg(long, value_delimiter = ',', value_name = "N", value_parser = within(STEPS))]
    pub step: Option<Vec<u32>>,
    #[command(flatten)]
    pub method: MethodArgs,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Frames, evenly over the flight [default: the suite's, or else the flight's own]
    #[arg(long, value_name = "N", value_parser = within(FRAMES))]
    pub frames: Option<u32>,
    /// How often each method flies the live and the speed pass, interleaved (A B A B); intervals need 2, and are narrow
    /// from 5
    #[arg(long, value_name = "N", value_parser = within(REPEATS))]
    pub repeats: Option<u32>,
    /// Repeat the speed pass until the 95 % interval of each run's median frame time is narrower than this share of it,
    /// such as 1%
    #[arg(long, value_name = "PERCENT", value_parser = parse_percent)]
    pub until_ci: Option<f64>,
    /// With --until-ci, the most repeats [default: 30]
    #[arg(long, value_name = "N", value_parser = within(REPEATS))]
    pub max_repeats: Option<u32>,
    /// Fly each run of the speed pass twice, as A and as B, and say whether their times are the same; exit code 1 where
    /// they are not
    #[arg(long)]
    pub aa: bool,
    #[command(flatten)]
    pub adapter: AdapterArgs,
    /// What the triangles are coloured by [default: shaded]
    #[arg(long)]
    pub colour: Option<ColourName>,
    /// Where normals are read [default: pixel]
    #[arg(long)]
    pub normals: Option<NormalsName>,
    /// How the draws are sent [default: direct]
    #[arg(long)]
    pub submission: Option<SubmissionName>,
    /// The folder for the results, new or empty [default: bench-results/TIME-SUITE]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Go on with the bench that was interrupted in this folder, with its settings; what it has finished is not flown
    /// again. Further flags must be all of those that it was begun with
    #[arg(long, value_name = "DIR", conflicts_with = "out")]
    pub resume: Option<PathBuf>,
    /// Leave out all that needs a GPU: frame times and pictures
    #[arg(long)]
    pub no_gpu: bool,
    /// List the runs with their repeats and what --resume would leave out, check DEM, flight and output folder, estimate
    /// the time; fly nothing
    #[arg(long)]
    pub dry_run: bool,
}

impl BenchArgs {
    /// Refuses `--benches` with a name that the suite does not have.
    pub fn refuse_benches(&self, known: &[&str]) -> Result<(), Fault> {
        match self.benches.iter().flatten().find(|name| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) if known.is_empty() => {
                Err(Fault::usage(format!("--benches {name}: the suite has no [[benches]]")))
            }
            Some(name) => Err(Fault::usage(format!("--benches {name}: expected of {}", known.join(", ")))),
        }
    }

    /// How frames and pictures look; their normals are the suite's.
    pub fn look(&self) -> Look {
        Look { colour: self.colour.map(Colour::from).unwrap_or_default(), ..Default::default() }
    }
}

#[derive(Debug, Args)]
pub struct ReportArgs {
    /// A folder that bench has written
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The HTML file [default: DIR/report.html]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Write each chart as an SVG file too, into this folder
    #[arg(long, value_name = "DIR")]
    pub svg: Option<PathBuf>,
    /// Leave out the pictures, which are most of the file
    #[arg(long)]
    pub no_pictures: bool,
}

#[derive(Debug, Args)]
pub struct MeshArgs {
    #[command(flatten)]
    pub dem: DemArgs,
    /// The method that makes the mesh
    #[arg(long, value_name = "NAME")]
    pub method: MethodName,
    /// tin, htp by error, rqt, geomipmap, greedy: allowed screen-space error in pixels [default: 1]
    #[arg(long, value_name = "PX", value_parser = parse_pixels)]
    pub tolerance: Option<f64>,
    /// tin: which samples are kept [default: bounded]
    #[arg(long)]
    pub selector: Option<SelectorName>,
    /// tin: what connects the selected samples [default: grid]
    #[arg(long)]
    pub triangulator: Option<TriangulatorName>,
    /// tin: side of a patch in grid intervals (8, 16, 32, 64) [default: 32]
    #[arg(long, value_name = "N")]
    pub patch: Option<u32>,
    /// htp by distance or box: longest screen length of a triangle's leg in pixels [default: 8]
    #[arg(long, value_name = "PX", value_parser = parse_pixels)]
    pub leg_px: Option<f64>,
    /// htp: what decides which patches are split [default: error where instanced, or else distance]
    #[arg(long)]
    pub metric: Option<MetricName>,
    /// htp: how the visible patches become draws; htp-instanced is htp with instanced [default: per-patch]
    #[arg(long)]
    pub batching: Option<BatchingName>,
    /// htp: small triangles along the side of a patch, 2 to 16 [default: 3]
    #[arg(long, value_name = "N")]
    pub k: Option<u32>,
    /// htp: cut the DEM into cells, and keep those around the eye in so many MiB; with instanced [default: all of the DEM]
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    pub window_mib: Option<u32>,
    /// decimated: grid intervals between the rows and columns that are kept
    #[arg(long, value_name = "N", default_value = "2", value_parser = within(STEPS))]
    pub step: u32,
    #[command(flatten)]
    pub settings: MethodArgs,
    /// A flight in data/flights, or a TOML file [default: ground-level]
    #[arg(long, value_name = "FILE")]
    pub flight: Option<String>,
    /// Frames, evenly over the flight, as in bench
    #[arg(long, value_name = "N", default_value = "120", value_parser = within(FRAMES))]
    pub frames: u32,
    /// The frame whose mesh is written, from 0; the flight is replayed up to it
    #[arg(long, value_name = "N", default_value = "0")]
    pub frame: u32,
    /// Width and height of the picture in pixels, as in bench [default: 640x360]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// The file to write; its ending says the format: .ply, .obj, .stl or .glb
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }
}
