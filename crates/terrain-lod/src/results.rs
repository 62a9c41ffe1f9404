//! The result folder. It is marked with a file `INCOMPLETE` until all is written, and every file in it is whole.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use terrain_dem::write_atomically;

use crate::fault::{Cause, Fault};

const MARKER: &str = "INCOMPLETE";
/// What `--resume` needs, and a complete folder does not have any more.
const PARTS: &str = "parts";

/// A result folder under way.
pub struct Results {
    folder: PathBuf,
}

impl Results {
    /// The folder as it is: nothing is checked or written.
    pub fn at(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf() }
    }

    /// Whether a folder can take results: it is new or empty, and can be written to. Leaves nothing behind.
    pub fn check(folder: &Path) -> Result<(), Fault> {
        refuse_occupied(folder)?;
        // Of a new folder's ancestors the nearest that is there decides.
        let existing = folder.ancestors().find(|f| f.is_dir()).unwrap_or(Path::new("."));
        probe(existing).map_err(|e| Fault::write(folder, e))
    }

    /// Makes the folder, its subfolders and the marker.
    pub fn create(folder: &Path) -> Result<Self, Fault> {
        let results = Self::create_plain(folder)?;
        results.make_subfolders()?;
        Ok(results)
    }

    /// The same without subfolders.
    pub fn create_plain(folder: &Path) -> Result<Self, Fault> {
        refuse_occupied(folder)?;
        let results = Self::at(folder);
        results.make("")?;
        results.write_text(MARKER, "This run has not finished: do not trust what stands here.\n")?;
        Ok(results)
    }

    /// Opens the folder of a bench that was interrupted, to go on. Removes what a killed process was writing.
    pub fn reopen(folder: &Path) -> Result<Self, Fault> {
        let results = Self::at(folder);
        probe(folder).map_err(|e| Fault::write(folder, e))?;
        results.make_subfolders()?;
        ["", "frames", "shots", PARTS].iter().try_for_each(|name| remove_partial(&results.path(name)))?;
        Ok(results)
    }

    pub fn is_incomplete(&self) -> bool {
        self.path(MARKER).exists()
    }

    fn make_subfolders(&self) -> Result<(), Fault> {
        ["frames", "shots", PARTS].iter().try_for_each(|name| self.make(name))
    }

    fn make(&self, name: &str) -> Result<(), Fault> {
        let path = self.path(name);
        fs::create_dir_all(&path).map_err(|e| Fault::write(&path, e))
    }

    /// Makes a further subfolder, or removes from it what a killed process was writing.
    pub fn prepare(&self, name: &str) -> Result<(), Fault> {
        self.make(name)?;
        remove_partial(&self.path(name))
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    pub fn write_text(&self, name: &str, text: &str) -> Result<(), Fault> {
        let path = self.path(name);
        write_atomically(&path, |file| file.write_all(text.as_bytes())).map_err(|e| Fault::write(&path, e))
    }

    pub fn write_csv<T: Serialize>(&self, name: &str, rows: &[T]) -> Result<(), Fault> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        let fault = |e: &dyn std::fmt::Display| Fault::write(&self.path(name), e);
        rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|e| fault(&e))?;
        let bytes = writer.into_inner().map_err(|e| fault(&e))?;
        self.write_text(name, &String::from_utf8_lossy(&bytes))
    }

    pub fn write_json<T: Serialize>(&self, name: &str, value: &T) -> Result<(), Fault> {
        let text = serde_json::to_string_pretty(value).map_err(|e| Fault::write(&self.path(name), e))?;
        self.write_text(name, &(text + "\n"))
    }

    /// The rows of a CSV file; `None` where it is not there.
    pub fn read_csv<T: DeserializeOwned>(&self, name: &str) -> Result<Option<Vec<T>>, Fault> {
        let Some(bytes) = self.read(name)? else { return Ok(None) };
        let rows: Result<Vec<T>, csv::Error> = csv::Reader::from_reader(&bytes[..]).deserialize().collect();
        rows.map(Some).map_err(|error| self.refuse(name, &error))
    }

    /// The content of a JSON file; `None` where it is not there.
    pub fn read_json<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, Fault> {
        let Some(bytes) = self.read(name)? else { return Ok(None) };
        serde_json::from_slice(&bytes).map(Some).map_err(|error| self.refuse(name, &error))
    }

    /// Something done that `--resume` need not do again, by a name of its own.
    pub fn write_part<T: Serialize>(&self, name: &str, part: &T) -> Result<(), Fault> {
        self.write_json(&part_file(name), part)
    }

    /// What [`Self::write_part`] wrote; `None` where it was not done.
    pub fn read_part<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, Fault> {
        self.read_json(&part_file(name))
    }

    fn read(&self, name: &str) -> Result<Option<Vec<u8>>, Fault> {
        let path = self.path(name);
        match fs::read(&path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(Fault::read(&path, &error, "a file of a bench")),
        }
    }

    fn refuse(&self, name: &str, error: &dyn std::fmt::Display) -> Fault {
        let path = self.path(name);
        Fault::new(Cause::BadInput, format_args!("{}: {error}; expected what this version writes", path.display()))
    }

    /// Takes the marker away: all is written. The parts go last, since a kill in between must not cost them; where they stay
    /// nobody looks at them.
    pub fn complete(self) -> Result<PathBuf, Fault> {
        let marker = self.path(MARKER);
        fs::remove_file(&marker).map_err(|e| Fault::write(&marker, e))?;
        let parts = self.path(PARTS);
        if parts.exists() {
            fs::remove_dir_all(&parts).map_err(|e| Fault::write(&parts, e))?;
        }
        Ok(self.folder)
    }
}

