//! The error pass: the mirror flies, no GPU, no clock. What it counts and measures is the same every time.

use serde::Serialize;
use terrain_core::error::{ErrorDistribution, ErrorOracle};
use terrain_core::popping::{Popping, TriangleSet};
use terrain_core::watertight::{WatertightOracle, Watertightness};
use terrain_core::{BufferSizes, FramePlan, FrameStats, Heightmap, IndexFormat, MeshMirror, View, triangles_by_level};

use crate::fault::{Cause, Fault};
use crate::interrupt;
use crate::methods::Run;
use crate::output::tidy;
use crate::progress::Progress;
use crate::read_failures::ReadFailures;
use crate::suite::Bench;

/// One frame of the error pass, a row in `frames/*-error.csv`; the columns as METHODOLOGY.md defines them.
#[expect(missing_docs, reason = "the names are those of the columns, and METHODOLOGY.md defines them")]
#[derive(Clone, Debug, Default, Serialize)]
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
    /// DEM samples in view that have a height. Without any the errors are empty.
    pub samples: u64,
    pub error_px_max: Option<f64>,
    pub error_px_p999: Option<f64>,
    pub error_px_p99: Option<f64>,
    pub error_px_p95: Option<f64>,
    pub error_px_rms: Option<f64>,
    /// Share of the samples in view above the first tolerance.
    pub over_tolerance_share: Option<f64>,
    pub error_m_max: Option<f64>,
    pub cracks: u64,
    /// The errors as displacements on the screen.
    pub displacement_px_max: Option<f64>,
    pub displacement_px_p99: Option<f64>,
    /// From here on: what the change of the mesh since the frame before does at this frame's camera. DEM samples in view
    /// that it has moved; without any the lengths are empty.
    pub popping_samples: u64,
    pub popping_px_max: Option<f64>,
    pub popping_px_p99: Option<f64>,
    /// The same as displacements on the screen.
    pub popping_displacement_px_max: Option<f64>,
    pub popping_displacement_px_p99: Option<f64>,
    /// Triangles that the mesh before had not, where it drew the ground.
    pub changed_triangles: u64,
    /// Of a method that loads cells: those in view that are drawn too coarsely for want of them, the pixels that the
    /// worst of it counts (0 where the bound is held, `inf` where the eye is within its bounds), and the DEM in memory.
    pub stand_ins: u64,
    pub unheld_px: f64,
    pub resident_bytes: u64,
    /// From level 0 on, with spaces between them, up to the last that has any.
    pub triangles_by_level: String,
    /// Cells that the frame still waits for, and from the beginning of the flight: cells loaded, reads that failed, reads
    /// after a failure.
    pub cells_due: u64,
    pub cells_loaded: u64,
    pub reads_failed: u64,
    pub read_retries: u64,
    /// Voids in view, which are none of `samples`.
    pub void_samples: u64,
}

/// The error pass of one run.
pub struct ErrorFlight {
    pub frames: Vec<ErrorFrame>,
    /// All samples of all frames, over the run's tolerances.
    pub errors: ErrorDistribution,
    /// All changes of all frames.
    pub popping: Popping,
    /// As of the last frame.
    pub index_bytes_reserved: u64,
}

/// Flies one run.
pub fn fly(bench: &Bench, run: &Run, progress: &Progress) -> Result<ErrorFlight, Fault> {
    let heightmap = &bench.dem.heightmap;
    let mut method = run.converged().build(heightmap, &bench.prepared)?;
    let mut judge = Judge::new(bench, run, &method.buffers());
    let mut plan = FramePlan::default();
    let mut frames = Vec::with_capacity(bench.path.len() as usize);
    let mut failures = ReadFailures::of(run);
    for frame in 0..bench.path.len() {
        interrupt::check()?;
        let view = bench.view(frame)?;
        method.plan(&view, &mut plan);
        failures.tell(&mut *method);
        frames.push(judge.judge(frame, &view, &plan)?);
        progress.step();
    }
    let index_bytes_reserved = method.buffers().indices;
    failures.finish(&mut *method, &plan);
    Ok(ErrorFlight { frames, errors: judge.flight, popping: judge.flight_popping, index_bytes_reserved })
}

/// The mirror and the oracles of one flight: what a plan draws, measured. The live pass has its plans judged here too.
pub struct Judge<'a> {
    heightmap: &'a Heightmap,
    mirror: MeshMirror<'a>,
    index_format: IndexFormat,
    watertight: WatertightOracle,
    /// As of the last change of the mesh.
    topology: Watertightness,
    oracle: ErrorOracle<'a>,
    triangles: TriangleSet,
    frame: ErrorDistribution,
    frame_popping: Popping,
    /// All samples of all frames judged so far, over the run's tolerances.
    pub flight: ErrorDistribution,
    /// All changes of all frames judged so far.
    pub flight_popping: Popping,
}

/// What a plan has done to the mesh.
#[derive(Clone, Copy)]
pub enum Change {
    /// It is the mesh of before.
    Nothing,
    /// It may be another one.
    Mesh {
        /// Those that the mesh before had not, where it drew the ground.
        triangles: u64,
    },
}

