//! Suite files: one bench, or several by name.
//!
//! ```toml
//! frames = 60                 # for all benches
//!
//! [[benches]]
//! name = "small"              # its folder
//! dem = "synthetic:257x257:1" # any field of a suite; what it leaves out is that of the file's top
//!
//! [[benches]]
//! name = "large"
//! dem = "synthetic:4097x4097:1"
//! optional = true             # flown where --benches names it
//! ```

use std::path::Path;

use serde::Deserialize;
use terrain_core::source::SourceText;
use toml::{Table, Value};

use super::{PUGET, Suite};
use crate::cli::BenchArgs;
use crate::equal_error::EqualError;
use crate::fault::{Cause, Fault};
use crate::figures::{self, Figure};
use crate::flight_curves::FlightCurves;
use crate::pivot::Pivot;

/// The suites in `data/suites`.
const BUILT_IN: [(&str, &str); 10] = [
    ("ablation", include_str!("../../../../data/suites/ablation.toml")),
    ("equal-error", include_str!("../../../../data/suites/equal-error.toml")),
    ("htp", include_str!("../../../../data/suites/htp.toml")),
    ("htp-window", include_str!("../../../../data/suites/htp-window.toml")),
    ("live", include_str!("../../../../data/suites/live.toml")),
    ("paper-htp", include_str!("../../../../data/suites/paper-htp.toml")),
    ("paper-tin", include_str!("../../../../data/suites/paper-tin.toml")),
    ("quick", include_str!("../../../../data/suites/quick.toml")),
    ("scaling", include_str!("../../../../data/suites/scaling.toml")),
    ("smoke", include_str!("../../../../data/suites/smoke.toml")),
];

/// Keys of a suite's top that its benches do not take over.
const OF_THE_TOP: [&str; 5] = ["benches", "tables", "equal_error", "flight_curves", "figures"];

/// What a suite file asks for, with the command line's own choices.
pub struct SuiteFile {
    /// The file's name without folder and ending.
    pub name: String,
    /// Over the rows of all benches.
    pub tables: Vec<Pivot>,
    pub equal_error: Vec<EqualError>,
    pub flight_curves: Vec<FlightCurves>,
    pub figures: Vec<Figure>,
    /// What a reader must know: benches that are not flown, DEMs that stand in for others.
    pub notes: Vec<String>,
    pub benches: Vec<NamedSuite>,
}

/// One bench of a suite.
#[derive(Clone, Debug)]
pub struct NamedSuite {
    /// Its folder; `None` for the only one of a file without `[[benches]]`.
    pub name: Option<String>,
    pub suite: Suite,
}

/// What an entry of `[[benches]]` says beside the fields of a suite.
#[derive(Deserialize)]
struct Head {
    name: String,
    /// Whether it is flown only where `--benches` names it.
    #[serde(default)]
    optional: bool,
}

impl SuiteFile {
    /// The suite that the command line names.
    pub fn from_args(args: &BenchArgs) -> Result<Self, Fault> {
        let (place, text) = find(&args.suite)?;
        let Content { top, benches } = Content::parse(&place, &text).map_err(|e| Fault::new(Cause::BadInput, e))?;
        let mut file = Self {
            name: stem(&args.suite),
            tables: top.tables.clone(),
            equal_error: top.equal_error.clone(),
            flight_curves: top.flight_curves.clone(),
            figures: top.figures.clone(),
            notes: Vec::new(),
            benches: Vec::new(),
        };
        if args.puget.is_some() && !names_puget(&top) {
            return Err(Fault::usage(format!("{place}: no bench flies over Puget Sound; expected --dem, not --puget")));
        }
        args.refuse_benches(&names(&benches))?;
        if benches.is_empty() {
            file.take(None, top, args)?;
            return Ok(file);
        }
        for (head, suite) in benches {
            if args.benches.as_ref().map_or(!head.optional, |asked| asked.contains(&head.name)) {
                file.take(Some(head.name), suite, args)?;
            }
        }
        if file.benches.is_empty() {
            return Err(Fault::usage(format!("{place}: no bench is left to fly; --dry-run lists what a suite has")));
        }
        Ok(file)
    }

    /// The only bench, if the file has no `[[benches]]`.
    pub fn single(&self) -> Option<&NamedSuite> {
        self.benches.first().filter(|bench| bench.name.is_none())
    }

