//! What a path of the command line names: one bench, or a suite of several.

use std::path::Path;

use serde::Deserialize;

use super::summary::{Row, Summary};
use crate::benches::SUITE_FILE;
use crate::fault::{Cause, Fault};
use crate::results::Results;

/// One of the two sides of a comparison.
pub struct Side {
    /// As the user named it.
    pub name: String,
    pub is_suite: bool,
    pub is_incomplete: bool,
    /// One, without a name, or those of a suite.
    pub benches: Vec<Bench>,
}

pub struct Bench {
    /// Empty where there is only one.
    pub name: String,
    pub summary: Summary,
}

/// `suite.json` as far as a comparison reads it.
#[derive(Deserialize)]
struct SuiteFacts {
    benches: Vec<String>,
}

impl Side {
    /// A result folder, that of a suite, or a summary of one of them.
    pub fn open(path: &Path) -> Result<Self, Fault> {
        let name = path.display().to_string();
        let is_incomplete = path.is_dir() && Results::at(path).is_incomplete();
        if let Some(SuiteFacts { benches }) = suite_facts(path)? {
            let is_begun = |bench: &&String| !is_incomplete || path.join(bench).join("summary.json").exists();
            let open = |bench: &String| Ok(Bench { name: bench.clone(), summary: Summary::open(&path.join(bench))? });
            let benches = benches.iter().filter(is_begun).map(open).collect::<Result<_, Fault>>()?;
            return Ok(Self { name, is_suite: true, is_incomplete, benches });
        }
        let benches = by_bench(Summary::open(path)?);
        Ok(Self { name, is_suite: benches.iter().any(|bench| !bench.name.is_empty()), is_incomplete, benches })
    }

    pub fn bench(&self, name: &str) -> Option<&Summary> {
        self.benches.iter().find(|bench| bench.name == name).map(|bench| &bench.summary)
    }

    pub fn rows(&self) -> usize {
        self.benches.iter().map(|bench| bench.summary.rows.len()).sum()
    }
}

fn suite_facts(path: &Path) -> Result<Option<SuiteFacts>, Fault> {
    // The folder of one bench of a suite has no such file.
    if !path.is_dir() {
        return Ok(None);
    }
    let facts = Results::at(path).read_json(SUITE_FILE)?;
    match &facts {
        Some(SuiteFacts { benches }) if benches.iter().any(|name| !is_plain(name)) => {
            let file = path.join(SUITE_FILE);
            Err(Fault::new(Cause::BadInput, format_args!("{}: benches; expected names of folders", file.display())))
        }
        _ => Ok(facts),
    }
}

fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(std::path::Component::Normal(_)), None))
}

/// The summary of a suite has its bench in a column.
fn by_bench(summary: Summary) -> Vec<Bench> {
    let bench = |row: &Row| row.text("bench").to_owned();
    let mut benches: Vec<Bench> = Vec::new();
    let Summary { facts, rows } = summary;
    for row in rows {
        let name = bench(&row);
        match benches.iter_mut().find(|bench| bench.name == name) {
            Some(bench) => bench.summary.rows.push(row),
            None => benches.push(Bench { name, summary: Summary { facts: facts.clone(), rows: vec![row] } }),
        }
    }
    if benches.is_empty() {
        benches.push(Bench { name: String::new(), summary: Summary { facts, rows: Vec::new() } });
    }
    benches.iter_mut().for_each(|bench| bench.summary.take_facts_of_rows());
    benches
}
