//! The live pass: runs with the schedule `live` fly in the flight's own time, so that the worker races the camera as it
//! would before a user.
//!
//! While a run flies, its plans are timed and copied, and nothing else is done. Nothing is drawn: the main thread sleeps
//! until the next frame is due, and the worker has the machine. After the flight the mirror replays the copies, so errors
//! and cracks are those of what would have been on the screen, lag included.

use std::thread::sleep;
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use serde::Serialize;
use terrain_core::error::ErrorDistribution;
use terrain_core::{FramePlan, LodMethod, View, WorkReport};

use crate::attempt::attempt;
use crate::error_pass::{ErrorFrame, Judge};
use crate::fault::{Cause, Fault};
use crate::interrupt;
use crate::methods::Run;
use crate::progress::Progress;
use crate::read_failures::ReadFailures;
use crate::speed_pass::ms;
use crate::suite::Bench;

/// How long a worker may take to catch up with the first view.
const PATIENCE: Duration = Duration::from_secs(120);

/// One frame of the live pass, a row in `frames/*-live.csv`. Times are milliseconds.
#[derive(Clone, Debug, Serialize)]
pub struct LiveFrame {
    pub repeat: u32,
    pub frame: u32,
    pub plan_ms: f64,
    /// CPU time of the same on its own thread: what is left of `plan_ms` where no other thread takes the core away.
    pub plan_cpu_ms: f64,
    /// Whether the plan was not there when the next frame was due.
    pub late: bool,
    /// Patches drawn for an older view.
    pub stale_patches: u32,
    /// The longest that an update of this frame was on its way; empty where none arrived.
    pub latency_ms: Option<f64>,
    pub updated_patches: u64,
    pub upload_bytes: u64,
    pub triangles: u64,
    /// As in the error pass, of the mesh that was drawn.
    pub samples: u64,
    pub error_px_max: Option<f64>,
    pub error_px_p99: Option<f64>,
    pub error_px_rms: Option<f64>,
    pub over_tolerance_share: Option<f64>,
    pub cracks: u64,
    /// As in the error pass.
    pub stand_ins: u64,
    pub unheld_px: f64,
    pub cells_due: u64,
    pub cells_loaded: u64,
    pub reads_failed: u64,
    pub read_retries: u64,
}

/// The live flights of one run.
pub struct LiveFlight {
    pub frames: Vec<LiveFrame>,
    /// All samples of all frames, over the run's tolerances.
    pub errors: ErrorDistribution,
}

/// The live flights of one run so far (`None` before the first), or why it failed.
pub type LiveFlights = Result<Option<LiveFlight>, Fault>;

/// A frame as it was flown, kept for the judge.
struct Flown {
    view: View,
    plan: FramePlan,
    plan_time: Duration,
    plan_cpu_time: Duration,
    late: bool,
}

/// Flies these runs in turn, `repeats` times, and passes on what a run has so far after each of its flights.
pub fn fly_all(
    bench: &Bench,
    runs: &[&Run],
    progress: &Progress,
    mut keep: impl FnMut(&Run, &[LiveFrame]) -> Result<(), Fault>,
) -> Result<Vec<LiveFlights>, Fault> {
    let mut flights: Vec<LiveFlights> = runs.iter().map(|_| Ok(None)).collect();
    for repeat in 0..bench.suite.repeats {
        for (run, flight) in runs.iter().zip(&mut flights) {
            let Ok(so_far) = flight else { continue };
            match attempt(|| fly(bench, run, repeat, progress))? {
                Ok(more) => {
                    let all = LiveFlight::joined(so_far.take(), more);
                    keep(run, &all.frames)?;
                    *so_far = Some(all);
                }
                Err(fault) => *flight = Err(fault),
            }
        }
    }
    Ok(flights)
}

impl LiveFlight {
    /// The flights so far and one more.
    fn joined(so_far: Option<Self>, more: Self) -> Self {
        let Some(mut all) = so_far else { return more };
        all.frames.extend(more.frames);
        all.errors.merge(&more.errors);
        all
    }
}

