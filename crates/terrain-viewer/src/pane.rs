//! One method in the window: built behind the frames, planned, drawn, measured.

use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};

use terrain_core::{BufferSizes, FramePlan, FrameStats, LodMethod, View};
use terrain_dem::Dem;
use terrain_lod::{Fault, Prepared, Run};
use terrain_renderer::{Gpu, Look, MethodBuffers, PreparedFrame, RenderError, TerrainPass, ViewBindings};

use crate::cells::LoadedCells;
use crate::measure::{Measured, Measurer};
use crate::thread;

/// The ground that is flown over, and what the methods prepared for it: kept while their settings change.
pub struct Ground {
    /// As on the command line.
    pub spec: String,
    pub dem: Dem,
    prepared: Mutex<Prepared>,
}

impl Ground {
    pub fn new(spec: String, dem: Dem) -> Self {
        Self { spec, dem, prepared: Mutex::default() }
    }

    /// Makes a method; takes a while.
    pub fn build(&self, run: &Run) -> Result<Box<dyn LodMethod>, Fault> {
        run.validate()?;
        let mut prepared = self.prepared.lock().unwrap_or_else(PoisonError::into_inner);
        prepared.add(&[*run], &self.dem, &self.spec, None)?;
        run.build(&self.dem.heightmap, &prepared)
    }
}

/// A method that is wanted, and the one that is drawn: they differ while the new one is being built.
pub struct Pane {
    pub wanted: Run,
    building: Option<(Run, Receiver<Built>)>,
    drawn: Option<Drawn>,
    /// Why the wanted one is not drawn.
    pub fault: Option<String>,
}

type Built = Result<Box<dyn LodMethod>, Fault>;

/// A method with all that it takes to draw it.
struct Drawn {
    run: Run,
    method: Box<dyn LodMethod>,
    plan: FramePlan,
    buffers: MethodBuffers,
    bindings: ViewBindings,
    measurer: Measurer,
    loaded: Option<LoadedCells>,
    counts: Counts,
}

/// The cells that a method loads, for the map.
pub struct Cells<'a> {
    /// Sample intervals along a cell.
    pub side: u32,
    /// By level, the finest first: first and last cell of what is kept of it around the eye. Empty for a DEM in memory.
    pub windows: Vec<[[u32; 2]; 2]>,
    /// Which of them are there, by the same levels.
    pub loaded: Option<&'a LoadedCells>,
}

/// What the HUD shows of the last frame, all of it counted by the bench's code.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    pub stats: FrameStats,
    /// Calls that the renderer made of the draws when they were drawn last, those of a wireframe included.
    pub draw_calls: u32,
    /// Bytes uploaded since the method was made.
    pub uploaded: u64,
    /// From asking for the last update to drawing it, in milliseconds.
    pub latency_ms: f64,
    /// Bytes of the method's buffers on the GPU.
    pub buffer_bytes: u64,
    /// By how many pixels the tolerance is not held, and cells that are still to be loaded.
    pub unheld_px: f64,
    pub cells_due: u64,
}

impl Pane {
    pub fn new(wanted: Run) -> Self {
        Self { wanted, building: None, drawn: None, fault: None }
    }

    /// The settings of what is drawn.
    pub fn run(&self) -> Option<&Run> {
        self.drawn.as_ref().map(|drawn| &drawn.run)
    }

    /// Whether what is drawn is what is wanted.
    pub fn is_settled(&self) -> bool {
        self.building.is_none() && (self.fault.is_some() || self.run() == Some(&self.wanted))
    }

    /// Whether every part of the mesh belongs to the last view.
    pub fn is_converged(&self) -> bool {
        let caught_up = |drawn: &Drawn| drawn.plan.stale_patches == 0 && drawn.plan.streaming.cells_due == 0;
        self.is_settled() && self.drawn.as_ref().is_none_or(caught_up)
    }

    pub fn counts(&self) -> Option<&Counts> {
        self.drawn.as_ref().map(|drawn| &drawn.counts)
    }

