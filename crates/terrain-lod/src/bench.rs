//! `bench`: the passes, the pictures, the table.

use std::path::{Path, PathBuf};

use serde_json::Value;
use terrain_core::{Heightmap, Sample};
use terrain_dem::Dem;
use terrain_renderer::{Gpu, RenderError, Renderer, RendererSettings, Scene};

use crate::begun::Begun;
use crate::benches;
use crate::cli::BenchArgs;
use crate::dry_run;
use crate::fault::{Cause, Fault};
use crate::figures::{self, Made};
use crate::frame_times::RepeatTimes;
use crate::interrupt;
use crate::interval::Verdict;
use crate::machine::Machine;
use crate::output::print;
use crate::passes::{self, Flown};
use crate::record::{Record, record};
use crate::repeats;
use crate::results::{Results, utc_now};
use crate::suite::{Bench, SuiteFile};
use crate::summary::{SummaryRow, Surroundings};
use crate::summary_file::{SCHEMA, SummaryFile, SummaryFileRow};
use crate::table;
use crate::tables;

pub fn run(args: &BenchArgs) -> Result<(), Fault> {
    let begun = args.resume.as_deref().map(Begun::open).transpose()?;
    let said = begun.as_ref().map(|begun| begun.arguments(args)).transpose()?;
    let args = said.as_ref().unwrap_or(args);
    let file = SuiteFile::from_args(args)?;
    let single = match begun.as_ref().and_then(Begun::bench) {
        // One bench of several goes on alone.
        Some(name) => file.benches.iter().find(|bench| bench.name.as_deref() == Some(name)),
        None => file.single(),
    };
    let Some(named) = single else { return benches::run(args, &file, begun) };
    let bench = Bench::of(&file.name, named, args)?;
    let utc = utc_now();
    let folder = match &begun {
        Some(begun) => begun.folder().to_path_buf(),
        None => free_folder(args, &utc, &bench.suite_name)?,
    };
    let sitting = Sitting { args, gpu: open_gpu(args)?, utc };
    if args.dry_run {
        let figures = file.single().map_or_else(String::new, |_| figures::describe(&file, &sitting));
        return print(&(sitting.describe(bench, &folder, begun)? + &figures));
    }
    // One bench of several goes on without the suite's figures.
    let figures = |results: &Results| match file.single() {
        Some(_) => figures::make(&file, &sitting, results),
        None => Ok(Ok(())),
    };
    let landed = sitting.fly(bench, &folder, begun, &figures)?;
    print(&format!("{}\nResults: {}\n", landed.text, folder.display()))?;
    landed.answer
}

/// What all benches of one call share.
pub struct Sitting<'a> {
    pub args: &'a BenchArgs,
    pub gpu: Option<Gpu>,
    pub utc: String,
}

/// A bench that has come to its end.
pub struct Landed {
    /// `summary.md`.
    pub text: String,
    pub rows: Vec<SummaryRow>,
    /// Whether all was well.
    pub answer: Result<(), Fault>,
}

impl Sitting<'_> {
    /// All passes of one bench, into its folder; `last` is what else belongs there.
    pub fn fly(
        &self,
        mut bench: Bench,
        folder: &Path,
        begun: Option<Begun>,
        last: &dyn Fn(&Results) -> Made,
    ) -> Result<Landed, Fault> {
        let mut renderer = self.prepare(&mut bench, begun.as_ref())?;
        // From here on there is something to leave in order. What is above ends at once.
        interrupt::listen();
        let machine = Machine::of(&bench, renderer.as_ref(), self.utc.clone());
        let results = begun.map_or_else(|| begin(folder, &machine), |begun| begun.go_on(&machine))?;
        let mut flown = passes::fly(&bench, &mut renderer, &results, &surroundings(&machine))?;
        write_summary(&bench, &results, &flown)?;
        if let Some(gpu) = &self.gpu {
            passes::take_shots(&bench, gpu, &results, &mut flown)?;
        }
        let text = write_summary(&bench, &results, &flown)?;
        let last = last(&results)?;
        results.complete()?;
        let rows = flown.iter().flat_map(|flown| flown.rows.clone()).collect();
        Ok(Landed { text, rows, answer: answer(&flown).and(last) })
    }

    /// What would be flown.
    pub fn describe(&self, mut bench: Bench, folder: &Path, begun: Option<Begun>) -> Result<String, Fault> {
        let mut renderer = self.prepare(&mut bench, begun.as_ref())?;
        interrupt::listen();
        dry_run::describe(&bench, &mut renderer, &Results::at(folder))
    }

    fn prepare(&self, bench: &mut Bench, begun: Option<&Begun>) -> Result<Option<Renderer>, Fault> {
        let renderer = self.gpu.as_ref().map(|gpu| renderer(gpu, bench)).transpose()?;
        if let Some(begun) = begun {
            begun.refuse_another(&Machine::of(bench, renderer.as_ref(), self.utc.clone()))?;
        }
        bench.prepare(self.args.method.keep_maps, !self.args.dry_run)?;
        Ok(renderer)
    }
}

