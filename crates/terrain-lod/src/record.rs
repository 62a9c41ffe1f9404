//! A row of the summary by its names: what the tables of a suite are made of.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use crate::summary::SummaryRow;

/// A row by column, with the name of its `bench`, and with what `setting` lists as names of their own (`k=3`).
pub type Record = BTreeMap<String, Value>;

/// The record of a row. `bench` is empty where a suite has only one.
pub fn record(bench: &str, row: &SummaryRow) -> Record {
    let Ok(Value::Object(columns)) = serde_json::to_value(row) else { unreachable!("a struct becomes an object") };
    let columns: Map<String, Value> = columns;
    // What is a column, such as the threads, stays a number.
    let settings = row.setting.split(' ').filter_map(|word| word.split_once('='));
    let settings = settings.map(|(name, value)| (name.to_owned(), Value::from(value)));
    let bench = std::iter::once(("bench".to_owned(), Value::from(bench)));
    settings.chain(columns).chain(bench).collect()
}

/// Refuses what is no column of the summary.
pub fn validate_columns<'a>(names: impl IntoIterator<Item = &'a String>) -> Result<(), String> {
    let known = record("", &SummaryRow::default());
    match names.into_iter().find(|name| !known.contains_key(*name)) {
        Some(name) => Err(format!("{name} is no column of summary.csv")),
        None => Ok(()),
    }
}

/// A name's value as a reader wants it; empty where there is none.
pub fn named(record: &Record, name: &str) -> String {
    record.get(name).map(text).unwrap_or_default()
}

/// A name's value as a number.
pub fn number(record: &Record, name: &str) -> Option<f64> {
    record.get(name).and_then(Value::as_f64)
}

/// In the order in which they come first.
pub fn distinct<T: PartialEq>(all: impl Iterator<Item = T>) -> Vec<T> {
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

/// Four digits, or as many as stand before the point.
pub fn digits(number: f64) -> String {
    let before = if number == 0.0 { 1 } else { number.abs().log10().floor() as i32 + 1 };
    let decimals = (4 - before).clamp(0, 6) as usize;
    let text = format!("{number:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        assert_eq!([0.99891, 12.0, 123_456.7, 0.0, 0.0312345].map(digits), ["0.9989", "12", "123457", "0", "0.03123"]);
    }

    #[test]
    fn settings_have_names_of_their_own() {
        let row = SummaryRow { setting: "k=3 threads=2 geomorph".into(), threads: 2, ..Default::default() };
        let record = record("small", &row);
        assert_eq!(["k", "bench", "geomorph"].map(|name| named(&record, name)), ["3", "small", ""]);
        assert_eq!(number(&record, "threads"), Some(2.0));
    }
}
