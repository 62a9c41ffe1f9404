//! What `report` is asked for: the folder of one bench, or that of a suite of several with a folder each.

use std::path::Path;

use serde_json::Value;

use crate::benches::SUITE_FILE;
use crate::fault::{Cause, Fault};
use crate::flight_curves::FlightCurves;
use crate::report::figures::{self, Figure};
use crate::report::folder::{Folder, plain, read_text};
use crate::report::sheet::Sheet;

/// All that is said of the benches together.
pub struct Whole {
    /// `suite.json`; `None` where there is one bench alone.
    pub suite: Option<Suite>,
    /// `equal-error.csv`, of suites that sweep settings.
    pub equal_error: Option<Sheet>,
    pub flight_curves: Vec<FlightCurves>,
    pub figures: Vec<Figure>,
}

/// The top of a suite's folder.
pub struct Suite {
    pub facts: Value,
    pub is_incomplete: bool,
    /// All rows, the bench in the first column; none where the first bench is not done.
    pub summary: Sheet,
    /// `tables.md`.
    pub tables_md: String,
    /// Benches that have not begun.
    pub absent: Vec<String>,
}

impl Whole {
    /// Reads all of it; the benches in the order of the suite.
    pub fn read(folder: &Path) -> Result<(Self, Vec<Folder>), Fault> {
        let place = folder.join(SUITE_FILE);
        let (suite, benches) = match read_text(&place)? {
            Some(text) => {
                let facts: Value = serde_json::from_str(&text).map_err(|e| refuse(&place, &e))?;
                let (suite, benches) = read_suite(folder, facts)?;
                (Some(suite), benches)
            }
            None => (None, vec![Folder::read(folder, "")?]),
        };
        let facts = match &suite {
            Some(suite) => &suite.facts["flight_curves"],
            None => &benches[0].machine["options"]["flight_curves"],
        };
        let flight_curves = match facts {
            // Of an older version.
            Value::Null => Vec::new(),
            facts => serde_json::from_value(facts.clone())
                .map_err(|e| refuse(folder, &format_args!("flight_curves of the suite: {e}")))?,
        };
        let equal_error = Sheet::read(&folder.join("equal-error.csv"))?;
        let mut figures = figures::read(folder)?;
        for bench in benches.iter().filter(|_| suite.is_some()) {
            figures.extend(figures::read(&bench.path)?);
        }
        Ok((Self { suite, equal_error, flight_curves, figures }, benches))
    }

    /// A fact of `suite.json` as text; empty where it has none.
    pub fn fact(&self, name: &str) -> String {
        self.suite.as_ref().map_or_else(String::new, |suite| plain(&suite.facts[name]))
    }
}

fn read_suite(folder: &Path, facts: Value) -> Result<(Suite, Vec<Folder>), Fault> {
    let is_incomplete = folder.join("INCOMPLETE").exists();
    let (mut benches, mut absent) = (Vec::new(), Vec::new());
    let names = facts["benches"].as_array().map(Vec::as_slice).unwrap_or_default();
    for name in names.iter().map(plain) {
        match folder.join(&name).join("machine.json").exists() {
            false if is_incomplete => absent.push(name),
            _ => benches.push(Folder::read(&folder.join(&name), &name)?),
        }
    }
    let summary = match Sheet::read(&folder.join("summary.csv"))? {
        Some(summary) => summary,
        None => Sheet::parse("summary.csv", b"")?,
    };
    let tables_md = read_text(&folder.join("tables.md"))?.unwrap_or_default();
    Ok((Suite { facts, is_incomplete, summary, tables_md, absent }, benches))
}

fn refuse(place: &Path, error: &dyn std::fmt::Display) -> Fault {
    Fault::new(Cause::BadInput, format_args!("{}: {error}", place.display()))
}
