//! What each command does.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::sync_channel;

use terrain_core::Heightmap;
use terrain_dem::ReadOptions;
use terrain_lod::open_flight;
use terrain_renderer::{Normals, RenderError, Submission};

use crate::command::{Command, Mode, Side};
use crate::flights::{Playback, Recorder};
use crate::pane::Ground;
use crate::state::State;
use crate::thread;
use crate::viewer::Viewer;

impl Viewer {
    /// Does what is asked for. What the user got wrong is said in the window; an error is the GPU's.
    pub fn apply(&mut self, command: Command) -> Result<(), RenderError> {
        let state = &mut self.state;
        match command {
            Command::Help => state.open.help = !state.open.help,
            Command::Panel => state.open.panel = !state.open.panel,
            Command::Hud => state.open.hud = !state.open.hud,
            Command::Map => state.open.map = !state.open.map,
            Command::Flip => state.shown = state.shown.next(),
            Command::Mode(mode) => state.mode = mode,
            Command::NextMode => state.mode = next_mode(state.mode),
            Command::Wireframe => self.toggle_wireframe(),
            Command::Normals => state.normals = other_normals(state.normals),
            Command::Stale => state.mark_stale = !state.mark_stale,
            Command::Boxes => state.boxes = !state.boxes,
            Command::Freeze => self.toggle_freeze(),
            Command::AboveGround => state.rig.above_ground = !state.rig.above_ground,
            Command::Orbit => state.rig.toggle_orbit(&self.ground.dem.heightmap),
            Command::Record => self.toggle_recording(),
            Command::Play => self.toggle_playing(),
            Command::Step(frames) => self.with_flight(|flight| flight.step(frames)),
            Command::Scrub(frame) => self.with_flight(|flight| flight.scrub(frame)),
            Command::Screenshot(path) => self.wanted_shot = Some(path.unwrap_or_else(|| self.free_name("view", "png"))),
            Command::CopyCamera => {
                state.say(format!("copied: --camera {}", state.rig.link()));
                self.copied = Some(self.state.rig.link());
            }
            Command::Method(side, run) => {
                let pane = &mut self.panes[(side == Side::Right) as usize];
                (pane.wanted, pane.fault) = (*run, None);
            }
            Command::Divider(share) => state.divider = share.clamp(0.02, 0.98),
            Command::Camera(link) => take_camera(state, &link),
            Command::OpenDem(spec) => self.open_dem(spec),
            Command::OpenFlight(spec) => self.open_flight(&spec),
            Command::Sun(angles) => state.sun_deg = angles,
            Command::Exaggeration(times) => return self.exaggerate(times),
            Command::ErrorScale(px) => state.error_scale_px = px,
            Command::Submission(submission) => self.submit_by(submission),
            Command::LoseDevice => {
                self.gpu.device.destroy();
                return Err(RenderError::Gpu("device lost: as the script asked".into()));
            }
            Command::Quit => self.wants_quit = true,
        }
        Ok(())
    }

    fn toggle_wireframe(&mut self) {
        if self.gpu.facts().wireframe {
            self.state.wireframe = !self.state.wireframe;
        } else {
            self.state.say_fault(format!("{} cannot draw a wireframe", self.gpu.facts().name));
        }
    }

    fn toggle_freeze(&mut self) {
        self.state.frozen = match self.state.frozen.take() {
            Some(_) => None,
            None => self.last_view().cloned(),
        };
    }

    fn toggle_recording(&mut self) {
        let Some(recorder) = self.state.recorder.take() else {
            self.state.recorder = Some(Recorder::start(&self.state.rig));
            return;
        };
        let path = self.free_name("flight", "toml");
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        match recorder.finish(&self.state.rig, &name).map(|text| std::fs::write(&path, text)) {
            None => self.state.say("nothing recorded: no time has passed"),
            Some(Ok(())) => {
                self.open_flight(&path.display().to_string());
                self.state.say(format!("recorded; fly it with: cargo xtask bench --flight {}", path.display()));
            }
            Some(Err(error)) => self.state.say_fault(format!("cannot write {}: {error}", path.display())),
        }
    }

    fn toggle_playing(&mut self) {
        if self.state.flight.is_none() {
            self.open_flight("fly-over");
        }
        if let Some(flight) = &mut self.state.flight {
            flight.toggle();
        }
    }

    /// The camera follows at once.
    fn with_flight(&mut self, change: impl FnOnce(&mut Playback)) {
        let State { flight, rig, .. } = &mut self.state;
        match flight {
            Some(flight) => {
                change(flight);
                flight.place(rig);
            }
            None => self.state.say("no flight yet: P plays one, R records one, a TOML file may be dropped"),
        }
    }

    fn open_flight(&mut self, spec: &str) {
        let opened = open_flight(spec).map_err(|fault| fault.to_string());
        let heightmap = &self.ground.dem.heightmap;
        let flight = opened.and_then(|flight| Playback::new(&flight, heightmap).map_err(|error| error.to_string()));
        match flight {
            Ok(flight) => {
                flight.place(&mut self.state.rig);
                self.state.flight = Some(flight);
            }
            Err(reason) => self.state.say_fault(reason),
        }
    }

