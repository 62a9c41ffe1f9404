//! `cargo xtask check-bench`: flies the quick suite and checks its table.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::program;
use crate::{Fault, set_up_gpu};

/// Methods that the quick suite has a row for.
const METHODS: [&str; 4] = ["tin", "htp", "htp-instanced", "full-grid"];

/// Says in a result folder that its run did not finish.
const INCOMPLETE: &str = "INCOMPLETE";

/// What one check found: nothing, or one line.
type Check = Result<(), String>;

/// Flies and checks; prints a line for each check that fails, and the sum.
pub fn run(with_gpu: bool) -> Result<(), Fault> {
    let program = program::build()?;
    let folder = fresh_folder()?;
    let mut checks = vec![fly(&program, &folder, with_gpu)?];
    checks.extend(check_folder(&folder, with_gpu));
    for failed in checks.iter().filter_map(|check| check.as_ref().err()) {
        println!("FAILED: {failed}");
    }
    let failed = checks.iter().filter(|check| check.is_err()).count();
    println!("{} passed, {failed} failed", checks.len() - failed);
    if failed == 0 { Ok(()) } else { Err(Fault::failure("the table of the quick suite has failed its checks")) }
}

/// A place in the target folder that does not exist yet. It stays after the run, for a look.
fn fresh_folder() -> Result<PathBuf, Fault> {
    let xtask = std::env::current_exe().map_err(|error| Fault::failure(format!("cannot find xtask: {error}")))?;
    // The executable is <target folder>/<profile>/xtask.
    let target = xtask.ancestors().nth(2).expect("an executable that cargo built is two folders deep");
    let folder = target.join("check-bench");
    match std::fs::remove_dir_all(&folder) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(Fault::failure(format!("cannot empty {}: {error}", folder.display())))
        }
        _ => Ok(folder),
    }
}

/// A bench that fails is a failed check and not the end: its table may say which row it was.
fn fly(program: &Path, folder: &Path, with_gpu: bool) -> Result<Check, Fault> {
    let mut args: Vec<OsString> = ["bench", "--suite", "quick", "--out"].map(OsString::from).into();
    args.push(folder.into());
    if with_gpu {
        set_up_gpu(program, &mut args);
    } else {
        args.push("--no-gpu".into());
    }
    let status = program::command(program, &args).status().map_err(|e| program::cannot_start(program, &e))?;
    Ok(match program::exit_code(status) {
        0 => Ok(()),
        code => Err(format!("the bench ended with exit code {code}")),
    })
}

fn check_folder(folder: &Path, with_gpu: bool) -> Vec<Check> {
    let mut checks = vec![match folder.join(INCOMPLETE).exists() {
        true => Err(format!("{} is marked {INCOMPLETE}", folder.display())),
        false => Ok(()),
    }];
    let table = folder.join("summary.csv");
    match std::fs::read_to_string(&table) {
        Ok(text) => checks.extend(check_table(&text, with_gpu)),
        Err(error) => checks.push(Err(format!("cannot read {}: {error}", table.display()))),
    }
    checks
}

/// Every method has a row, and no row has an error, a crack, or numbers without the adapter that they come from.
fn check_table(text: &str, with_gpu: bool) -> Vec<Check> {
    let table = match Table::parse(text) {
        Ok(table) => table,
        Err(error) => return vec![Err(format!("summary.csv is no CSV table: {error}"))],
    };
    let mut checks: Vec<Check> = METHODS.iter().map(|method| table.has_method(method)).collect();
    checks.extend(table.check_column("err", "empty", str::is_empty));
    checks.extend(table.check_column("cracks", "0", |value| value == "0"));
    if with_gpu {
        checks.extend(table.check_column("adapter", "not empty", |value| !value.is_empty()));
    }
    checks
}

struct Table {
    header: csv::StringRecord,
    rows: Vec<csv::StringRecord>,
}

