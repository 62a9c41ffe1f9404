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

    /// Of some of several benches.
    fn of(self, benches: &[&str], count: usize) -> Self {
        let head = if benches.len() == count { self.head } else { format!("{}: {}", benches.join(", "), self.head) };
        Self { head, ..self }
    }

    /// Failures in red, doubts in amber; HTML.
    pub fn html(&self) -> String {
        format!("<p class=\"{}\"><strong>{}</strong> {}</p>\n", self.class, escape(&self.head), escape(&self.body))
    }
}

/// Of all benches, failures first: what holds for each of them is said once, and the rest with the benches that it is of.
pub fn warnings(parts: &[BenchPage]) -> Result<Vec<Warning>, Fault> {
    let mut said: Vec<(Warning, Vec<&str>)> = Vec::new();
    for part in parts {
        for warning in of_bench(part)? {
            let name = part.folder.name.as_str();
            match said.iter_mut().find(|(other, _)| *other == warning) {
                Some((_, benches)) if benches.contains(&name) => {}
                Some((_, benches)) => benches.push(name),
                None => said.push((warning, vec![name])),
            }
        }
    }
    said.sort_by_key(|(warning, _)| warning.class);
    Ok(said.into_iter().map(|(warning, benches)| warning.of(&benches, parts.len())).collect())
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
        // How high it was stands among the facts.
        let body = format!(
            "The load average was above its {cores} cores when the bench began: times are those of a loaded machine."
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_holds_for_all_is_said_without_their_names() {
        let warning = || Warning::doubt("Busy machine.", "Its times.");
        assert_eq!(warning().of(&["a", "b"], 2).head, "Busy machine.");
        assert_eq!(warning().of(&["a", "c"], 3).head, "a, c: Busy machine.");
        let html = Warning::bad("<x> failed.", "a & b").html();
        assert_eq!(html, "<p class=\"bad\"><strong>&lt;x&gt; failed.</strong> a &amp; b</p>\n");
    }
}