    /// Adds a bench with the command line's choices, unless nothing of it is to be flown.
    fn take(&mut self, name: Option<String>, mut suite: Suite, args: &BenchArgs) -> Result<(), Fault> {
        suite.override_with_args(args);
        let shown = name.clone().unwrap_or_default();
        match suite.resolve_puget(args) {
            Ok(Some(stand_in)) => self.notes.push(format!("{shown}: {stand_in}")),
            Ok(None) => {}
            Err(reason) if name.is_some() => {
                self.notes.push(format!("{shown} is not flown: {reason}"));
                return Ok(());
            }
            Err(reason) => return Err(Fault::usage(reason)),
        }
        let of_bench = name.as_ref().map_or_else(String::new, |name| format!("bench {name:?}: "));
        let refuse = |reason| Fault::new(Cause::BadInput, format_args!("suite {}: {of_bench}{reason}", args.suite));
        suite.validate().map_err(refuse)?;
        // Of several benches a filter may leave out some whole.
        if name.is_some() && suite.filter.is_some() && suite.runs_or_none()?.is_empty() {
            return Ok(());
        }
        self.benches.push(NamedSuite { name, suite });
        Ok(())
    }
}

fn names_puget(top: &Suite) -> bool {
    let own = top.benches.iter().filter_map(|bench| bench.get("dem")?.as_str());
    own.chain([top.dem.as_str()]).any(|dem| dem == PUGET)
}

/// Whether a suite file is sound, whatever the command line asks for.
pub fn check_suite(name: &str, text: &str) -> Result<(), Fault> {
    let refuse = |reason: String| Fault::new(Cause::BadInput, reason);
    let Content { top, benches } = Content::parse(name, text).map_err(refuse)?;
    let own = if benches.is_empty() { Some(&top) } else { None };
    own.into_iter().chain(benches.iter().map(|(_, suite)| suite)).try_for_each(|suite| {
        suite.validate().map_err(refuse)?;
        suite.runs_or_none().map(drop)
    })
}

/// What stands in a suite file.
struct Content {
    top: Suite,
    /// With what they take from the top.
    benches: Vec<(Head, Suite)>,
}

impl Content {
    /// What belongs together in the file is checked; each bench by itself is not, since flags may mend it.
    fn parse(place: &str, text: &str) -> Result<Self, String> {
        let source = SourceText { name: place, text };
        let top: Suite = source.parse().map_err(|e| e.to_string())?;
        let table: Table = source.parse().map_err(|e| e.to_string())?;
        let in_file = |reason: String| format!("{place}: {reason}");
        let benches = benches(&table, &top.benches).map_err(in_file)?;
        let content = Self { top, benches };
        content.validate().map_err(in_file)?;
        Ok(content)
    }

    /// The only bench of a file has no name and is checked as a whole.
    fn validate(&self) -> Result<(), String> {
        let (top, names) = (&self.top, names(&self.benches));
        figures::refuse_benches(&top.figures, &names)?;
        if names.is_empty() {
            return Ok(());
        }
        top.tables.iter().try_for_each(Pivot::validate)?;
        top.equal_error.iter().try_for_each(EqualError::validate)?;
        top.flight_curves.iter().try_for_each(|curves| curves.validate(&names))?;
        figures::validate(&top.figures)
    }
}

fn names(benches: &[(Head, Suite)]) -> Vec<&str> {
    benches.iter().map(|(head, _)| head.name.as_str()).collect()
}

/// Where a suite comes from, for messages, and its text.
fn find(name: &str) -> Result<(String, String), Fault> {
    if let Some((name, text)) = BUILT_IN.iter().find(|suite| suite.0 == name) {
        return Ok((name.to_string(), text.to_string()));
    }
    let built_in: Vec<&str> = BUILT_IN.iter().map(|suite| suite.0).collect();
    let expected = &format!("a suite file, or one of the built-in suites {}", built_in.join(", "));
    let text = std::fs::read_to_string(name).map_err(|e| Fault::read(Path::new(name), &e, expected))?;
    Ok((name.into(), text))
}

/// The benches of a file with what they take from its top.
fn benches(top: &Table, benches: &[Table]) -> Result<Vec<(Head, Suite)>, String> {
    let mut all: Vec<(Head, Suite)> = Vec::new();
    for (i, bench) in benches.iter().enumerate() {
        let place = match bench.get("name").and_then(Value::as_str) {
            Some(name) => format!("bench {name:?}"),
            None => format!("bench {} of {}", i + 1, benches.len()),
        };
        let (head, suite) = merge(top, bench).map_err(|reason| format!("{place}: {reason}"))?;
        if all.iter().any(|(other, _)| other.name == head.name) {
            return Err(format!("{place}: the name is taken; expected one of its own"));
        }
        all.push((head, suite));
    }
    Ok(all)
}

