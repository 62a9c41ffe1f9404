//! Whole updates of a DEM through the public method: a view that alternates, no culling, medians of interleaved rounds.
//!
//! `cargo bench -p tin-lod --bench update [-- path/to/dem.png spacing scale]`; without arguments the Puget Sound DEM
//! that lies beside the project on some machines, or else synthetic terrain of the same size.
//!
//! CPU time is that of the whole plan, uploads and draws included. Stages and wall time are those of the plan's
//! `WorkReport`; on a busy machine the fastest rounds tell more than the median.

mod common;

use std::sync::Arc;

use terrain_core::{Camera, FramePlan, FrameStats, Heightmap, Lens, LodMethod, View};
use tin_lod::{Options, Selector, Tin, Triangulator};

const ROUNDS: usize = 9;

/// Patch side and what the paper's Table 2 says: maximum, minimum and mean seconds of an update over a flight.
const TABLE_2: [(u32, [f64; 3]); 4] =
    [(8, [3.45, 0.41, 1.94]), (16, [1.57, 0.43, 0.90]), (32, [1.19, 0.19, 0.68]), (64, [2.45, 0.25, 1.01])];

fn main() {
    let (name, dem) = common::open();
    let dem = Arc::new(dem);
    println!("{name}: {} x {} samples, {ROUNDS} rounds", dem.columns(), dem.rows());
    for (share, target) in [(0.2, 5.0), (0.6, 8.0)] {
        triangulators(&dem, share, target);
    }
    for share in [0.01, 0.02, 0.05] {
        selection(&dem, share);
    }
    threads(&dem);
    table_2(&dem);
}

/// A TIN that goes from one view to another, again and again.
struct Subject {
    tin: Tin,
    from: View,
    to: View,
    plan: FramePlan,
}

/// One update, in milliseconds.
#[derive(Clone, Copy)]
struct Times {
    cpu: f64,
    select: f64,
    wall: f64,
}

impl Subject {
    fn new(dem: &Arc<Heightmap>, options: Options, from: &View, to: &View) -> Self {
        let mut tin = Tin::new(dem.clone(), options).unwrap();
        tin.set_culling(false);
        Self { tin, from: from.clone(), to: to.clone(), plan: FramePlan::default() }
    }

    fn update(&mut self) -> Times {
        self.tin.plan(&self.from, &mut self.plan);
        let start_ms = common::cpu_ms();
        self.tin.plan(&self.to, &mut self.plan);
        let cpu = common::cpu_ms() - start_ms;
        let work = self.plan.work.last().expect("the views differ");
        Times { cpu, select: 1e3 * work.select.as_secs_f64(), wall: 1e3 * work.update.as_secs_f64() }
    }

    fn patches(&self) -> u64 {
        FrameStats::of(&self.plan).updated_patches
    }

    /// Triangles of those of the full grid: about the share of the samples that is kept.
    fn share(&self, dem: &Heightmap) -> f64 {
        FrameStats::of(&self.plan).triangles as f64 / (2 * (dem.columns() - 1) * (dem.rows() - 1)) as f64
    }
}

/// Updates all subjects in turn, again and again.
fn rounds<const N: usize>(subjects: &mut [Subject; N]) -> Vec<[Times; N]> {
    let mut round = || subjects.each_mut().map(Subject::update);
    round();
    (0..ROUNDS).map(|_| round()).collect()
}

/// Median and least of something over the rounds.
fn of_rounds<const N: usize>(rounds: &[[Times; N]], value: impl Fn(&[Times; N]) -> f64) -> (f64, f64) {
    let mut values: Vec<f64> = rounds.iter().map(value).collect();
    values.sort_by(f64::total_cmp);
    (values[values.len() / 2], values[0])
}

/// From so high above that one pixel is the same number of metres everywhere.
fn one_pixel_is(dem: &Heightmap, metres: f64) -> View {
    const HEIGHT_M: f64 = 1e7;
    let [x, z] = dem.extent_m().map(|extent| extent / 2.0);
    let camera = Camera { eye_world: [x, HEIGHT_M, z].into(), heading: 0.0, pitch: -1.5 };
    let fov_y = 2.0 * (common::lens().size_px[1] as f64 * metres / (2.0 * HEIGHT_M)).atan();
    View::new(&camera, &Lens { fov_y, ..common::lens() }).unwrap()
}

/// Every patch that is not quite flat changes on the way from here to any other view.
fn finest(dem: &Heightmap) -> View {
    one_pixel_is(dem, 1e-3)
}

/// Every patch is as coarse as can be.
fn coarsest(dem: &Heightmap) -> View {
    one_pixel_is(dem, 1e6)
}