impl Table {
    fn parse(text: &str) -> Result<Self, csv::Error> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers()?.clone();
        let rows = reader.records().collect::<Result<_, _>>()?;
        Ok(Self { header, rows })
    }

    fn column(&self, name: &str) -> Result<usize, String> {
        let position = self.header.iter().position(|column| column == name);
        position.ok_or_else(|| format!("summary.csv has no column {name}"))
    }

    fn has_method(&self, method: &str) -> Check {
        let column = self.column("method")?;
        match self.rows.iter().any(|row| &row[column] == method) {
            true => Ok(()),
            false => Err(format!("summary.csv has no row for the method {method}")),
        }
    }

    /// One check a row.
    fn check_column(&self, name: &str, expected: &str, holds: impl Fn(&str) -> bool) -> Vec<Check> {
        let column = match self.column(name) {
            Ok(column) => column,
            Err(missing) => return vec![Err(missing)],
        };
        let check = |row: &csv::StringRecord| match row[column].trim() {
            value if holds(value) => Ok(()),
            value => Err(format!("column {name} is '{value}', expected {expected}, in the row {}", row_text(row))),
        };
        self.rows.iter().map(check).collect()
    }
}

/// The row with the number of its line, to be found again.
fn row_text(row: &csv::StringRecord) -> String {
    let line = row.position().map_or(0, csv::Position::line);
    format!("at line {line}: {}", row.iter().collect::<Vec<_>>().join(","))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "\
method,setting,adapter,cracks,err
tin,1 px,llvmpipe,0,
htp,8 px,llvmpipe,0,
htp-instanced,8 px,llvmpipe,0,
full-grid,,llvmpipe,0,
";

    fn failures(text: &str) -> Vec<String> {
        check_table(text, true).into_iter().filter_map(Result::err).collect()
    }

    #[test]
    fn a_good_table_passes_every_check() {
        assert_eq!(failures(GOOD), [""; 0]);
        // Four methods, and three columns in four rows.
        assert_eq!(check_table(GOOD, true).len(), 4 + 3 * 4);
        assert_eq!(check_table(GOOD, false).len(), 4 + 2 * 4);
    }

    #[test]
    fn a_missing_method_is_named() {
        assert_eq!(
            failures(&GOOD.replace("htp-instanced", "htp")),
            ["summary.csv has no row for the method htp-instanced"]
        );
        assert_eq!(failures("method,adapter,cracks,err\n").len(), METHODS.len());
    }

    #[test]
    fn an_error_is_shown_with_its_row() {
        let text = GOOD.replace("htp,8 px,llvmpipe,0,", "htp,8 px,llvmpipe,0,\"lost, the device\"");
        assert_eq!(
            failures(&text),
            [
                "column err is 'lost, the device', expected empty, in the row at line 3: htp,8 px,llvmpipe,0,lost, the device"
            ]
        );
    }

    #[test]
    fn a_crack_fails_and_so_does_a_count_that_is_not_there() {
        for (cracks, message) in [("1", "column cracks is '1', expected 0"), ("", "column cracks is '', expected 0")] {
            let failures = failures(&GOOD.replace("tin,1 px,llvmpipe,0,", &format!("tin,1 px,llvmpipe,{cracks},")));
            assert!(failures.len() == 1 && failures[0].starts_with(message), "{failures:?}");
        }
    }

    #[test]
    fn a_row_without_adapter_fails() {
        let failures = failures(&GOOD.replace("full-grid,,llvmpipe", "full-grid,,"));
        assert_eq!(failures, ["column adapter is '', expected not empty, in the row at line 5: full-grid,,,0,"]);
    }

    #[test]
    fn a_missing_column_is_one_failure() {
        let failures = failures(&GOOD.replace("cracks", "gaps"));
        assert_eq!(failures, ["summary.csv has no column cracks"]);
    }

    #[test]
    fn a_torn_row_is_one_failure() {
        let failures = failures("method,adapter,cracks,err\ntin,llvm");
        assert!(failures.len() == 1 && failures[0].starts_with("summary.csv is no CSV table"), "{failures:?}");
    }
}