fn fly(bench: &Bench, run: &Run, repeat: u32, progress: &Progress) -> Result<LiveFlight, Fault> {
    let mut method = run.build(&bench.dem.heightmap, &bench.prepared)?;
    let mut judge = Judge::new(bench, run, &method.buffers());
    settle(bench, &mut *method, &mut judge)?;
    let flown = fly_in_time(bench, &mut *method)?;
    // Not on the way: nothing but plans is timed there.
    flown.last().into_iter().for_each(|last| ReadFailures::of(run).finish(&mut *method, &last.plan));
    // Its worker must not work on beside the judge.
    drop(method);
    let mut frames = Vec::with_capacity(flown.len());
    for (frame, flown) in (0..).zip(flown) {
        interrupt::check()?;
        let judged = judge.judge(frame, &flown.view, &flown.plan)?;
        frames.push(live_frame(repeat, &flown, judged));
        progress.step();
    }
    Ok(LiveFlight { frames, errors: judge.flight })
}

/// Stands at the first view until the worker has caught up, or the cells are loaded: the flight measures its lag, not its
/// start.
fn settle(bench: &Bench, method: &mut dyn LodMethod, judge: &mut Judge) -> Result<(), Fault> {
    let (view, start) = (bench.view(0)?, Instant::now());
    let mut plan = FramePlan::default();
    while start.elapsed() < PATIENCE {
        interrupt::check()?;
        method.plan(&view, &mut plan);
        judge.replay(&plan)?;
        if plan.stale_patches == 0 && plan.streaming.cells_due == 0 {
            return Ok(());
        }
        sleep(Duration::from_millis(1));
    }
    let message = format!("the worker has not caught up with a camera that stands for {} s", PATIENCE.as_secs());
    Err(Fault::new(Cause::Failure, message))
}

/// The flight itself. Every frame is due at its own time after the start, so one that is late does not delay the others.
fn fly_in_time(bench: &Bench, method: &mut dyn LodMethod) -> Result<Vec<Flown>, Fault> {
    let step = Duration::from_secs_f64(bench.path.step_s());
    let mut plan = FramePlan::default();
    let mut flown = Vec::with_capacity(bench.path.len() as usize);
    let start = Instant::now();
    for frame in 0..bench.path.len() {
        interrupt::check()?;
        let (view, due) = (bench.view(frame)?, start + step * frame);
        sleep(due.saturating_duration_since(Instant::now()));
        let (cpu, asked) = (ThreadTime::now(), Instant::now());
        method.plan(&view, &mut plan);
        let (done, plan_cpu_time) = (Instant::now(), cpu.elapsed());
        let (plan_time, late) = (done - asked, done > due + step);
        flown.push(Flown { view, plan: plan.clone(), plan_time, plan_cpu_time, late });
    }
    Ok(flown)
}

fn live_frame(repeat: u32, flown: &Flown, judged: ErrorFrame) -> LiveFrame {
    let latency = |work: &WorkReport| work.latency;
    LiveFrame {
        repeat,
        frame: judged.frame,
        plan_ms: ms(flown.plan_time),
        plan_cpu_ms: ms(flown.plan_cpu_time),
        late: flown.late,
        stale_patches: flown.plan.stale_patches,
        latency_ms: flown.plan.work.iter().map(latency).max().map(ms),
        updated_patches: judged.updated_patches,
        upload_bytes: judged.upload_bytes,
        triangles: judged.triangles,
        samples: judged.samples,
        error_px_max: judged.error_px_max,
        error_px_p99: judged.error_px_p99,
        error_px_rms: judged.error_px_rms,
        over_tolerance_share: judged.over_tolerance_share,
        cracks: judged.cracks,
        stand_ins: judged.stand_ins,
        unheld_px: judged.unheld_px,
        cells_due: judged.cells_due,
        cells_loaded: judged.cells_loaded,
        reads_failed: judged.reads_failed,
        read_retries: judged.read_retries,
    }
}
