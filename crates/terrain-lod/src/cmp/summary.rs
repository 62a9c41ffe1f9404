//! One bench of a comparison.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::Deserialize;
use serde_json::{Map, Value};

use super::columns::{MACHINE_FACTS, ROW_FACTS};
use crate::fault::{Cause, Fault};
use crate::frame_times::RepeatTimes;
use crate::interval::Interval;
use crate::summary_file::SCHEMA;

/// What a folder, or a file of its summary, says.
pub struct Summary {
    /// What must be equal on both sides, as far as both know it.
    pub facts: BTreeMap<String, Value>,
    pub rows: Vec<Row>,
}

/// A row of the summary.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// By column; texts, numbers, and null for what was not measured.
    pub columns: Map<String, Value>,
    /// Empty in a CSV.
    pub times: RepeatTimes,
}

/// `summary.json` as far as a comparison reads it.
#[derive(Deserialize)]
struct File {
    schema: u32,
    machine: Value,
    rows: Vec<FileRow>,
}

#[derive(Deserialize)]
struct FileRow {
    #[serde(default)]
    repeat_times: RepeatTimes,
    #[serde(flatten)]
    columns: Map<String, Value>,
}

impl Summary {
    /// The result folder of one bench, or one of its summaries.
    pub fn open(path: &Path) -> Result<Self, Fault> {
        let file = if path.is_dir() { path.join("summary.json") } else { path.to_path_buf() };
        let text = fs::read_to_string(&file)
            .map_err(|e| Fault::read(&file, &e, "a result folder, or its summary.json or summary.csv"))?;
        let is_csv = file.extension().is_some_and(|ending| ending == "csv");
        let read = if is_csv { read_csv(&text) } else { read_json(&text) };
        let (facts, rows) =
            read.map_err(|reason| Fault::new(Cause::BadInput, format_args!("{}: {reason}", file.display())))?;
        let mut summary = Self { facts, rows };
        summary.take_facts_of_rows();
        Ok(summary)
    }

    /// Facts that stand in each row.
    pub fn take_facts_of_rows(&mut self) {
        if let Some(row) = self.rows.first() {
            let of_row = ROW_FACTS.iter().filter_map(|fact| Some((fact.to_string(), row.columns.get(*fact)?.clone())));
            self.facts.extend(of_row);
        }
    }
}

impl Row {
    pub fn text(&self, column: &str) -> &str {
        self.columns.get(column).and_then(Value::as_str).unwrap_or_default()
    }

    pub fn number(&self, column: &str) -> Option<f64> {
        self.columns.get(column).and_then(Value::as_f64)
    }

    /// Method, setting, and tolerance as text: the same for partners.
    pub fn key(&self) -> (&str, &str, String) {
        (self.text("method"), self.text("setting"), self.number("tolerance_px").unwrap_or(0.0).to_string())
    }

    /// A time with the ends of its interval, from the columns.
    pub fn interval(&self, column: &str) -> Option<Interval> {
        let end = |end: &str| self.number(&format!("{column}_{end}"));
        Some(Interval { estimate: self.number(column)?, low: end("low")?, high: end("high")? })
    }
}

fn read_json(text: &str) -> Result<(BTreeMap<String, Value>, Vec<Row>), String> {
    let file: File = serde_json::from_str(text).map_err(|e| format!("no summary.json: {e}"))?;
    if file.schema != SCHEMA {
        return Err(format!("schema {}; expected {SCHEMA}", file.schema));
    }
    let fact =
        |place: &&str| Some((place.trim_start_matches('/').replace('/', "."), file.machine.pointer(place)?.clone()));
    let facts = MACHINE_FACTS.iter().filter_map(fact).collect();
    let rows = file.rows.into_iter().map(|FileRow { repeat_times: times, columns }| Row { columns, times });
    Ok((facts, rows.collect()))
}

fn read_csv(text: &str) -> Result<(BTreeMap<String, Value>, Vec<Row>), String> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| e.to_string())?.clone();
    if !header.iter().any(|column| column == "method") {
        return Err("no summary.csv: no column method".into());
    }
    let row = |record: csv::StringRecord| {
        let columns = header.iter().map(str::to_string).zip(record.iter().map(cell)).collect();
        Row { columns, times: RepeatTimes::default() }
    };
    let rows: Result<Vec<Row>, csv::Error> = reader.records().map(|record| record.map(row)).collect();
    Ok((BTreeMap::new(), rows.map_err(|e| e.to_string())?))
}

/// As JSON has it: a number where it is one, null where nothing was measured.
fn cell(text: &str) -> Value {
    match text {
        "" => Value::Null,
        _ => serde_json::from_str::<serde_json::Number>(text).map_or_else(|_| text.into(), Value::Number),
    }
}