fn part_file(name: &str) -> String {
    format!("{PARTS}/{name}.json")
}

/// Removes the temporary files of `write_atomically` that a killed process has left in a folder.
fn remove_partial(folder: &Path) -> Result<(), Fault> {
    let failed = |error| Fault::write(folder, error);
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.extension().is_some_and(|ending| ending == "partial") {
            fs::remove_file(&path).map_err(|e| Fault::write(&path, e))?;
        }
    }
    Ok(())
}

/// Whether a file can be written at this path: before long work, not after. Leaves nothing behind.
pub fn probe_parent(path: &Path) -> Result<(), Fault> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    probe(parent).map_err(|e| Fault::write(path, e))
}

fn probe(folder: &Path) -> std::io::Result<()> {
    let probe = folder.join(format!(".terrain-lod-{}", std::process::id()));
    fs::write(&probe, "").and_then(|()| fs::remove_file(&probe))
}

fn refuse_occupied(folder: &Path) -> Result<(), Fault> {
    let occupied = match fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_some(),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => false,
        Err(error) => return Err(Fault::write(folder, error)),
    };
    if occupied {
        let message = format!("{} is not empty; results go to a new or empty folder", folder.display());
        return Err(Fault::new(Cause::Io, message));
    }
    Ok(())
}

/// The time of day as UTC, for folder names: 2026-01-31T12-59-59Z.
pub fn utc_now() -> String {
    let since_epoch = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    utc(since_epoch.as_secs())
}

/// Civil date from days since the epoch, by counting years of March to February (Gregorian calendar).
fn utc(seconds: u64) -> String {
    let (days, second) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let march_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * march_month + 2) / 5 + 1;
    let month = if march_month < 10 { march_month + 3 } else { march_month - 9 };
    let year = era * 400 + year_of_era + (month <= 2) as u64;
    let (hour, minute, second) = (second / 3_600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}-{minute:02}-{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_around_leap_days() {
        assert_eq!(utc(0), "1970-01-01T00-00-00Z");
        assert_eq!(utc(951_782_399), "2000-02-28T23-59-59Z");
        assert_eq!(utc(951_782_400), "2000-02-29T00-00-00Z");
        assert_eq!(utc(1_709_251_199), "2024-02-29T23-59-59Z");
        assert_eq!(utc(1_798_761_599), "2026-12-31T23-59-59Z");
    }

    #[test]
    fn a_folder_is_marked_until_complete_and_never_reused() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("a/b");
        Results::check(&folder).unwrap();
        assert!(!place.path().join("a").exists(), "a check leaves nothing behind");
        let results = Results::create(&folder).unwrap();
        assert!(folder.join("INCOMPLETE").is_file());
        results.complete().unwrap();
        assert!(!folder.join("INCOMPLETE").exists());
        assert!(Results::create(&folder).is_err(), "there are results already");
    }

    #[test]
    fn what_a_killed_process_has_left_is_swept_and_what_it_has_finished_stays() {
        let place = tempfile::tempdir().unwrap();
        let results = Results::create(place.path()).unwrap();
        results.write_part("a", &[1, 2]).unwrap();
        fs::write(results.path("parts/b.json.77.partial"), "[1,").unwrap();
        fs::write(results.path("summary.csv.77.partial"), "meth").unwrap();
        let results = Results::reopen(place.path()).unwrap();
        assert_eq!(results.read_part("a").unwrap(), Some(vec![1, 2]));
        assert_eq!(results.read_part::<Vec<u32>>("b").unwrap(), None);
        assert!(!results.path("parts/b.json.77.partial").exists() && !results.path("summary.csv.77.partial").exists());
        results.complete().unwrap();
        assert!(!place.path().join("parts").exists(), "of no use to a reader");
    }

    #[test]
    fn a_file_that_is_not_ours_is_named() {
        let place = tempfile::tempdir().unwrap();
        let results = Results::create(place.path()).unwrap();
        fs::write(results.path("frames/x.csv"), "a,b\n1,2,3\n").unwrap();
        let refused = results.read_csv::<Vec<u32>>("frames/x.csv").unwrap_err();
        assert!(refused.cause == Cause::BadInput && refused.to_string().contains("x.csv: "), "{refused}");
        assert_eq!(results.read_csv::<Vec<u32>>("frames/y.csv").unwrap(), None);
    }
}
