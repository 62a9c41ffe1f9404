//! The program `terrain-viewer`: two terrain methods side by side, on the core, the methods and the renderer of the bench.
//!
//! ```text
//!  app (winit) ───┐                     ┌─> pane: method.plan ──> FramePlan ──> stage: TerrainPass, egui
//!  script ────────┴─> viewer: a frame ──┤            └─> measure: the bench's judge, behind the frames
//!                                       └─> interface: panel, hud, overlay, map ──> Command ──> apply
//! ```

mod app;
mod apply;
mod camera;
mod cells;
mod cli;
mod command;
mod difference;
mod flights;
mod gui;
mod help;
mod hud;
mod input;
mod interface;
mod map;
mod measure;
mod memory;
mod overlay;
mod pane;
mod panel;
mod run_text;
mod script;
mod settings;
mod soak;
mod stage;
mod state;
mod thread;
mod times;
mod viewer;

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use terrain_lod::{Fault, LoadingName, Run, ScheduleName, open_flight};
use terrain_renderer::{Gpu, Target};

use crate::cli::Cli;
use crate::command::Command;
use crate::flights::Playback;
use crate::pane::Ground;
use crate::script::{Runner, Script};
use crate::settings::Kept;
use crate::viewer::{Options, Viewer};

fn main() -> ExitCode {
    let cli = Cli::parse();
    match run(&cli, Instant::now()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            eprintln!("error: {fault}");
            ExitCode::from(fault.cause as u8)
        }
    }
}

fn run(cli: &Cli, began: Instant) -> Result<(), Fault> {
    match &cli.headless_script {
        Some(path) => run_script(cli, path),
        None => open_window(cli, began),
    }
}

fn run_script(cli: &Cli, path: &Path) -> Result<(), Fault> {
    let text = std::fs::read_to_string(path).map_err(|error| Fault::read(path, &error, "a script"))?;
    let script = Script::parse(&path.display().to_string(), &text)?;
    let choice = cli.adapter.choice();
    let ground = ground(cli)?;
    let gpu = Gpu::headless(&choice)?;
    let viewer = viewer(cli, ground, &Kept::default(), false, gpu, Target::COLOUR_FORMAT)?;
    Runner::new(viewer, choice, cli.size)?.run(&script)
}

fn open_window(cli: &Cli, began: Instant) -> Result<(), Fault> {
    let path = settings::usual_path().filter(|_| !cli.no_settings);
    let kept = path.as_deref().map(Kept::read).unwrap_or_default();
    let ground = ground(cli)?;
    let (title, owned) = (format!("terrain-viewer: {}", cli.dem), cli.clone());
    let closed = app::run(app::Start {
        choice: cli.adapter.choice(),
        size_px: cli.size,
        title,
        began,
        exit_after: cli.exit_after,
        make: Box::new(move |gpu, format| viewer(&owned, ground, &kept, true, gpu, format)),
    })?;
    if let (Some(viewer), Some(path)) = (closed, path)
        && let Err(error) = Kept::of(&viewer.state, viewer.panes.each_ref().map(|pane| &pane.wanted)).write(&path)
    {
        eprintln!("note: cannot keep the settings in {}: {error}", path.display());
    }
    Ok(())
}

fn ground(cli: &Cli) -> Result<Arc<Ground>, Fault> {
    let dem = terrain_lod::open_dem(&cli.dem, &cli.read.options())?;
    Ok(Arc::new(Ground::new(cli.dem.clone(), dem)))
}

/// `is_window`: methods work behind the frames and the measurement leaves the processor to others. Scripts wait instead, so
/// that they do the same every time.
fn viewer(
    cli: &Cli,
    ground: Arc<Ground>,
    kept: &Kept,
    is_window: bool,
    gpu: Gpu,
    format: wgpu::TextureFormat,
) -> Result<Viewer, Fault> {
    let side = |given: &Option<String>, kept: &Option<String>, usual: &str| -> Result<Run, Fault> {
        // What was kept may be of another version.
        let kept = || kept.as_deref().and_then(|line| run_text::parse(line).ok());
        let mut run = match given {
            Some(line) => run_text::parse(line).map_err(Fault::usage)?,
            None => kept().unwrap_or_else(|| run_text::parse(usual).expect("a method that there is")),
        };
        if !is_window && given.is_none() {
            (run.settings.schedule, run.settings.loading) = (ScheduleName::Blocking, LoadingName::Blocking);
        }
        Ok(run)
    };
    let runs = [side(&cli.left, &kept.left, "tin")?, side(&cli.right, &kept.right, "htp-instanced")?];
    let options = Options { folder: cli.out.clone(), rests: is_window };
    let can_wireframe = gpu.facts().wireframe;
    let mut viewer = Viewer::new(gpu, format, ground, runs, options)?;
    kept.put(&mut viewer.state, can_wireframe);
    if let Some(submission) = cli.submission {
        viewer.apply(Command::Submission(submission.into()))?;
    }
    if let Some(flight) = &cli.flight {
        let flight = Playback::new(&open_flight(flight)?, &viewer.ground().dem.heightmap)?;
        flight.place(&mut viewer.state.rig);
        viewer.state.flight = Some(flight);
    }
    if let Some(link) = &cli.camera {
        viewer.state.rig.take_link(link).map_err(Fault::usage)?;
    }
    Ok(viewer)
}
