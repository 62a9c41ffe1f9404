//! Live loading from a source that fails in every way that files do: whatever arrives when, every frame is whole.

use super::mesh_tests::assert_restricted;
use super::stream_tests::{sides, terrain};
use super::*;
use crate::cells::{CellSource, cut};
use std::io::{Error, ErrorKind, Result as IoResult};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use terrain_core::walk::RandomWalk;
use terrain_core::watertight::WatertightOracle;
use terrain_core::{MeshMirror, SplitMix64};

/// Bytes in memory that are read with faults drawn by lot: half of all reads once they are switched on.
struct Faulty {
    bytes: Vec<u8>,
    /// The byte after each level's records.
    ends: Vec<u64>,
    seed: u64,
    reads: AtomicU64,
    /// Read number from which on there are faults.
    from: AtomicU64,
    /// Faults so far: of the operating system, of damaged bytes, of another cell's bytes.
    faults: [AtomicU64; 3],
}

impl Faulty {
    fn new(bytes: Vec<u8>, seed: u64) -> Self {
        let from = AtomicU64::new(u64::MAX);
        let ends = CellFile::open(Arc::new(bytes.clone())).unwrap().0.level_ends();
        Self { bytes, ends, seed, reads: AtomicU64::default(), from, faults: Default::default() }
    }

    fn fail(&self, kind: ErrorKind) -> IoResult<()> {
        self.faults[0].fetch_add(1, Relaxed);
        Err(Error::from(kind))
    }
}

impl CellSource for Faulty {
    fn len(&self) -> IoResult<u64> {
        Ok(self.bytes.len() as u64)
    }

    fn read_at(&self, at: u64, into: &mut [u8]) -> IoResult<()> {
        let read = self.reads.fetch_add(1, Relaxed);
        let mut random = SplitMix64::new(self.seed ^ read);
        let fault = if read < self.from.load(Relaxed) { u64::MAX } else { random.below(12) };
        match fault {
            0 => return self.fail(ErrorKind::NotFound),
            1 => return self.fail(ErrorKind::UnexpectedEof),
            2 => return self.fail(ErrorKind::PermissionDenied),
            _ => {}
        }
        // Records of a level have equal lengths: the next one is another cell's, or the one before.
        let length = into.len() as u64;
        let other = if self.ends.contains(&(at + length)) { at - length } else { at + length };
        self.bytes.read_at(if fault == 3 { other } else { at }, into)?;
        match fault {
            3 => _ = self.faults[2].fetch_add(1, Relaxed),
            4 => {
                let bit = random.below(8 * length);
                into[bit as usize / 8] ^= 1 << (bit % 8);
                self.faults[1].fetch_add(1, Relaxed);
            }
            5 => {
                into.fill(0);
                self.faults[1].fetch_add(1, Relaxed);
            }
            6 => std::thread::sleep(std::time::Duration::from_micros(300)),
            _ => {}
        }
        Ok(())
    }
}

/// Frames and faults in all, at least. Debug builds have assertions on, so that a denied restriction would panic, too.
const FRAMES: usize = 20_000;
const FAULTS: u64 = 2_000;

#[test]
fn live_cells_with_thousands_of_faults_leave_no_crack() {
    let mut faults = [0; 3];
    for (seed, k, layers, window, metric) in [
        (1, 2, 3, 5, LevelMetric::Error),
        (2, 3, 2, 4, LevelMetric::Error),
        (3, 2, 4, 3, LevelMetric::Distance),
        (4, 3, 3, 2, LevelMetric::Error),
    ] {
        let heightmap = terrain(97, 86, seed % 2 == 0);
        let (leg_px, tolerance_px, batching) = (80.0, 4.0, Batching::Instanced);
        let options = Options { k, layers, metric, leg_px, tolerance_px, batching, ..Options::default() };
        let found = fly(&heightmap, options, window, seed);
        faults.iter_mut().zip(found).for_each(|(all, found)| *all += found);
    }
    assert!(faults.iter().all(|count| *count > 100) && faults.iter().sum::<u64>() >= FAULTS, "{faults:?}");
}

