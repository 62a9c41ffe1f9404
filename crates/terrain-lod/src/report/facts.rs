//! What was flown, where, and what a reader must know before any number.

use std::fmt::Write;

use serde_json::Value;

use crate::fault::Fault;
use crate::report::Report;
use crate::report::folder::{Folder, plain};
use crate::report::headline;
use crate::report::html::{Column, digits, escape, number, table};
use crate::report::runs::Run;

/// The command that made the folder, as a user types it.
pub fn command(folder: &Folder) -> String {
    let words = folder.machine["command"].as_array().map(Vec::as_slice).unwrap_or_default();
    let words: Vec<String> = words.iter().map(|word| quoted(&plain(word))).collect();
    format!("cargo xtask {}", words.join(" "))
}

fn quoted(word: &str) -> String {
    let is_plain = |char: char| char.is_ascii_alphanumeric() || "-_./:,=+%@".contains(char);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Failures in red, doubts in amber; HTML.
pub fn warnings(report: &Report) -> Result<String, Fault> {
    let folder = &report.folder;
    let mut text = String::new();
    let mut warn = |class: &str, head: &str, body: &str| {
        let _ = writeln!(text, "<p class=\"{class}\"><strong>{}</strong> {}</p>", escape(head), escape(body));
    };
    if folder.is_incomplete {
        warn("bad", "Incomplete.", "The bench has not finished. What follows is what it had written: do not trust it.");
    }
    for failure in failures(report)? {
        warn("bad", &failure.0, &failure.1);
    }
    let adapter = folder.fact("adapter");
    if folder.fact("adapter_type") == "software" {
        let body = format!(
            "{adapter} draws on the CPU. Frame times here say little about a GPU: compare counts, errors and plan times."
        );
        warn("doubt", "Software adapter.", &body);
    }
    if !headline::has_frame_times(folder)? {
        warn("doubt", "No frame times.", "Nothing was drawn or timed on an adapter. Plan times stand in their place.");
    }
    if folder.fact("profile") == "debug" {
        warn("doubt", "Debug build.", "Its times mean nothing.");
    }
    if folder.fact("dirty") == "true" {
        warn("doubt", "Changed sources.", "The checkout had changes that the commit does not name.");
    }
    let (load, cores) = (folder.machine["load_average"].as_f64(), folder.machine["cores"].as_f64());
    if let (Some(load), Some(cores)) = (load, cores)
        && load > cores
    {
        let body = format!(
            "Its load average was {} on {cores} cores when the bench began: times are those of a loaded machine.",
            number(load, 1)
        );
        warn("doubt", "Busy machine.", &body);
    }
    Ok(text)
}

/// What is said of each run that failed or has cracks.
fn failures(report: &Report) -> Result<Vec<(String, String)>, Fault> {
    let summary = &report.folder.summary;
    let mut failures = Vec::new();
    for run in report.runs.iter().filter(|run| !run.rows.is_empty()) {
        let err = summary.text(run.rows[0], "err");
        if !err.is_empty() {
            failures.push((format!("{} failed.", run.label), err.to_owned()));
        }
        for (column, pass) in [("cracks", "the error pass"), ("live_cracks", "the live pass")] {
            if let Some(cracks) = run.number(summary, column)?.filter(|cracks| *cracks > 0.0) {
                failures.push((format!("{} has cracks.", run.label), format!("{} in {pass}.", number(cracks, 0))));
            }
        }
    }
    Ok(failures)
}

/// The facts of what was flown, as a list.
pub fn flown(folder: &Folder) -> String {
    let fact = |name: &str| folder.fact(name);
    let option = |name: &str| plain(&folder.machine["options"][name]);
    let count = |value: &Value| value.as_f64().map_or_else(String::new, digits);
    let samples = format!("{} x {} samples", fact("dem_columns"), fact("dem_rows"));
    let spacing = folder.machine["dem_spacing_m"].as_array().map(Vec::as_slice).unwrap_or_default();
    let spacing: Vec<String> = spacing.iter().map(count).collect();
    let adapter = match fact("adapter") {
        name if name.is_empty() => "none: without a GPU".to_owned(),
        name => format!("{name} ({}, {}), {}", fact("adapter_type"), fact("backend"), fact("driver")),
    };
    let changed = if fact("dirty") == "true" { ", with changes" } else { "" };
    let size = option("size_px").replace(", ", " x ");
    let facts = [
        ("Suite", [fact("suite"), option("description")].join(": ").trim_end_matches(": ").to_owned()),
        ("DEM", format!("{}, {samples}, {} m apart", fact("dem"), spacing.join(" and "))),
        ("Source", fact("dem_source")),
        ("Licence", fact("dem_licence")),
        ("Notice", fact("dem_notice")),
        ("Flight", format!("{}, {} frames", fact("flight"), count(&folder.machine["frames"]))),
        ("Picture", format!("{size} px, vertical field of view {} degrees", count(&folder.machine["fov_y_deg"]))),
        ("Repeats", option("repeats")),
        ("Date", fact("utc")),
        ("Commit", fact("commit") + changed),
        ("Adapter", adapter),
        ("Machine", format!("{}, {} cores, {}", fact("cpu"), fact("cores"), fact("os"))),
    ];
    let mut text = String::from("<dl>\n");
    for (name, value) in facts.iter().filter(|(_, value)| !value.is_empty()) {
        let _ = writeln!(text, "<dt>{name}</dt><dd>{}</dd>", escape(value));
    }
    text + "</dl>\n"
}

/// All of `machine.json`, a line a fact.
pub fn machine(folder: &Folder) -> String {
    let mut rows = Vec::new();
    flatten("", &folder.machine, &mut rows);
    let column = |head: &str| Column::new(head.into(), false);
    table(&[column("fact"), column("value")], &rows)
}

fn flatten(name: &str, value: &Value, rows: &mut Vec<Vec<String>>) {
    let Value::Object(facts) = value else {
        rows.push(vec![format!("<code>{}</code>", escape(name)), escape(&plain(value))]);
        return;
    };
    for (inner, value) in facts {
        // The suite's tables stand in the page, made.
        if (name, inner.as_str()) == ("options", "tables") {
            continue;
        }
        let name = if name.is_empty() { inner.clone() } else { format!("{name}.{inner}") };
        flatten(&name, value, rows);
    }
}

/// The settings of every run.
pub fn settings(report: &Report) -> String {
    let summary = &report.folder.summary;
    let heads = ["run", "method", "setting", "tolerance px", "threads", "submission", "repeats", "files"];
    let is_number = |head: &str| ["tolerance px", "threads", "repeats"].contains(&head);
    let columns: Vec<Column> = heads.iter().map(|head| Column::new((*head).into(), is_number(head))).collect();
    let row = |run: &Run| {
        let text = |column: &str| run.rows.first().map_or_else(String::new, |row| escape(summary.text(*row, column)));
        let tolerances: Vec<&str> = run.rows.iter().map(|row| summary.text(*row, "tolerance_px")).collect();
        let name = format!("{} {}", run.look.swatch(&run.label), escape(&run.label));
        let tolerances = escape(&tolerances.join(", "));
        let files = escape(run.stem.as_deref().unwrap_or("none"));
        vec![
            name,
            text("method"),
            text("setting"),
            tolerances,
            text("threads"),
            text("submission"),
            text("repeats"),
            files,
        ]
    };
    table(&columns, &report.runs.iter().map(row).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_can_be_typed_again() {
        assert_eq!(
            ["--size", "640x360", "a b", "it's", ""].map(quoted),
            ["--size", "640x360", "'a b'", "'it'\\''s'", "''"]
        );
    }

    #[test]
    fn nested_facts_have_dotted_names() {
        let mut rows = Vec::new();
        flatten("", &serde_json::json!({"a": {"b": [1, null, "<"]}, "c": null}), &mut rows);
        assert_eq!(rows, [["<code>a.b</code>", "1, , &lt;"], ["<code>c</code>", ""]]);
    }
}
