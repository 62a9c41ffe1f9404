//! The window: winit's events in, frames out.

use std::sync::Arc;
use std::time::Instant;

use terrain_lod::{Cause, Fault};
use terrain_renderer::{AdapterChoice, Gpu, RenderError};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowId};

use crate::apply::dropped;
use crate::viewer::Viewer;

/// Devices that may be lost one after the other, without a frame between them.
const MOST_LOST: u32 = 3;
/// The longest step of the clock that the camera follows, in seconds: after a pause it does not jump.
const LONGEST_STEP_S: f64 = 0.25;

/// What the window is opened with.
pub struct Start {
    pub choice: AdapterChoice,
    pub size_px: [u32; 2],
    pub title: String,
    pub began: Instant,
    pub exit_after: Option<u32>,
    /// Makes the viewer on the window's device.
    pub make: Box<dyn FnOnce(Gpu, wgpu::TextureFormat) -> Result<Viewer, Fault>>,
}

/// Opens the window and stays until it is closed; gives the viewer back for its settings.
pub fn run(start: Start) -> Result<Option<Viewer>, Fault> {
    let no_window = |error: &dyn std::fmt::Display| {
        let remedy = "is there a display? --headless-script needs none";
        Fault::new(Cause::Gpu, format_args!("cannot open a window: {error}; {remedy}"))
    };
    let event_loop = EventLoop::new().map_err(|error| no_window(&error))?;
    let mut app = App { start: Some(start), running: None, fault: None };
    event_loop.run_app(&mut app).map_err(|error| no_window(&error))?;
    match app.fault {
        Some(fault) => Err(fault),
        None => Ok(app.running.map(|running| running.viewer)),
    }
}

struct App {
    start: Option<Start>,
    running: Option<Running>,
    fault: Option<Fault>,
}

struct Running {
    viewer: Viewer,
    screen: Screen,
    egui: egui_winit::State,
    choice: AdapterChoice,
    began: Instant,
    last: Instant,
    frames: u32,
    exit_after: Option<u32>,
    lost: u32,
}

/// A window with its surface.
struct Screen {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let Some(start) = self.start.take() else { return };
        match Running::open(event_loop, start) {
            Ok(running) => self.running = Some(running),
            Err(fault) => self.end(event_loop, Some(fault)),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(running) = &mut self.running else { return };
        let _ = running.egui.on_window_event(&running.screen.window, &event);
        let result = match event {
            WindowEvent::CloseRequested => return self.end(event_loop, None),
            WindowEvent::Resized(size) => {
                running.screen.resize(&running.viewer.gpu, size);
                Ok(())
            }
            WindowEvent::DroppedFile(path) => running.viewer.apply(dropped(&path)).map_err(Fault::from),
            WindowEvent::RedrawRequested => running.frame(),
            _ => Ok(()),
        };
        let is_done = running.viewer.wants_quit || running.exit_after.is_some_and(|frames| running.frames >= frames);
        match result {
            Err(fault) => self.end(event_loop, Some(fault)),
            Ok(()) if is_done => {
                running.say_times();
                self.end(event_loop, None);
            }
            Ok(()) => {}
        }
    }

    fn about_to_wait(&mut self, _: &ActiveEventLoop) {
        if let Some(running) = &self.running {
            running.screen.window.request_redraw();
        }
    }
}

impl App {
    fn end(&mut self, event_loop: &ActiveEventLoop, fault: Option<Fault>) {
        self.fault = fault;
        event_loop.exit();
    }
}

impl Running {
    fn open(event_loop: &ActiveEventLoop, start: Start) -> Result<Self, Fault> {
        let size = PhysicalSize::new(start.size_px[0], start.size_px[1]);
        let attributes = Window::default_attributes().with_title(&start.title).with_inner_size(size);
        let window = event_loop.create_window(attributes);
        let window = Arc::new(window.map_err(|error| gpu_fault(format_args!("cannot open a window: {error}")))?);
        let (screen, gpu) = Screen::open(window, &start.choice)?;
        let viewer = (start.make)(gpu, screen.configuration.format)?;
        Ok(Self {
            egui: egui_state(&viewer, &screen.window),
            viewer,
            screen,
            choice: start.choice,
            began: start.began,
            last: Instant::now(),
            frames: 0,
            exit_after: start.exit_after,
            lost: 0,
        })
    }

    /// What a window that was opened for some frames has measured.
    fn say_times(&self) {
        if self.exit_after.is_some() {
            let times = &self.viewer.times;
            let said = |[p50, p99]: [f64; 2]| format!("P50 {p50:.1} P99 {p99:.1} ms");
            let own =
                times.own_ms().map_or(String::new(), |own_ms| format!(", without others on its core {}", said(own_ms)));
            println!("frames {}; work without the GPU's {}{own}", said(times.frame_ms()), said(times.work_ms()));
        }
    }

