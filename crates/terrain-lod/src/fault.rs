//! What ends the program early: one line for the user, and an exit code for the script.

use std::fmt::{self, Display};
use std::path::Path;

use terrain_core::{FlightError, ViewError};
use terrain_dem::DemError;
use terrain_renderer::RenderError;

/// Whose fault it was. The numbers are the exit codes that the README documents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Cause {
    /// A run failed, or we did.
    Failure = 1,
    /// The command line.
    Usage = 2,
    /// `cmp --fail-on`: something is worse.
    Regression = 3,
    /// A DEM, flight or suite that cannot be used.
    BadInput = 4,
    /// The adapter or the GPU.
    Gpu = 5,
    /// The file system.
    Io = 6,
    /// Ctrl-C.
    Interrupted = 130,
}

/// An error that has reached the user.
#[derive(Clone, Debug)]
pub struct Fault {
    /// Whose it was: the exit code.
    pub cause: Cause,
    message: String,
}

impl Fault {
    /// One line: what was found, what was expected, what to do. It stays one whatever a file says that it quotes.
    pub fn new(cause: Cause, message: impl Display) -> Self {
        Self { cause, message: message.to_string().replace(char::is_control, " ") }
    }

    /// A value on the command line that cannot be used.
    pub fn usage(message: impl Display) -> Self {
        Self::new(Cause::Usage, message)
    }

    /// A file that we could not write.
    pub fn write(path: &Path, error: impl Display) -> Self {
        Self::new(Cause::Io, format_args!("cannot write {}: {error}; choose another place", path.display()))
    }

    /// A text file that we could not read: one that is not there is bad input, all else is the file system's.
    pub fn read(path: &Path, error: &std::io::Error, expected: &str) -> Self {
        let cause = match error.kind() {
            std::io::ErrorKind::NotFound | std::io::ErrorKind::InvalidData => Cause::BadInput,
            _ => Cause::Io,
        };
        Self::new(cause, format_args!("cannot read {}: {error}; expected {expected}", path.display()))
    }
}

impl Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl From<ViewError> for Fault {
    fn from(error: ViewError) -> Self {
        Self::new(Cause::BadInput, error)
    }
}

impl From<FlightError> for Fault {
    fn from(error: FlightError) -> Self {
        Self::new(Cause::BadInput, error)
    }
}

impl From<DemError> for Fault {
    fn from(error: DemError) -> Self {
        Self::new(if error.is_io() { Cause::Io } else { Cause::BadInput }, error)
    }
}

impl From<RenderError> for Fault {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Png { .. } => Self::new(Cause::Io, error),
            RenderError::UnknownBackend(_) => Self::new(Cause::Usage, error),
            _ => Self::new(Cause::Gpu, error),
        }
    }
}
