//! The error of what is drawn, measured behind the frames: a worker replays every plan in the bench's own judge.
//!
//! The render thread never waits for it. While it measures, uploads are kept for it and only the newest view is; so what
//! it says is of a frame that was drawn, and its age is known.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use glam::DVec3;
use terrain_core::{BufferSizes, FramePlan, Heightmap, Sample, Triangle, Upload, View};
use terrain_lod::{ErrorFrame, Judge};

use crate::thread;

/// Uploads that wait for the worker. One that falls behind by more gives up: a bound, not a setting.
const MOST_BYTES: usize = 512 << 20;
/// The longest rest after a measurement.
const LONGEST_REST: Duration = Duration::from_millis(300);

/// What was measured last.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The number of the frame that was drawn.
    pub frame: u32,
    /// When it was drawn.
    pub drawn: Instant,
    /// As in the bench's error pass.
    pub row: ErrorFrame,
    /// Around each patch.
    pub boxes: Arc<[PatchBox]>,
}

/// The bounds of a patch's triangles, in metres along the world's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchBox {
    pub low: DVec3,
    pub high: DVec3,
}

impl PatchBox {
    /// Metres from a point; 0 inside.
    pub fn distance_to(&self, point: DVec3) -> f64 {
        point.distance(point.clamp(self.low, self.high))
    }

    /// `None` for a patch without triangles.
    fn around(triangles: &[Triangle], spacing_m: [f64; 2]) -> Option<Self> {
        let [x_m, z_m] = spacing_m;
        let point = |(at, height_m): (Sample, f32)| {
            DVec3::new(f64::from(at.column) * x_m, height_m.into(), f64::from(at.row) * z_m)
        };
        let points = || triangles.iter().flat_map(|triangle| triangle.samples.into_iter().zip(triangle.heights_m));
        let low = points().map(point).reduce(DVec3::min)?;
        Some(Self { low, high: points().map(point).fold(low, DVec3::max) })
    }
}

/// The worker and what it is told.
pub struct Measurer {
    shared: Arc<Shared>,
    worker: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    news: Condvar,
}

#[derive(Default)]
struct State {
    newest: Option<Task>,
    measured: Option<Measured>,
    fault: Option<String>,
    closed: bool,
}

struct Task {
    frame: u32,
    drawn: Instant,
    view: View,
    /// With the uploads of the frames before that were passed over.
    plan: FramePlan,
}

impl Measurer {
    /// Starts a worker for a method with these buffers. With `rests`, it leaves the processor to others half of the time.
    pub fn start(heightmap: Arc<Heightmap>, sizes: BufferSizes, tolerance_px: f64, rests: bool) -> Self {
        let shared = Arc::<Shared>::default();
        let theirs = shared.clone();
        let work = move || {
            thread::step_back();
            let judge = &mut Judge::over(&heightmap, &[tolerance_px as f32], &sizes);
            theirs.work(judge, heightmap.spacing_m(), rests);
        };
        let worker = std::thread::Builder::new().name("measure".into()).spawn(work);
        let fault = worker.as_ref().err().map(|error| format!("cannot start the thread that measures: {error}"));
        shared.lock().fault = fault;
        Self { shared, worker: worker.ok() }
    }

    /// Tells of a frame that is drawn. Every plan must be told, in order.
    pub fn tell(&self, frame: u32, view: &View, plan: &FramePlan) {
        let mut state = self.shared.lock();
        if state.fault.is_some() {
            return;
        }
        let plan = match state.newest.take() {
            None => plan.clone(),
            Some(passed_over) => following(passed_over.plan, plan),
        };
        if plan.bytes.len() > MOST_BYTES {
            state.fault = Some("the measurement fell behind the uploads and was given up".into());
            return;
        }
        state.newest = Some(Task { frame, drawn: Instant::now(), view: view.clone(), plan });
        drop(state);
        self.shared.news.notify_one();
    }

    /// What was measured last, or why nothing is.
    pub fn measured(&self) -> Result<Option<Measured>, String> {
        let state = self.shared.lock();
        state.fault.clone().map_or_else(|| Ok(state.measured.clone()), Err)
    }
}

impl Drop for Measurer {
    fn drop(&mut self) {
        self.shared.lock().closed = true;
        self.shared.news.notify_one();
        // It ends with its measurement; nobody waits for that.
        drop(self.worker.take());
    }
}

