//! Triangles of the bounded mesh against greedy insertion over the whole DEM, and against Algorithm 1 at equal error.
//!
//! `cargo bench -p tin-lod --bench reference [-- NAME ...]`, with names of DEMs that lie beside the project on some
//! machines: by default `ps_1025` and `deathvalley_2049_80m`. Without them, synthetic terrain. Some minutes; everything
//! counts triangles, nothing is timed.
//!
//! One tolerance everywhere, a rung of the ladder, so that no snapping is in the ratios. Algorithm 1 has the default
//! spacing. Its tolerance is no bound, so it is given whatever tolerance makes its measured error that of the bounded
//! mesh: once the largest over all samples, once the root of the mean square. Its error does not rise evenly with its
//! tolerance; the search comes from the coarse side and takes the first tolerance that is good enough, which is the
//! kindest to Algorithm 1. `jumps to` marks where its error leaps over the target by more than 1 %. `NOT REACHED` is
//! what it says: even at tolerance 0 it leaves out the last sample of flat ground before a slope to the south or the
//! east, because it looks west and north alone.

#[path = "../tests/bounded/terrain.rs"]
#[expect(dead_code, reason = "only the DEMs beside the project are wanted")]
mod terrain;
#[path = "../tests/bounded/whole_dem.rs"]
#[expect(dead_code, reason = "of the bounded mesh only the uniform one is wanted")]
mod whole_dem;

use lod_baselines::GreedyInsertion;
use terrain_core::Heightmap;
use terrain_core::error::ErrorOracle;
use tin_lod::algorithm1::{select_edge, select_interior};
use tin_lod::levels::NodeLevels;
use tin_lod::{Border, EdgeId, KeptSamples, Mask, PatchGrid, PatchId, Triangulator, ladder};
use whole_dem::{Mesh, WholeDem};

const PATCH: u32 = 32;
/// The default for that patch.
const GROUP: u32 = 2;
/// The default of [`tin_lod::Options::max_spacing`].
const MAX_SPACING: u32 = PATCH / 2;
const TOLERANCES_M: [f64; 6] = [128.0, 64.0, 32.0, 16.0, 8.0, 4.0];
/// Below so many triangles a patch the four corners of every patch weigh too much for the target.
const TRIANGLES_A_PATCH: usize = 80;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let names = if arguments.is_empty() { vec!["ps_1025".into(), "deathvalley_2049_80m".into()] } else { arguments };
    let mut dems: Vec<_> = names.iter().filter_map(|name| Some((name.clone(), terrain::shared(name)?))).collect();
    if dems.is_empty() {
        dems.push(("synthetic:1025x1025:1".into(), terrain_dem::synthetic::generate(1025, 1025, 1)));
    }
    for (name, dem) in dems {
        compare(&name, dem);
    }
}

fn compare(name: &str, dem: Heightmap) {
    let whole = WholeDem::new(dem, PATCH, GROUP);
    println!("\n{name}: {} x {} samples, patch {PATCH}", whole.dem.columns(), whole.dem.rows());
    let (mut reference, mut algorithm1) = (GreedyInsertion::new(&whole.dem), Algorithm1::new(&whole));
    for tolerance_m in TOLERANCES_M {
        let level = ladder::level_of(tolerance_m);
        let (mut mesh, rung_m) = (Mesh::default(), ladder::tolerance_m(level));
        let levels = vec![NodeLevels::Uniform(level); whole.maps.nodes().len()];
        whole.triangulate(&whole.best_cut(levels), &mut mesh);
        let bounded = Measured::of(&whole, &mesh);
        reference.refine(rung_m);
        compare_with_reference(&whole, rung_m, bounded, reference.triangle_count());
        for (measure, target_m) in [(MAX, bounded.max_m), (RMS, bounded.rms_m)] {
            let found = algorithm1.coarsest_within(target_m, measure.of);
            print_algorithm1(measure.name, target_m, bounded, found, measure.of);
        }
    }
}

fn grid(whole: &WholeDem) -> &PatchGrid {
    whole.maps.nodes().patches()
}

fn compare_with_reference(whole: &WholeDem, rung_m: f64, bounded: Measured, reference: usize) {
    let (a_patch, ratio) =
        (bounded.triangles / grid(whole).patches() as usize, bounded.triangles as f64 / reference as f64);
    let target = match (a_patch >= TRIANGLES_A_PATCH, ratio <= 1.05) {
        (false, _) => "no target below 80 a patch",
        (true, true) => "target 1.05: kept",
        (true, false) => "target 1.05: MISSED",
    };
    println!(
        "{rung_m:8.3} m: bounded {} ({a_patch} a patch), greedy {reference}, ratio {ratio:.3} ({target})",
        bounded.triangles
    );
}

fn print_algorithm1(name: &str, target_m: f64, bounded: Measured, found: Found, error_of: fn(&Measured) -> f64) {
    let Found { tolerance_m, measured, beyond } = found;
    let ratio = measured.triangles as f64 / bounded.triangles as f64;
    let error_m = error_of(&measured);
    print!("      {name} {target_m:7.3} m: Algorithm 1 at {tolerance_m:9.4} m has {error_m:7.3} m, ");
    print!("{} triangles, ratio {ratio:.2}", measured.triangles);
    match beyond {
        _ if error_m > 1.01 * target_m => println!("; NOT REACHED"),
        _ if error_m >= 0.99 * target_m => println!(),
        Some(beyond) => println!("; jumps to {:.3} m with {}", error_of(&beyond), beyond.triangles),
        None => println!("; its coarsest mesh"),
    }
}

