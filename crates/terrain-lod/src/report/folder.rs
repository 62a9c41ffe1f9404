//! A result folder as `bench` leaves it, read without the bench's own types: older folders have fewer columns.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::fault::{Cause, Fault};
use crate::report::sheet::Sheet;

/// All that is said of one bench.
pub struct Folder {
    pub path: PathBuf,
    /// Its name in a suite of several; empty where it is the only one.
    pub name: String,
    /// `machine.json`.
    pub machine: Value,
    /// Whether the bench has not finished.
    pub is_incomplete: bool,
    /// `summary.csv`; without rows where the bench has not come so far.
    pub summary: Sheet,
    /// `summary.md`; empty where the bench has not come so far.
    pub summary_md: String,
    /// `popping.csv`, of versions that measure popping.
    pub popping: Option<Sheet>,
    /// `frames/*`, by the name that a run's files share.
    pub frames: BTreeMap<String, Frames>,
    pub shots: Vec<Shot>,
    /// `pictures.csv`, of versions that measure pictures.
    pub pictures: Option<Sheet>,
}

/// The frames of one run, where the passes have come to them.
#[derive(Default)]
pub struct Frames {
    pub error: Option<Sheet>,
    pub speed: Option<Sheet>,
    pub live: Option<Sheet>,
}

/// One picture. The order of the fields is that of the pictures in the report.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shot {
    pub frame: u32,
    /// `shaded`, `wireframe`, `error`.
    pub look: String,
    /// The run's files' name.
    pub stem: String,
    pub path: PathBuf,
}

impl Folder {
    pub fn read(folder: &Path, name: &str) -> Result<Self, Fault> {
        let machine = read_machine(folder)?;
        let is_incomplete = folder.join("INCOMPLETE").exists();
        let summary = match Sheet::read(&folder.join("summary.csv"))? {
            Some(summary) => summary,
            None if is_incomplete => Sheet::parse("summary.csv", b"")?,
            None => return Err(no_results(folder, "summary.csv")),
        };
        Ok(Self {
            path: folder.to_path_buf(),
            name: name.into(),
            machine,
            is_incomplete,
            summary,
            summary_md: read_text(&folder.join("summary.md"))?.unwrap_or_default(),
            popping: Sheet::read(&folder.join("popping.csv"))?,
            frames: read_frames(&folder.join("frames"))?,
            shots: list_shots(&folder.join("shots"))?,
            pictures: Sheet::read(&folder.join("pictures.csv"))?,
        })
    }

    /// The name of something of this bench that no other bench's has.
    pub fn id(&self, name: &str) -> String {
        if self.name.is_empty() { name.into() } else { format!("{}-{name}", self.name) }
    }

    /// A fact of `machine.json` as text; empty where it has none.
    pub fn fact(&self, name: &str) -> String {
        plain(&self.machine[name])
    }
}

/// A JSON value as a reader wants it: text without quotes, lists with commas, nothing for null.
pub fn plain(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Array(list) => list.iter().map(plain).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    }
}

fn no_results(folder: &Path, missing: &str) -> Fault {
    let message = format!("{} is no results folder: it has no {missing}; expected a folder of bench", folder.display());
    Fault::new(Cause::BadInput, message)
}

fn read_machine(folder: &Path) -> Result<Value, Fault> {
    let path = folder.join("machine.json");
    let text = read_text(&path)?.ok_or_else(|| no_results(folder, "machine.json"))?;
    let refuse = |error: &dyn std::fmt::Display| Fault::new(Cause::BadInput, format!("{}: {error}", path.display()));
    match serde_json::from_str(&text) {
        Ok(Value::Object(facts)) => Ok(Value::Object(facts)),
        Ok(_) => Err(refuse(&"expected an object")),
        Err(error) => Err(refuse(&error)),
    }
}

pub fn read_text(path: &Path) -> Result<Option<String>, Fault> {
    match fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Fault::read(path, &error, "a text file of a bench")),
    }
}

/// The names in a folder, sorted; none where it is not there.
fn names(folder: &Path) -> Result<Vec<String>, Fault> {
    let failed = |error: &std::io::Error| Fault::read(folder, error, "a folder of a bench");
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(failed(&error)),
    };
    let mut names = Vec::new();
    for entry in entries {
        names.push(entry.map_err(|e| failed(&e))?.file_name().to_string_lossy().into_owned());
    }
    names.sort();
    Ok(names)
}

fn read_frames(folder: &Path) -> Result<BTreeMap<String, Frames>, Fault> {
    let mut all: BTreeMap<String, Frames> = BTreeMap::new();
    for name in names(folder)? {
        let Some((stem, pass)) = name.strip_suffix(".csv").and_then(|name| name.rsplit_once('-')) else { continue };
        let place = |frames: &mut Frames, sheet| match pass {
            "error" => frames.error = sheet,
            "speed" => frames.speed = sheet,
            _ => frames.live = sheet,
        };
        // Other files, such as the second flights of an A/A check, are not drawn.
        if ["error", "speed", "live"].contains(&pass) {
            place(all.entry(stem.into()).or_default(), Sheet::read(&folder.join(&name))?);
        }
    }
    Ok(all)
}

fn list_shots(folder: &Path) -> Result<Vec<Shot>, Fault> {
    let mut shots: Vec<Shot> = names(folder)?.iter().filter_map(|name| shot(folder, name)).collect();
    shots.sort();
    Ok(shots)
}

/// `<stem>-frame0019-shaded.png`.
fn shot(folder: &Path, name: &str) -> Option<Shot> {
    let (rest, look) = name.strip_suffix(".png")?.rsplit_once('-')?;
    let (stem, frame) = rest.rsplit_once("-frame")?;
    Some(Shot { frame: frame.parse().ok()?, look: look.into(), stem: stem.into(), path: folder.join(name) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_pictures() {
        let shot = |name| super::shot(Path::new("shots"), name).map(|shot| (shot.frame, shot.look, shot.stem));
        assert_eq!(shot("tin-0.5px-frame0019-shaded.png"), Some((19, "shaded".into(), "tin-0.5px".into())));
        assert_eq!(shot("tin-frame12345-error.png"), Some((12345, "error".into(), "tin".into())));
        assert_eq!([shot("tin-shaded.png"), shot("tin-frame0019-shaded.png.77.partial")], [None, None]);
    }

    #[test]
    fn what_a_folder_lacks_is_named() {
        let place = tempfile::tempdir().unwrap();
        let refused = |missing| {
            let message = Folder::read(place.path(), "").err().unwrap().to_string();
            assert!(message.contains("no results folder") && message.contains(missing), "{message}");
        };
        refused("machine.json");
        fs::write(place.path().join("machine.json"), "{}").unwrap();
        refused("summary.csv");
        fs::write(place.path().join("INCOMPLETE"), "").unwrap();
        assert_eq!(Folder::read(place.path(), "").unwrap().summary.len(), 0, "it may be interrupted this early");
        fs::write(place.path().join("machine.json"), "{\n\"dem\": 1,,").unwrap();
        assert!(Folder::read(place.path(), "").err().unwrap().to_string().contains("line 2"));
    }
}
