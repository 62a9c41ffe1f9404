//! A flight over cells that are loaded while it goes on, without the DEM in memory.
//!
//! `cargo bench -p htp-lod --bench stream [-- FILE.cells [PX]]`; without a file synthetic terrain of 2049 x 2049 samples,
//! cut in memory. 500 m/s over the DEM's diagonal, 100 m above the coarse samples, turning by 10 degrees a second; 1280 x 720
//! pixels, 60 degrees, a tolerance of PX (1), 60 plans a second. Times of plans are CPU time of the planning thread.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use htp_lod::{CellFile, CellSource, CellsHeader, Htp, Options, Resident, cut};
use terrain_core::watertight::WatertightOracle;
use terrain_core::{
    Buffer, Camera, FramePlan, Lens, LocalVertex, LodMethod, PatchInstance, Sample, Triangle, Upload, View,
};

const FRAMES: usize = 3_600;
const FRAME: Duration = Duration::from_nanos(1_000_000_000 / 60);
const SPEED_M: f64 = 500.0 / 60.0;
const TURN_A_FRAME: f64 = 10.0 / 60.0;
/// Meshes that are judged.
const JUDGED: usize = 12;

struct OnDisk(File);

impl CellSource for OnDisk {
    fn len(&self) -> std::io::Result<u64> {
        Ok(self.0.metadata()?.len())
    }

    fn read_at(&self, at: u64, into: &mut [u8]) -> std::io::Result<()> {
        self.0.read_exact_at(into, at)
    }
}

fn main() {
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    let file = arguments.next();
    let tolerance_px = arguments.next().map_or(1.0, |px| px.parse().expect("a tolerance in pixels"));
    let in_memory = || {
        let dem = terrain_dem::synthetic::generate(2049, 2049, 1);
        let bytes: Arc<dyn CellSource> = Arc::new(cut(&dem, &Options { layers: 5, ..Options::bounded() }));
        bytes
    };
    let in_memory = file.is_none().then(in_memory);
    let open = || match (&file, &in_memory) {
        (Some(path), _) => Arc::new(OnDisk(File::open(path).expect(path))),
        (_, Some(bytes)) => bytes.clone(),
        _ => unreachable!(),
    };
    for window_mib in [256, 64] {
        fly(&open, Options { window_mib, tolerance_px, ..Options::bounded() });
    }
}

/// Opens the file, as a program that starts does, and flies.
fn fly(open: &dyn Fn() -> Arc<dyn CellSource>, options: Options) {
    let Options { window_mib, tolerance_px, .. } = options;
    let (wall, cpu) = (Instant::now(), ThreadTime::now());
    let (file, resident) = CellFile::open(open()).unwrap();
    let path = Path::new(file.header(), &resident);
    let CellsHeader { k, layers, samples, streamed, .. } = *file.header();
    let (cells, cell_side) = (file.header().cells(), file.header().cell_side());
    let options = Options { k, layers, ..options };
    let mut method = match Htp::stream(file, resident, options) {
        Ok(method) => method,
        Err(error) => return println!("{window_mib} MiB: {error}"),
    };
    let mut plan = FramePlan::default();
    method.plan(&path.view(0), &mut plan);
    let start_up = [wall.elapsed(), cpu.elapsed()].map(|time| time.as_secs_f64() * 1e3);
    println!(
        "{window_mib} MiB, {tolerance_px} px: {} x {} samples, k {k}, {layers} layers, {streamed} streamed; {} x {} cells of {cell_side}",
        samples[0], samples[1], cells[0], cells[1]
    );
    println!(
        "  open and first plan: {:.0} ms, CPU {:.0}; windows of {:?} cells by level, {:.1} MiB",
        start_up[0],
        start_up[1],
        method.window_cells(),
        method.resident_bytes() as f64 / (1 << 20) as f64
    );
    let mut flight = Flight::new(&method, samples);
    flight.follow(&plan, 0.0);
    let begin = Instant::now();
    for frame in 1..FRAMES {
        std::thread::sleep((FRAME * frame as u32).saturating_sub(begin.elapsed()));
        let (view, start) = (path.view(frame), ThreadTime::now());
        method.plan(&view, &mut plan);
        flight.follow(&plan, start.elapsed().as_secs_f64() * 1e3);
        if frame % (FRAMES / JUDGED) == 0 {
            flight.judge(&plan);
        }
    }
    flight.report();
    println!("  {:?}; failed {:?}", plan.streaming, method.failed_reads());
    println!("  peak resident set {}", peak_kib().map_or("unknown".to_owned(), |kib| format!("{} MiB", kib >> 10)));
}

