//! `cargo xtask record` and `check-readme`: the README's result tables come out of recorded runs.
//!
//! A recorded run is a folder of `bench-results/recorded` with what a reader needs to check a number: `machine.json`,
//! `summary.csv` and the tables, no frames. The README shows it between two lines:
//!
//! ```text
//! <!-- recorded: quick -->
//! ...
//! <!-- end of quick -->
//! ```

mod equal_error;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::Fault;
use crate::program::workspace_root;

const RECORDED: &str = "bench-results/recorded";
/// What of a result folder is recorded, as far as it is there.
const FILES: [&str; 4] = ["summary.csv", "summary.md", "tables.md", "equal-error.csv"];
/// The same of a suite of several benches.
const SUITE_FILES: [&str; 2] = ["suite.json", "equal-error.csv"];
/// A record is for readers of the repository: none of its files is larger.
const MOST_BYTES: u64 = 200_000;
/// The settings that tell a reader what a run is. The rest stands in the record.
const SETTINGS: [&str; 5] = ["selector", "metric", "leg-px", "k", "layers"];
/// Who has one of these knows no tolerance.
const NO_TOLERANCE: [&str; 2] = ["leg-px", "step"];

/// `record DIR`: takes a result folder over, under the name of its suite, and shows it in the README.
///
/// Of a suite of several benches come the costs at equal error, under the names of suite and DEM; `machine.json` is that of
/// its first bench.
pub fn record(folder: &Path) -> Result<(), Fault> {
    let suite_file = folder.join("suite.json");
    let suite = if suite_file.exists() { Some(parse(&suite_file, &read(&suite_file)?)?) } else { None };
    let first = suite.as_ref().and_then(|suite| suite["benches"][0].as_str()).unwrap_or_default();
    let machine_file = folder.join(first).join("machine.json");
    let machine = parse(&machine_file, &read(&machine_file)?)?;
    if folder.join("INCOMPLETE").exists() {
        return Err(Fault::failure(format!("{}: marked INCOMPLETE; finish it first", folder.display())));
    }
    let text = |name: &str| machine[name].as_str().unwrap_or("unnamed").to_owned();
    let (name, files) = match suite {
        None => (text("suite"), &FILES[..]),
        Some(_) => (format!("{}-{}", text("suite"), text("dem")), &SUITE_FILES[..]),
    };
    let target = workspace_root().join(RECORDED).join(&name);
    std::fs::create_dir_all(&target).map_err(|error| cannot_write(&target, &error))?;
    keep(&machine_file, &target.join("machine.json"))?;
    for file in files.iter().filter(|file| folder.join(file).exists()) {
        keep(&folder.join(file), &target.join(file))?;
    }
    check(true)
}

/// Copies a file of a record.
fn keep(from: &Path, to: &Path) -> Result<(), Fault> {
    let text = read(from)?;
    let refuse = |why: String| Err(Fault::failure(format!("{}: {why}", from.display())));
    if text.len() as u64 > MOST_BYTES {
        return refuse(format!("{} bytes; a record's files have at most {MOST_BYTES}", text.len()));
    }
    if text.contains("\"/") {
        return refuse("it names a place of this machine; run the bench with relative paths".into());
    }
    std::fs::write(to, text).map_err(|error| cannot_write(to, &error))
}

/// `check-readme`: whether the README shows what is recorded. `write`: makes it so.
pub fn check(write: bool) -> Result<(), Fault> {
    let path = workspace_root().join("README.md");
    let text = read(&path)?;
    let spliced = splice(&text, &shown)?;
    match spliced == text {
        true => Ok(()),
        false if write => std::fs::write(&path, spliced).map_err(|error| cannot_write(&path, &error)),
        false => Err(Fault::failure(
            "README.md does not show the recorded runs; mend it with: cargo xtask check-readme --write",
        )),
    }
}

/// The text with what stands between each two lines made anew.
fn splice(text: &str, table: &dyn Fn(&str) -> Result<String, Fault>) -> Result<String, Fault> {
    let (mut made, mut rest, mut count) = (String::new(), text, 0);
    while let Some((before, after)) = rest.split_once("<!-- recorded: ") {
        let name = after.split(" -->").next().unwrap_or_default();
        let end = format!("<!-- end of {name} -->");
        let Some(at) = after.find(&end) else {
            return Err(Fault::failure(format!("README.md: expected a line {end} after <!-- recorded: {name} -->")));
        };
        let _ = write!(made, "{before}<!-- recorded: {name} -->\n{}\n{end}", table(name)?);
        rest = &after[at + end.len()..];
        count += 1;
    }
    match count {
        0 => Err(Fault::failure("README.md: expected a line <!-- recorded: NAME -->")),
        _ => Ok(made + rest),
    }
}