/// A plan with the growths and uploads of those that were never replayed before it. Buffers keep what they hold when they
/// grow, so all growths may come first.
fn following(earlier: FramePlan, plan: &FramePlan) -> FramePlan {
    let FramePlan { mut growths, mut uploads, mut bytes, .. } = earlier;
    let shift = bytes.len();
    let shifted =
        |upload: &Upload| Upload { bytes: upload.bytes.start + shift..upload.bytes.end + shift, ..upload.clone() };
    growths.extend_from_slice(&plan.growths);
    uploads.extend(plan.uploads.iter().map(shifted));
    bytes.extend_from_slice(&plan.bytes);
    FramePlan { growths, uploads, bytes, ..plan.clone() }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work(&self, judge: &mut Judge, spacing_m: [f64; 2], rests: bool) {
        while let Some(task) = self.next() {
            let start = Instant::now();
            match judge.judge(task.frame, &task.view, &task.plan) {
                Ok(row) => {
                    let around = |triangles| PatchBox::around(triangles, spacing_m);
                    let boxes = judge.mirror().patches().filter_map(around).collect();
                    self.lock().measured = Some(Measured { frame: task.frame, drawn: task.drawn, row, boxes });
                }
                Err(fault) => {
                    self.lock().fault = Some(format!("the measurement failed: {fault}"));
                    return;
                }
            }
            if rests {
                std::thread::sleep(start.elapsed().min(LONGEST_REST));
            }
        }
    }

    /// Waits for a frame to measure; `None` at the end.
    fn next(&self) -> Option<Task> {
        let mut state = self.lock();
        loop {
            if state.closed {
                return None;
            }
            if let Some(task) = state.newest.take() {
                return Some(task);
            }
            state = self.news.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

#[cfg(test)]
mod tests {
    use terrain_core::{FrameStats, LodMethod, SplitMix64};
    use terrain_lod::{MethodName, Prepared, Run, Settings};

    use super::*;
    use crate::camera::{Motion, Rig};

    fn hills() -> Arc<Heightmap> {
        let height = |i: u32| ((i % 65) as f32 * 0.3).sin() * 30.0 + ((i / 65) as f32 * 0.2).cos() * 40.0;
        Arc::new(Heightmap::new(65, 65, [10.0; 2], (0..65 * 65).map(height).collect()).unwrap())
    }

    fn tin(dem: &Arc<Heightmap>) -> Box<dyn LodMethod> {
        let run = Run { method: MethodName::Tin, settings: Settings::default() };
        run.build(dem, &Prepared::default()).unwrap()
    }

    /// Frames are told much faster than they are measured, so that most are passed over. What is measured at the end must
    /// be what the bench measures, which sees every frame.
    #[test]
    fn frames_that_are_passed_over_leave_no_trace() {
        let dem = hills();
        let (mut method, mut rig, mut random) = (tin(&dem), Rig::over(&dem), SplitMix64::new(3));
        let measurer = Measurer::start(dem.clone(), method.buffers(), 1.0, false);
        let mut judge = Judge::over(&dem, &[1.0], &method.buffers());
        let mut plan = FramePlan::default();
        let (mut expected, mut uploads) = (None, 0);
        for frame in 0..60 {
            let motion = Motion { forward: 1.0, turn: [random.range(-1.0, 1.0), 0.0], ..Default::default() };
            rig.fly(&dem, &motion, 0.4);
            let view = rig.view([640, 360]).unwrap();
            method.plan(&view, &mut plan);
            uploads += u32::from(FrameStats::of(&plan).upload_bytes > 0);
            measurer.tell(frame, &view, &plan);
            expected = Some(judge.judge(frame, &view, &plan).unwrap());
        }
        assert!(uploads > 10, "{uploads}: nothing was passed over");
        let measured = wait_for(&measurer, 59);
        let [measured, expected] = [measured.row, expected.unwrap()]
            .map(|row| (row.triangles, row.samples, row.error_px_max, row.error_px_rms, row.cracks));
        assert_eq!(measured, expected);
    }

    fn wait_for(measurer: &Measurer, frame: u32) -> Measured {
        for _ in 0..60_000 {
            match measurer.measured().unwrap() {
                Some(measured) if measured.frame == frame => return measured,
                _ => std::thread::sleep(Duration::from_millis(1)),
            }
        }
        panic!("frame {frame} was never measured")
    }

    #[test]
    fn a_broken_plan_is_said_and_ends_the_measurement() {
        let dem = hills();
        let method = tin(&dem);
        let measurer = Measurer::start(dem.clone(), method.buffers(), 1.0, false);
        let view = Rig::over(&dem).view([64, 64]).unwrap();
        let mut plan = FramePlan::default();
        plan.draws.push(terrain_core::Draw { indices: 0..3, base_vertex: 0, instances: 0..1 });
        measurer.tell(0, &view, &plan);
        let refused = (0..60_000).find_map(|_| {
            std::thread::sleep(Duration::from_millis(1));
            measurer.measured().err()
        });
        assert!(refused.unwrap().contains("not all is uploaded"));
    }
}