    /// `None` where the method has no cells.
    pub fn cells(&self) -> Option<Cells<'_>> {
        let drawn = self.drawn.as_ref()?;
        let sizes = drawn.method.buffers();
        let windows = sizes.heights.iter().flat_map(|tiles| {
            let sides = &tiles.windows[..tiles.coarse_level as usize];
            sides
                .iter()
                .zip(drawn.plan.streaming.first_cells)
                .map(|(side, first)| [first, first.map(|at| at + side - 1)])
        });
        Some(Cells { side: sizes.cell_side?, windows: windows.collect(), loaded: drawn.loaded.as_ref() })
    }

    pub fn measured(&self) -> Option<Result<Measured, String>> {
        self.drawn.as_ref().and_then(|drawn| drawn.measurer.measured().transpose())
    }

    /// Forgets what is on a GPU, for another one or another ground. What is wanted stays.
    pub fn reset(&mut self) {
        self.retire();
        (self.building, self.fault) = (None, None);
    }

    /// Ends what is drawn. Its workers may be in the middle of an update, which nobody waits for here.
    fn retire(&mut self) {
        if let Some(Drawn { method, .. }) = self.drawn.take() {
            // Where no thread can be started, the method ends here after all.
            let _ = std::thread::Builder::new().name("retire".into()).spawn(move || drop(method));
        }
    }

    /// Builds what is wanted, one method at a time, and takes what was built.
    pub fn build(
        &mut self,
        ground: &Arc<Ground>,
        gpu: &Gpu,
        pass: &TerrainPass,
        rests: bool,
    ) -> Result<(), RenderError> {
        if let Some((run, receiver)) = &self.building {
            match receiver.try_recv() {
                Err(TryRecvError::Empty) => return Ok(()),
                Ok(Ok(method)) => {
                    let run = *run;
                    self.building = None;
                    self.take(run, method, ground, gpu, pass, rests)?;
                }
                Ok(Err(fault)) => self.refuse(fault.to_string()),
                Err(TryRecvError::Disconnected) => self.refuse("the method panicked while it was built".into()),
            }
        }
        if self.run() != Some(&self.wanted) && self.fault.is_none() && self.building.is_none() {
            self.start_building(ground);
        }
        Ok(())
    }

    fn refuse(&mut self, fault: String) {
        // What was asked for meanwhile gets its turn.
        let is_wanted = self.building.take().is_some_and(|(run, _)| run == self.wanted);
        self.fault = is_wanted.then_some(fault);
    }

    fn start_building(&mut self, ground: &Arc<Ground>) {
        let (sender, receiver) = sync_channel(1);
        let (run, ground) = (self.wanted, ground.clone());
        let build = move || {
            // With it the threads that the method starts: interaction goes before updates.
            thread::step_back();
            // Nobody may be there any more to take it.
            drop(sender.send(ground.build(&run)));
        };
        match std::thread::Builder::new().name("build".into()).spawn(build) {
            Ok(_) => self.building = Some((run, receiver)),
            Err(error) => self.fault = Some(format!("cannot start the thread that builds: {error}")),
        }
    }

    fn take(
        &mut self,
        run: Run,
        method: Box<dyn LodMethod>,
        ground: &Ground,
        gpu: &Gpu,
        pass: &TerrainPass,
        rests: bool,
    ) -> Result<(), RenderError> {
        // The old buffers go first: both may not fit.
        self.retire();
        let sizes = method.buffers();
        let buffers = match MethodBuffers::new(gpu, sizes) {
            Err(error @ (RenderError::BufferTooLarge { .. } | RenderError::NoHeightTiles(_))) => {
                self.fault = Some(error.to_string());
                return Ok(());
            }
            buffers => buffers?,
        };
        let heightmap = ground.dem.heightmap.clone();
        self.drawn = Some(Drawn {
            loaded: sizes.heights.map(LoadedCells::new),
            measurer: Measurer::start(heightmap, sizes, run.settings.tolerance_px, rests),
            run,
            method,
            plan: FramePlan::default(),
            buffers,
            bindings: pass.view_bindings(gpu),
            counts: Counts::default(),
        });
        Ok(())
    }

    /// Plans a frame. Without a view what was planned last stays, and nothing is uploaded.
    pub fn plan(&mut self, frame: u32, view: Option<&View>) {
        let Some(drawn) = &mut self.drawn else { return };
        match view {
            Some(view) => {
                drawn.method.plan(view, &mut drawn.plan);
                drawn.measurer.tell(frame, view, &drawn.plan);
                drawn.loaded.iter_mut().for_each(|loaded| loaded.follow(&drawn.plan));
            }
            None => {
                drawn.plan.uploads.clear();
                drawn.plan.growths.clear();
                drawn.plan.work.clear();
            }
        }
        drawn.count(view.is_some());
    }

    /// Queues what the plan needs to be drawn in this view.
    pub fn prepare<'a>(
        &'a mut self,
        gpu: &Gpu,
        pass: &'a TerrainPass,
        view: &View,
        look: &Look,
    ) -> Result<Option<PreparedPane<'a>>, RenderError> {
        let Some(Drawn { plan, buffers, bindings, counts, .. }) = &mut self.drawn else { return Ok(None) };
        let frame = pass.prepare(gpu, view, plan, look, buffers, bindings)?;
        Ok(Some(PreparedPane { frame, draw_calls: &mut counts.draw_calls }))
    }

    /// Queues the uploads of a plan that is not drawn.
    pub fn upload(&mut self, gpu: &Gpu) -> Result<(), RenderError> {
        match &mut self.drawn {
            Some(drawn) => drawn.buffers.apply(gpu, &drawn.plan),
            None => Ok(()),
        }
    }
}

impl Drawn {
    fn count(&mut self, is_planned: bool) {
        let counts = &mut self.counts;
        let stats = FrameStats::of(&self.plan);
        counts.uploaded += stats.upload_bytes;
        if is_planned {
            counts.stats = stats;
        }
        if let Some(latency) = self.plan.work.iter().map(|work| work.latency).max() {
            counts.latency_ms = latency.as_secs_f64() * 1e3;
        }
        counts.buffer_bytes = bytes_of(&self.method.buffers());
        (counts.unheld_px, counts.cells_due) = (self.plan.unheld_px, self.plan.streaming.cells_due);
    }
}

fn bytes_of(sizes: &BufferSizes) -> u64 {
    sizes.vertices + sizes.indices + sizes.instances + sizes.heights.map_or(0, |tiles| tiles.bytes())
}

/// A plan that is ready to be drawn.
pub struct PreparedPane<'a> {
    frame: PreparedFrame<'a>,
    draw_calls: &'a mut u32,
}

impl PreparedPane<'_> {
    pub fn draw(&mut self, pass: &mut wgpu::RenderPass, wireframe: bool) {
        *self.draw_calls = self.frame.draw(pass);
        if wireframe {
            *self.draw_calls += self.frame.draw_wireframe(pass);
        }
    }
}
