//! `bench`: the passes, the pictures, the table.

use std::path::PathBuf;

use serde::Serialize;
use terrain_dem::Dem;
use terrain_renderer::{Gpu, RenderError, Renderer, RendererSettings};

use crate::attempt::attempt;
use crate::cli::BenchArgs;
use crate::dry_run;
use crate::error_pass::{self, ErrorFlight};
use crate::fault::{Cause, Fault};
use crate::interrupt;
use crate::live_pass::{self, LiveFlights};
use crate::machine::Machine;
use crate::methods::Run;
use crate::output::print;
use crate::progress::Progress;
use crate::results::{Results, utc_now};
use crate::shots;
use crate::speed_pass::{self, SpeedFlights};
use crate::suite::Bench;
use crate::summary::{self, Measured, SummaryRow, Surroundings};
use crate::table;

pub fn run(args: &BenchArgs) -> Result<(), Fault> {
    let mut bench = Bench::from_args(args)?;
    let utc = utc_now();
    let folder = args.out.clone().unwrap_or_else(|| default_folder(&utc, &bench.suite_name));
    Results::check(&folder)?;
    let gpu = open_gpu(args)?;
    bench.prepare_maps(args.method.keep_maps, !args.dry_run)?;
    // From here on there is something to leave in order. What is above ends at once.
    interrupt::listen();
    let mut renderer = gpu.as_ref().map(|gpu| renderer(gpu, &bench, false)).transpose()?;
    if args.dry_run {
        return print(&dry_run::describe(&bench, &mut renderer, &folder)?);
    }
    let results = Results::create(&folder)?;
    let machine = Machine::of(&bench, renderer.as_ref(), utc);
    results.write_json("machine.json", &machine)?;
    let mut flown = fly(&bench, &mut renderer, &results, &surroundings(&machine))?;
    write_summary(&bench, &results, &flown)?;
    if let Some(gpu) = &gpu {
        take_shots(&bench, gpu, &results, &mut flown)?;
    }
    let text = write_summary(&bench, &results, &flown)?;
    let folder = results.complete()?;
    print(&format!("{text}\nResults: {}\n", folder.display()))?;
    answer(&flown)
}

/// What became of one run.
struct Flown {
    rows: Vec<SummaryRow>,
    /// Why it failed, if it did.
    fault: Option<Fault>,
}

impl Flown {
    /// The first failure counts, and stands in every row of the run.
    fn fail(&mut self, stage: &str, fault: Fault) {
        if self.fault.is_none() {
            self.rows.iter_mut().for_each(|row| row.err = format!("{stage}: {fault}"));
            self.fault = Some(fault);
        }
    }
}

/// A dry run goes on without an adapter, and says so.
fn open_gpu(args: &BenchArgs) -> Result<Option<Gpu>, Fault> {
    if args.no_gpu {
        return Ok(None);
    }
    match Gpu::headless(&args.adapter.choice()) {
        Err(RenderError::NoAdapter { .. }) if args.dry_run && args.adapter.is_open() => Ok(None),
        Ok(gpu) if gpu.facts().backend == "noop" => {
            Err(Fault::usage("the backend noop draws nothing, so there is nothing to measure; leave it to tests"))
        }
        gpu => Ok(Some(gpu?)),
    }
}

fn default_folder(utc: &str, suite: &str) -> PathBuf {
    PathBuf::from("bench-results").join(format!("{utc}-{suite}"))
}

fn renderer(gpu: &Gpu, bench: &Bench, count_primitives: bool) -> Result<Renderer, Fault> {
    let settings = RendererSettings { size_px: bench.suite.size_px, submission: bench.submission, count_primitives };
    Ok(Renderer::new(gpu.clone(), &bench.dem.heightmap, &settings)?)
}

/// Who made the DEM, and what they want to be said with it.
fn credits(dem: &Dem) -> String {
    let credit = |(what, text): (&str, &Option<String>)| Some(format!("{what}: {}. ", text.as_ref()?));
    let said: String = [("Source", &dem.source), ("Licence", &dem.licence), ("Notice", &dem.notice)]
        .into_iter()
        .filter_map(credit)
        .collect();
    if said.is_empty() { said } else { format!("\n{}\n", said.trim_end()) }
}

fn surroundings(machine: &Machine) -> Surroundings {
    Surroundings {
        adapter: machine.adapter.clone().unwrap_or_default(),
        adapter_type: machine.adapter_type.clone().unwrap_or_else(|| "none".into()),
        submission: machine.submission.clone().unwrap_or_default(),
        load_average: machine.load_average,
    }
}

