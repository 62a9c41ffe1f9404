//! Figures of the method, by what the crate's users set: CPU time of a plan, triangles, draws, bytes, error tables.
//!
//! `cargo bench -p htp-lod --bench plan [-- path/to/dem.png spacing scale]`; without arguments the Puget Sound DEM that
//! lies beside the project on some machines, or else synthetic terrain of the same size. One thread, 1280 x 720 pixels,
//! 60 degrees, at first 100 m above the middle of the DEM. Times are CPU time of this thread.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use cpu_time::{ProcessTime, ThreadTime};
use htp_lod::{Batching, Htp, LevelMetric, Options};
use terrain_core::{Camera, FramePlan, FrameStats, Heightmap, Lens, LodMethod, MeshMirror, Sample, View};
use terrain_dem::ReadOptions;

const FRAMES: usize = 900;
const SPEED_M: f64 = 100.0 / 60.0;

fn main() {
    let (name, dem) = open();
    println!("{name}: {} x {} samples, spacing {:?} m", dem.columns(), dem.rows(), dem.spacing_m());
    error_tables(&dem);
    for k in [2, 3, 4] {
        triangles(&dem, k);
    }
    draws(&dem);
    rim(&dem);
    let bounded = Options::bounded();
    for options in [bounded, Options { k: 2, layers: 6, ..bounded }, Options { k: 4, ..bounded }] {
        times(&dem, options);
    }
    for metric in [LevelMetric::Distance, LevelMetric::Box] {
        times(&dem, Options { metric, ..bounded });
    }
    growth(mean_visible(&dem, Options::bounded()));
}

/// Visible triangles of a plan after a teleport.
fn mean_visible(dem: &Arc<Heightmap>, options: Options) -> u64 {
    let (mut method, mut frame_plan) = (Htp::new(dem.clone(), options).unwrap(), FramePlan::default());
    let visible = (0..FRAMES).step_by(9).map(|frame| {
        method.plan(&teleport(dem, frame), &mut frame_plan);
        FrameStats::of(&frame_plan).triangles
    });
    visible.sum::<u64>() / FRAMES.div_ceil(9) as u64
}

fn open() -> (String, Arc<Heightmap>) {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/dem/ps_1025.png");
    let (path, spacing_m, scale) = match &arguments[..] {
        [path, spacing, scale] => (PathBuf::from(path), spacing.parse().unwrap(), scale.parse().unwrap()),
        _ => (beside, 160.0, 0.1),
    };
    if !path.is_file() {
        return ("synthetic".to_owned(), Arc::new(terrain_dem::synthetic::generate(1025, 1025, 1)));
    }
    let options = ReadOptions { spacing_m: Some([spacing_m; 2]), scale: Some(scale), ..Default::default() };
    let dem = terrain_dem::read(&path, &options).unwrap();
    (dem.name, dem.heightmap)
}

/// Construction with errors less construction without: on 1 and on 2 threads, and the CPU time of both threads.
fn error_tables(dem: &Arc<Heightmap>) {
    for (k, layers) in [(2, 6), (3, 4), (4, 4)] {
        let options = Options { k, layers, ..Options::bounded() };
        let bytes = Htp::new(dem.clone(), options).unwrap().error_bytes() as f64 / dem.heights_m().len() as f64;
        let [[one, _], [two, cpu]] = [1, 2].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let build = |metric: LevelMetric| {
                pool.install(|| drop(Htp::new(dem.clone(), Options { metric, ..options })));
            };
            let [with, without] = [LevelMetric::Error, LevelMetric::Distance].map(|metric| median_ms(|| build(metric)));
            [with[0] - without[0], with[1] - without[1]]
        });
        println!(
            "errors k {k}, {layers} layers: {bytes:.3} bytes a sample; {one:.0} ms on 1 thread, {two:.0} on 2; CPU {cpu:.0}"
        );
    }
}