/// The camera's way over the coarse samples.
struct Path {
    heights_m: Vec<f32>,
    size: [u32; 2],
    step_m: [f64; 2],
}

impl Path {
    fn new(header: &CellsHeader, resident: &Resident) -> Self {
        let code = header.format.bytes() as usize;
        Self {
            heights_m: resident.heights.chunks_exact(code).map(|code| header.format.decode(code)).collect(),
            size: header.coarse_size(),
            step_m: header.spacing_m.map(|metres| metres * header.coarse_step() as f64),
        }
    }

    fn view(&self, frame: usize) -> View {
        let way_m = frame as f64 * SPEED_M * 0.5_f64.sqrt();
        let at_m = [0, 1].map(|axis| 0.3 * self.size[axis] as f64 * self.step_m[axis] + way_m);
        let at = [0, 1].map(|axis| (at_m[axis] / self.step_m[axis]) as u32);
        let corner_m = |[column, row]: [u32; 2]| {
            let [column, row] = [column.min(self.size[0] - 1), row.min(self.size[1] - 1)];
            self.heights_m[(row * self.size[0] + column) as usize]
        };
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, z]| corner_m([at[0] + x, at[1] + z]));
        let ground_m = corners.into_iter().fold(f32::NEG_INFINITY, f32::max) as f64;
        let eye_world = [at_m[0], ground_m + 100.0, at_m[1]].into();
        let heading = (135.0 + frame as f64 * TURN_A_FRAME).to_radians();
        let camera = Camera { eye_world, heading, pitch: -5f64.to_radians() };
        View::new(&camera, &Lens { fov_y: 60f64.to_radians(), size_px: [1280, 720], near_m: 1.0 }).unwrap()
    }
}

/// What is counted on the way.
struct Flight {
    times_ms: Vec<f64>,
    upload_bytes: Vec<f64>,
    missing: Vec<u64>,
    unheld_px: Vec<f64>,
    buffers: [Vec<u8>; 3],
    oracle: WatertightOracle,
    samples: [u32; 2],
    judged: [u64; 3],
}

impl Flight {
    fn new(method: &Htp, samples: [u32; 2]) -> Self {
        let sizes = method.buffers();
        Self {
            times_ms: Vec::new(),
            upload_bytes: Vec::new(),
            missing: Vec::new(),
            unheld_px: Vec::new(),
            buffers: [sizes.vertices, sizes.indices, sizes.instances].map(|bytes| vec![0; bytes as usize]),
            oracle: WatertightOracle::new(samples[0], samples[1]),
            samples,
            judged: [0; 3],
        }
    }

    fn follow(&mut self, plan: &FramePlan, time_ms: f64) {
        self.times_ms.push(time_ms);
        self.upload_bytes.push(plan.uploads.iter().map(|upload| upload.bytes.len()).sum::<usize>() as f64);
        self.missing.push(plan.streaming.cells_missing);
        self.unheld_px.push(plan.unheld_px);
        plan.growths.iter().for_each(|growth| self.buffer(growth.buffer).unwrap().resize(growth.bytes as usize, 0));
        for Upload { buffer, offset, bytes } in &plan.uploads {
            if let Some(to) = self.buffer(*buffer) {
                to[*offset as usize..][..bytes.len()].copy_from_slice(&plan.bytes[bytes.clone()]);
            }
        }
    }

