//! `bench`: both passes, the pictures, the table.

use std::path::PathBuf;

use terrain_dem::Dem;
use terrain_renderer::{Gpu, Renderer, RendererSettings};

use crate::cli::BenchArgs;
use crate::dry_run;
use crate::error_pass;
use crate::fault::{Cause, Fault};
use crate::interrupt;
use crate::machine::Machine;
use crate::output::print;
use crate::progress::Progress;
use crate::results::{Results, utc_now};
use crate::shots;
use crate::speed_pass;
use crate::suite::Bench;
use crate::summary::{self, SummaryRow, Surroundings};
use crate::table;

pub fn run(args: &BenchArgs) -> Result<(), Fault> {
    interrupt::listen();
    let bench = Bench::from_args(args)?;
    let utc = utc_now();
    let folder = args.out.clone().unwrap_or_else(|| default_folder(&utc, &bench.suite_name));
    Results::check(&folder)?;
    let gpu = open_gpu(args)?;
    let mut renderer = gpu.as_ref().map(|gpu| renderer(gpu, &bench, false)).transpose()?;
    if args.dry_run {
        return print(&dry_run::describe(&bench, &mut renderer, &folder)?);
    }
    let results = Results::create(&folder)?;
    let machine = Machine::of(&bench, renderer.as_ref(), utc);
    results.write_json("machine.json", &machine)?;
    let surroundings = surroundings(&machine);

    let mut rows = fly(&bench, &mut renderer, &results, &surroundings)?;
    if let Some(gpu) = &gpu {
        take_shots(&bench, gpu, &results, &mut rows)?;
    }
    results.write_csv("summary.csv", &rows)?;
    let text = table::markdown(&rows) + &credits(&bench.dem);
    results.write_text("summary.md", &text)?;
    let folder = results.complete()?;
    print(&format!("{text}\nResults: {}\n", folder.display()))?;
    answer(&rows)
}

/// A dry run goes on without an adapter, and says so.
fn open_gpu(args: &BenchArgs) -> Result<Option<Gpu>, Fault> {
    if args.no_gpu {
        return Ok(None);
    }
    match Gpu::headless(&args.adapter.choice()) {
        Err(_) if args.dry_run => Ok(None),
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

/// Both passes, a CSV for each run and pass, and the rows of the summary.
fn fly(
    bench: &Bench,
    renderer: &mut Option<Renderer>,
    results: &Results,
    surroundings: &Surroundings,
) -> Result<Vec<SummaryRow>, Fault> {
    let steps = bench.runs.len() as u64 * bench.path.len() as u64;
    let errors = error_pass::fly_all(bench, &Progress::new("errors", steps))?;
    let speed = speed_pass::fly_all(bench, renderer, &Progress::new("speed", steps * bench.suite.repeats as u64))?;
    let mut rows = Vec::new();
    for ((run, errors), speed) in bench.runs.iter().zip(&errors).zip(&speed) {
        let stem = run.file_stem();
        if let Ok(flight) = errors {
            results.write_csv(&format!("frames/{stem}-error.csv"), &flight.frames)?;
        }
        if let Ok(frames) = speed {
            results.write_csv(&format!("frames/{stem}-speed.csv"), frames)?;
        }
        rows.extend(summary::rows(bench, run, surroundings, errors, speed));
    }
    Ok(rows)
}

/// A failure here belongs into the rows of its run, beside what the passes have measured.
fn take_shots(bench: &Bench, gpu: &Gpu, results: &Results, rows: &mut [SummaryRow]) -> Result<(), Fault> {
    let mut renderer = renderer(gpu, bench, true)?;
    let progress = Progress::new("pictures", 3 * bench.runs.len() as u64);
    for run in &bench.runs {
        match shots::take(bench, run, &mut renderer, &results.path("shots"), &progress) {
            Err(fault) if matches!(fault.cause, Cause::Interrupted | Cause::Io) => return Err(fault),
            Err(fault) => {
                let is_of_run =
                    |row: &&mut SummaryRow| row.method == run.method.as_str() && row.setting == run.setting();
                for row in rows.iter_mut().filter(is_of_run).filter(|row| row.err.is_empty()) {
                    row.err = format!("pictures: {fault}");
                }
            }
            Ok(()) => {}
        }
    }
    Ok(())
}

/// A run that failed or cracked is no success.
fn answer(rows: &[SummaryRow]) -> Result<(), Fault> {
    let failed = rows.iter().filter(|row| !row.err.is_empty()).count();
    let cracked = rows.iter().filter(|row| row.cracks.is_some_and(|cracks| cracks > 0)).count();
    if failed + cracked == 0 {
        return Ok(());
    }
    let message = format!("{failed} of {} rows failed, {cracked} have cracks; see the table", rows.len());
    Err(Fault::new(Cause::Failure, message))
}
