//! The sidecar beside a DEM that we write: it must speak of no other file.

use std::path::Path;
use std::{fs, io};

use terrain_dem::{SIDECAR_MARK, sidecar_of};

use crate::fault::Fault;

/// Endings of files that the sidecar of their name speaks of.
const ENDINGS: [&str; 18] = [
    "png", "tif", "tiff", "hgt", "asc", "bil", "flt", "dt0", "dt1", "dt2", "pgm", "npy", "r16", "r32", "raw", "dem",
    "gz", "zip",
];

/// Refuses to write `out` where that or its sidecar would change what is read of another file.
pub fn check_place(input: &Path, out: &Path) -> Result<(), Fault> {
    if input.canonicalize().is_ok_and(|input| out.canonicalize().is_ok_and(|out| out == input)) {
        return Err(Fault::write(out, "it is the file that is read; expected another name"));
    }
    let sidecar = sidecar_of(out);
    let is_free = match fs::read_to_string(&sidecar) {
        Ok(text) => text.starts_with(SIDECAR_MARK),
        Err(e) => e.kind() == io::ErrorKind::NotFound,
    };
    if !is_free {
        let said = "it is there, and not by terrain-lod; expected another name, or no such file";
        return Err(Fault::write(&sidecar, said));
    }
    let mut others = ENDINGS.iter().map(|ending| out.with_extension(ending));
    match others.find(|other| *other != out && other.is_file()) {
        Some(other) => {
            let said = format!("as a sidecar it would speak of {}, too; expected another name", other.display());
            Err(Fault::write(&sidecar, said))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_other_file_is_spoken_of() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let said = |input: &str, out: &str| check_place(&at(input), &at(out)).map_err(|fault| fault.to_string());
        fs::write(at("a.tif"), "x").unwrap();
        assert_eq!(said("a.tif", "b.png"), Ok(()));
        assert!(said("a.tif", "a.tif").unwrap_err().contains("it is the file that is read"));
        assert!(said("a.tif", "a.png").unwrap_err().contains("a.tif, too; expected another name"));
        fs::write(at("b.toml"), "spacing_m = 30").unwrap();
        assert!(said("a.tif", "b.png").unwrap_err().contains("not by terrain-lod"));
        fs::write(at("b.toml"), SIDECAR_MARK).unwrap();
        assert_eq!(said("a.tif", "b.png"), Ok(()));
    }
}