    /// One frame. A lost device is replaced, with all that was on it.
    fn frame(&mut self) -> Result<(), Fault> {
        match self.try_frame() {
            Ok(()) => self.lost = 0,
            Err(error @ (RenderError::Gpu(_) | RenderError::Timeout { .. })) if self.lost < MOST_LOST => {
                self.lost += 1;
                self.replace_device()?;
                self.viewer.state.say_fault(format!("the device was lost and replaced: {error}"));
            }
            Err(error) => return Err(error.into()),
        }
        Ok(())
    }

    fn try_frame(&mut self) -> Result<(), RenderError> {
        let Some(texture) = self.screen.next(&self.viewer.gpu)? else { return Ok(()) };
        let dt_s = std::mem::replace(&mut self.last, Instant::now()).elapsed().as_secs_f64();
        let size_px = [texture.texture.width(), texture.texture.height()];
        let input = self.egui.take_egui_input(&self.screen.window);
        let planned = self.viewer.plan(input, size_px, dt_s.min(LONGEST_STEP_S))?;
        let view = texture.texture.create_view(&Default::default());
        let (platform, _) = self.viewer.draw(planned, &view, dt_s)?;
        self.viewer.gpu.queue.present(texture);
        self.egui.handle_platform_output(&self.screen.window, platform);
        self.frames += 1;
        if self.frames == 1 && self.exit_after.is_some() {
            println!("first frame after {:.2} s", self.began.elapsed().as_secs_f64());
        }
        self.viewer.gpu.check()
    }

    fn replace_device(&mut self) -> Result<(), Fault> {
        let (screen, gpu) = Screen::open(self.screen.window.clone(), &self.choice)?;
        self.screen = screen;
        self.viewer.move_to(gpu, self.screen.configuration.format)?;
        self.egui = egui_state(&self.viewer, &self.screen.window);
        Ok(())
    }
}

fn egui_state(viewer: &Viewer, window: &Window) -> egui_winit::State {
    let longest = viewer.gpu.device.limits().max_texture_dimension_2d as usize;
    let context = viewer.context().clone();
    egui_winit::State::new(context, egui::ViewportId::ROOT, window, None, window.theme(), Some(longest))
}

impl Screen {
    fn open(window: Arc<Window>, choice: &AdapterChoice) -> Result<(Self, Gpu), Fault> {
        let instance = choice.instance()?;
        let surface = instance.create_surface(window.clone());
        let surface = surface.map_err(|error| gpu_fault(format_args!("the window cannot be drawn into: {error}")))?;
        let adapter = choice.adapter(&instance)?;
        let gpu = Gpu::on(&adapter)?;
        let formats = surface.get_capabilities(&adapter).formats;
        let has_four_bytes = |format: &&wgpu::TextureFormat| {
            use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba8Unorm, Rgba8UnormSrgb};
            matches!(format, Bgra8UnormSrgb | Rgba8UnormSrgb | Bgra8Unorm | Rgba8Unorm)
        };
        // The shaders write linear light.
        let format = formats.iter().filter(has_four_bytes).max_by_key(|format| format.is_srgb());
        let size = window.inner_size();
        let configuration = surface.get_default_config(&adapter, size.width.max(1), size.height.max(1));
        let (Some(format), Some(configuration)) = (format, configuration) else {
            let remedy = "choose another one with --adapter";
            return Err(gpu_fault(format_args!("{} cannot draw into this window; {remedy}", gpu.facts().name)));
        };
        let configuration = wgpu::SurfaceConfiguration { format: *format, ..configuration };
        surface.configure(&gpu.device, &configuration);
        gpu.check()?;
        Ok((Self { window, surface, configuration }, gpu))
    }

    fn resize(&mut self, gpu: &Gpu, size: PhysicalSize<u32>) {
        let longest = gpu.device.limits().max_texture_dimension_2d;
        [self.configuration.width, self.configuration.height] =
            [size.width, size.height].map(|side| side.clamp(1, longest));
        self.surface.configure(&gpu.device, &self.configuration);
    }

    /// The texture of the next frame; `None` where there is none to be drawn now.
    fn next(&mut self, gpu: &Gpu) -> Result<Option<wgpu::SurfaceTexture>, RenderError> {
        use wgpu::CurrentSurfaceTexture::{Lost, Occluded, Outdated, Suboptimal, Success, Timeout};
        match self.surface.get_current_texture() {
            Success(texture) | Suboptimal(texture) => Ok(Some(texture)),
            Timeout | Occluded => Ok(None),
            Outdated => {
                self.resize(gpu, self.window.inner_size());
                Ok(None)
            }
            // A new surface comes with a new device.
            Lost => Err(RenderError::Gpu("the window's surface was lost".into())),
            _ => gpu.check().map(|()| None),
        }
    }
}

fn gpu_fault(message: impl std::fmt::Display) -> Fault {
    Fault::new(Cause::Gpu, message)
}
