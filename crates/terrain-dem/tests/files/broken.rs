//! Broken files, each with its one line: file, finding, expectation, remedy.
//!
//! `refusals.txt` holds a line a case, `what: message`. A case whose message changes on purpose changes its line there.

use std::path::Path;

use terrain_dem::{ReadOptions, read, read_bytes};

use crate::{broken_headers, broken_tiffs};

/// A file that must be refused.
pub struct Case {
    /// What is wrong with it; fit for a file name.
    pub what: String,
    /// Its name.
    pub name: &'static str,
    pub bytes: Vec<u8>,
    /// What the `.hdr` beside it holds, if there is one.
    pub header: Option<String>,
    pub options: ReadOptions,
}

impl Case {
    pub fn new(what: &str, name: &'static str, bytes: impl Into<Vec<u8>>) -> Self {
        Self { what: what.into(), name, bytes: bytes.into(), header: None, options: ReadOptions::default() }
    }

    pub fn with_header(self, header: impl Into<String>) -> Self {
        Self { header: Some(header.into()), ..self }
    }

    pub fn with_options(self, options: ReadOptions) -> Self {
        Self { options, ..self }
    }

    /// The message that the file is refused with.
    fn refusal(&self, folder: &Path) -> String {
        let result = match &self.header {
            None => read_bytes(self.name, self.bytes.clone(), &self.options),
            Some(header) => {
                let path = folder.join(self.name);
                std::fs::write(&path, &self.bytes).unwrap();
                std::fs::write(path.with_extension("hdr"), header).unwrap();
                read(&path, &self.options)
            }
        };
        match result {
            Ok(dem) => format!("NOT REFUSED: {:?}", dem.reading),
            Err(error) => {
                assert!(!error.is_io(), "{}: {error}", self.what);
                error.to_string().replace(&format!("{}/", folder.display()), "")
            }
        }
    }
}

#[test]
fn broken_files_are_refused_with_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    let cases: Vec<Case> = broken_tiffs::cases().into_iter().chain(broken_headers::cases()).collect();
    let found: Vec<String> =
        cases.iter().map(|case| format!("{}: {}", case.what, case.refusal(folder.path()))).collect();
    let taken: Vec<&String> = found.iter().filter(|line| line.contains("NOT REFUSED")).collect();
    assert!(taken.is_empty(), "{taken:#?}");
    let expected: Vec<&str> = include_str!("refusals.txt").lines().collect();
    if found != expected {
        let new = found.iter().filter(|line| !expected.contains(&line.as_str()));
        panic!("these lines are not in refusals.txt:\n{}", new.cloned().collect::<Vec<_>>().join("\n"));
    }
    println!("{} broken files", found.len());
}