/// The view at which Algorithm 1 keeps a share of the samples.
fn keeping(dem: &Arc<Heightmap>, share: f64) -> View {
    let (mut low_m, mut high_m) = (0.01f64, 1e4f64);
    for _ in 0..12 {
        let middle_m = (low_m * high_m).sqrt();
        let mut subject = Subject::new(dem, algorithm1(), &finest(dem), &one_pixel_is(dem, middle_m));
        subject.update();
        *(if subject.share(dem) > share { &mut low_m } else { &mut high_m }) = middle_m;
    }
    one_pixel_is(dem, high_m)
}

fn algorithm1() -> Options {
    Options { selector: Selector::Algorithm1, ..Default::default() }
}

fn triangulators(dem: &Arc<Heightmap>, share: f64, target: f64) {
    let view = keeping(dem, share);
    let subject = |triangulator| Subject::new(dem, Options { triangulator, ..algorithm1() }, &finest(dem), &view);
    let mut subjects = [Triangulator::Grid, Triangulator::Delaunator, Triangulator::Spade].map(subject);
    let rounds = rounds(&mut subjects);
    let [grid, delaunator, spade] = [0, 1, 2].map(|i| of_rounds(&rounds, |round| round[i].cpu).0);
    let [to_delaunator, to_spade] = [1, 2].map(|i| of_rounds(&rounds, |round| round[i].cpu / round[0].cpu).0);
    println!("\nupdate, {:.1} % kept, {} patches, CPU:", 100.0 * subjects[0].share(dem), subjects[0].patches());
    println!("  grid {grid:.1} ms, delaunator {delaunator:.1} ms ({to_delaunator:.2} x)");
    println!("  spade {spade:.1} ms ({to_spade:.2} x) [target: {target} x]");
}

/// The plan's CPU time by the selection's share of the update: slightly too much, but free of other programs.
fn selection(dem: &Arc<Heightmap>, share: f64) {
    let mut subjects = [Subject::new(dem, algorithm1(), &finest(dem), &keeping(dem, share))];
    let (median, fastest) = of_rounds(&rounds(&mut subjects), |[one]| one.cpu * one.select / one.wall);
    let (share, patches) = (100.0 * subjects[0].share(dem), subjects[0].patches());
    println!("\nselection alone, {share:.1} % kept, {patches} patches, CPU:");
    println!("  {median:.1} ms, fastest {fastest:.1} [target: 15]");
}

fn threads(dem: &Arc<Heightmap>) {
    println!("\nfrom nothing to 0.5 px, from 100 m above the middle:");
    for selector in [Selector::Algorithm1, Selector::Bounded] {
        let options = Options { selector, tolerance_px: 0.5, ..Default::default() };
        let (from, to) = (coarsest(dem), common::above_the_middle(dem));
        let subject = |threads| Subject::new(dem, Options { threads, ..options }, &from, &to);
        let rounds = rounds(&mut [1, 2].map(subject));
        let (cpu, _) = of_rounds(&rounds, |round| round[0].cpu);
        let [one, two] = [0, 1].map(|i| of_rounds(&rounds, |round| round[i].wall));
        println!(
            "  {selector:?}: 1 thread {:.2} ms (CPU {cpu:.2}), 2 threads {:.2} ms, fastest {:.2} and {:.2}: {:.2} x [target: 1.8 x]",
            one.0,
            two.0,
            one.1,
            two.1,
            one.1 / two.1
        );
    }
    println!("  [target for Bounded on 2 threads: 7 ms]");
}

fn table_2(dem: &Arc<Heightmap>) {
    println!("\nSeconds of one update (the paper's Table 2): 0.5 px, from nothing, CPU time on one thread.");
    println!("The paper's are those of another machine, over a flight, for what is in view.");
    println!("  patch | paper: max  min  mean | algorithm1: grid delaunator   spade | bounded: grid");
    let (from, to) = (coarsest(dem), common::above_the_middle(dem));
    for (patch, [max, min, mean]) in TABLE_2 {
        let options = Options { patch, tolerance_px: 0.5, ..algorithm1() };
        let ours = [
            options,
            Options { triangulator: Triangulator::Delaunator, ..options },
            Options { triangulator: Triangulator::Spade, ..options },
            Options { selector: Selector::Bounded, ..options },
        ];
        let rounds = rounds(&mut ours.map(|options| Subject::new(dem, options, &from, &to)));
        let [grid, delaunator, spade, bounded] = [0, 1, 2, 3].map(|i| of_rounds(&rounds, |round| round[i].cpu).0 / 1e3);
        println!(
            "  {patch:5} |       {max:.2} {min:.2}  {mean:.2} |          {grid:.4}     {delaunator:.4}  {spade:.4} |        {bounded:.4}"
        );
    }
}