/// Wall-clock and CPU time of this program.
fn median_ms(run: impl Fn()) -> [f64; 2] {
    let mut times_ms = [(); 2].map(|_| Vec::new());
    for _ in 0..7 {
        let (wall, cpu) = (Instant::now(), ProcessTime::now());
        run();
        times_ms[0].push(wall.elapsed().as_secs_f64() * 1e3);
        times_ms[1].push(cpu.elapsed().as_secs_f64() * 1e3);
    }
    times_ms.map(|mut times_ms| quantile(&mut times_ms, 0.5))
}

fn triangles(dem: &Arc<Heightmap>, k: u32) {
    let bounded = Options { k, layers: if k == 2 { 6 } else { 4 }, ..Options::bounded() };
    for px in [0.5, 1.0, 2.0] {
        for metric in [LevelMetric::Error, LevelMetric::Distance, LevelMetric::Box] {
            // A leg as long as it takes: the other metrics know no error.
            let options = Options { metric, tolerance_px: px, leg_px: 8.0 * px, ..bounded };
            let mut method = Htp::new(dem.clone(), options).unwrap();
            let view = view(dem, 0.0, 0.0);
            let [whole, in_view] = [false, true].map(|culling| {
                method.set_culling(culling);
                let plan = plan(&mut method, &view);
                let patches: usize = plan.draws.iter().map(|draw| draw.instances.len()).sum();
                format!("{} in {patches} patches", FrameStats::of(&plan).triangles)
            });
            let setting = if metric == LevelMetric::Error { px } else { 8.0 * px };
            println!("triangles k {k}, {metric:?} {setting} px: {whole}; in view {in_view}");
        }
    }
}

fn draws(dem: &Arc<Heightmap>) {
    for (k, layers) in [(2, 6), (3, 4), (4, 4)] {
        let draws = [Batching::PerPatch, Batching::MergedCell, Batching::Instanced].map(|batching| {
            let options = Options { k, layers, batching, ..Options::bounded() };
            plan(&mut Htp::new(dem.clone(), options).unwrap(), &view(dem, 0.0, 0.0)).draws.len()
        });
        println!("draws k {k}: {} per patch, {} merged cells, {} instanced", draws[0], draws[1], draws[2]);
    }
}

/// What it costs that squares which cross the rim split both halves together: triangles with an area, against a DEM that
/// goes on beyond the rim up to the next whole cell, with the heights of its last column and row. Of that one, only
/// triangles that reach inside the rim count. It has no square to split so but is otherwise the same, wherever it counts.
fn rim(dem: &Arc<Heightmap>) {
    for (k, layers) in [(2, 6), (3, 4), (4, 4)] {
        let options = Options { k, layers, ..Options::bounded() };
        let whole = Arc::new(up_to_whole_cells(dem, k.pow(layers)));
        let last = [dem.columns() - 1, dem.rows() - 1];
        for px in [0.5, 1.0, 2.0] {
            let [clamped, whole] = [dem, &whole].map(|heightmap| {
                let mut method = Htp::new(heightmap.clone(), Options { tolerance_px: px, ..options }).unwrap();
                method.set_culling(false);
                let mut mirror = MeshMirror::new(&method.buffers(), heightmap);
                mirror.replay(&plan(&mut method, &view(dem, 0.0, 0.0))).unwrap();
                let is_inside = |s: &Sample| s.column < last[0] && s.row < last[1];
                mirror.triangles().iter().filter(|triangle| triangle.samples.iter().any(is_inside)).count()
            });
            let more = 100.0 * (clamped as f64 / whole as f64 - 1.0);
            println!("rim k {k}, {px} px: {clamped} triangles, {whole} without a rim to cross: {more:+.2} %");
        }
    }
}

fn up_to_whole_cells(dem: &Heightmap, side: u32) -> Heightmap {
    let [last_column, last_row] = [dem.columns() - 1, dem.rows() - 1];
    let [columns, rows] = [last_column, last_row].map(|last| last.next_multiple_of(side) + 1);
    let height = |i: u32| Sample { column: (i % columns).min(last_column), row: (i / columns).min(last_row) };
    let heights_m = (0..columns * rows).map(|i| dem.height_m(height(i))).collect();
    Heightmap::new(columns, rows, dem.spacing_m(), heights_m).unwrap()
}

