//! What was flown, and where.

use std::fmt::Write;

use serde_json::Value;

use crate::report::bench_page::BenchPage;
use crate::report::folder::{Folder, plain};
use crate::report::html::{Column, digits, escape, table};
use crate::report::runs::Run;
use crate::report::whole::{Suite, Whole};

/// The command that facts were written by, as a user types it; of one bench of a suite, with its name.
pub fn command(facts: &Value, bench: &str) -> String {
    let words = facts["command"].as_array().map(Vec::as_slice).unwrap_or_default();
    let mut words: Vec<String> = words.iter().map(plain).collect();
    if !bench.is_empty() {
        match words.iter().position(|word| word == "--benches") {
            Some(at) if at + 1 < words.len() => words[at + 1] = bench.into(),
            _ => words.extend(["--benches".into(), bench.into()]),
        }
    }
    format!("cargo xtask {}", words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" "))
}

fn quoted(word: &str) -> String {
    let is_plain = |char: char| char.is_ascii_alphanumeric() || "-_./:,=+%@".contains(char);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
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
    list(&facts)
}

/// Facts with their names; those without a value are left out.
fn list(facts: &[(&str, String)]) -> String {
    let mut text = String::from("<dl>\n");
    for (name, value) in facts.iter().filter(|(_, value)| !value.is_empty()) {
        let _ = writeln!(text, "<dt>{name}</dt><dd>{}</dd>", escape(value));
    }
    text + "</dl>\n"
}

/// The benches of a suite, a row each, and what is to be known of all.
pub fn flown_by_suite(whole: &Whole, suite: &Suite, parts: &[BenchPage]) -> String {
    let notes = suite.facts["notes"].as_array().map(Vec::as_slice).unwrap_or_default();
    let notes: Vec<String> = notes.iter().map(plain).collect();
    let facts = [
        ("Suite", whole.fact("suite")),
        ("Date", whole.fact("utc")),
        ("Notes", notes.join("; ")),
        ("Not flown yet", suite.absent.join(", ")),
    ];
    let heads = ["bench", "DEM", "samples", "flight", "frames", "picture", "repeats", "runs", "adapter"];
    let is_number = |head: &str| ["frames", "repeats", "runs"].contains(&head);
    let columns: Vec<Column> = heads.iter().map(|head| Column::new((*head).into(), is_number(head))).collect();
    let row = |part: &BenchPage| {
        let fact = |name: &str| escape(&part.folder.fact(name));
        let option = |name: &str| escape(&plain(&part.folder.machine["options"][name]));
        let name = &part.folder.name;
        let state = if part.folder.is_incomplete { " (incomplete)" } else { "" };
        let adapter = fact("adapter");
        vec![
            format!("<a href=\"#{}\">{}</a>{state}", part.folder.id("flown"), escape(name)),
            fact("dem"),
            format!("{} x {}", fact("dem_columns"), fact("dem_rows")),
            fact("flight"),
            fact("frames"),
            format!("{} px", option("size_px").replace(", ", " x ")),
            option("repeats"),
            part.runs.len().to_string(),
            if adapter.is_empty() { "none".into() } else { adapter },
        ]
    };
    list(&facts) + &table(&columns, &parts.iter().map(row).collect::<Vec<_>>())
}

/// All of `machine.json`, or of another object, a line a fact.
pub fn of_json(facts: &Value) -> String {
    let mut rows = Vec::new();
    flatten("", facts, &mut rows);
    let column = |head: &str| Column::new(head.into(), false);
    table(&[column("fact"), column("value")], &rows)
}

fn flatten(name: &str, value: &Value, rows: &mut Vec<Vec<String>>) {
    let Value::Object(facts) = value else {
        rows.push(vec![format!("<code>{}</code>", escape(name)), escape(&plain(value))]);
        return;
    };
    for (inner, value) in facts {
        // The suite's tables and curves stand in the page, made.
        if ["tables", "equal_error", "flight_curves", "figures"].contains(&inner.as_str()) {
            continue;
        }
        let name = if name.is_empty() { inner.clone() } else { format!("{name}.{inner}") };
        flatten(&name, value, rows);
    }
}

/// The settings of every run.
pub fn settings(part: &BenchPage) -> String {
    let summary = &part.folder.summary;
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
    table(&columns, &part.runs.iter().map(row).collect::<Vec<_>>())
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
    fn the_command_of_one_bench_names_it() {
        let facts = |words: &[&str]| serde_json::json!({ "command": words });
        let begun = facts(&["bench", "--suite", "two"]);
        assert_eq!(command(&begun, ""), "cargo xtask bench --suite two");
        assert_eq!(command(&begun, "a"), "cargo xtask bench --suite two --benches a");
        assert_eq!(command(&facts(&["bench", "--benches", "a,b"]), "b"), "cargo xtask bench --benches b");
    }

    #[test]
    fn nested_facts_have_dotted_names() {
        let mut rows = Vec::new();
        flatten("", &serde_json::json!({"a": {"b": [1, null, "<"]}, "c": null}), &mut rows);
        assert_eq!(rows, [["<code>a.b</code>", "1, , &lt;"], ["<code>c</code>", ""]]);
    }
}
