use std::io;
use std::path::{Path, PathBuf};

use terrain_core::source::SourceError;

/// Why a DEM could not be read or a file not be written; one line each.
#[derive(Debug, thiserror::Error)]
pub enum DemError {
    /// The operating system refused.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// "read" or "write".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
    /// The file is not what was expected.
    #[error("{file}: {reason}")]
    Input {
        /// The file as the user knows it.
        file: String,
        /// What was found, what was expected, what to do.
        reason: String,
    },
    /// The sidecar is wrong at a line and column.
    #[error(transparent)]
    Sidecar(#[from] SourceError),
}

impl DemError {
    /// Whether the operating system failed (exit code 6), rather than the input (exit code 4).
    pub fn is_io(&self) -> bool {
        matches!(self, Self::Io { .. })
    }

    pub(crate) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), source }
    }

    pub(crate) fn input(file: &str, reason: String) -> Self {
        Self::Input { file: file.to_owned(), reason }
    }
}