/// Triangles of a mesh, and its vertical error over all samples of the DEM.
#[derive(Clone, Copy)]
struct Measured {
    triangles: usize,
    max_m: f64,
    rms_m: f64,
}

struct Measure {
    name: &'static str,
    of: fn(&Measured) -> f64,
}

const MAX: Measure = Measure { name: "max", of: |measured| measured.max_m };
const RMS: Measure = Measure { name: "RMS", of: |measured| measured.rms_m };

impl Measured {
    fn of(whole: &WholeDem, mesh: &Mesh) -> Self {
        let mut oracle = ErrorOracle::new(&whole.dem);
        oracle.set_mesh(&whole.triangles(mesh));
        let deviations_m = || oracle.deviations_m().map(f64::from);
        assert!(deviations_m().all(|d| !d.is_nan()), "a sample is not covered");
        let squares: f64 = deviations_m().map(|d| d * d).sum();
        let rms_m = (squares / whole.dem.heights_m().len() as f64).sqrt();
        Self { triangles: mesh.indices.len() / 3, max_m: deviations_m().fold(0.0, f64::max), rms_m }
    }
}

/// Algorithm 1 over the whole DEM, at tolerances that were tried before and at new ones.
struct Algorithm1<'a> {
    whole: &'a WholeDem,
    /// The coarsest first: infinity, then from [`COARSEST_M`] down in steps of 2^(1/8), then 0.
    tried: Vec<(f64, Measured)>,
}

/// The result of a search: the mesh at tolerance 0 if none is good enough.
struct Found {
    tolerance_m: f64,
    measured: Measured,
    /// The nearest coarser mesh, whose error is too large; none if this is the coarsest of all.
    beyond: Option<Measured>,
}

const COARSEST_M: f64 = 2048.0;
/// Half a step of the heights: finer tolerances than this are as good as 0.
const FINEST_M: f64 = 0.05;

/// Quotient of the ends between which the search stops. Heights in steps of 0.1 m leave no more to find.
const BISECTED: f64 = 1.0002;

impl<'a> Algorithm1<'a> {
    fn new(whole: &'a WholeDem) -> Self {
        Self { whole, tried: vec![(f64::INFINITY, algorithm1(whole, f64::INFINITY))] }
    }

    /// The coarsest mesh whose error exceeds a target by no more than 1 %.
    fn coarsest_within(&mut self, target_m: f64, error_of: fn(&Measured) -> f64) -> Found {
        let fits = |measured: &Measured| error_of(measured) <= 1.01 * target_m;
        let mut at = 0;
        while !fits(&self.tried(at).1) && self.tried(at).0 > 0.0 {
            at += 1;
        }
        let (mut tolerance_m, mut measured) = self.tried(at);
        let Some(coarser) = at.checked_sub(1) else {
            return Found { tolerance_m, measured, beyond: None };
        };
        let (mut beyond_m, mut beyond) = self.tried(coarser);
        while beyond_m.is_finite() && tolerance_m > 0.0 && beyond_m > BISECTED * tolerance_m {
            let middle_m = (tolerance_m * beyond_m).sqrt();
            let middle = algorithm1(self.whole, middle_m);
            if fits(&middle) {
                (tolerance_m, measured) = (middle_m, middle);
            } else {
                (beyond_m, beyond) = (middle_m, middle);
            }
        }
        Found { tolerance_m, measured, beyond: Some(beyond) }
    }

    fn tried(&mut self, at: usize) -> (f64, Measured) {
        while self.tried.len() <= at {
            let tolerance_m = COARSEST_M * (-(self.tried.len() as f64) / 8.0).exp2();
            let tolerance_m = if tolerance_m < FINEST_M { 0.0 } else { tolerance_m };
            self.tried.push((tolerance_m, algorithm1(self.whole, tolerance_m)));
        }
        self.tried[at]
    }
}

/// Selects the whole DEM at one tolerance in metres, and triangulates it.
fn algorithm1(whole: &WholeDem, tolerance_m: f64) -> Measured {
    let (dem, grid) = (&whole.dem, grid(whole));
    let edge = |edge: EdgeId| select_edge(dem, grid.run(edge), tolerance_m, MAX_SPACING);
    let edges: Vec<Mask> = (0..grid.edges()).map(edge).collect();
    let mut mesh = Mesh::default();
    for patch in 0..grid.patches() {
        triangulate(whole, patch, tolerance_m, &edges, &mut mesh.indices);
    }
    Measured::of(whole, &mesh)
}

fn triangulate(whole: &WholeDem, patch: PatchId, tolerance_m: f64, edges: &[Mask], indices: &mut Vec<u32>) {
    let (area, dem) = (grid(whole).area(patch), &whole.dem);
    let [north, south, west, east] = grid(whole).edges_of(patch).all().map(|edge| edges[edge as usize]);
    let border = Border { north, south, west, east };
    let mut interior = Vec::new();
    select_interior(dem, area, border, tolerance_m, MAX_SPACING, &mut interior);
    let kept = KeptSamples {
        width: area.width,
        depth: area.depth,
        border,
        interior: &interior,
        first_index: dem.index(area.first),
        row_stride: dem.columns(),
    };
    Triangulator::Grid.triangulate(&kept, indices);
}
