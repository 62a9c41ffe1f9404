//! The viewer without a window: one frame from input to picture. The window and the scripts both drive it.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError};

use egui::{PlatformOutput, RawInput};
use terrain_core::View;
use terrain_dem::Dem;
use terrain_lod::{Fault, Run};
use terrain_renderer::{Gpu, RenderError, Target};

use crate::camera::Rig;
use crate::command::Command;
use crate::gui::{Gui, Layout};
use crate::input::{self, Keyboard};
use crate::interface::{self, Interface};
use crate::map::Map;
use crate::memory::Memory;
use crate::pane::{Ground, Pane};
use crate::stage::{self, Stage};
use crate::state::State;
use crate::thread::{Spent, Stopwatch};
use crate::times::Times;

/// What is fixed for the life of a viewer.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where recorded flights and screenshots go.
    pub folder: PathBuf,
    /// Whether the measurement leaves the processor to others half of the time.
    pub rests: bool,
}

pub struct Viewer {
    pub options: Options,
    pub gpu: Gpu,
    format: wgpu::TextureFormat,
    pub(crate) stage: Stage,
    gui: Gui,
    /// As the file has it, and as it is drawn: they differ by the exaggeration.
    pub(crate) level_ground: Arc<Ground>,
    pub(crate) ground: Arc<Ground>,
    pub panes: [Pane; 2],
    pub state: State,
    keyboard: Keyboard,
    pub times: Times,
    pub memory: Memory,
    map: Map,
    /// Counts frames.
    frame: u32,
    /// The first frame for which nothing has changed since: whose measurement is up to date.
    unchanged_since: u32,
    last_view: Option<View>,
    pub(crate) opening: Option<Receiver<Result<(String, Dem), Fault>>>,
    pub(crate) wanted_shot: Option<PathBuf>,
    pub(crate) copied: Option<String>,
    pub wants_quit: bool,
}

/// A frame that is planned and laid out, ready to be drawn.
pub struct Planned {
    view: View,
    layout: Layout,
    work: Spent,
}

impl Viewer {
    pub fn new(
        gpu: Gpu,
        format: wgpu::TextureFormat,
        ground: Arc<Ground>,
        runs: [Run; 2],
        options: Options,
    ) -> Result<Self, RenderError> {
        let state = State::new(Rig::over(&ground.dem.heightmap));
        Ok(Self {
            options,
            stage: Stage::new(&gpu, &ground.dem.heightmap, format, state.submission)?,
            gui: Gui::new(&gpu, format),
            map: Map::of(&ground.dem.heightmap),
            panes: runs.map(Pane::new),
            level_ground: ground.clone(),
            ground,
            state,
            gpu,
            format,
            keyboard: Keyboard::default(),
            times: Times::default(),
            memory: Memory::default(),
            frame: 0,
            unchanged_since: 0,
            last_view: None,
            opening: None,
            wanted_shot: None,
            copied: None,
            wants_quit: false,
        })
    }

    pub fn context(&self) -> &egui::Context {
        &self.gui.context
    }

    /// As it is drawn.
    pub fn ground(&self) -> &Ground {
        &self.ground
    }

    /// What the methods were planned for last.
    pub fn last_view(&self) -> Option<&View> {
        self.last_view.as_ref()
    }

    /// Everything on a new device: what was lost is built again behind the frames.
    pub fn move_to(&mut self, gpu: Gpu, format: wgpu::TextureFormat) -> Result<(), RenderError> {
        (self.gpu, self.format) = (gpu, format);
        self.gui = Gui::new(&self.gpu, format);
        self.map = Map::of(&self.ground.dem.heightmap);
        self.restage()
    }

    /// The ground and the methods, anew.
    pub(crate) fn restage(&mut self) -> Result<(), RenderError> {
        self.panes.iter_mut().for_each(Pane::reset);
        self.stage = Stage::new(&self.gpu, &self.ground.dem.heightmap, self.format, self.state.submission)?;
        Ok(())
    }

    /// Another ground: the map and the methods are of the old one.
    pub(crate) fn move_over(&mut self, ground: Arc<Ground>) -> Result<(), RenderError> {
        self.ground = ground;
        self.map = Map::of(&self.ground.dem.heightmap);
        (self.state.frozen, self.last_view) = (None, None);
        self.restage()
    }

    /// Takes the input of a frame that follows the last one by `dt_s` seconds, moves, plans, and lays the interface out.
    pub fn plan(&mut self, mut input: RawInput, size_px: [u32; 2], dt_s: f64) -> Result<Planned, RenderError> {
        let watch = Stopwatch::start();
        self.state.advance(dt_s);
        self.take_opened()?;
        for command in self.keyboard.take(&mut input, self.gui.context.text_edit_focused()) {
            self.apply(command)?;
        }
        for pane in &mut self.panes {
            pane.build(&self.ground, &self.gpu, &self.stage.pass, self.options.rests)?;
        }
        self.fly(dt_s);
        let view = self.view(size_px);
        self.plan_methods(&view);
        let mut commands = Vec::new();
        let layout = self.lay_out(input, &view, &mut commands);
        self.take_gestures(size_px);
        for command in commands {
            self.apply(command)?;
        }
        Ok(Planned { view, layout, work: watch.spent() })
    }

    fn fly(&mut self, dt_s: f64) {
        let State { rig, flight, recorder, .. } = &mut self.state;
        let motion = self.keyboard.motion();
        match flight {
            Some(flight) if flight.is_playing => flight.fly(rig, dt_s),
            _ => rig.fly(&self.ground.dem.heightmap, &motion, dt_s),
        }
        if let Some(recorder) = recorder {
            recorder.fly(rig, dt_s);
        }
    }