/// All passes, one after the other: while one measures time, nothing else runs.
fn fly(
    bench: &Bench,
    renderer: &mut Option<Renderer>,
    results: &Results,
    surroundings: &Surroundings,
) -> Result<Vec<Flown>, Fault> {
    let errors = fly_errors(bench, results)?;
    let live = fly_live(bench, results)?;
    let speed = fly_speed(bench, renderer, results)?;
    let runs = bench.runs.iter().zip(errors).zip(live).zip(speed);
    Ok(runs.map(|(((run, errors), live), speed)| sum_up(bench, run, surroundings, errors, live, speed)).collect())
}

fn fly_errors(bench: &Bench, results: &Results) -> Result<Vec<Result<ErrorFlight, Fault>>, Fault> {
    let steps = bench.runs.len() as u64 * bench.path.len() as u64;
    let errors = error_pass::fly_all(bench, &Progress::new("errors", steps))?;
    for (run, errors) in bench.runs.iter().zip(&errors) {
        if let Ok(flight) = errors {
            write_frames(results, run, "error", &flight.frames)?;
        }
    }
    Ok(errors)
}

fn fly_live(bench: &Bench, results: &Results) -> Result<Vec<LiveFlights>, Fault> {
    let flights = bench.runs.iter().filter(|run| run.is_live()).count() as u64 * bench.suite.repeats as u64;
    let progress = Progress::new("live", flights * bench.path.len() as u64);
    live_pass::fly_all(bench, &progress, |run, frames| write_frames(results, run, "live", frames))
}

fn fly_speed(bench: &Bench, renderer: &mut Option<Renderer>, results: &Results) -> Result<Vec<SpeedFlights>, Fault> {
    let flights = bench.runs.len() as u64 * bench.suite.repeats as u64;
    let progress = Progress::new("speed", flights * bench.path.len() as u64);
    speed_pass::fly_all(bench, renderer, &progress, |run, frames| write_frames(results, run, "speed", frames))
}

/// The frames of a run so far, as soon as there is something to write.
fn write_frames<T: Serialize>(results: &Results, run: &Run, pass: &str, frames: &[T]) -> Result<(), Fault> {
    results.write_csv(&format!("frames/{}-{pass}.csv", run.file_stem()), frames)
}

fn sum_up(
    bench: &Bench,
    run: &Run,
    surroundings: &Surroundings,
    errors: Result<ErrorFlight, Fault>,
    live: LiveFlights,
    speed: SpeedFlights,
) -> Flown {
    let measured = Measured {
        errors: errors.as_ref().ok(),
        live: live.as_ref().ok().and_then(Option::as_ref),
        speed: speed.as_deref().ok(),
    };
    let rows = summary::rows(bench, run, surroundings, &measured);
    let mut flown = Flown { rows, fault: None };
    errors.err().into_iter().for_each(|fault| flown.fail("error pass", fault));
    live.err().into_iter().for_each(|fault| flown.fail("live pass", fault));
    speed.err().into_iter().for_each(|fault| flown.fail("speed pass", fault));
    flown
}

/// Writes `summary.csv` and `summary.md`, and returns the latter.
fn write_summary(bench: &Bench, results: &Results, flown: &[Flown]) -> Result<String, Fault> {
    let rows: Vec<&SummaryRow> = flown.iter().flat_map(|flown| &flown.rows).collect();
    results.write_csv("summary.csv", &rows)?;
    let tables: String = bench.suite.tables.iter().map(|table| format!("\n{}", table.markdown(&rows))).collect();
    let text = table::markdown(&rows) + &tables + &credits(&bench.dem);
    results.write_text("summary.md", &text)?;
    Ok(text)
}

/// Pictures of the runs that have come so far.
fn take_shots(bench: &Bench, gpu: &Gpu, results: &Results, flown: &mut [Flown]) -> Result<(), Fault> {
    let mut renderer = renderer(gpu, bench, true)?;
    let (folder, progress) = (results.path("shots"), Progress::new("pictures", 3 * bench.runs.len() as u64));
    for (run, flown) in bench.runs.iter().zip(flown).filter(|(_, flown)| flown.fault.is_none()) {
        if let Err(fault) = attempt(|| shots::take(bench, run, &mut renderer, &folder, &progress))? {
            flown.fail("pictures", fault);
        }
    }
    Ok(())
}

/// A run that failed or cracked is no success. The exit code is the first failure's.
fn answer(flown: &[Flown]) -> Result<(), Fault> {
    let is_cracked = |row: &SummaryRow| row.cracks > Some(0) || row.live_cracks > Some(0);
    let cracked = flown.iter().filter(|flown| flown.rows.iter().any(is_cracked)).count();
    let faults: Vec<&Fault> = flown.iter().filter_map(|flown| flown.fault.as_ref()).collect();
    if faults.is_empty() && cracked == 0 {
        return Ok(());
    }
    let cause = faults.first().map_or(Cause::Failure, |fault| fault.cause);
    let message = format!("{} of {} runs failed, {cracked} have cracks; see the table", faults.len(), flown.len());
    Err(Fault::new(cause, message))
}
