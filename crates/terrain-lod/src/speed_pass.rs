//! The speed pass: every method flies with a clock on each step, and nothing else is measured.
//!
//! Methods take turns (A B C, A B C, ...), so that a slow spell of the machine hits all of them. Frames follow each other
//! as fast as they come: how a live run keeps up with a camera is the live pass's matter.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use serde::{Deserialize, Serialize};
use terrain_core::{FramePlan, FrameStats, View, WorkReport};
use terrain_renderer::{FrameTimes, Look, MethodBuffers, Renderer};

use crate::attempt::attempt;
use crate::fault::Fault;
use crate::frame_times::RepeatTimes;
use crate::interrupt;
use crate::methods::Run;
use crate::progress::Progress;
use crate::read_failures::ReadFailures;
use crate::suite::Bench;

/// One frame of the speed pass, a row in `frames/*-speed.csv`. Times are milliseconds.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SpeedFrame {
    pub repeat: u32,
    pub frame: u32,
    /// Whether the frame is one of those at the start that are not counted.
    pub warm_up: bool,
    /// From the call of `plan` to the end of the GPU's work.
    pub frame_ms: Option<f64>,
    pub plan_ms: f64,
    /// The updates that the plan did: all of it, and its stages summed over all threads.
    pub update_ms: f64,
    pub select_ms: f64,
    pub triangulate_ms: f64,
    pub upload_ms: Option<f64>,
    /// Recording the commands: what draw calls cost.
    pub encode_ms: Option<f64>,
    pub submit_ms: Option<f64>,
    pub wait_ms: Option<f64>,
    pub gpu_ms: Option<f64>,
    /// CPU time of the whole process.
    pub cpu_ms: f64,
    pub draw_calls: Option<u32>,
    /// Triangles that the updates made.
    #[serde(default)]
    pub updated_triangles: u64,
    /// Finding out what is in view, of methods where that is a step of its own.
    #[serde(default)]
    pub cull_ms: f64,
}

/// Which flights of a run: in an A/A check there are two sets that differ in nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Copy {
    A,
    B,
}

/// The flights of one run, or of its copy.
pub struct Lane<'a> {
    pub run: &'a Run,
    pub copy: Copy,
    /// All repeats so far, or why one failed.
    pub frames: Result<Vec<SpeedFrame>, Fault>,
}

impl Lane<'_> {
    /// Flights that are done.
    pub fn repeats(&self) -> u32 {
        self.frames.as_ref().ok().and_then(|frames| frames.last()).map_or(0, |last| last.repeat + 1)
    }

    /// The lane's statistics; empty where it failed.
    pub fn times(&self) -> RepeatTimes {
        self.frames.as_ref().map(|frames| RepeatTimes::of(frames)).unwrap_or_default()
    }

    /// Whether its median is known well enough. A lane that failed keeps nobody waiting.
    fn is_narrow(&self, share: f64) -> bool {
        self.frames.is_err() || self.times().headline_width().is_some_and(|width| width <= share)
    }
}

/// Flies all lanes in turn (A B C, A B C, ...) as often as the suite asks for, and passes a lane on after each of its
/// flights. Flights that a lane brings along are not flown again; a lane that fails is left out from then on.
pub fn fly_all(
    bench: &Bench,
    renderer: &mut Option<Renderer>,
    lanes: &mut [Lane],
    progress: &Progress,
    mut keep: impl FnMut(&Lane) -> Result<(), Fault>,
) -> Result<(), Fault> {
    for repeat in 0..bench.suite.most_repeats() {
        if repeat >= bench.suite.repeats {
            let share = bench.suite.until_ci.expect("without it there are no more repeats");
            if lanes.iter().all(|lane| lane.is_narrow(share)) {
                break;
            }
            progress.extend(lanes.len() as u64 * bench.path.len() as u64);
        }
        for lane in lanes.iter_mut().filter(|lane| lane.repeats() <= repeat) {
            let Ok(frames) = &mut lane.frames else { continue };
            match attempt(|| fly(bench, lane.run, repeat, renderer, progress))? {
                Ok(more) => {
                    frames.extend(more);
                    keep(lane)?;
                }
                Err(fault) => lane.frames = Err(fault),
            }
        }
    }
    Ok(())
}

fn fly(
    bench: &Bench,
    run: &Run,
    repeat: u32,
    renderer: &mut Option<Renderer>,
    progress: &Progress,
) -> Result<Vec<SpeedFrame>, Fault> {
    let mut method = run.build(&bench.dem.heightmap, &bench.prepared)?;
    let mut buffers = renderer.as_ref().map(|renderer| renderer.buffers(method.buffers())).transpose()?;
    let mut plan = FramePlan::default();
    let mut frames = Vec::with_capacity(bench.path.len() as usize);
    for frame in 0..bench.path.len() {
        interrupt::check()?;
        let view = bench.view(frame)?;
        let (cpu, start) = (ProcessTime::now(), Instant::now());
        method.plan(&view, &mut plan);
        let plan_time = start.elapsed();
        let times = draw(renderer, &mut buffers, &view, &plan, &bench.look)?;
        let cpu_time = cpu.elapsed();
        let work = |stage: fn(&WorkReport) -> Duration| ms(plan.work.iter().map(stage).sum());
        frames.push(SpeedFrame {
            repeat,
            frame,
            warm_up: frame < bench.warm_up,
            // Reading the GPU's clock comes after the frame and is not part of it.
            frame_ms: times.map(|t| ms(plan_time + t.upload + t.encode + t.submit + t.wait)),
            plan_ms: ms(plan_time),
            update_ms: work(|w| w.update),
            select_ms: work(|w| w.select),
            triangulate_ms: work(|w| w.triangulate),
            upload_ms: times.map(|t| ms(t.upload)),
            encode_ms: times.map(|t| ms(t.encode)),
            submit_ms: times.map(|t| ms(t.submit)),
            wait_ms: times.map(|t| ms(t.wait)),
            gpu_ms: times.and_then(|t| t.gpu).map(ms),
            cpu_ms: ms(cpu_time),
            draw_calls: times.map(|t| t.draw_calls),
            updated_triangles: FrameStats::of(&plan).updated_triangles,
            cull_ms: ms(plan.cull.0),
        });
        progress.step();
    }
    if repeat == 0 {
        ReadFailures::of(run).finish(&mut *method, &plan);
    }
    Ok(frames)
}

fn draw(
    renderer: &mut Option<Renderer>,
    buffers: &mut Option<MethodBuffers>,
    view: &View,
    plan: &FramePlan,
    look: &Look,
) -> Result<Option<FrameTimes>, Fault> {
    match (renderer, buffers) {
        (Some(renderer), Some(buffers)) => Ok(Some(renderer.frame(view, plan, buffers, look)?)),
        _ => Ok(None),
    }
}

/// Milliseconds to the microsecond.
pub fn ms(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e6).round() / 1e3
}
