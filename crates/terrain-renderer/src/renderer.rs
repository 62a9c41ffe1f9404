//! One frame, offscreen: uploads, one pass, one submission, and a clock on each step.

use std::time::{Duration, Instant};

use terrain_core::{BufferSizes, FramePlan, Heightmap, View};

use crate::timing::Gauges;
use crate::{
    Gpu, Look, MethodBuffers, PreparedFrame, RenderError, Scene, Submission, Target, TerrainPass, ViewBindings,
};

/// What is fixed for the life of a [`Renderer`].
#[derive(Clone, Copy, Debug)]
pub struct RendererSettings {
    /// Width and height of the picture in pixels, each 1 to the adapter's longest texture side (default 640 x 360).
    pub size_px: [u32; 2],
    /// How draws are sent (default: one by one).
    pub submission: Submission,
    /// Let the GPU count its primitives, where it can (default: no, since it may cost time).
    pub count_primitives: bool,
}

impl Default for RendererSettings {
    fn default() -> Self {
        Self { size_px: [640, 360], submission: Submission::Direct, count_primitives: false }
    }
}

/// What one frame took, and what was counted on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameTimes {
    /// CPU time to queue the plan's uploads, the uniforms and the indirect arguments.
    pub upload: Duration,
    /// CPU time to record the commands and to finish the recording: what the draw calls cost.
    pub encode: Duration,
    /// CPU time to submit. (On GL this contains the whole frame.)
    pub submit: Duration,
    /// From the submission to the end of the GPU's work.
    pub wait: Duration,
    /// GPU time of the pass, where the adapter has timestamps.
    pub gpu: Option<Duration>,
    /// Triangles that the GPU's clipper was given, the wireframe's excluded; where it was asked for and the adapter
    /// can count.
    pub primitives: Option<u64>,
    /// Draw calls made, the wireframe's included.
    pub draw_calls: u32,
}

/// Draws the plans of any method over one heightmap into an offscreen target.
#[derive(Debug)]
pub struct Renderer {
    gpu: Gpu,
    pass: TerrainPass,
    bindings: ViewBindings,
    target: Target,
    gauges: Gauges,
}

impl Renderer {
    /// Uploads the heightmap and builds the pipelines.
    pub fn new(gpu: Gpu, heightmap: &Heightmap, settings: &RendererSettings) -> Result<Self, RenderError> {
        let scene = Scene::new(&gpu, heightmap)?;
        Self::over(gpu, scene, settings)
    }

    /// Builds the pipelines over a scene.
    pub fn over(gpu: Gpu, scene: Scene, settings: &RendererSettings) -> Result<Self, RenderError> {
        let pass = TerrainPass::new(&gpu, scene, Target::COLOUR_FORMAT, settings.submission)?;
        let target = Target::new(&gpu, settings.size_px)?;
        let gauges = Gauges::new(&gpu, settings.count_primitives);
        let bindings = pass.view_bindings(&gpu);
        gpu.check()?;
        Ok(Self { gpu, pass, bindings, target, gauges })
    }

    /// The buffers of one method.
    pub fn buffers(&self, sizes: BufferSizes) -> Result<MethodBuffers, RenderError> {
        MethodBuffers::new(&self.gpu, sizes)
    }

    /// The device that everything is drawn on.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// How draws are sent: what the settings asked for, where the adapter can do it.
    pub fn submission(&self) -> Submission {
        self.pass.submission()
    }

    /// The picture that the frames are drawn into.
    pub fn target(&self) -> &Target {
        &self.target
    }

    /// Replays one plan and waits for the GPU. After an `Err` the next frame starts afresh.
    pub fn frame(
        &mut self,
        view: &View,
        plan: &FramePlan,
        buffers: &mut MethodBuffers,
        look: &Look,
    ) -> Result<FrameTimes, RenderError> {
        self.check_size(view)?;
        let mut clock = Clock::start();
        let frame = self.pass.prepare(&self.gpu, view, plan, look, buffers, &mut self.bindings)?;
        let upload = clock.lap();
        let (commands, draw_calls) = record(&self.gpu, &self.target, &self.gauges, &frame, look);
        let encode = clock.lap();
        let submission = self.gpu.queue.submit([commands]);
        let submit = clock.lap();
        self.gpu.check()?; // before the wait: a refused submission never finishes
        self.gpu.wait(submission)?;
        let wait = clock.lap();
        let (gpu, primitives) = self.gauges.read(&self.gpu)?;
        self.gpu.check()?;
        Ok(FrameTimes { upload, encode, submit, wait, gpu, primitives, draw_calls })
    }

    fn check_size(&self, view: &View) -> Result<(), RenderError> {
        if view.size_px == self.target.size_px() {
            return Ok(());
        }
        Err(RenderError::ViewSize { view_px: view.size_px, target_px: self.target.size_px() })
    }
}

/// The commands of a frame, and the number of draw calls among them.
fn record(
    gpu: &Gpu,
    target: &Target,
    gauges: &Gauges,
    frame: &PreparedFrame,
    look: &Look,
) -> (wgpu::CommandBuffer, u32) {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let (colour, depth) = (target.colour_view(), target.depth_view());
    let mut pass = TerrainPass::begin(&mut encoder, colour, depth, look, gauges.timestamp_writes());
    let mut draw_calls = gauges.count(&mut pass, |pass| frame.draw(pass));
    if look.wireframe {
        draw_calls += frame.draw_wireframe(&mut pass);
    }
    drop(pass);
    gauges.resolve(&mut encoder);
    (encoder.finish(), draw_calls)
}

/// A stopwatch with laps.
struct Clock(Instant);

impl Clock {
    fn start() -> Self {
        Self(Instant::now())
    }

    /// Time since the start or the last lap.
    fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now - std::mem::replace(&mut self.0, now)
    }
}
