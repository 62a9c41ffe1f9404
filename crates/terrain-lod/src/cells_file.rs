//! Files of cells: where htp-lod, which opens no files, reads and what it cut is written.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use htp_lod::{CellFile, CellSource, CellsError, Cutter, Resident};

use crate::fault::{Cause, Fault};

/// A file that is read and written at places, by several threads at once.
pub struct Placed {
    file: File,
    /// Where there is only one place at a time: who moves it waits for the others.
    #[cfg(not(unix))]
    turn: std::sync::Mutex<()>,
}

impl Placed {
    pub fn new(file: File) -> Self {
        Self {
            file,
            #[cfg(not(unix))]
            turn: Default::default(),
        }
    }

    #[cfg(unix)]
    pub fn write_at(&self, at: u64, bytes: &[u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::write_all_at(&self.file, bytes, at)
    }

    #[cfg(not(unix))]
    pub fn write_at(&self, at: u64, bytes: &[u8]) -> io::Result<()> {
        use std::io::{Seek, Write};
        let _turn = self.turn.lock().expect("nobody panics with it");
        (&self.file).seek(io::SeekFrom::Start(at))?;
        (&self.file).write_all(bytes)
    }
}

impl CellSource for Placed {
    fn len(&self) -> io::Result<u64> {
        Ok(self.file.metadata()?.len())
    }

    #[cfg(unix)]
    fn read_at(&self, at: u64, into: &mut [u8]) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, into, at)
    }

    #[cfg(not(unix))]
    fn read_at(&self, at: u64, into: &mut [u8]) -> io::Result<()> {
        use std::io::{Read, Seek};
        let _turn = self.turn.lock().expect("nobody panics with it");
        (&self.file).seek(io::SeekFrom::Start(at))?;
        (&self.file).read_exact(into)
    }
}

/// Whether a file begins as one of cells.
pub fn is_one(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| io::Read::read_to_end(&mut io::Read::take(file, 8), &mut start));
    read.is_ok() && CellFile::is_one(&start)
}

/// Opens a file of cells.
pub fn open(path: &Path) -> Result<(CellFile, Resident), Fault> {
    CellFile::open(source(path)?).map_err(|error| fault(path, &error))
}

/// The bytes of a file of cells.
pub fn source(path: &Path) -> Result<Arc<dyn CellSource>, Fault> {
    let file = File::open(path).map_err(|e| Fault::read(path, &e, "a file of cells"))?;
    Ok(Arc::new(Placed::new(file)))
}

/// An error with the file's name.
pub fn fault(path: &Path, error: &CellsError) -> Fault {
    let cause = if matches!(error, CellsError::Io(_)) { Cause::Io } else { Cause::BadInput };
    Fault::new(cause, format_args!("{}: {error}", path.display()))
}

/// A file of cells that is being cut, under the name `OUT.partial`. It stays when the cutting ends early, so that the
/// next one goes on.
pub struct Partial {
    pub file: Placed,
    path: PathBuf,
    out: PathBuf,
}

impl Partial {
    /// Goes on with the file that is there, if it was begun for the same DEM and cells; or else begins anew.
    pub fn begin(path: &Path, out: &Path, cutter: &Cutter) -> Result<Self, Fault> {
        let refuse = |e| Fault::write(path, e);
        let file = open_locked(path)?;
        let partial = Self { file: Placed::new(file), path: path.to_owned(), out: out.to_owned() };
        if !cutter.began(&partial.file) {
            partial.clear(cutter.file_bytes()).map_err(refuse)?;
            partial.write_at(0, &cutter.header_bytes())?;
        }
        Ok(partial)
    }

    fn clear(&self, bytes: u64) -> io::Result<()> {
        self.file.file.set_len(0)?;
        self.file.file.set_len(bytes)
    }

    pub fn write_at(&self, at: u64, bytes: &[u8]) -> Result<(), Fault> {
        self.file.write_at(at, bytes).map_err(|e| Fault::write(&self.path, e))
    }

    /// Removes the file: some of it may be of other heights than the next cut will find.
    pub fn discard(&self) {
        // If it stays, the next cut compares it height by height.
        let _ = fs::remove_file(&self.path);
    }

    /// The file takes its name, whole.
    pub fn finish(self) -> Result<(), Fault> {
        // A full disk may show only here, and a rename must never outlive the bytes that it promises.
        let done = self.file.file.sync_all().and_then(|()| fs::rename(&self.path, &self.out));
        done.map_err(|e| Fault::write(&self.out, e))
    }
}

/// Opens a file for one writer. Who held it before may have given it the name `OUT` between opening and locking: it is
/// no longer ours to write to then, and another takes its place.
fn open_locked(path: &Path) -> Result<File, Fault> {
    let refuse = |e| Fault::write(path, e);
    loop {
        let file = File::options().read(true).write(true).create(true).truncate(false).open(path).map_err(refuse)?;
        if is_taken(file.try_lock()) {
            let message = format_args!("{} is being written by another program; wait for it", path.display());
            return Err(Fault::new(Cause::Io, message));
        }
        if has_name(&file, path).map_err(refuse)? {
            return Ok(file);
        }
    }
}

/// Where a file system knows no locks, nobody can be kept out: that is no reason to refuse.
fn is_taken(locked: Result<(), TryLockError>) -> bool {
    matches!(locked, Err(TryLockError::WouldBlock))
}

/// Whether the file at a path is this one.
#[cfg(unix)]
fn has_name(file: &File, path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let file = file.metadata()?;
    match path.metadata() {
        Ok(named) => Ok((named.dev(), named.ino()) == (file.dev(), file.ino())),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(e) => Err(e),
    }
}

/// Whether there is a file at a path: which one, the standard library does not say here.
#[cfg(not(unix))]
fn has_name(_: &File, path: &Path) -> io::Result<bool> {
    path.try_exists()
}

/// `OUT.partial`, in the same folder, so that the rename stays within one file system.
pub fn partial_of(out: &Path) -> Result<PathBuf, Fault> {
    let Some(name) = out.file_name().filter(|_| !out.is_dir()) else {
        return Err(Fault::write(out, "expected a path that ends in a file name"));
    };
    let mut name = name.to_owned();
    name.push(".partial");
    Ok(out.with_file_name(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_system_without_locks_is_not_another_program() {
        assert!(!is_taken(Err(TryLockError::Error(io::ErrorKind::Unsupported.into()))));
        assert!(is_taken(Err(TryLockError::WouldBlock)) && !is_taken(Ok(())));
    }

    #[cfg(unix)]
    #[test]
    fn a_partial_that_was_renamed_before_it_was_locked_is_left_alone() {
        let place = tempfile::tempdir().unwrap();
        let [partial, out] = ["a.cells.partial", "a.cells"].map(|name| place.path().join(name));
        let opened = open_locked(&partial).unwrap();
        assert!(has_name(&opened, &partial).unwrap());
        fs::rename(&partial, &out).unwrap();
        assert!(!has_name(&opened, &partial).unwrap(), "no file has the name");
        let other = open_locked(&partial).unwrap();
        assert!(!has_name(&opened, &partial).unwrap() && has_name(&other, &partial).unwrap(), "another has it");
    }
}