/// What the README says of the record of a name, or of those that begin with it: a suite's, one a DEM.
fn shown(name: &str) -> Result<String, Fault> {
    let recorded = workspace_root().join(RECORDED);
    if recorded.join(name).exists() {
        return table(&recorded.join(name));
    }
    let entries = std::fs::read_dir(&recorded).into_iter().flatten().flatten().map(|entry| entry.path());
    let begins = |folder: &PathBuf| folder.file_name().is_some_and(|it| it.to_string_lossy().starts_with(name));
    let mut folders: Vec<PathBuf> = entries.filter(begins).collect();
    folders.sort();
    equal_error::table(&folders)
}

/// What the README says of a record.
fn table(folder: &Path) -> Result<String, Fault> {
    let machine_file = folder.join("machine.json");
    let machine = parse(&machine_file, &read(&machine_file)?)?;
    let summary_file = folder.join("summary.csv");
    let rows = rows(&read(&summary_file)?).map_err(|e| Fault::failure(format!("{}: {e}", summary_file.display())))?;
    Ok(caption(&machine) + "\n" + &markdown(&rows))
}

/// What was flown, with what command, where and when.
fn caption(machine: &Value) -> String {
    let text = |name: &str| machine[name].as_str().unwrap_or_default().to_owned();
    let number = |name: &str| machine[name].to_string();
    let adapter = match (text("adapter").as_str(), text("adapter_type").as_str()) {
        ("", _) => "without a GPU".to_owned(),
        (name, "software") => {
            format!("{name}: a **software adapter**, so read the frame times as a comparison of CPU work")
        }
        (name, kind) => format!("{name} ({kind})"),
    };
    let build = if text("profile") == "debug" { " **Debug build: its times mean nothing.**" } else { "" };
    let size: Vec<String> =
        machine["options"]["size_px"].as_array().into_iter().flatten().map(Value::to_string).collect();
    format!(
        "DEM {} ({} x {} samples), flight {}, {} frames of {} pixels.\n`cargo xtask {}`, {}, {} cores ({}), {adapter}.{build}\n",
        text("dem"),
        number("dem_columns"),
        number("dem_rows"),
        text("flight"),
        number("frames"),
        size.join(" x "),
        caption_words(machine),
        text("utc").split('T').next().unwrap_or_default(),
        number("cores"),
        text("cpu"),
    )
}

/// The command of a run.
fn caption_words(run: &Value) -> String {
    let words: Vec<&str> = run["command"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    words.join(" ")
}

/// A row by its columns.
struct Row {
    header: csv::StringRecord,
    cells: csv::StringRecord,
}

impl Row {
    fn text(&self, column: &str) -> &str {
        let at = self.header.iter().position(|name| name == column);
        at.and_then(|at| self.cells.get(at)).unwrap_or_default()
    }

    /// Empty where nothing was measured.
    fn number(&self, column: &str, decimals: usize) -> String {
        self.text(column).parse::<f64>().map_or_else(|_| String::new(), |value| grouped(&format!("{value:.decimals$}")))
    }

    fn settings(&self) -> impl Iterator<Item = (&str, &str)> {
        self.text("setting").split(' ').filter_map(|word| word.split_once('='))
    }

    fn setting(&self) -> String {
        let told = self.settings().filter(|(name, _)| SETTINGS.contains(name));
        told.map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
    }

    fn tolerance(&self) -> String {
        let is_yardstick = self.settings().any(|(name, _)| NO_TOLERANCE.contains(&name));
        if is_yardstick { String::new() } else { self.text("tolerance_px").into() }
    }
}

fn rows(text: &str) -> Result<Vec<Row>, csv::Error> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers()?.clone();
    reader.records().map(|cells| Ok(Row { header: header.clone(), cells: cells? })).collect()
}

