//! The result folder. It is marked with a file `INCOMPLETE` until all is written.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use terrain_dem::write_atomically;

use crate::fault::{Cause, Fault};

const MARKER: &str = "INCOMPLETE";

/// A result folder under way.
pub struct Results {
    folder: PathBuf,
}

impl Results {
    /// Whether a folder can take results: it is new or empty, and can be written to. Leaves nothing behind.
    pub fn check(folder: &Path) -> Result<(), Fault> {
        refuse_occupied(folder)?;
        // Of a new folder's ancestors the nearest that is there decides.
        let existing = folder.ancestors().find(|f| f.is_dir()).unwrap_or(Path::new("."));
        probe(existing).map_err(|e| Fault::write(folder, e))
    }

    /// Makes the folder, its subfolders and the marker.
    pub fn create(folder: &Path) -> Result<Self, Fault> {
        refuse_occupied(folder)?;
        let results = Self { folder: folder.to_path_buf() };
        let make = |path: &Path| fs::create_dir_all(path).map_err(|e| Fault::write(path, e));
        make(folder)?;
        results.write_text(MARKER, "This run has not finished: do not trust what stands here.\n")?;
        make(&results.path("frames"))?;
        make(&results.path("shots"))?;
        Ok(results)
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

    /// Takes the marker away: all is written.
    pub fn complete(self) -> Result<PathBuf, Fault> {
        let marker = self.path(MARKER);
        fs::remove_file(&marker).map_err(|e| Fault::write(&marker, e))?;
        Ok(self.folder)
    }
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
}
