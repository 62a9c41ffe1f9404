//! `report`: one HTML file from a result folder, of one bench or of a suite of several, which opens without a network and
//! reads without a script.
//!
//! The folder is read by column names (`folder.rs`, `sheet.rs`), so reports of older folders still work. The same folder
//! gives the same bytes: no clock, no random names, everything in the order of the summary. HTML and SVG are written by
//! hand: a template engine would have a dozen sections to fill and bring a compiler, and a plotting library knows neither
//! style sheets for dark and light nor the classes by which the script finds a run.

mod album;
mod axis;
mod bench_page;
mod chart;
mod curves;
mod distributions;
mod facts;
mod families;
mod figures;
mod flights;
mod folder;
mod headline;
mod html;
mod look;
mod markdown;
mod marks;
mod measures;
mod page;
mod pictures;
mod runs;
mod sheet;
mod tables;
mod warnings;
mod whole;

pub use facts::command;

use std::path::Path;

use terrain_dem::write_atomically;

use crate::cli::ReportArgs;
use crate::fault::Fault;
use crate::output::print;
use crate::report::bench_page::BenchPage;
use crate::report::chart::Chart;
use crate::report::families::Families;
use crate::report::flights::Flights;
use crate::report::runs::Run;
use crate::report::whole::Whole;

/// A folder with all that is drawn of it.
struct Report {
    whole: Whole,
    /// The only bench, or those of the suite.
    parts: Vec<BenchPage>,
    /// Of a suite that sweeps settings.
    families: Option<Families>,
    flights: Vec<Flights>,
}

impl Report {
    fn read(folder: &Path) -> Result<Self, Fault> {
        let (whole, benches) = Whole::read(folder)?;
        let (mut parts, mut runs) = (Vec::new(), 0);
        for bench in benches {
            let part = BenchPage::of(bench, runs)?;
            runs += part.runs.len();
            parts.push(part);
        }
        let summary =
            whole.suite.as_ref().map(|suite| &suite.summary).or(parts.first().map(|part| &part.folder.summary));
        let families = match whole.equal_error.as_ref().zip(summary) {
            Some((equal_error, summary)) => Some(families::of(summary, equal_error, runs)?),
            None => None,
        };
        runs += families.as_ref().map_or(0, |families| families.runs.len());
        let flights = whole.flight_curves.iter().map(|curves| flights::of(curves.clone(), &parts, runs));
        let flights = flights.collect::<Result<_, Fault>>()?;
        Ok(Self { whole, parts, families, flights })
    }

    /// All charts, each with the runs of its legend.
    fn charts(&self) -> impl Iterator<Item = (&Chart, &[Run])> {
        let of_families = self.families.iter().flat_map(|of| of.charts.iter().map(|chart| (chart, &of.runs[..])));
        let of_flights = self.flights.iter().flat_map(|of| of.charts.iter().map(|chart| (chart, &[][..])));
        let of_parts = self.parts.iter().flat_map(|part| part.charts().map(|chart| (chart, &part.runs[..])));
        of_families.chain(of_flights).chain(of_parts)
    }
}

pub fn run(args: &ReportArgs) -> Result<(), Fault> {
    let report = Report::read(&args.folder)?;
    let page = page::html(&report, !args.no_pictures)?;
    let path = args.out.clone().unwrap_or_else(|| args.folder.join("report.html"));
    write(&path, &page)?;
    if let Some(folder) = &args.svg {
        std::fs::create_dir_all(folder).map_err(|e| Fault::write(folder, e))?;
        for (chart, runs) in report.charts() {
            write(&folder.join(format!("{}.svg", chart.id)), &chart.file(runs))?;
        }
    }
    let runs: usize = report.parts.iter().map(|part| part.runs.len()).sum();
    print(&format!("Report: {} ({}, {runs} runs)\n", path.display(), html::bytes(page.len())))
}

fn write(path: &Path, text: &str) -> Result<(), Fault> {
    write_atomically(path, |file| file.write_all(text.as_bytes())).map_err(|e| Fault::write(path, e))
}
