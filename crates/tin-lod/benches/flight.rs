//! What `plan()` of the bounded TIN costs in flight: by the size of the DEM, and in jumps; and what it takes in memory.
//!
//! `cargo bench -p tin-lod --bench flight [-- NAME ...]`: `SIDE` for synthetic terrain of SIDE x SIDE samples, or the
//! name of a DEM that lies beside the project on some machines. By default 1025, 2049, 4097 and `ps_1025`.
//!
//! 1 px, 1280 x 720 pixels, 60 degrees, patch 32, one thread, the uploads written. CPU time of this program, so that
//! others on the machine count little.
//!
//! - Flight: 600 frames at 60 Hz, 100 m/s, 100 m above ground, heading east over the middle of the DEM. The first plan,
//!   which uploads the whole DEM, is not among them, nor a second one.
//! - Jumps: 200 frames, each anywhere on the DEM, 100 m above ground, in any direction.
//!
//! Memory is computed from the sizes of what is kept, since a counting allocator would be `unsafe`. Beside it stands by
//! how much the system says that the process has grown (Linux). It counts the plan's own bytes too, and means something
//! for the first DEM of a run alone: the others reuse its memory.

#[path = "../tests/bounded/terrain.rs"]
#[expect(dead_code, reason = "only the DEMs beside the project are wanted")]
mod terrain;

use std::sync::Arc;

use cpu_time::ProcessTime;
use terrain_core::{Camera, FramePlan, FrameStats, Heightmap, Lens, LodMethod, SplitMix64, View};
use tin_lod::levels::NodeLevels;
use tin_lod::{Mask, NodeMaps, Nodes, Options, PatchGrid, Selection, Tin};

const FRAMES: u32 = 600;
const JUMPS: u32 = 200;
const METRES_A_FRAME: f64 = 100.0 / 60.0;
const ABOVE_GROUND_M: f64 = 100.0;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let defaults = ["1025", "2049", "4097", "ps_1025"].map(str::to_owned).to_vec();
    for name in if arguments.is_empty() { defaults } else { arguments } {
        let dem = match name.parse() {
            Ok(side) => Some(terrain_dem::synthetic::generate(side, side, 1)),
            Err(_) => terrain::shared(&name),
        };
        if let Some(dem) = dem {
            measure(&name, Arc::new(dem));
        }
    }
}

fn measure(name: &str, dem: Arc<Heightmap>) {
    let options = Options::default();
    let nodes = Nodes::new(&dem, options.patch, options.group());
    println!("\n{name}: {} x {} samples, {} patches", dem.columns(), dem.rows(), nodes.patches().patches());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let (_, build_ms) = timed_ms(|| pool.install(|| NodeMaps::build(&dem, nodes.clone())));
    println!("  threshold map: {:.2} s", build_ms / 1e3);
    print_memory(&dem, &nodes);
    for culling in [true, false] {
        let seen = if culling { "in view" } else { "whole DEM" };
        Flown::over(&dem, culling, flight(&dem)).print(&format!("flight, {seen}"));
        Flown::over(&dem, culling, jumps(&dem)).print(&format!("jumps, {seen}"));
    }
}

/// Runs something, and its CPU time on all threads.
fn timed_ms<T>(run: impl FnOnce() -> T) -> (T, f64) {
    let start = ProcessTime::now();
    let result = run();
    (result, start.elapsed().as_secs_f64() * 1e3)
}

fn flight(dem: &Heightmap) -> Vec<View> {
    let [width_m, depth_m] = dem.extent_m();
    // The middle of the flight over the middle of the DEM.
    let start_m = (width_m - FRAMES as f64 * METRES_A_FRAME) / 2.0;
    let east = std::f64::consts::FRAC_PI_2;
    (0..FRAMES + 2).map(|frame| view(dem, start_m + frame as f64 * METRES_A_FRAME, depth_m / 2.0, east)).collect()
}

fn jumps(dem: &Heightmap) -> Vec<View> {
    let (mut random, [width_m, depth_m]) = (SplitMix64::new(1), dem.extent_m());
    let mut jump = |_| {
        let (x_m, z_m) = (random.range(0.0, width_m), random.range(0.0, depth_m));
        view(dem, x_m, z_m, random.range(0.0, std::f64::consts::TAU))
    };
    (0..JUMPS + 2).map(&mut jump).collect()
}

