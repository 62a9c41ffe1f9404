//! The tables that a suite asks for, and the files beside them.

use crate::equal_error::{EqualError, EqualErrorRow};
use crate::fault::Fault;
use crate::pivot::Pivot;
use crate::record::Record;
use crate::results::Results;

/// All tables as Markdown. Those at equal error are also written as `equal-error.csv`.
pub fn write(
    results: &Results,
    tables: &[Pivot],
    equal_error: &[EqualError],
    records: &[Record],
) -> Result<String, Fault> {
    let mut text: String = tables.iter().map(|table| format!("\n{}", table.markdown(records))).collect();
    let mut all: Vec<EqualErrorRow> = Vec::new();
    for table in equal_error {
        let rows = table.rows(records);
        text += &format!("\n{}", table.markdown(&rows));
        all.extend(rows);
    }
    if !equal_error.is_empty() {
        results.write_csv("equal-error.csv", &all)?;
    }
    Ok(text)
}
