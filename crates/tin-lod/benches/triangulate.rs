//! The three triangulators of patches in one interleaved run, on one thread: medians, and ratios with their spread.
//!
//! `cargo bench -p tin-lod --bench triangulate`
//!
//! Patches of 33 x 33 samples with random kept samples, the corners among them. A round hands all patches of a load
//! to each competitor in turn, and a ratio is taken within a round. On a busy machine the fastest rounds tell more
//! than the median. There are many different patches, as in a DEM: with one patch over and over, the processor
//! learns its branches by heart.
//!
//! The kernel is timed whole, from bit masks to indices. The libraries are timed twice: whole, as
//! [`Triangulator`] runs them, and bare, their own function alone on points made ready before the clock starts.

use std::hint::black_box;
use std::time::Instant;

use spade::{DelaunayTriangulation, Point2};
use terrain_core::SplitMix64;
use tin_lod::{Border, KeptSamples, Mask, Triangulator};

const SIDE: u32 = 32;
const SEED: u64 = 1;
const PATCHES: usize = 256;
const ROUNDS: usize = 31;

/// Kept samples and the least that the kernel must gain on bare spade and bare delaunator.
const LOADS: [(usize, f64, f64); 4] = [(50, 4.0, 2.0), (200, 6.0, 2.0), (400, 8.0, 2.0), (1089, 12.0, 2.0)];

fn main() {
    println!("{PATCHES} patches a load, {ROUNDS} rounds, seed {SEED}; microseconds a patch: median");
    println!("ratio to the kernel: median (lower - upper quartile), of the fastest rounds [target]\n");
    for (samples, spade_target, delaunator_target) in LOADS {
        let rounds = run(samples);
        println!("{samples:4} samples: kernel {:.1} us", median(rounds.iter().map(|round| round[0])));
        let rows = [
            (1, "spade, bare", Some(spade_target)),
            (2, "spade, whole", None),
            (3, "delaunator, bare", Some(delaunator_target)),
            (4, "delaunator, whole", None),
        ];
        for (competitor, name, target) in rows {
            let [low, ratio, high] = quartiles(rounds.iter().map(|round| round[competitor] / round[0]));
            let time = median(rounds.iter().map(|round| round[competitor]));
            let fastest = |i: usize| rounds.iter().map(|round| round[i]).fold(f64::INFINITY, f64::min);
            let best = fastest(competitor) / fastest(0);
            let target = target.map_or(String::new(), |target| format!(" [{target}]"));
            println!("    {name:18} {time:7.1} us   {ratio:5.2} ({low:.2} - {high:.2}), {best:5.2}{target}");
        }
    }
}

/// Times of all competitors in each round, in microseconds a patch: kernel, spade and delaunator bare and whole.
fn run(samples: usize) -> Vec<[f64; 5]> {
    let mut random = SplitMix64::new(SEED);
    let patches: Vec<_> = (0..PATCHES).map(|_| Patch::random(&mut random, samples)).collect();
    let spade_points: Vec<Vec<_>> = patches.iter().map(|p| p.points(Point2::new)).collect();
    let delaunator_points: Vec<Vec<_>> = patches.iter().map(|p| p.points(|x, y| delaunator::Point { x, y })).collect();
    let mut indices = Vec::new();
    let mut whole = |triangulator: Triangulator| {
        time_each(&patches, |patch| {
            indices.clear();
            triangulator.triangulate(&patch.kept(), &mut indices);
            black_box(&indices);
        })
    };
    let mut round = || {
        [
            whole(Triangulator::Grid),
            time_each(spade_points.clone(), |points| drop(black_box(bulk_load(points)))),
            whole(Triangulator::Spade),
            time_each(&delaunator_points, |points| drop(black_box(delaunator::triangulate(points)))),
            whole(Triangulator::Delaunator),
        ]
    };
    round();
    (0..ROUNDS).map(|_| round()).collect()
}

fn bulk_load(points: Vec<Point2<f64>>) -> DelaunayTriangulation<Point2<f64>> {
    DelaunayTriangulation::bulk_load_stable(points).expect("samples are finite")
}

fn time_each<T>(inputs: impl IntoIterator<Item = T>, work: impl FnMut(T)) -> f64 {
    let start = Instant::now();
    inputs.into_iter().for_each(work);
    start.elapsed().as_secs_f64() * 1e6 / PATCHES as f64
}

fn quartiles(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut values: Vec<_> = values.collect();
    values.sort_by(f64::total_cmp);
    [1, 2, 3].map(|quarter| values[values.len() * quarter / 4])
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    quartiles(values)[1]
}

struct Patch {
    border: Border,
    interior: Vec<Mask>,
}

impl Patch {
    /// Keeps a random set of so many samples, the corners among them.
    fn random(random: &mut SplitMix64, samples: usize) -> Self {
        let mut patch = Self { border: Border::default(), interior: vec![0; SIDE as usize - 1] };
        let mut others: Vec<_> = (0..=SIDE).flat_map(|z| (0..=SIDE).map(move |x| (x, z))).collect();
        others.retain(|(x, z)| x % SIDE != 0 || z % SIDE != 0);
        for chosen in 0..samples - 4 {
            let rest = others.len() - chosen;
            others.swap(chosen, chosen + random.below(rest as u64) as usize);
            patch.keep(others[chosen]);
        }
        patch
    }

    fn keep(&mut self, (x, z): (u32, u32)) {
        let Border { north, south, west, east } = &mut self.border;
        match (x, z) {
            (_, 0) => *north |= 1 << x,
            (_, SIDE) => *south |= 1 << x,
            (0, _) => *west |= 1 << z,
            (SIDE, _) => *east |= 1 << z,
            _ => self.interior[z as usize - 1] |= 1 << x,
        }
    }

    fn kept(&self) -> KeptSamples<'_> {
        let Self { border, interior } = self;
        KeptSamples { width: SIDE, depth: SIDE, border: *border, interior, first_index: 0, row_stride: SIDE + 1 }
    }

    fn points<P>(&self, point: impl Fn(f64, f64) -> P) -> Vec<P> {
        self.kept().positions().map(|(x, z)| point(x as f64, z as f64)).collect()
    }
}