    /// A camera that cannot be used is not kept.
    fn view(&mut self, size_px: [u32; 2]) -> View {
        self.state.rig.view(size_px).unwrap_or_else(|error| {
            self.state.say_fault(error.to_string());
            self.state.rig = Rig::over(&self.ground.dem.heightmap);
            self.state.rig.view(size_px).expect("a camera over the DEM can be used")
        })
    }

    fn plan_methods(&mut self, view: &View) {
        self.frame += 1;
        let state = &mut self.state;
        let planned_for = state.frozen.as_ref().unwrap_or(view);
        let uploaded = |panes: &[Pane; 2]| panes.each_ref().map(|pane| pane.counts().map(|counts| counts.uploaded));
        let before = uploaded(&self.panes);
        for pane in &mut self.panes {
            pane.plan(self.frame, state.frozen.is_none().then_some(view));
        }
        if self.last_view.as_ref() != Some(planned_for) || uploaded(&self.panes) != before {
            self.unchanged_since = self.frame;
            self.last_view = Some(planned_for.clone());
        }
    }

    fn lay_out(&mut self, input: RawInput, view: &View, commands: &mut Vec<Command>) -> Layout {
        self.memory.refresh();
        let facts = self.gpu.facts().clone();
        let mut parts = Interface {
            state: &self.state,
            panes: &self.panes,
            ground: &self.ground,
            times: &self.times,
            memory: &self.memory,
            map: &mut self.map,
            adapter: &facts,
            view,
            commands,
        };
        let copied = self.copied.take();
        self.gui.run(input, view.size_px, |ui| {
            copied.iter().for_each(|text| ui.ctx().copy_text(text.clone()));
            interface::show(ui, &mut parts);
        })
    }

    /// What the pointer did over the terrain moves the camera of the next frame.
    fn take_gestures(&mut self, size_px: [u32; 2]) {
        let gestures = input::gestures(&self.gui.context);
        let pixels_per_point = f64::from(self.gui.context.pixels_per_point());
        let rig = &mut self.state.rig;
        if gestures.drag != [0.0; 2] {
            rig.drag(gestures.drag.map(|points| points * pixels_per_point), size_px[1].into());
        }
        match (gestures.wheel, gestures.zooms, rig.orbit) {
            (0.0, ..) => {}
            (notches, true, _) => rig.zoom(notches),
            (notches, false, Some(_)) => rig.approach(notches),
            (notches, false, None) => rig.change_speed(notches),
        }
        if let Some(at) = gestures.double_click {
            rig.jump(&self.ground.dem.heightmap, at.map(|points| points * pixels_per_point), size_px);
        }
    }

    /// Draws what was planned, after a picture of it where one is wanted.
    pub fn draw(
        &mut self,
        planned: Planned,
        colour: &wgpu::TextureView,
        dt_s: f64,
    ) -> Result<(PlatformOutput, wgpu::SubmissionIndex), RenderError> {
        if let Some(path) = self.wanted_shot.take() {
            match self.shoot(&planned, &path) {
                Ok(()) => self.state.say(format!("{}: camera {}", path.display(), self.state.rig.link())),
                Err(error @ RenderError::Png { .. }) => self.state.say_fault(error.to_string()),
                Err(error) => return Err(error),
            }
        }
        let watch = Stopwatch::start();
        let submission = self.draw_into(&planned, colour)?;
        self.times.add(1e3 * dt_s, planned.work + watch.spent());
        self.gpu.check()?;
        Ok((planned.layout.platform, submission))
    }

    fn draw_into(
        &mut self,
        planned: &Planned,
        colour: &wgpu::TextureView,
    ) -> Result<wgpu::SubmissionIndex, RenderError> {
        let Planned { view, layout, .. } = planned;
        let frame = stage::Frame { state: &self.state, view, layout, colour };
        self.stage.draw(&self.gpu, &mut self.gui, &frame, &mut self.panes)
    }

    fn shoot(&mut self, planned: &Planned, path: &Path) -> Result<(), RenderError> {
        let target = Target::with_format(&self.gpu, planned.view.size_px, self.format)?;
        self.draw_into(planned, target.colour_view())?;
        target.save_png(&self.gpu, path)
    }

    /// Whether both methods are there, have caught up with the camera, and are measured.
    pub fn is_converged(&self) -> bool {
        let is_measured = |pane: &Pane| match (pane.run(), pane.measured()) {
            (None, _) | (_, Some(Err(_))) => true,
            (_, Some(Ok(measured))) => measured.frame >= self.unchanged_since,
            (_, None) => false,
        };
        self.opening.is_none() && self.panes.iter().all(|pane| pane.is_converged() && is_measured(pane))
    }

    fn take_opened(&mut self) -> Result<(), RenderError> {
        let Some(receiver) = &self.opening else { return Ok(()) };
        match receiver.try_recv() {
            Err(TryRecvError::Empty) => return Ok(()),
            Ok(Ok((spec, dem))) => self.fly_over(Arc::new(Ground::new(spec, dem)))?,
            Ok(Err(fault)) => self.state.say_fault(fault.to_string()),
            Err(TryRecvError::Disconnected) => self.state.say_fault("the reader panicked: this DEM cannot be opened"),
        }
        self.opening = None;
        Ok(())
    }
}
