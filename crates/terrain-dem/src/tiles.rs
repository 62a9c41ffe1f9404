//! Which files a pattern or a folder names: the tiles of one DEM.

use std::fs;
use std::path::{Path, PathBuf};

use crate::DemError;

/// Files that lie beside tiles and are none, by their endings.
const COMPANIONS: [&str; 18] = [
    "toml", "json", "hdr", "prj", "tfw", "pgw", "aux", "xml", "ovr", "txt", "md", "pdf", "html", "stx", "blw", "cells",
    "tin-maps", "partial",
];

/// More tiles than anybody means: one a degree of land.
const MAX_TILES: usize = 30_000;

/// Several files as one DEM.
#[derive(Debug, PartialEq)]
pub struct Tiles {
    /// Fit for file names.
    pub name: String,
    /// Sorted by name; at least one.
    pub paths: Vec<PathBuf>,
}

/// The tiles that the user names by a folder or a pattern with `*`, `?` or `[...]`; `None` for a single file. A file of
/// that very name comes before a pattern.
pub fn named(spec: &str) -> Result<Option<Tiles>, DemError> {
    let path = Path::new(spec);
    let found = match path.is_dir() {
        true => in_folder(path)?,
        false if spec.contains(['*', '?', '[']) && !path.exists() => matching(spec)?,
        false => return Ok(None),
    };
    let mut paths: Vec<PathBuf> = found.into_iter().filter(|path| path.is_file() && !is_companion(path)).collect();
    paths.sort();
    let refuse = |reason: String| Err(DemError::input(spec, reason));
    let Some(first) = paths.first() else { return refuse("no elevation file in it; expected tiles of one DEM".into()) };
    if paths.len() > MAX_TILES {
        return refuse(format!("{} files; expected at most {MAX_TILES} tiles", paths.len()));
    }
    let name = match path.is_dir() {
        // `.` and `..` have names, too, once they are resolved.
        true => stem(&path.canonicalize().unwrap_or(path.to_owned())),
        false => format!("{}-of-{}", stem(first), paths.len()),
    };
    Ok(Some(Tiles { name, paths }))
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn in_folder(folder: &Path) -> Result<Vec<PathBuf>, DemError> {
    let entries = fs::read_dir(folder).and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect());
    entries.map_err(|e| DemError::io("read", folder, e))
}

fn matching(pattern: &str) -> Result<Vec<PathBuf>, DemError> {
    let refuse =
        |e: glob::PatternError| DemError::input(pattern, format!("{}; expected a pattern such as N4*.hgt", e.msg));
    let found: Result<Vec<PathBuf>, _> = glob::glob(pattern).map_err(refuse)?.take(MAX_TILES + 1).collect();
    let unread = |e: glob::GlobError| {
        let path = e.path().to_owned();
        DemError::io("read", &path, e.into())
    };
    let found = found.map_err(unread)?;
    if found.is_empty() {
        return Err(DemError::input(pattern, "no file is named so; expected a pattern such as 'N4*W12*.hgt'".into()));
    }
    Ok(found)
}

fn is_companion(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending);
    name.starts_with('.') || COMPANIONS.contains(&ending)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_and_patterns_name_tiles() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["N45W122.hgt", "N44W122.hgt", "N44W122.toml", "n44.hdr", ".hidden", "odd[1].hgt"] {
            fs::write(at(name), b"x").unwrap();
        }
        fs::create_dir(at("N46W122.hgt")).unwrap();
        let named = |spec: PathBuf| super::named(spec.to_str().unwrap()).unwrap();
        let both = vec![at("N44W122.hgt"), at("N45W122.hgt")];
        assert_eq!(named(at("N4*.hgt")), Some(Tiles { name: "N44W122-of-2".to_owned(), paths: both.clone() }));
        assert_eq!(named(at("N4[45]W12?.*")).unwrap().paths, both);
        assert_eq!(named(folder.path().to_owned()).unwrap().paths, [both, vec![at("odd[1].hgt")]].concat());
        assert_eq!(named(at("odd[1].hgt")), None, "a file of that very name");
        assert_eq!(named(at("none.hgt")), None, "whoever opens it says so");
        for (wrong, said) in [("S*.hgt", "no file is named so"), ("*.toml", "no elevation file"), ("a***", "pattern")] {
            let error = super::named(at(wrong).to_str().unwrap()).unwrap_err();
            assert!(error.to_string().contains(said) && !error.is_io(), "{error}");
        }
    }
}
