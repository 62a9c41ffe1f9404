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
use crate::suite::Bench;

/// Lists the runs with an estimate from one frame each, in the middle of the flight.
pub fn describe(bench: &Bench, renderer: &mut Option<Renderer>, folder: &Path) -> Result<String, Fault> {
    let mut text = surroundings(bench, renderer.as_ref(), folder);
    let mut total = Duration::ZERO;
    for run in &bench.runs {
        let time = estimate(bench, run, renderer)?;
        let tolerances: Vec<String> = bench.suite.tolerances_of(run).iter().map(f64::to_string).collect();
        let (method, setting, tolerances) = (run.method.as_str(), run.setting(), tolerances.join(", "));
        text += &format!("  {method}  {setting}  tolerance {tolerances} px  about {:.0} s\n", time.as_secs_f64());
        total += time;
    }
    text += &format!("{} runs, about {:.0} s in all\n", bench.runs.len(), total.as_secs_f64());
    Ok(text)
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
         Adapter: {adapter}\n\
         Results: {}\n",
        bench.dem.name,
        bench.flight_name,
        bench.path.len(),
        folder.display()
    )
}

/// One frame of each pass, times the number of frames. The first plan does far more than the others, so it is the
/// second one, a frame further on, that is timed.
fn estimate(bench: &Bench, run: &Run, renderer: &mut Option<Renderer>) -> Result<Duration, Fault> {
    let mut method = run.converged().build(&bench.dem.heightmap, &bench.maps)?;
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
    let live_time =
        if run.is_live() { Duration::from_secs_f64(bench.path.step_s()) + error_time } else { Duration::ZERO };
    Ok(((speed_time + live_time) * bench.suite.repeats + error_time) * bench.path.len())
}