impl<'a> Judge<'a> {
    /// What the last plan draws.
    pub fn mirror(&self) -> &MeshMirror<'a> {
        &self.mirror
    }

    /// Of one run of a bench.
    pub fn new(bench: &'a Bench, run: &Run, sizes: &BufferSizes) -> Self {
        let tolerances: Vec<f32> = bench.suite.tolerances_of(run).iter().map(|t| *t as f32).collect();
        Self::over(&bench.dem.heightmap, &tolerances, sizes)
    }

    /// Over a DEM, for tolerances in pixels, of which the first is the frames' own.
    pub fn over(heightmap: &'a Heightmap, tolerances: &[f32], sizes: &BufferSizes) -> Self {
        Self {
            heightmap,
            mirror: MeshMirror::new(sizes, heightmap),
            index_format: sizes.index_format,
            watertight: WatertightOracle::new(heightmap.columns(), heightmap.rows()),
            topology: Watertightness::default(),
            oracle: ErrorOracle::new(heightmap),
            triangles: TriangleSet::default(),
            frame: ErrorDistribution::new(tolerances),
            frame_popping: Popping::default(),
            flight: ErrorDistribution::new(tolerances),
            flight_popping: Popping::default(),
        }
    }

    /// Executes a plan, and measures what has changed in its mesh.
    pub fn replay(&mut self, plan: &FramePlan) -> Result<Change, Fault> {
        let may_differ = self.mirror.replay(plan).map_err(|e| Fault::new(Cause::Failure, e))?;
        if !may_differ {
            return Ok(Change::Nothing);
        }
        let triangles = self.mirror.triangles();
        self.topology = self.watertight.check(triangles, self.mirror.degenerate());
        self.oracle.set_mesh(triangles);
        Ok(Change::Mesh { triangles: self.triangles.replace(triangles, |at| self.oracle.was_covered(at)) })
    }

    /// Measures errors and popping in a view.
    fn measure(&mut self, view: &View, change: Change) {
        self.frame.clear();
        self.oracle.measure(view, &mut self.frame);
        self.flight.merge(&self.frame);
        self.frame_popping.clear();
        if let Change::Mesh { .. } = change {
            self.oracle.measure_popping(view, &mut self.frame_popping);
            self.flight_popping.merge(&self.frame_popping);
        }
    }

    /// Executes a plan, and measures all that its view shows of it.
    pub fn judge(&mut self, frame: u32, view: &View, plan: &FramePlan) -> Result<ErrorFrame, Fault> {
        let change = self.replay(plan)?;
        self.measure(view, change);
        // Culling may only leave out what is out of view, and no sample in view may be without a triangle over it.
        let holes = self.watertight.open_edges_in_view(self.heightmap, view);
        let stats = FrameStats::of(plan);
        let measured = |value: f64| (self.frame.samples() > 0).then(|| tidy(value));
        let percentile = |share| measured(self.frame.percentile_px(share).into());
        let (pops, popping_samples) = (&self.frame_popping, self.frame_popping.pixels().samples());
        let popped = |value: f32| (popping_samples > 0).then(|| tidy(value.into()));
        Ok(ErrorFrame {
            frame,
            eye_x_m: tidy(view.eye_world.x),
            eye_y_m: tidy(view.eye_world.y),
            eye_z_m: tidy(view.eye_world.z),
            triangles: stats.triangles,
            draws: stats.draws,
            upload_bytes: stats.upload_bytes,
            index_bytes_used: stats.indices_used * self.index_format.bytes(),
            updated_patches: stats.updated_patches,
            samples: self.frame.samples(),
            error_px_max: measured(self.frame.max_px().into()),
            error_px_p999: percentile(0.999),
            error_px_p99: percentile(0.99),
            error_px_p95: percentile(0.95),
            error_px_rms: measured(self.frame.rms_px()),
            over_tolerance_share: measured(self.frame.over_share(0)),
            error_m_max: measured(self.frame.max_m().into()),
            cracks: self.topology.cracks() + holes + self.frame.uncovered(),
            displacement_px_max: measured(self.frame.displacements().max_px().into()),
            displacement_px_p99: measured(self.frame.displacements().percentile_px(0.99).into()),
            popping_samples,
            popping_px_max: popped(pops.pixels().max_px()),
            popping_px_p99: popped(pops.pixels().percentile_px(0.99)),
            popping_displacement_px_max: popped(pops.displacements().max_px()),
            popping_displacement_px_p99: popped(pops.displacements().percentile_px(0.99)),
            changed_triangles: match change {
                Change::Nothing => 0,
                Change::Mesh { triangles } => triangles,
            },
            stand_ins: plan.streaming.cells_missing,
            unheld_px: tidy(plan.unheld_px),
            resident_bytes: plan.streaming.resident_bytes,
            triangles_by_level: levels_text(&triangles_by_level(&self.mirror)),
            cells_due: plan.streaming.cells_due,
            cells_loaded: plan.streaming.cells_loaded,
            reads_failed: plan.streaming.reads_failed,
            read_retries: plan.streaming.retries,
            void_samples: self.frame.voids(),
        })
    }
}

/// `120 0 31`: level 0 first.
fn levels_text(levels: &[u64]) -> String {
    let count = levels.iter().rposition(|triangles| *triangles > 0).map_or(0, |last| last + 1);
    levels[..count].iter().map(u64::to_string).collect::<Vec<_>>().join(" ")
}
