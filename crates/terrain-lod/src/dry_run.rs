//! `bench --dry-run`: what would be flown, and how long it would take. Writes nothing.

use std::path::Path;
use std::time::{Duration, Instant};

use terrain_core::error::{ErrorDistribution, ErrorOracle};
use terrain_core::watertight::WatertightOracle;
use terrain_core::{FramePlan, MeshMirror};
use terrain_renderer::Renderer;

use crate::fault::{Cause, Fault};
use crate::interrupt;
use crate::methods::Run;
use crate::parts;
use crate::passes;
use crate::results::Results;
use crate::suite::{Bench, Suite};

/// Lists the runs with an estimate from one frame each, in the middle of the flight. What the folder has already is
/// left out of the estimate.
pub fn describe(bench: &Bench, renderer: &mut Option<Renderer>, results: &Results) -> Result<String, Fault> {
    let mut text = surroundings(bench, renderer.as_ref(), results.folder());
    let mut total = Duration::ZERO;
    for run in &bench.runs {
        let to_fly = ToFly::of(bench, results, run)?;
        let time = estimate(bench, run, renderer, &to_fly)?;
        let yardsticks: Vec<String> = bench.suite.tolerances_of(run).iter().map(f64::to_string).collect();
        let yardsticks = match run.takes_tolerance() {
            true => String::new(),
            false => format!("  yardsticks {} px", yardsticks.join(", ")),
        };
        text += &format!("  {}{yardsticks}  about {:.0} s{}\n", run.title(), time.as_secs_f64(), to_fly.found(bench));
        total += time;
    }
    text += &format!("{} runs, about {:.0} s in all\n", bench.runs.len(), total.as_secs_f64());
    Ok(text)
}

/// What of a run is still to be flown.
struct ToFly {
    errors: bool,
    /// Flights in the flight's own time; `None` for a run that has none.
    live: Option<u32>,
    /// Flights in the speed pass, its copy's included.
    speed: u32,
}

impl ToFly {
    fn of(bench: &Bench, results: &Results, run: &Run) -> Result<Self, Fault> {
        let repeats = bench.suite.repeats;
        let mut speed = 0;
        for copy in passes::copies(bench) {
            let flown = parts::speed(bench, results, run, *copy)?.len() as u32 / bench.path.len();
            speed += repeats.saturating_sub(flown);
        }
        let live = if parts::live(results, run)?.is_none() { repeats } else { 0 };
        Ok(Self { errors: parts::errors(results, run)?.is_none(), live: run.is_live().then_some(live), speed })
    }

    /// What `--resume` leaves out.
    fn found(&self, bench: &Bench) -> String {
        let speed = bench.suite.repeats * passes::copies(bench).len() as u32;
        if self.errors && self.speed == speed {
            return String::new();
        }
        let said = |to_fly: bool| if to_fly { "to fly" } else { "done" };
        let live = self.live.map_or_else(String::new, |flights| format!("live {}, ", said(flights > 0)));
        let errors = said(self.errors);
        format!("  (errors {errors}, {live}speed {} of {speed} flights done)", speed - self.speed)
    }
}

fn surroundings(bench: &Bench, renderer: Option<&Renderer>, folder: &Path) -> String {
    let [width_km, depth_km] = bench.dem.heightmap.extent_m().map(|metres| metres / 1e3);
    let (columns, rows) = (bench.dem.heightmap.columns(), bench.dem.heightmap.rows());
    let [width_px, height_px] = bench.suite.size_px;
    let adapter = renderer.map_or("none; frame times and pictures are left out".into(), |renderer| {
        let facts = renderer.gpu().facts();
        format!("{} ({}, {})", facts.name, facts.adapter_type, facts.backend)
    });
    format!(
        "DEM {}: {columns} x {rows} samples, {width_km:.1} x {depth_km:.1} km\n\
         Flight {}: {} frames of {width_px} x {height_px} px\n\
         Repeats: {}\n\
         Adapter: {adapter}\n\
         Results: {}\n",
        bench.dem.name,
        bench.flight_name,
        bench.path.len(),
        repeats(bench),
        folder.display()
    )
}

fn repeats(bench: &Bench) -> String {
    let Suite { repeats, until_ci, aa, .. } = bench.suite;
    let until = |share: f64| {
        let most = bench.suite.most_repeats();
        format!(", and on to {most} until the medians' intervals are narrower than {} %", 100.0 * share)
    };
    let until = until_ci.map_or_else(String::new, until);
    let warm_up = bench.warm_up;
    let twice = if aa { ", each run as A and as B" } else { "" };
    format!("{repeats}{until}, the first {warm_up} frames of each not timed{twice}")
}

/// One frame of each pass, times the number of frames. The first plan does far more than the others, so it is the
/// second one, a frame further on, that is timed.
fn estimate(bench: &Bench, run: &Run, renderer: &mut Option<Renderer>, to_fly: &ToFly) -> Result<Duration, Fault> {
    let mut method = run.converged().build(&bench.dem.heightmap, &bench.prepared)?;
    let mut mirror = MeshMirror::new(&method.buffers(), &bench.dem.heightmap);
    let mut buffers = renderer.as_ref().map(|r| r.buffers(method.buffers())).transpose()?;
    let mut plan = FramePlan::default();
    let (mut error_time, mut speed_time) = (Duration::ZERO, Duration::ZERO);
    let middle = bench.path.len() / 2;
    for frame in [middle.saturating_sub(1), middle] {
        interrupt::check()?;
        let view = bench.view(frame)?;
        let start = Instant::now();
        method.plan(&view, &mut plan);
        if let (Some(renderer), Some(buffers)) = (renderer.as_mut(), buffers.as_mut()) {
            renderer.frame(&view, &plan, buffers, &bench.look)?;
        }
        speed_time = start.elapsed();
        let start = Instant::now();
        mirror.replay(&plan).map_err(|e| Fault::new(Cause::Failure, e))?;
        let (columns, rows) = (bench.dem.heightmap.columns(), bench.dem.heightmap.rows());
        WatertightOracle::new(columns, rows).check(mirror.triangles(), mirror.degenerate());
        let mut oracle = ErrorOracle::new(&bench.dem.heightmap);
        oracle.set_mesh(mirror.triangles());
        oracle.measure(&view, &mut ErrorDistribution::new(&[]));
        error_time = start.elapsed();
    }
    // A live flight takes its own time, and is judged afterwards as in the error pass.
    let live_time = Duration::from_secs_f64(bench.path.step_s()) + error_time;
    let errors = u32::from(to_fly.errors);
    Ok((error_time * errors + live_time * to_fly.live.unwrap_or(0) + speed_time * to_fly.speed) * bench.path.len())
}