/// The same visible triangles after teleports on DEMs of growing size: tolerances found by bisection.
fn growth(triangles: u64) {
    for side in [1025, 2049, 4097] {
        let dem = Arc::new(terrain_dem::synthetic::generate(side, side, 1));
        let (mut low_px, mut high_px) = (1e-3_f64, 1e3_f64);
        for _ in 0..12 {
            let tolerance_px = (low_px * high_px).sqrt();
            let found = mean_visible(&dem, Options { tolerance_px, ..Options::bounded() });
            (low_px, high_px) = if found > triangles { (tolerance_px, high_px) } else { (low_px, tolerance_px) };
        }
        print!("{side} x {side} at {high_px:.3} px: ");
        times(&dem, Options { tolerance_px: high_px, ..Options::bounded() });
    }
}

/// A straight flight, a turn at 30 degrees a second, and teleports.
fn times(dem: &Arc<Heightmap>, options: Options) {
    let Options { k, layers, metric, .. } = options;
    println!("plans k {k}, {layers} layers, {metric:?}:");
    report("straight", dem, options, |frame| view(dem, frame as f64 * SPEED_M, 0.0));
    report("turning", dem, options, |frame| view(dem, 0.0, (frame as f64 * 0.5).to_radians()));
    report("teleports", dem, options, |frame| teleport(dem, frame));
}

fn report(name: &str, dem: &Arc<Heightmap>, options: Options, view: impl Fn(usize) -> View) {
    let mut method = Htp::new(dem.clone(), options).unwrap();
    let mut frame_plan = FramePlan::default();
    method.plan(&view(0), &mut frame_plan);
    let (mut times_ms, mut bytes, mut uploads, mut triangles) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for frame in 1..FRAMES {
        let view = view(frame);
        let start = ThreadTime::now();
        method.plan(&view, &mut frame_plan);
        times_ms.push(start.elapsed().as_secs_f64() * 1e3);
        bytes.push(FrameStats::of(&frame_plan).upload_bytes as f64);
        uploads.push(frame_plan.uploads.len() as f64);
        triangles += FrameStats::of(&frame_plan).triangles;
    }
    let mean_bytes = bytes.iter().sum::<f64>() / bytes.len() as f64;
    println!(
        "  {name:9}: P50 {:.3}, P99 {:.3} ms; mean {mean_bytes:.0}, P99 {:.0} bytes in P99 {:.0} uploads; mean {} triangles",
        quantile(&mut times_ms, 0.5),
        quantile(&mut times_ms, 0.99),
        quantile(&mut bytes, 0.99),
        quantile(&mut uploads, 0.99),
        triangles / times_ms.len() as u64,
    );
}

fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share) as usize]
}

fn plan(method: &mut Htp, view: &View) -> FramePlan {
    let mut plan = FramePlan::default();
    method.plan(view, &mut plan);
    plan
}

/// Far from the frame before, and turned.
fn teleport(dem: &Heightmap, frame: usize) -> View {
    view(dem, (frame * 7919 % 1000) as f64 / 2500.0 * dem.extent_m()[0], frame as f64)
}

/// 100 m above the ground, so many metres east of the middle; looks so far from east, 5 degrees down.
fn view(dem: &Heightmap, way_m: f64, turned: f64) -> View {
    let [x_m, z_m] = dem.extent_m().map(|extent_m| extent_m / 2.0);
    let x_m = x_m + way_m;
    let eye_world = [x_m, dem.ground_m(x_m, z_m) + 100.0, z_m].into();
    let camera = Camera { eye_world, heading: 90f64.to_radians() + turned, pitch: -5f64.to_radians() };
    View::new(&camera, &Lens { fov_y: 60f64.to_radians(), size_px: [1280, 720], near_m: 1.0 }).unwrap()
}
