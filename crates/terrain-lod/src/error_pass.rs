//! The error pass: the mirror flies, no GPU, no clock. What it counts and measures is the same every time.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rayon::prelude::*;
use serde::Serialize;
use terrain_core::error::{ErrorDistribution, ErrorOracle};
use terrain_core::watertight::{WatertightOracle, Watertightness};
use terrain_core::{FramePlan, FrameStats, MeshMirror};

use crate::fault::{Cause, Fault};
use crate::interrupt;
use crate::methods::Run;
use crate::progress::Progress;
use crate::suite::Bench;

/// One frame of the error pass, a row in `frames/*-error.csv`.
#[derive(Clone, Debug, Serialize)]
pub struct ErrorFrame {
    pub frame: u32,
    pub eye_x_m: f64,
    pub eye_y_m: f64,
    pub eye_z_m: f64,
    pub triangles: u64,
    pub draws: u64,
    pub upload_bytes: u64,
    pub index_bytes_used: u64,
    pub updated_patches: u64,
    /// DEM samples in view.
    pub samples: u64,
    pub error_px_max: f64,
    pub error_px_p999: f64,
    pub error_px_p99: f64,
    pub error_px_p95: f64,
    pub error_px_rms: f64,
    /// Share of the samples in view above the first tolerance.
    pub over_tolerance_share: f64,
    pub error_m_max: f64,
    pub cracks: u64,
}

/// The error pass of one run.
pub struct ErrorFlight {
    pub frames: Vec<ErrorFrame>,
    /// All samples of all frames, over the run's tolerances.
    pub errors: ErrorDistribution,
    pub index_bytes_reserved: u64,
}

/// Flies all runs, on all cores. A run that fails yields its reason.
pub fn fly_all(bench: &Bench, progress: &Progress) -> Result<Vec<Result<ErrorFlight, String>>, Fault> {
    let fly_one = |run: &Run| outcome(catch_unwind(AssertUnwindSafe(|| fly(bench, run, progress))));
    bench.runs.par_iter().map(fly_one).collect()
}

/// A failure or a panic of one run becomes the text of its row; Ctrl-C ends them all.
pub fn outcome<T>(result: std::thread::Result<Result<T, Fault>>) -> Result<Result<T, String>, Fault> {
    match result {
        Ok(Ok(flight)) => Ok(Ok(flight)),
        Ok(Err(fault)) if fault.cause == Cause::Interrupted => Err(fault),
        Ok(Err(fault)) => Ok(Err(fault.to_string())),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| s.to_string()));
            Ok(Err(format!("panicked: {}", text.unwrap_or_default().replace('\n', " "))))
        }
    }
}

fn fly(bench: &Bench, run: &Run, progress: &Progress) -> Result<ErrorFlight, Fault> {
    let heightmap = &bench.dem.heightmap;
    let mut method = run.build(heightmap)?;
    let mut judge = Judge::new(bench, run, MeshMirror::new(&method.buffers(), heightmap));
    let index_bytes_reserved = method.buffers().indices;
    let mut plan = FramePlan::default();
    let mut frames = Vec::with_capacity(bench.path.len() as usize);
    for frame in 0..bench.path.len() {
        interrupt::check()?;
        let view = bench.path.view(frame, bench.suite.size_px).map_err(|e| Fault::new(Cause::BadInput, e))?;
        method.plan(&view, &mut plan);
        frames.push(judge.judge(frame, &view, &plan)?);
        progress.step();
    }
    Ok(ErrorFlight { frames, errors: judge.flight, index_bytes_reserved })
}

/// The mirror and the oracles of one run.
struct Judge<'a> {
    mirror: MeshMirror<'a>,
    watertight: WatertightOracle,
    /// As of the last change of the mesh.
    topology: Watertightness,
    oracle: ErrorOracle<'a>,
    frame: ErrorDistribution,
    flight: ErrorDistribution,
}

impl<'a> Judge<'a> {
    fn new(bench: &'a Bench, run: &Run, mirror: MeshMirror<'a>) -> Self {
        let tolerances: Vec<f32> = bench.suite.tolerances_of(run).iter().map(|t| *t as f32).collect();
        Self {
            mirror,
            watertight: WatertightOracle::new(bench.dem.heightmap.columns(), bench.dem.heightmap.rows()),
            topology: Watertightness::default(),
            oracle: ErrorOracle::new(&bench.dem.heightmap),
            frame: ErrorDistribution::new(&tolerances),
            flight: ErrorDistribution::new(&tolerances),
        }
    }

    fn judge(&mut self, frame: u32, view: &terrain_core::View, plan: &FramePlan) -> Result<ErrorFrame, Fault> {
        let changed = self.mirror.replay(plan).map_err(|e| Fault::new(Cause::Failure, e))?;
        if changed {
            self.topology = self.watertight.check(self.mirror.triangles(), self.mirror.degenerate());
            self.oracle.set_mesh(self.mirror.triangles());
        }
        self.frame.clear();
        self.oracle.measure(view, &mut self.frame);
        self.flight.merge(&self.frame);
        let stats = FrameStats::of(plan);
        let percentile = |share| tidy(self.frame.percentile_px(share).into());
        Ok(ErrorFrame {
            frame,
            eye_x_m: tidy(view.eye_world.x),
            eye_y_m: tidy(view.eye_world.y),
            eye_z_m: tidy(view.eye_world.z),
            triangles: stats.triangles,
            draws: stats.draws,
            upload_bytes: stats.upload_bytes,
            index_bytes_used: stats.index_bytes_used,
            updated_patches: stats.updated_patches,
            samples: self.frame.samples(),
            error_px_max: tidy(self.frame.max_px().into()),
            error_px_p999: percentile(0.999),
            error_px_p99: percentile(0.99),
            error_px_p95: percentile(0.95),
            error_px_rms: tidy(self.frame.rms_px()),
            over_tolerance_share: tidy(self.frame.over_share(0)),
            error_m_max: tidy(self.frame.max_m().into()),
            // A sample in view without a triangle over it is a hole.
            cracks: self.topology.cracks() + self.frame.uncovered(),
        })
    }
}

/// Six decimals: more than any of these numbers means, and the same text on every machine.
pub fn tidy(number: f64) -> f64 {
    (number * 1e6).round() / 1e6
}
