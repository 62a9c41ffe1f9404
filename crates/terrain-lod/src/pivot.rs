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
//! Names are those of the summary's columns, of what its column `setting` lists (`k=3`), and `bench`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::layout::{self, Heading};
use crate::record::{Record, distinct, named, validate_columns};

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

impl Pivot {
    /// Refuses what would be no table.
    pub fn validate(&self) -> Result<(), String> {
        let refuse = |reason: String| format!("table {:?}: {reason}", self.title);
        validate_columns(&self.values).map_err(refuse)?;
        if self.rows.is_empty() || self.values.is_empty() {
            return Err(refuse("expected rows and values".into()));
        }
        Ok(())
    }

    /// The table as Markdown, with its title. Where several rows of the summary fall together, the first counts.
    pub fn markdown(&self, records: &[Record]) -> String {
        let records: Vec<&Record> = records.iter().filter(|row| self.counts(row)).collect();
        let tops = distinct(records.iter().map(|row| self.top(row)));
        let sides = distinct(records.iter().map(|row| self.side(row)));
        let cell = |side: &[String], top: &str, value: &str| {
            let found = records.iter().find(|row| self.side(row) == side && self.top(row) == top);
            found.map_or_else(String::new, |row| named(row, value))
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
        self.only.iter().all(|(name, expected)| named(row, name) == *expected)
    }

    fn side(&self, row: &Record) -> Vec<String> {
        self.rows.iter().map(|name| named(row, name)).collect()
    }

    fn top(&self, row: &Record) -> String {
        self.columns.as_ref().map(|name| named(row, name)).unwrap_or_default()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::record;
    use crate::summary::SummaryRow;

    fn row(setting: &str, draws: f64) -> Record {
        let setting = setting.into();
        record("", &SummaryRow { method: "htp".into(), setting, draws_mean: Some(draws), ..Default::default() })
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
        assert_eq!(pivot.markdown(&rows), expected);
    }

    #[test]
    fn what_is_no_column_is_refused() {
        let pivot = Pivot { rows: vec!["k".into()], values: vec!["draw_mean".into()], ..Default::default() };
        assert_eq!(pivot.validate().unwrap_err(), "table \"\": draw_mean is no column of summary.csv");
        assert!(Pivot::default().validate().is_err());
    }
}
