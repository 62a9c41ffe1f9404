//! What a reader must know before any number.

use crate::fault::Fault;
use crate::report::bench_page::BenchPage;
use crate::report::headline;
use crate::report::html::{escape, number};

/// One of them.
#[derive(Clone, PartialEq)]
pub struct Warning {
    /// `bad` for failures, `doubt` for what to read with care.
    class: &'static str,
    head: String,
    body: String,
}

impl Warning {
    pub fn bad(head: impl Into<String>, body: impl Into<String>) -> Self {
        Self { class: "bad", head: head.into(), body: body.into() }
    }

    fn doubt(head: &str, body: impl Into<String>) -> Self {
        Self { class: "doubt", head: head.into(), body: body.into() }
    }

    /// Failures in red, doubts in amber; HTML.
    pub fn html(&self) -> String {
        format!("<p class=\"{}\"><strong>{}</strong> {}</p>\n", self.class, escape(&self.head), escape(&self.body))
    }
}

/// Of all benches: what holds for each of them once, the rest with its bench.
pub fn warnings(parts: &[BenchPage]) -> Result<Vec<Warning>, Fault> {
    let all = parts.iter().map(of_bench).collect::<Result<Vec<Vec<Warning>>, Fault>>()?;
    let mut said: Vec<Warning> = Vec::new();
    for (part, warnings) in parts.iter().zip(&all) {
        for warning in warnings {
            let mut warning = warning.clone();
            if !all.iter().all(|others| others.contains(&warning)) {
                warning.head = format!("{}: {}", part.folder.name, warning.head);
            }
            if !said.contains(&warning) {
                said.push(warning);
            }
        }
    }
    said.sort_by_key(|warning| warning.class);
    Ok(said)
}

fn of_bench(part: &BenchPage) -> Result<Vec<Warning>, Fault> {
    let folder = &part.folder;
    let mut warnings = Vec::new();
    if folder.is_incomplete {
        let body = "The bench has not finished. What follows is what it had written: do not trust it.";
        warnings.push(Warning::bad("Incomplete.", body));
    }
    warnings.extend(failures(part)?);
    let adapter = folder.fact("adapter");
    if folder.fact("adapter_type") == "software" {
        let body = format!(
            "{adapter} draws on the CPU. Frame times here say little about a GPU: compare counts, errors and plan times."
        );
        warnings.push(Warning::doubt("Software adapter.", body));
    }
    if !headline::has_frame_times(folder)? {
        let body = "Nothing was drawn or timed on an adapter. Plan times stand in their place.";
        warnings.push(Warning::doubt("No frame times.", body));
    }
    if folder.fact("profile") == "debug" {
        warnings.push(Warning::doubt("Debug build.", "Its times mean nothing."));
    }
    if folder.fact("dirty") == "true" {
        let body = "The checkout had changes that the commit does not name.";
        warnings.push(Warning::doubt("Changed sources.", body));
    }
    let (load, cores) = (folder.machine["load_average"].as_f64(), folder.machine["cores"].as_f64());
    if let (Some(load), Some(cores)) = (load, cores)
        && load > cores
    {
        let body = format!(
            "Its load average was {} on {cores} cores when the bench began: times are those of a loaded machine.",
            number(load, 1)
        );
        warnings.push(Warning::doubt("Busy machine.", body));
    }
    Ok(warnings)
}

/// What is said of each run that failed or has cracks.
fn failures(part: &BenchPage) -> Result<Vec<Warning>, Fault> {
    let summary = &part.folder.summary;
    let mut failures = Vec::new();
    for run in part.runs.iter().filter(|run| !run.rows.is_empty()) {
        let err = summary.text(run.rows[0], "err");
        if !err.is_empty() {
            failures.push(Warning::bad(format!("{} failed.", run.label), err));
        }
        for (column, pass) in [("cracks", "the error pass"), ("live_cracks", "the live pass")] {
            if let Some(cracks) = run.number(summary, column)?.filter(|cracks| *cracks > 0.0) {
                let body = format!("{} in {pass}.", number(cracks, 0));
                failures.push(Warning::bad(format!("{} has cracks.", run.label), body));
            }
        }
    }
    Ok(failures)
}