    /// All but the heights, which do not matter for cracks.
    fn buffer(&mut self, buffer: Buffer) -> Option<&mut Vec<u8>> {
        match buffer {
            Buffer::Vertices => Some(&mut self.buffers[0]),
            Buffer::Indices => Some(&mut self.buffers[1]),
            Buffer::Instances => Some(&mut self.buffers[2]),
            Buffer::Heights => None,
        }
    }

    /// Looks for cracks.
    fn judge(&mut self, plan: &FramePlan) {
        let mut meshes = [Vec::new(), Vec::new()];
        for draw in &plan.draws {
            for instance in draw.instances.clone() {
                let instance: PatchInstance = element(&self.buffers[2], instance);
                let corner = |index: u32| -> Sample {
                    let vertex: LocalVertex = element(&self.buffers[0], element::<u32>(&self.buffers[1], index));
                    instance.sample(vertex, self.samples[0], self.samples[1])
                };
                for first in draw.indices.clone().step_by(3) {
                    let samples = [first, first + 1, first + 2].map(corner);
                    let triangle = Triangle { samples, heights_m: [0.0; 3] };
                    meshes[(triangle.doubled_area() == 0) as usize].push(triangle);
                }
            }
        }
        let found = self.oracle.check(&meshes[0], &meshes[1]);
        let counts = [1, meshes[0].len() as u64, found.cracks()];
        self.judged.iter_mut().zip(counts).for_each(|(all, count)| *all += count);
    }

    fn report(&mut self) {
        let share = |count: usize| 100.0 * count as f64 / FRAMES as f64;
        let first_whole = self.missing.iter().position(|missing| *missing == 0).unwrap_or(FRAMES);
        let with = |missing: &[u64]| missing.iter().filter(|missing| **missing > 0).count();
        let unheld: Vec<f64> = self.unheld_px.iter().copied().filter(|px| *px > 0.0).collect();
        let worst_px = unheld.iter().copied().filter(|px| px.is_finite()).fold(0.0, f64::max);
        let infinite = unheld.iter().filter(|px| px.is_infinite()).count();
        println!(
            "  plan: P50 {:.3}, P99 {:.3}, max {:.3} ms; uploads P50 {:.0}, P99 {:.0}, max {:.0} bytes",
            quantile(&self.times_ms, 0.5),
            quantile(&self.times_ms, 0.99),
            quantile(&self.times_ms, 1.0),
            quantile(&self.upload_bytes, 0.5),
            quantile(&self.upload_bytes, 0.99),
            quantile(&self.upload_bytes, 1.0),
        );
        println!(
            "  stand-ins in view: {:.2} % of the frames; none before frame {first_whole}; {:.2} % after it",
            share(with(&self.missing)),
            share(with(&self.missing[first_whole..])),
        );
        println!(
            "  bound held: {:.2} % of the frames; at worst {worst_px:.2} px, and {infinite} frames without any bound",
            100.0 - share(unheld.len()),
        );
        let steady = &self.unheld_px[FRAMES / 3..];
        let [p50, p99, largest] = [0.5, 0.99, 1.0].map(|share| quantile(steady, share));
        println!("  unheld after a third of the frames: P50 {p50:.2}, P99 {p99:.2}, max {largest:.2} px");
        let [meshes, triangles, cracks] = self.judged;
        println!("  {meshes} meshes of {} triangles judged: {cracks} cracks", triangles / meshes.max(1));
    }
}

fn element<T: bytemuck::AnyBitPattern>(bytes: &[u8], at: u32) -> T {
    bytemuck::pod_read_unaligned(&bytes[at as usize * size_of::<T>()..][..size_of::<T>()])
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

/// The largest that the process has been so far, on Linux.
fn peak_kib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.trim().strip_suffix(" kB")?.parse().ok()
}