fn view(dem: &Heightmap, x_m: f64, z_m: f64, heading: f64) -> View {
    let eye_world = [x_m, dem.ground_m(x_m, z_m) + ABOVE_GROUND_M, z_m].into();
    let lens = Lens { fov_y: 60f64.to_radians(), size_px: [1280, 720], near_m: 1.0 };
    View::new(&Camera { eye_world, heading, pitch: 0.0 }, &lens).unwrap()
}

/// What the frames of some views came to, all but the first two.
struct Flown {
    /// CPU time of `plan()`, sorted.
    times_ms: Vec<f64>,
    frames: Vec<FrameStats>,
}

impl Flown {
    fn over(dem: &Arc<Heightmap>, culling: bool, views: Vec<View>) -> Self {
        let mut tin = Tin::new(dem.clone(), Options::default()).unwrap();
        tin.set_culling(culling);
        let mut plan = FramePlan::default();
        let mut frame = |view: &View| {
            let ((), time_ms) = timed_ms(|| tin.plan(view, &mut plan));
            (time_ms, FrameStats::of(&plan))
        };
        let (mut times_ms, frames): (Vec<f64>, Vec<FrameStats>) = views.iter().map(&mut frame).skip(2).unzip();
        times_ms.sort_by(f64::total_cmp);
        Self { times_ms, frames }
    }

    fn print(&self, what: &str) {
        let quantile_ms =
            |share: f64| self.times_ms[((self.times_ms.len() as f64 * share) as usize).min(self.times_ms.len() - 1)];
        let mean = |count: fn(&FrameStats) -> u64| {
            self.frames.iter().map(count).sum::<u64>() as f64 / self.frames.len() as f64
        };
        println!(
            "  {what:17}: plan P50 {:.3}, P99 {:.3}, max {:.3} ms; stale patches {}",
            quantile_ms(0.5),
            quantile_ms(0.99),
            quantile_ms(1.0),
            self.frames.iter().map(|frame| frame.stale_patches).sum::<u64>()
        );
        println!(
            "  {:19}a frame: {:.0} patches drawn, {:.0} updated, {:.0} triangles drawn, {:.1} KiB uploaded",
            "",
            mean(|frame| frame.draws),
            mean(|frame| frame.updated_patches),
            mean(|frame| frame.triangles),
            mean(|frame| frame.upload_bytes) / 1024.0
        );
    }
}

fn print_memory(dem: &Arc<Heightmap>, nodes: &Nodes) {
    let before = resident_bytes();
    let mut tin = Tin::new(dem.clone(), Options::default()).unwrap();
    let built = resident_bytes();
    let mut plan = FramePlan::default();
    tin.plan(&flight(dem)[0], &mut plan);
    let planned = resident_bytes();

    let (samples, buffers) = (dem.heights_m().len() as f64, tin.buffers());
    let of_grids = |bytes: fn(f64, f64, f64) -> f64| {
        let of_grid = |grid: &PatchGrid| bytes(grid.patches() as f64, grid.edges() as f64, grid.side() as f64);
        nodes.grids().map(of_grid).sum::<f64>() / samples
    };
    let map = of_grids(|patches, edges, side| (edges + patches * (side - 1.0)) * side);
    let of_node =
        |side: f64| (size_of::<Selection>() + size_of::<NodeLevels>()) as f64 + side * size_of::<Mask>() as f64;
    let selections = nodes.patches().patches() as f64 * of_node(nodes.patches().side() as f64) / samples;
    let heights = size_of::<f32>() as f64;
    let cpu = heights + map + selections;
    println!("  CPU: {cpu:.2} bytes a sample = heights {heights:.2} + map {map:.2} + selections {selections:.2}");
    let [vertices, indices] = [buffers.vertices, buffers.indices].map(|bytes| bytes as f64 / samples);
    println!("  GPU: {:.2} = vertices {vertices:.2} + indices reserved {indices:.2}", vertices + indices);
    if let (Some(before), Some(built), Some(planned)) = (before, built, planned) {
        let [built, planned] = [built, planned].map(|bytes| (bytes as f64 - before as f64) / samples);
        println!(
            "  the system says: Tin::new {built:.2}, with the first plan {planned:.2} (the heights are not in it)"
        );
    }
}

/// Memory that the system counts as this process's.
fn resident_bytes() -> Option<u64> {
    let statm = std::fs::read_to_string("/proc/self/statm").ok()?;
    Some(statm.split(' ').nth(1)?.parse::<u64>().ok()? * 4096)
}
