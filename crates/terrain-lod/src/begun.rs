//! `bench --resume DIR`: a bench that was interrupted, found again in its folder.
//!
//! Its settings are those of `machine.json`, which is written before the first flight. The numbers of both sittings stand
//! in one table, so the second must be the same bench on the same machine.

use std::path::{Path, PathBuf};

use clap::{CommandFactory, FromArgMatches};
use serde_json::{Value, json};

use crate::benches::SUITE_FILE;
use crate::cli::{BenchArgs, Cli, Command};
use crate::fault::{Cause, Fault};
use crate::machine::Machine;
use crate::results::Results;

/// Facts that may differ between two sittings of one bench. `dirty`, since results in the checkout make it so: whether the
/// program is the same is what `program_sha256` says.
const MAY_DIFFER: [&str; 6] = ["utc", "command", "load_average", "memory_mib", "resumed", "dirty"];
/// Flags beside `--resume` that say nothing of the settings: xtask adds `--no-gpu` where there is no adapter.
const NEUTRAL: [&str; 2] = ["--dry-run", "--no-gpu"];

/// A bench under way.
pub struct Begun {
    folder: PathBuf,
    machine: Value,
}

impl Begun {
    /// Refuses a folder without a bench to go on with.
    pub fn open(folder: &Path) -> Result<Self, Fault> {
        let results = Results::at(folder);
        let machine: Option<Value> = match results.read_json("machine.json")? {
            Some(machine) => Some(machine),
            None => results.read_json(SUITE_FILE)?,
        };
        let refuse = |reason| Err(Fault::usage(format!("{}: {reason}", folder.display())));
        match machine {
            Some(_) if !results.is_incomplete() => refuse("complete; there is nothing to resume"),
            Some(machine) => Ok(Self { folder: folder.to_path_buf(), machine }),
            None => refuse("no bench has begun here (no machine.json); start it without --resume"),
        }
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether the folder is that of a suite of several benches.
    pub fn is_suite(&self) -> bool {
        !self.machine["benches"].is_null()
    }

    /// The bench's name in a suite of several.
    pub fn bench(&self) -> Option<&str> {
        self.machine["bench"].as_str()
    }

    /// The arguments that the bench was begun with; those of this call where it gives any of its own.
    pub fn arguments(&self, here: &BenchArgs) -> Result<BenchArgs, Fault> {
        let own: Vec<String> = std::env::args().skip(1).collect();
        let said = if is_bare(&own) { self.command()? } else { own };
        let no_command = |e: &dyn std::fmt::Display| {
            let name = self.folder.join("machine.json");
            Fault::new(Cause::BadInput, format_args!("{}: command: {e}", name.display()))
        };
        let matches = Cli::command().try_get_matches_from(std::iter::once("terrain-lod".to_string()).chain(said));
        let cli = matches.and_then(|matches| Cli::from_arg_matches(&matches)).map_err(|e| no_command(&e))?;
        match cli.command {
            Command::Bench(args) => {
                Ok(BenchArgs { dry_run: here.dry_run, no_gpu: args.no_gpu || here.no_gpu, ..*args })
            }
            _ => Err(no_command(&"no bench")),
        }
    }

    fn command(&self) -> Result<Vec<String>, Fault> {
        serde_json::from_value(self.machine["command"].clone())
            .map_err(|e| Fault::new(Cause::BadInput, format_args!("{}: command: {e}", self.folder.display())))
    }

    /// Refuses to go on as another bench, or elsewhere.
    pub fn refuse_another(&self, machine: &Machine) -> Result<(), Fault> {
        let now = json!(machine);
        match difference("", &self.machine, &now) {
            None => Ok(()),
            Some((fact, begun, now)) => {
                let message = format!("{}: begun with {fact} {begun}, now {now}", self.folder.display());
                Err(Fault::usage(message + "; resume it as it was begun, or start another"))
            }
        }
    }

    /// Opens the folder, and notes in `machine.json` that a further sitting begins.
    pub fn go_on(mut self, machine: &Machine) -> Result<Results, Fault> {
        let results = Results::reopen(&self.folder)?;
        let sitting = json!({ "utc": machine.utc, "load_average": machine.load_average });
        match self.machine["resumed"].as_array_mut() {
            Some(sittings) => sittings.push(sitting),
            None => self.machine["resumed"] = json!([sitting]),
        }
        results.write_json("machine.json", &self.machine)?;
        Ok(results)
    }
}

/// Whether a command line names the folder to resume and nothing else: `bench --resume DIR`.
fn is_bare(said: &[String]) -> bool {
    let mut rest = said.iter().skip(1);
    while let Some(word) = rest.next() {
        match word.as_str() {
            "--resume" => drop(rest.next()),
            word if word.starts_with("--resume=") || NEUTRAL.contains(&word) => {}
            _ => return false,
        }
    }
    true
}

/// The first fact that differs, by its place, and both values.
fn difference(place: &str, begun: &Value, now: &Value) -> Option<(String, String, String)> {
    let (Value::Object(begun_facts), Value::Object(now_facts)) = (begun, now) else {
        return (begun != now).then(|| (place.to_string(), begun.to_string(), now.to_string()));
    };
    let names = begun_facts.keys().chain(now_facts.keys()).filter(|name| !MAY_DIFFER.contains(&name.as_str()));
    names.into_iter().find_map(|name| {
        let place = if place.is_empty() { name.clone() } else { format!("{place}.{name}") };
        difference(&place, &begun[name], &now[name])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bare_command_line_names_the_folder_alone() {
        let bare = |line: &str| is_bare(&line.split(' ').map(str::to_string).collect::<Vec<_>>());
        assert!(
            bare("bench --resume a") && bare("bench --resume=a --no-gpu") && bare("bench --dry-run --resume --frames")
        );
        assert!(!bare("bench --resume a --frames 3") && !bare("bench --suite smoke --resume a"));
    }

    #[test]
    fn the_first_difference_is_named_by_its_place() {
        let begun = json!({ "utc": "then", "cpu": "x", "options": { "frames": 3, "k": 3 } });
        let now = json!({ "utc": "now", "cpu": "x", "options": { "frames": 4, "k": 3 } });
        let found = difference("", &begun, &now).unwrap();
        assert_eq!(found, ("options.frames".into(), "3".into(), "4".into()));
        assert_eq!(difference("", &begun, &begun), None);
        let more = difference("", &json!({}), &json!({ "look": "shaded" })).unwrap();
        assert_eq!(more, ("look".into(), "null".into(), "\"shaded\"".into()));
    }
}
