//! A file that is being read: its bytes, its length, and its name in messages.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::DemError;

pub trait ReadSeek: BufRead + Seek {}

impl<T: BufRead + Seek> ReadSeek for T {}

/// How much of a file's start tells its format.
const START: u64 = 512;

/// Knows where it is: to ask a file takes a system call, for each strip of a picture.
struct Counted<R> {
    inner: R,
    here: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(bytes)?;
        self.here += count as u64;
        Ok(count)
    }
}

impl<R: BufRead> BufRead for Counted<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.inner.fill_buf()
    }

    fn consume(&mut self, count: usize) {
        self.inner.consume(count);
        self.here += count as u64;
    }
}

impl<R: Seek> Seek for Counted<R> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.here = self.inner.seek(to)?;
        Ok(self.here)
    }

    fn seek_relative(&mut self, step: i64) -> io::Result<()> {
        self.inner.seek_relative(step)?;
        self.here = self.here.wrapping_add_signed(step);
        Ok(())
    }

    fn stream_position(&mut self) -> io::Result<u64> {
        Ok(self.here)
    }
}

pub struct Input {
    /// The file in messages.
    pub shown: String,
    /// The last part of its path: `N44W122.hgt`.
    pub file_name: String,
    /// Where its sidecars are; `None` for what lies in memory or in an archive.
    pub path: Option<PathBuf>,
    /// Its first bytes.
    pub start: Vec<u8>,
    /// In bytes.
    pub length: u64,
    file: Box<dyn ReadSeek>,
}

impl Input {
    pub fn open(path: &Path) -> Result<Self, DemError> {
        let io_error = |e| DemError::io("read", path, e);
        let file = File::open(path).map_err(io_error)?;
        let length = file.metadata().map_err(io_error)?.len();
        let file_name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let file = Box::new(Counted { inner: BufReader::with_capacity(1 << 15, file), here: 0 });
        Self::new(path.display().to_string(), file_name, Some(path.to_owned()), length, file)
    }

    pub fn memory(shown: String, file_name: String, bytes: impl AsRef<[u8]> + 'static) -> Result<Self, DemError> {
        let length = bytes.as_ref().len() as u64;
        Self::new(shown, file_name, None, length, Box::new(Cursor::new(bytes)))
    }

    fn new(
        shown: String,
        file_name: String,
        path: Option<PathBuf>,
        length: u64,
        file: Box<dyn ReadSeek>,
    ) -> Result<Self, DemError> {
        let mut input = Self { shown, file_name, path, start: Vec::new(), length, file };
        input.start = input.bytes_at(0, length.min(START))?;
        Ok(input)
    }

    pub fn refuse(&self, reason: impl Into<String>) -> DemError {
        // Some reasons quote the file or another library.
        DemError::input(&self.shown, reason.into().replace(['\n', '\r'], " "))
    }

    pub fn read_error(&self, error: std::io::Error) -> DemError {
        match error.kind() {
            ErrorKind::UnexpectedEof => self.refuse("ends too soon; expected a whole file: fetch it again"),
            _ => DemError::io("read", Path::new(&self.shown), error),
        }
    }

    /// Whether `count` bytes from `offset` on are in the file.
    pub fn holds(&self, offset: u64, count: u64) -> bool {
        offset.checked_add(count).is_some_and(|end| end <= self.length)
    }

    /// Bytes in the middle of the file. Refuses before it allocates what the file does not hold.
    pub fn bytes_at(&mut self, offset: u64, count: u64) -> Result<Vec<u8>, DemError> {
        let mut bytes = Vec::new();
        self.read_at(offset, count, &mut bytes)?;
        Ok(bytes)
    }

    /// As [`Self::bytes_at`], into a buffer that is used again.
    pub fn read_at(&mut self, offset: u64, count: u64, bytes: &mut Vec<u8>) -> Result<(), DemError> {
        if !self.holds(offset, count) {
            let length = self.length;
            let reason =
                format!("ends at byte {length}; expected {count} more at byte {offset}: fetch or convert it again");
            return Err(self.refuse(reason));
        }
        self.seek(offset)?;
        bytes.resize(count as usize, 0);
        self.file.read_exact(bytes).map_err(|e| self.read_error(e))
    }

    fn seek(&mut self, offset: u64) -> Result<(), DemError> {
        // A step rather than a place: what has been read ahead is kept.
        let here = self.file.stream_position().map_err(|e| self.read_error(e))?;
        match (offset as i64).wrapping_sub(here as i64) {
            0 => Ok(()),
            step => self.file.seek_relative(step).map_err(|e| self.read_error(e)),
        }
    }

    /// The file from a byte on.
    pub fn from(&mut self, offset: u64) -> Result<&mut dyn ReadSeek, DemError> {
        self.seek(offset)?;
        Ok(&mut *self.file)
    }

    /// The next bytes, where the last read ended.
    pub fn read_exact(&mut self, bytes: &mut [u8]) -> Result<(), DemError> {
        self.file.read_exact(bytes).map_err(|e| self.read_error(e))
    }

    /// A text file as a whole, of at most `limit` bytes.
    pub fn text(&mut self, limit: u64) -> Result<String, DemError> {
        if self.length > limit {
            return Err(self.refuse(format!("{} bytes; expected a text of at most {limit}", self.length)));
        }
        let bytes = self.bytes_at(0, self.length)?;
        Ok(String::from_utf8_lossy(&bytes).trim_start_matches('\u{feff}').to_owned())
    }

    /// A file beside this one, of another ending, whichever way it is spelled.
    pub fn sibling(&self, endings: &[&str]) -> Option<PathBuf> {
        let path = self.path.as_ref()?;
        let spellings = endings.iter().flat_map(|ending| [ending.to_string(), ending.to_uppercase()]);
        spellings.map(|ending| path.with_extension(ending)).find(|path| path.is_file())
    }

    /// The ending of the file's name in small letters.
    pub fn ending(&self) -> String {
        self.file_name.rsplit_once('.').map_or(String::new(), |(_, ending)| ending.to_lowercase())
    }
}
