//! A suite of several benches: one after the other, each into its own folder, and what all of them say at the top.
//!
//! `OUT/NAME` is a result folder as any other. `OUT` has `suite.json` (what was begun), `summary.csv` (all rows, the bench
//! in the first column), `tables.md`, and the marker until the last bench is done. `--resume OUT` goes on with the first
//! bench that is not complete.

use std::path::Path;

use serde::Serialize;

use crate::begun::Begun;
use crate::bench::{Landed, Sitting, free_folder, open_gpu};
use crate::cli::BenchArgs;
use crate::fault::{Cause, Fault};
use crate::figures;
use crate::flight_curves::FlightCurves;
use crate::output::print;
use crate::record::{Record, record};
use crate::results::{Results, utc_now};
use crate::suite::{Bench, SuiteFile};
use crate::summary::SummaryRow;
use crate::{table, tables};

/// In the folder of a suite of several benches, what `machine.json` is in a bench's.
pub const SUITE_FILE: &str = "suite.json";

/// What was begun.
#[derive(Serialize)]
struct SuiteFacts<'a> {
    program: &'static str,
    version: &'static str,
    utc: &'a str,
    command: Vec<String>,
    suite: &'a str,
    benches: Vec<&'a str>,
    notes: &'a [String],
    flight_curves: &'a [FlightCurves],
}

/// The first column of the rows of all benches.
#[derive(Serialize)]
struct BenchColumn<'a> {
    bench: &'a str,
}

/// The rows of one bench.
type BenchRows<'a> = (&'a str, Vec<SummaryRow>);

pub fn run(args: &BenchArgs, file: &SuiteFile, begun: Option<Begun>) -> Result<(), Fault> {
    let utc = utc_now();
    let folder = match &begun {
        Some(begun) if !begun.is_suite() => {
            let place = begun.folder().display();
            return Err(Fault::usage(format!("{place}: begun as one bench; --resume it with its own suite")));
        }
        Some(begun) => begun.folder().to_path_buf(),
        None => free_folder(args, &utc, &file.name)?,
    };
    // All are opened before the first is flown: what is wrong with the last one is said now.
    let benches = file.benches.iter().map(|named| Bench::of(&file.name, named, args));
    let benches = benches.collect::<Result<Vec<Bench>, Fault>>()?;
    let sitting = Sitting { args, gpu: open_gpu(args)?, utc };
    if args.dry_run {
        return describe(&sitting, file, benches, &folder);
    }
    let results = match begun {
        Some(_) => Results::at(&folder),
        None => begin(&folder, file, &sitting.utc)?,
    };
    let mut flown: Vec<BenchRows> = Vec::new();
    let mut answer = Ok(());
    for (name, bench) in names(file).zip(benches) {
        let landed = land(&sitting, bench, &results.path(name))?;
        print(&format!("## {name}\n\n{}\n", landed.text))?;
        answer = answer.and(landed.answer);
        flown.push((name, landed.rows));
        write_tables(&results, file, &flown)?;
    }
    answer = answer.and(figures::make(file, &sitting, &results)?);
    let text = write_tables(&results, file, &flown)?;
    print(&format!("## {}\n\n{text}\nResults: {}\n", file.name, results.complete()?.display()))?;
    answer
}

fn names(file: &SuiteFile) -> impl Iterator<Item = &str> {
    file.benches.iter().map(|named| named.name.as_deref().unwrap_or_default())
}

fn begin(folder: &Path, file: &SuiteFile, utc: &str) -> Result<Results, Fault> {
    let results = Results::create_plain(folder)?;
    let facts = SuiteFacts {
        program: env!("CARGO_PKG_NAME"),
        version: env!("CARGO_PKG_VERSION"),
        utc,
        command: std::env::args().skip(1).collect(),
        suite: &file.name,
        benches: names(file).collect(),
        notes: &file.notes,
        flight_curves: &file.flight_curves,
    };
    results.write_json(SUITE_FILE, &facts)?;
    Ok(results)
}

fn describe(sitting: &Sitting, file: &SuiteFile, benches: Vec<Bench>, folder: &Path) -> Result<(), Fault> {
    for (name, bench) in names(file).zip(benches) {
        let folder = folder.join(name);
        match Step::of(&folder)? {
            Step::Complete(_) => print(&format!("## {name}: complete\n\n"))?,
            Step::Begin => print(&format!("## {name}\n\n{}\n", sitting.describe(bench, &folder, None)?))?,
            Step::GoOn(begun) => {
                print(&format!("## {name}\n\n{}\n", sitting.describe(bench, &folder, Some(begun))?))?;
            }
        }
    }
    print(&figures::describe(file, sitting))?;
    file.notes.iter().try_for_each(|note| print(&format!("{note}\n")))
}

/// What is to be done about one bench of the suite.
enum Step {
    Begin,
    GoOn(Begun),
    Complete(Landed),
}

impl Step {
    fn of(folder: &Path) -> Result<Self, Fault> {
        let results = Results::at(folder);
        if !results.path("machine.json").exists() {
            return Ok(Self::Begin);
        }
        if results.is_incomplete() {
            return Ok(Self::GoOn(Begun::open(folder)?));
        }
        let rows: Vec<SummaryRow> = results.read_csv("summary.csv")?.unwrap_or_default();
        let is_sound = |row: &SummaryRow| row.err.is_empty() && !(row.cracks > Some(0) || row.live_cracks > Some(0));
        let answer = match rows.iter().all(is_sound) {
            true => Ok(()),
            false => Err(Fault::new(Cause::Failure, format_args!("{}: runs failed; see its table", folder.display()))),
        };
        Ok(Self::Complete(Landed { text: "Complete before.\n".into(), rows, answer }))
    }
}

fn land(sitting: &Sitting, bench: Bench, folder: &Path) -> Result<Landed, Fault> {
    match Step::of(folder)? {
        Step::Begin => sitting.fly(bench, folder, None, &|_| Ok(Ok(()))),
        Step::GoOn(begun) => sitting.fly(bench, folder, Some(begun), &|_| Ok(Ok(()))),
        Step::Complete(landed) => Ok(landed),
    }
}

/// Writes `summary.csv` and `tables.md`, and returns the latter.
fn write_tables(results: &Results, file: &SuiteFile, flown: &[BenchRows]) -> Result<String, Fault> {
    let rows = || flown.iter().flat_map(|(bench, rows)| rows.iter().map(move |row| (*bench, row)));
    let lines: Vec<_> = rows().map(|(bench, row)| (BenchColumn { bench }, row)).collect();
    results.write_csv("summary.csv", &lines)?;
    let records: Vec<Record> = rows().map(|(bench, row)| record(bench, row)).collect();
    let captions =
        flown.iter().filter_map(|(name, rows)| Some(format!("- {name}: {}\n", table::caption(rows.first()?))));
    let notes = file.notes.iter().map(|note| format!("- {note}\n"));
    let text =
        captions.chain(notes).collect::<String>() + &tables::write(results, &file.tables, &file.equal_error, &records)?;
    results.write_text("tables.md", &text)?;
    Ok(text)
}
