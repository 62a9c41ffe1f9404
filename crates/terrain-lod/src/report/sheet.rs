//! A CSV file by column name, whichever version of the bench wrote it.

use std::path::Path;

use csv::StringRecord;

use crate::fault::{Cause, Fault};

/// A CSV file. A column that is not there and a cell that is empty mean the same: not measured.
pub struct Sheet {
    place: String,
    columns: Vec<String>,
    rows: Vec<StringRecord>,
}

impl Sheet {
    /// Reads a file; `None` where there is none.
    pub fn read(path: &Path) -> Result<Option<Self>, Fault> {
        match std::fs::read(path) {
            Ok(bytes) => Self::parse(&path.display().to_string(), &bytes).map(Some),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Fault::read(path, &error, "a CSV file of a bench")),
        }
    }

    /// `place` is the file's name in errors.
    pub fn parse(place: &str, bytes: &[u8]) -> Result<Self, Fault> {
        let mut reader = csv::Reader::from_reader(bytes);
        // The error of the crate names the line.
        let refuse = |error: csv::Error| Fault::new(Cause::BadInput, format_args!("{place}: {error}"));
        let columns = reader.headers().map_err(refuse)?.iter().map(str::to_owned).collect();
        let rows = reader.records().collect::<Result<_, _>>().map_err(refuse)?;
        Ok(Self { place: place.into(), columns, rows })
    }

    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// A cell as it stands there.
    pub fn text(&self, row: usize, column: &str) -> &str {
        let index = self.columns.iter().position(|name| name == column);
        index.and_then(|index| self.rows[row].get(index)).unwrap_or_default()
    }

    /// A cell as a finite number. `inf`, which a frame says where nothing bounds it, has no place in a chart: `None`.
    pub fn number(&self, row: usize, column: &str) -> Result<Option<f64>, Fault> {
        let text = self.text(row, column);
        match text.parse::<f64>() {
            _ if text.is_empty() => Ok(None),
            Ok(number) if number.is_finite() => Ok(Some(number)),
            Ok(number) if number.is_infinite() => Ok(None),
            _ => {
                let line = self.rows[row].position().map_or(0, |position| position.line());
                let found = format_args!("{}: line {line}: {column} is {text:?}; expected a number", self.place);
                Err(Fault::new(Cause::BadInput, found))
            }
        }
    }

    /// A whole column, a value a row.
    pub fn numbers(&self, column: &str) -> Result<Vec<Option<f64>>, Fault> {
        if !self.columns.iter().any(|name| name == column) {
            return Ok(vec![None; self.len()]);
        }
        (0..self.len()).map(|row| self.number(row, column)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_was_not_measured() {
        let sheet = Sheet::parse("x.csv", b"frame,error_px_max\n0,1.5\n1,\n").unwrap();
        assert_eq!(sheet.numbers("error_px_max").unwrap(), [Some(1.5), None]);
        assert_eq!(sheet.numbers("popping_px_max").unwrap(), [None, None]);
        assert_eq!(sheet.text(0, "popping_px_max"), "");
    }

    /// Found by a review: one unbounded frame cost the whole report.
    #[test]
    fn an_infinite_frame_was_refused() {
        let sheet = Sheet::parse("x.csv", b"frame,unheld_px\n0,1.5\n1,inf\n").unwrap();
        assert_eq!(sheet.numbers("unheld_px").unwrap(), [Some(1.5), None]);
    }

    #[test]
    fn errors_name_file_and_line() {
        let sheet = Sheet::parse("x.csv", b"frame,ms\n0,1\n1,fast\n").unwrap();
        let refused = sheet.numbers("ms").unwrap_err();
        assert_eq!(refused.to_string(), "x.csv: line 3: ms is \"fast\"; expected a number");
        assert!(Sheet::parse("x.csv", b"ms\nNaN\n").unwrap().numbers("ms").is_err());
        let torn = Sheet::parse("x.csv", b"frame,ms\n0,1\n1\n").err().unwrap();
        assert!(torn.to_string().contains("x.csv") && torn.to_string().contains("line: 3"), "{torn}");
    }
}
