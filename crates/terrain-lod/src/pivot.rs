//! The tables of a suite: a few numbers of the summary, by the settings that the suite varies.
//!
//! ```toml
//! [[tables]]
//! title = "Draws by batching and k"
//! only = { metric = "error" }     # of the rows of the summary; all without it
//! rows = ["batching"]             # what stands at the left
//! columns = "k"                   # what stands at the top; without it, the values alone
//! values = ["draws_mean"]         # columns of the summary
//! ```
//!
//! Names are those of the summary's columns and of what its column `setting` lists (`k=3`).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::layout::{self, Heading};
use crate::summary::SummaryRow;

/// One table.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pivot {
    pub title: String,
    /// What a reader must know; a line under the title.
    pub note: String,
    /// The rows of the summary that count: those with all of these values.
    pub only: BTreeMap<String, String>,
    pub rows: Vec<String>,
    pub columns: Option<String>,
    pub values: Vec<String>,
}

/// A row of the summary by name, with what `setting` lists as names of their own.
type Record = BTreeMap<String, Value>;

impl Pivot {
    /// Refuses what would be no table.
    pub fn validate(&self) -> Result<(), String> {
        let known = record(&SummaryRow::default());
        let missing = |name: &&String| !known.contains_key(*name);
        match self.values.iter().find(missing) {
            Some(name) => Err(format!("table {:?}: {name} is no column of summary.csv", self.title)),
            None if self.rows.is_empty() || self.values.is_empty() => {
                Err(format!("table {:?}: expected rows and values", self.title))
            }
            None => Ok(()),
        }
    }

    /// The table as Markdown, with its title. Where several rows of the summary fall together, the first counts.
    pub fn markdown(&self, rows: &[&SummaryRow]) -> String {
        let records: Vec<Record> = rows.iter().map(|row| record(row)).filter(|row| self.counts(row)).collect();
        let tops = distinct(records.iter().map(|row| self.top(row)));
        let sides = distinct(records.iter().map(|row| self.side(row)));
        let cell = |side: &[String], top: &str, value: &str| {
            let found = records.iter().find(|row| self.side(row) == side && self.top(row) == top);
            found.map_or_else(String::new, |row| text(&row[value]))
        };
        let line = |side: &Vec<String>| {
            let cells = tops.iter().flat_map(|top| self.values.iter().map(move |value| cell(side, top, value)));
            side.iter().cloned().chain(cells).collect()
        };
        let lines: Vec<Vec<String>> = sides.iter().map(line).collect();
        let note = if self.note.is_empty() { String::new() } else { format!("{}\n\n", self.note) };
        format!("### {}\n\n{note}{}", self.title, layout::table(&self.headings(&tops), &lines))
    }

    fn counts(&self, row: &Record) -> bool {
        self.only.iter().all(|(name, expected)| row.get(name).map(text).as_ref() == Some(expected))
    }

    fn side(&self, row: &Record) -> Vec<String> {
        self.rows.iter().map(|name| row.get(name).map(text).unwrap_or_default()).collect()
    }

    fn top(&self, row: &Record) -> String {
        self.columns.as_ref().and_then(|name| row.get(name)).map(text).unwrap_or_default()
    }

    fn headings(&self, tops: &[String]) -> Vec<Heading> {
        let left = self.rows.iter().map(|name| Heading { text: name.replace('_', " "), right: false });
        let of_top = |top: &String, value: &String| match &self.columns {
            None => value.replace('_', " "),
            Some(name) if self.values.len() == 1 => format!("{name} {top}"),
            Some(name) => format!("{name} {top}: {}", value.replace('_', " ")),
        };
        let numbers = tops.iter().flat_map(|top| self.values.iter().map(move |value| of_top(top, value)));
        left.chain(numbers.map(|text| Heading { text, right: true })).collect()
    }
}

fn record(row: &SummaryRow) -> Record {
    let Ok(Value::Object(columns)) = serde_json::to_value(row) else { unreachable!("a struct becomes an object") };
    let columns: Map<String, Value> = columns;
    let settings = row.setting.split(' ').filter_map(|word| word.split_once('='));
    let settings = settings.map(|(name, value)| (name.to_owned(), Value::from(value)));
    columns.into_iter().chain(settings).collect()
}

/// In the order in which they come first.
fn distinct<T: PartialEq>(all: impl Iterator<Item = T>) -> Vec<T> {
    all.fold(Vec::new(), |mut seen, one| {
        if !seen.contains(&one) {
            seen.push(one);
        }
        seen
    })
}

/// A value as a reader wants it: of numbers with a fraction, four digits.
fn text(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => digits(number.as_f64().expect("a float")),
        other => other.to_string(),
    }
}

fn digits(number: f64) -> String {
    let before = if number == 0.0 { 1 } else { number.abs().log10().floor() as i32 + 1 };
    let decimals = (4 - before).clamp(0, 6) as usize;
    let text = format!("{number:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(setting: &str, draws: f64) -> SummaryRow {
        SummaryRow { method: "htp".into(), setting: setting.into(), draws_mean: Some(draws), ..Default::default() }
    }

    #[test]
    fn settings_become_rows_and_columns() {
        let rows = [
            row("metric=error k=2 batching=per-patch", 34_619.0),
            row("metric=error k=3 batching=per-patch", 30_763.25),
            row("metric=box k=3 batching=per-patch", 1.0),
            row("metric=error k=3 batching=instanced", 7.0),
        ];
        let pivot = Pivot {
            title: "Draws".into(),
            only: BTreeMap::from([("metric".into(), "error".into())]),
            rows: vec!["batching".into()],
            columns: Some("k".into()),
            values: vec!["draws_mean".into()],
            ..Default::default()
        };
        let expected = "\
### Draws

| batching  |   k 2 |   k 3 |
| --------- | ----: | ----: |
| per-patch | 34619 | 30763 |
| instanced |       |     7 |
";
        assert_eq!(pivot.markdown(&rows.iter().collect::<Vec<_>>()), expected);
    }

    #[test]
    fn what_is_no_column_is_refused() {
        let pivot = Pivot { rows: vec!["k".into()], values: vec!["draw_mean".into()], ..Default::default() };
        assert_eq!(pivot.validate().unwrap_err(), "table \"\": draw_mean is no column of summary.csv");
        assert!(Pivot::default().validate().is_err());
    }

    #[test]
    fn numbers_keep_four_digits() {
        assert_eq!([0.99891, 12.0, 123_456.7, 0.0, 0.0312345].map(digits), ["0.9989", "12", "123457", "0", "0.03123"]);
    }
}
