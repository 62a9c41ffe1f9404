//! Errors that say where in a text file they are.

use std::fmt;
use std::ops::Range;

use serde::de::DeserializeOwned;

/// The text of a TOML file that a person wrote, and its name in messages.
#[derive(Clone, Copy, Debug)]
pub struct SourceText<'a> {
    /// Path or other name, as the user knows it.
    pub name: &'a str,
    /// The whole text.
    pub text: &'a str,
}

/// A place in a text, both counted from 1; columns count characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineColumn {
    /// Line, from 1.
    pub line: usize,
    /// Character in the line, from 1.
    pub column: usize,
}

/// What is wrong, and where; displayed in one line as `FILE:LINE:COLUMN: reason`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{source_name}:{position}: {reason}")]
pub struct SourceError {
    /// Name of the file.
    pub source_name: String,
    /// Where in the file; its first character if the whole file is meant.
    pub position: LineColumn,
    /// What was found, what was expected.
    pub reason: String,
}

impl SourceText<'_> {
    /// Reads the text as TOML; the error stands where the TOML is wrong.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, SourceError> {
        toml::from_str(self.text).map_err(|e| {
            // An error without a place means the file as a whole, such as a key that it lacks.
            self.error(e.span().unwrap_or(0..0), e.message().replace('\n', " "))
        })
    }

    /// An error at the start of a range of bytes.
    pub fn error(&self, span: Range<usize>, reason: String) -> SourceError {
        SourceError { source_name: self.name.to_owned(), position: self.position(span.start), reason }
    }

    /// Line and column of a byte.
    pub fn position(&self, byte: usize) -> LineColumn {
        let before = &self.text[..self.text.floor_char_boundary(byte)];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        LineColumn { line: before.matches('\n').count() + 1, column: before[line_start..].chars().count() + 1 }
    }
}

impl fmt::Display for LineColumn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}
