//! `report`: one HTML file from a result folder, which opens without a network and reads without a script.
//!
//! The folder is read by column names (`folder.rs`, `sheet.rs`), so reports of older folders still work. The same folder
//! gives the same bytes: no clock, no random names, everything in the order of the summary. HTML and SVG are written by
//! hand: a template engine would have seven sections to fill and bring a compiler, and a plotting library knows neither
//! style sheets for dark and light nor the classes by which the script finds a run.

mod axis;
mod chart;
mod curves;
mod distributions;
mod facts;
mod folder;
mod headline;
mod html;
mod look;
mod markdown;
mod marks;
mod page;
mod pictures;
mod runs;
mod sheet;
mod tables;

use std::path::Path;

use terrain_dem::write_atomically;

use crate::cli::ReportArgs;
use crate::fault::Fault;
use crate::output::print;
use crate::report::chart::Chart;
use crate::report::curves::Curves;
use crate::report::folder::Folder;
use crate::report::runs::Run;

/// A folder with all that is drawn of it.
struct Report {
    folder: Folder,
    runs: Vec<Run>,
    headline: Vec<Chart>,
    curves: Curves,
    distributions: Vec<Chart>,
}

impl Report {
    fn of(folder: Folder) -> Result<Self, Fault> {
        let runs = runs::of(&folder);
        let headline = headline::charts(&folder, &runs)?;
        let curves = curves::of(&folder, &runs)?;
        let distributions = distributions::charts(&folder, &runs)?;
        Ok(Self { folder, runs, headline, curves, distributions })
    }

    fn charts(&self) -> impl Iterator<Item = &Chart> {
        self.headline.iter().chain(&self.curves.charts).chain(&self.distributions)
    }
}

pub fn run(args: &ReportArgs) -> Result<(), Fault> {
    let report = Report::of(Folder::read(&args.folder)?)?;
    let page = page::html(&report, !args.no_pictures)?;
    let path = args.out.clone().unwrap_or_else(|| args.folder.join("report.html"));
    write(&path, &page)?;
    if let Some(folder) = &args.svg {
        std::fs::create_dir_all(folder).map_err(|e| Fault::write(folder, e))?;
        for chart in report.charts() {
            write(&folder.join(format!("{}.svg", chart.id)), &chart.file(&report.runs))?;
        }
    }
    print(&format!("Report: {} ({}, {} runs)\n", path.display(), html::bytes(page.len()), report.runs.len()))
}

fn write(path: &Path, text: &str) -> Result<(), Fault> {
    write_atomically(path, |file| file.write_all(text.as_bytes())).map_err(|e| Fault::write(path, e))
}