/// A new result folder, which says what is about to be flown. One that a kill has left without that is as good as new.
fn begin(folder: &Path, machine: &Machine) -> Result<Results, Fault> {
    let is_left = Results::at(folder).is_incomplete();
    let results = if is_left { Results::reopen(folder)? } else { Results::create(folder)? };
    results.write_json("machine.json", machine)?;
    Ok(results)
}

/// A dry run goes on without an adapter, and says so.
pub fn open_gpu(args: &BenchArgs) -> Result<Option<Gpu>, Fault> {
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

pub fn free_folder(args: &BenchArgs, utc: &str, suite: &str) -> Result<PathBuf, Fault> {
    let default = || PathBuf::from("bench-results").join(format!("{utc}-{suite}"));
    let folder = args.out.clone().unwrap_or_else(default);
    Results::check(&folder)?;
    Ok(folder)
}

fn renderer(gpu: &Gpu, bench: &Bench) -> Result<Renderer, Fault> {
    let (size_px, submission) = (bench.suite.size_px, bench.submission);
    let settings = RendererSettings { size_px, submission, count_primitives: false };
    Ok(Renderer::over(gpu.clone(), scene(gpu, &bench.dem.heightmap)?, &settings)?)
}

/// The DEM on the GPU. What is too large for a texture is drawn without: by methods that bring their heights along, and with
/// the normals of the triangles.
pub fn scene(gpu: &Gpu, heightmap: &Heightmap) -> Result<Scene, Fault> {
    match Scene::new(gpu, heightmap) {
        Err(RenderError::TextureTooLarge { .. }) => {
            let size = [heightmap.columns(), heightmap.rows()];
            let last = Sample { column: size[0] - 1, row: size[1] - 1 };
            let range_m = heightmap.height_range_m(Sample { column: 0, row: 0 }, last);
            let bare = Scene::without_heights(gpu, size, heightmap.spacing_m(), range_m)?;
            Ok(match heightmap.voids() {
                Some(voids) => bare.with_voids(gpu, voids)?,
                None => bare,
            })
        }
        scene => Ok(scene?),
    }
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

/// Writes `summary.csv`, `summary.json`, `popping.csv`, `pictures.csv` and `summary.md`, and returns the last.
fn write_summary(bench: &Bench, results: &Results, flown: &[Flown]) -> Result<String, Fault> {
    let runs: Vec<(&SummaryRow, &RepeatTimes)> =
        flown.iter().flat_map(|flown| flown.rows.iter().map(|row| (row, &flown.times))).collect();
    let rows: Vec<&SummaryRow> = runs.iter().map(|(row, _)| *row).collect();
    results.write_csv("summary.csv", &rows)?;
    results.write_csv("popping.csv", &flown.iter().flat_map(|flown| &flown.popping).collect::<Vec<_>>())?;
    let pictures: Vec<_> = flown.iter().flat_map(|flown| &flown.pictures).collect();
    if !pictures.is_empty() {
        results.write_csv("pictures.csv", &pictures)?;
    }
    // What stands in the folder knows of earlier sittings.
    let machine: Value = results.read_json("machine.json")?.unwrap_or_default();
    let aa: Vec<_> = flown.iter().filter_map(|flown| flown.aa.clone()).collect();
    let records: Vec<Record> = rows.iter().map(|row| record("", row)).collect();
    let tables = tables::write(results, &bench.suite.tables, &bench.suite.equal_error, &records)?;
    let text = table::markdown(&rows)
        + &tables
        + &repeats::describe_width(&bench.suite, &runs)
        + &repeats::describe_aa(&aa)
        + &credits(&bench.dem);
    let rows = runs.iter().map(|(row, repeat_times)| SummaryFileRow { row, repeat_times }).collect();
    results.write_json("summary.json", &SummaryFile { schema: SCHEMA, machine, rows, aa })?;
    results.write_text("summary.md", &text)?;
    Ok(text)
}

/// A run that failed or cracked is no success, nor one whose copy is not the same. The exit code is the first failure's.
fn answer(flown: &[Flown]) -> Result<(), Fault> {
    let is_cracked = |row: &SummaryRow| row.cracks > Some(0) || row.live_cracks > Some(0);
    let cracked = flown.iter().filter(|flown| flown.rows.iter().any(is_cracked)).count();
    let faults: Vec<&Fault> = flown.iter().filter_map(|flown| flown.fault.as_ref()).collect();
    let unlike = flown.iter().filter_map(|flown| flown.aa.as_ref()).filter(|aa| aa.verdict != Verdict::Same).count();
    if faults.is_empty() && cracked == 0 && unlike == 0 {
        return Ok(());
    }
    let cause = faults.first().map_or(Cause::Failure, |fault| fault.cause);
    let mut message = format!("{} of {} runs failed, {cracked} have cracks", faults.len(), flown.len());
    if unlike > 0 {
        message += &format!(", {unlike} differ from their copy: this machine's times are not to be trusted");
    }
    Err(Fault::new(cause, message + "; see the table"))
}