fn merge(top: &Table, bench: &Table) -> Result<(Head, Suite), String> {
    let of_the_top = ["benches", "equal_error", "flight_curves", "figures"];
    if let Some(key) = of_the_top.iter().find(|key| bench.contains_key(**key)) {
        return Err(format!("{key}; expected at the top of the file"));
    }
    let one_line = |e: toml::de::Error| e.to_string().trim().replace('\n', " ");
    let head: Head = bench.clone().try_into().map_err(one_line)?;
    if !is_folder_name(&head.name) {
        return Err("its name is a folder; expected letters, digits, dots, dashes and underscores".into());
    }
    let inherited = top.iter().filter(|(key, _)| !OF_THE_TOP.contains(&key.as_str()));
    let own = bench.iter().filter(|(key, _)| !["name", "optional"].contains(&key.as_str()));
    let merged: Table = inherited.chain(own).map(|(key, value)| (key.clone(), value.clone())).collect();
    Ok((head, merged.try_into().map_err(one_line)?))
}

pub fn is_folder_name(name: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "._-".contains(c);
    !name.is_empty() && !name.starts_with('.') && name.chars().all(is_plain)
}

/// The name of a suite without folder and ending, for folders.
pub fn stem(name: &str) -> String {
    Path::new(name).file_stem().map_or_else(|| name.into(), |stem| stem.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Vec<(Head, Suite)>, String> {
        let top: Table = text.parse().unwrap();
        let suite: Suite = top.clone().try_into().unwrap();
        benches(&top, &suite.benches)
    }

    #[test]
    fn a_bench_takes_from_the_top_what_it_leaves_out() {
        let two = "frames = 7\nk = [2]\n[[benches]]\nname = 'a'\n[[benches]]\nname = 'b'\nframes = 9\noptional = true";
        let found: Vec<_> = parse(two).unwrap();
        let found = found.iter().map(|(head, suite)| (&head.name[..], head.optional, suite.frames, suite.k[0]));
        assert_eq!(found.collect::<Vec<_>>(), [("a", false, Some(7), 2), ("b", true, Some(9), 2)]);
    }

    #[test]
    fn what_is_wrong_is_named_by_bench_and_field() {
        let wrong = [
            ("name = 'a'\nfrmaes = 3", "bench \"a\": unknown field `frmaes`"),
            ("name = 'a'\nframes = 'x'", "bench \"a\": invalid type: string \"x\", expected u32 in `frames`"),
            ("frames = 3", "bench 1 of 1: missing field `name`"),
            ("name = '../a'", "bench \"../a\": its name is a folder"),
            ("name = 'a'\n[[benches]]\nname = 'a'", "bench \"a\": the name is taken"),
            ("name = 'a'\n[[benches.benches]]\nname = 'b'", "bench \"a\": benches; expected at the top"),
        ];
        for (bench, expected) in wrong {
            let refused = parse(&format!("[[benches]]\n{bench}")).err().unwrap();
            assert!(refused.starts_with(expected) && !refused.contains('\n'), "{refused}");
        }
    }

    #[test]
    fn every_built_in_suite_is_sound() {
        for (name, text) in BUILT_IN {
            let Content { benches, .. } = Content::parse(name, text).unwrap();
            for (head, suite) in benches {
                suite.validate().unwrap_or_else(|e| panic!("{name}: {}: {e}", head.name));
                assert!(!suite.runs().unwrap().is_empty());
            }
        }
    }

    /// A fuzzer's find: messages quote what a file says.
    #[test]
    fn no_name_in_a_suite_breaks_the_line() {
        let text = "[[tables]]\nrows = ['bench']\nvalues = [\"a\\nb\\u001b[31m\"]";
        let said = check_suite("a suite", text).unwrap_err().to_string();
        assert!(said.contains("a b [31m") && !said.contains(char::is_control), "{said}");
    }

    /// Files with random damage are refused in one line, or are suites.
    #[test]
    fn damaged_suites_neither_panic_nor_break_the_line() {
        let rounds = std::env::var("TERRAIN_MUTANTS").map_or(1000, |rounds| rounds.parse().unwrap());
        let mut refused = 0;
        for (name, text) in BUILT_IN {
            for seed in 0..rounds {
                let bytes = terrain_core::damage::damage(text.as_bytes(), &mut terrain_core::SplitMix64::new(seed));
                let text = String::from_utf8_lossy(&bytes);
                if let Err(said) = check_suite(name, &text).map_err(|fault| fault.to_string()) {
                    assert!(!said.contains('\n'), "{name}: seed {seed}: {said}");
                    refused += 1;
                }
            }
        }
        assert!(refused > 1000, "{refused}");
    }
}