    /// Reads a DEM behind the frames.
    fn open_dem(&mut self, spec: String) {
        let (sender, receiver) = sync_channel(1);
        self.state.say(format!("opening {spec} ..."));
        let open = move || {
            thread::step_back();
            let dem = terrain_lod::open_dem(&spec, &ReadOptions::default());
            drop(sender.send(dem.map(|dem| (spec, dem))));
        };
        match std::thread::Builder::new().name("open".into()).spawn(open) {
            Ok(_) => self.opening = Some(receiver),
            Err(error) => self.state.say_fault(format!("cannot start the thread that reads: {error}")),
        }
    }

    /// Another DEM: the camera starts anew and the flight of the old one ends.
    pub(crate) fn fly_over(&mut self, ground: Arc<Ground>) -> Result<(), RenderError> {
        let State { rig, flight, recorder, exaggeration, .. } = &mut self.state;
        *rig = crate::camera::Rig::over(&ground.dem.heightmap);
        (*flight, *recorder, *exaggeration) = (None, None, 1.0);
        self.level_ground = ground.clone();
        self.state.say(format!(
            "{}: {} x {} samples",
            ground.spec,
            ground.dem.heightmap.columns(),
            ground.dem.heightmap.rows()
        ));
        let moved = self.move_over(ground);
        self.keep_what_can_be_drawn(moved)
    }

    /// Methods, errors and pixels are all of the ground as it is drawn.
    fn exaggerate(&mut self, times: f64) -> Result<(), RenderError> {
        let level = &self.level_ground;
        let ground = if times == 1.0 { level.clone() } else { Arc::new(exaggerated(level, times)) };
        let rig = &mut self.state.rig;
        let eye = &mut rig.camera.eye_world;
        eye.y *= times / self.state.exaggeration;
        (self.state.exaggeration, rig.orbit, self.state.flight) = (times, None, None);
        let moved = self.move_over(ground);
        self.keep_what_can_be_drawn(moved)
    }

    /// A DEM that is too large for the adapter is refused in the window, and the built-in one takes its place.
    fn keep_what_can_be_drawn(&mut self, moved: Result<(), RenderError>) -> Result<(), RenderError> {
        match moved {
            Err(error @ RenderError::TextureTooLarge { .. }) => {
                let small = terrain_lod::open_dem("jacksboro", &ReadOptions::default()).expect("it is built in");
                self.fly_over(Arc::new(Ground::new("jacksboro".into(), small)))?;
                self.state.say_fault(error.to_string());
                Ok(())
            }
            moved => moved,
        }
    }

    fn submit_by(&mut self, submission: Submission) {
        self.state.submission = submission;
        self.stage.submit_by(&self.gpu, submission);
    }

    /// A name in our folder that no file has yet.
    fn free_name(&self, stem: &str, ending: &str) -> PathBuf {
        let name = |number: u32| self.options.folder.join(format!("{stem}-{number:03}.{ending}"));
        (1..).map(name).find(|path| !path.exists()).expect("numbers do not end before files do")
    }
}

fn next_mode(mode: Mode) -> Mode {
    let at = Mode::ALL.iter().position(|other| *other == mode).unwrap_or(0);
    Mode::ALL[(at + 1) % Mode::ALL.len()]
}

fn other_normals(normals: Normals) -> Normals {
    match normals {
        Normals::PerPixel => Normals::PerVertex,
        _ => Normals::PerPixel,
    }
}

fn take_camera(state: &mut State, link: &str) {
    if let Err(reason) = state.rig.take_link(link) {
        state.say_fault(reason);
    }
}

/// The same ground with its heights stretched; the steps of its cells stretch with it.
fn exaggerated(level: &Ground, times: f64) -> Ground {
    let map = &level.dem.heightmap;
    let heights = map.heights_m().iter().map(|height_m| (f64::from(*height_m) * times) as f32).collect();
    let stretched = Heightmap::new(map.columns(), map.rows(), map.spacing_m(), heights);
    let mut stretched = stretched.expect("finite heights stay finite");
    if let Some(voids) = level.dem.voids.clone().filter(|_| map.voids().is_some()) {
        stretched = stretched.with_voids(voids).expect("the mask is that of the same grid");
    }
    let mut dem = level.dem.clone();
    dem.heightmap = Arc::new(stretched);
    dem.reading.scale *= times;
    dem.reading.offset_m *= times;
    // Its own file of cells has other heights.
    Ground::new(format!("{} x {times}", level.spec), dem)
}

/// A file that is dropped on the window: a flight by its ending, or else a DEM.
pub fn dropped(path: &Path) -> Command {
    let spec = path.display().to_string();
    if path.extension().is_some_and(|ending| ending == "toml") {
        Command::OpenFlight(spec)
    } else {
        Command::OpenDem(spec)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exaggerated_ground_has_its_voids() {
        let text = "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -1\n1 2 3\n4 -1 6\n";
        let read = |options: &ReadOptions| terrain_dem::read_bytes("a.asc", text.into(), options).unwrap();
        let voids = |dem| exaggerated(&Ground::new("a.asc".into(), dem), 2.0).dem.heightmap.voids().cloned();
        assert!(voids(read(&ReadOptions::default())).unwrap().is_void(1, 1));
        let filled = ReadOptions { voids: terrain_dem::VoidPolicy::Fill, ..ReadOptions::default() };
        assert_eq!(voids(read(&filled)), None);
    }
}