/// Heading, whether it is a number, and the cell.
type Column = (&'static str, bool, fn(&Row) -> String);

const COLUMNS: [Column; 13] = [
    ("method", false, |row| format!("`{}`", row.text("method"))),
    ("setting", false, Row::setting),
    ("tolerance px", true, Row::tolerance),
    ("error max px", true, |row| row.number("error_px_max", 2)),
    ("error P99 px", true, |row| row.number("error_px_p99", 2)),
    ("error RMS px", true, |row| row.number("error_px_rms", 3)),
    ("cracks", true, |row| row.number("cracks", 0)),
    ("triangles", true, |row| row.number("triangles_mean", 0)),
    ("draws", true, |row| row.number("draws_mean", 0)),
    ("plan P50 / P99 ms", true, |row| format!("{} / {}", row.number("plan_ms_p50", 2), row.number("plan_ms_p99", 2))),
    ("encode ms", true, |row| row.number("encode_ms_p50", 2)),
    ("frame P50 ms", true, |row| row.number("frame_ms_p50", 1)),
    ("fps", true, |row| row.number("fps_mean", 0)),
];

fn markdown(rows: &[Row]) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | ").replace("  ", " "));
    let rule = |is_number: bool| if is_number { "---:" } else { "---" };
    let mut text = line(COLUMNS.iter().map(|column| column.0.into()).collect());
    text += &format!("|{}|\n", COLUMNS.map(|column| rule(column.1)).join("|"));
    rows.iter().for_each(|row| text += &line(COLUMNS.iter().map(|column| column.2(row)).collect()));
    text
}

/// Thousands apart by commas.
fn grouped(number: &str) -> String {
    let (whole, fraction) = number.split_at(number.find('.').unwrap_or(number.len()));
    let digits = whole.len();
    let apart = |(i, digit): (usize, char)| {
        let comma = (i > 0 && (digits - i).is_multiple_of(3)).then_some(',');
        comma.into_iter().chain([digit])
    };
    whole.chars().enumerate().flat_map(apart).collect::<String>() + fraction
}

fn read(path: &Path) -> Result<String, Fault> {
    std::fs::read_to_string(path).map_err(|error| Fault::failure(format!("cannot read {}: {error}", path.display())))
}

fn parse(path: &Path, text: &str) -> Result<Value, Fault> {
    serde_json::from_str(text).map_err(|error| Fault::failure(format!("{}: {error}", path.display())))
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Fault {
    Fault::failure(format!("cannot write {}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check that a landing must pass: numbers in the README are those of a run that anyone can look up.
    #[test]
    fn the_readme_shows_the_recorded_runs() {
        check(false).unwrap_or_else(|fault| panic!("{}", fault.message));
    }

    #[test]
    fn records_are_small_and_name_no_place_of_a_machine() {
        let recorded = workspace_root().join(RECORDED);
        let folders: Vec<PathBuf> = std::fs::read_dir(&recorded).unwrap().map(|entry| entry.unwrap().path()).collect();
        assert!(!folders.is_empty());
        for folder in folders {
            for entry in std::fs::read_dir(&folder).unwrap() {
                let path = entry.unwrap().path();
                assert!(path.metadata().unwrap().len() <= MOST_BYTES, "{}", path.display());
                assert!(!read(&path).unwrap().contains("\"/"), "{}", path.display());
            }
        }
    }

    #[test]
    fn what_stands_between_the_lines_is_made_anew_and_the_rest_stays() {
        let table = |name: &str| Ok(format!("table of {name}\n"));
        let text = "a\n<!-- recorded: q -->\nold 7.5\n<!-- end of q -->\nb\n";
        let made = splice(text, &table).map_err(|fault| fault.message).unwrap();
        assert_eq!(made, "a\n<!-- recorded: q -->\ntable of q\n\n<!-- end of q -->\nb\n");
        assert_eq!(splice(&made, &table).map_err(|fault| fault.message).unwrap(), made);
        assert!(splice("a\n<!-- recorded: q -->\n", &table).is_err());
        assert!(splice("no lines", &table).is_err());
    }

    #[test]
    fn a_row_has_what_was_measured_and_no_tolerance_that_is_only_a_yardstick() {
        let text = "method,setting,tolerance_px,triangles_mean,error_px_max,cracks\n\
                    tin,selector=bounded patch=32,1.0,12345.6,0.987,0\n\
                    htp,metric=distance leg-px=8 k=3,1.0,,,\n";
        let text = markdown(&rows(text).unwrap());
        let lines: Vec<&str> = text.lines().skip(2).collect();
        assert!(lines[0].starts_with("| `tin` | selector=bounded | 1.0 | 0.99 |"), "{text}");
        assert!(lines[0].contains("| 0 | 12,346 |"), "{text}");
        assert!(lines[1].starts_with("| `htp` | metric=distance leg-px=8 k=3 | | | |"), "{text}");
    }
}