/// Flies a quarter of all frames and meets a quarter of all faults. Returns these.
fn fly(heightmap: &Heightmap, options: Options, window: u32, seed: u64) -> [u64; 3] {
    let source = Arc::new(Faulty::new(cut(heightmap, &options), seed));
    let (file, resident) = CellFile::open(source.clone()).unwrap();
    source.from.store(0, Relaxed);
    let sides = sides(file.header(), window);
    let mut method = Htp::stream_windows(file, resident, options, &sides).unwrap();
    method.set_culling(false);
    let mut mirror = MeshMirror::new(&method.buffers(), heightmap);
    let mut oracle = WatertightOracle::new(heightmap.columns(), heightmap.rows());
    let (mut plan, mut messages) = (FramePlan::default(), Vec::new());
    for (frame, view) in RandomWalk::new(seed, heightmap).enumerate() {
        // How many frames the thread needs for so many reads is not decided here, but it is to have its share of them.
        std::thread::sleep(std::time::Duration::from_micros(20));
        if frame >= FRAMES / 4 && method.failed_reads().sum() >= FAULTS / 4 {
            break;
        }
        method.plan(&view, &mut plan);
        let at = format!("seed {seed}, frame {frame}");
        if mirror.replay(&plan).unwrap_or_else(|error| panic!("{at}: {error}")) {
            let found = oracle.check(mirror.triangles(), mirror.degenerate());
            assert!(found.covers(heightmap.columns(), heightmap.rows()), "{at}: {found:?}");
            let is_right = |triangle: &terrain_core::Triangle| {
                triangle.samples.map(|sample| heightmap.height_m(sample)) == triangle.heights_m
            };
            assert!(mirror.triangles().iter().all(is_right), "{at}: heights that are not the DEM's");
        }
        if frame % 16 == 0 {
            assert_restricted(&method);
        }
        messages.extend(method.take_messages());
    }
    assert!(plan.streaming.retries > 0 && plan.streaming.cells_unloaded > 0, "{:?}", plan.streaming);
    let faults = settle(&mut method, &source, heightmap, seed);
    messages.extend(method.take_messages());
    let reads = method.failed_reads();
    assert_eq!([reads.io, reads.damaged, reads.wrong_cell], faults, "seed {seed}: every fault is counted");
    let told: std::collections::BTreeSet<&String> = messages.iter().collect();
    assert!(!messages.is_empty() && messages.len() as u64 <= reads.sum());
    assert!(told.len() * 2 > messages.len(), "one line a cell and kind: {} of {}", told.len(), messages.len());
    faults
}

/// Cells come one by one as their reads succeed, often with no other wish: what a closure was denied is asked for again.
#[test]
fn plans_that_wait_for_failing_cells_are_those_decided_anew() {
    let mut random = SplitMix64::new(5);
    // Errors that hardly grow with the level: blocks are often worse than the patches that they match.
    let noise = (0..97 * 86).map(|_| random.range(0.0, 15.0) as f32).collect();
    let noise = Arc::new(Heightmap::new(97, 86, [30.0, 25.0], noise).unwrap());
    for (seed, k, layers, window) in
        [(1, 2, 3, 4), (2, 3, 2, 6), (3, 2, 4, 3), (4, 3, 3, 2), (5, 2, 2, 9), (6, 2, 3, 9)]
    {
        let heightmap = if seed % 2 == 0 { noise.clone() } else { terrain(97, 86, true) };
        let (metric, batching, loading) = (LevelMetric::Error, Batching::Instanced, Loading::Blocking);
        let options = Options { k, layers, metric, tolerance_px: 2.0, batching, loading, ..Options::default() };
        let [mut following, mut anew] = [(); 2].map(|_| {
            let source = Arc::new(Faulty::new(cut(&heightmap, &options), seed));
            let (file, resident) = CellFile::open(source.clone()).unwrap();
            source.from.store(0, Relaxed);
            let sides = sides(file.header(), window);
            Htp::stream_windows(file, resident, options, &sides).unwrap()
        });
        let [mut plan, mut expected] = [FramePlan::default(), FramePlan::default()];
        // Six plans a view.
        let views = RandomWalk::new(seed, &heightmap).take(300).flat_map(|view| std::iter::repeat_n(view, 6));
        for (frame, view) in views.enumerate() {
            following.plan(&view, &mut plan);
            anew.forget();
            anew.plan(&view, &mut expected);
            assert!(plan == expected, "seed {seed}, frame {frame}");
        }
        assert!(plan.streaming.retries > 20, "seed {seed}: {:?}", plan.streaming);
    }
}

/// Plans on until no read is on its way. Returns the faults.
fn settle(method: &mut Htp, source: &Faulty, heightmap: &Heightmap, seed: u64) -> [u64; 3] {
    let view = RandomWalk::new(seed, heightmap).next().unwrap();
    let mut plan = FramePlan::default();
    source.from.store(u64::MAX, Relaxed);
    let is_complete = |method: &Htp| method.grid.window.inside().all(|sheet| !method.grid.window.lacks(sheet));
    // Retries are counted in plans.
    for _ in 0..100_000 {
        method.plan(&view, &mut plan);
        if is_complete(method) {
            break;
        }
        std::thread::sleep(std::time::Duration::from_micros(20));
    }
    assert!(is_complete(method), "what has failed is read again: {:?}", plan.streaming);
    method.plan(&view, &mut plan);
    source.faults.each_ref().map(|faults| faults.load(Relaxed))
}
