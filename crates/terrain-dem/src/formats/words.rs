//! Grids written as text: one number after the other, however the lines are wrapped.

use std::io::BufRead;

use crate::DemError;
use crate::input::Input;
use crate::raster::{Facts, Grid, Heights};

/// The longest number that is read; longer ones are no numbers.
const MAX_WORD: usize = 64;

pub struct WordGrid {
    input: Input,
    facts: Facts,
    first_byte: u64,
}

impl WordGrid {
    /// Refuses a header that promises more numbers than the file has room for: a digit and a blank each.
    pub fn new(input: Input, facts: Facts, first_byte: u64) -> Result<Self, DemError> {
        let room = input.length.saturating_sub(first_byte).div_ceil(2);
        if facts.count() > room {
            let Facts { format, columns, rows, .. } = &facts;
            let reason = format!(
                "{format} of {} bytes; expected {columns} x {rows} numbers, which need more: fetch it again",
                input.length
            );
            return Err(input.refuse(reason));
        }
        Ok(Self { input, facts, first_byte })
    }
}

impl Grid for WordGrid {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn decode(&mut self, heights: &mut Heights) -> Result<(), DemError> {
        let Facts { columns, rows, .. } = self.facts;
        let (count, mut read) = (self.facts.count(), 0);
        let mut row_values = Vec::with_capacity(columns as usize);
        let mut wrong = None;
        let file = self.input.from(self.first_byte)?;
        let ended = each_word(file, |word| {
            match std::str::from_utf8(word).ok().filter(|word| word.len() <= MAX_WORD).and_then(number) {
                Some(value) if read < count => row_values.push(value),
                Some(_) => {
                    wrong = Some(format!(
                        "more than {columns} x {rows} numbers; expected as many as the header says: mend it"
                    ))
                }
                None => {
                    let (column, row) = (read % columns as u64, read / columns as u64);
                    let found = word[..word.len().min(20)].escape_ascii();
                    wrong = Some(format!("\"{found}\" at column {column}, row {row}; expected a number"));
                }
            }
            read += 1;
            if row_values.len() == columns as usize {
                heights.put((read / columns as u64) as u32 - 1, 0, row_values.drain(..));
            }
            wrong.is_none()
        });
        ended.map_err(|e| self.input.read_error(e))?;
        match wrong {
            Some(reason) => Err(self.input.refuse(reason)),
            None if read < count => {
                let reason = format!("ends after {read} of {count} numbers; expected a whole file: fetch it again");
                Err(self.input.refuse(reason))
            }
            None => Ok(()),
        }
    }
}

/// Calls with each word until that says false; a word beyond [`MAX_WORD`] comes cut, one byte too long.
fn each_word(file: &mut dyn BufRead, mut take: impl FnMut(&[u8]) -> bool) -> std::io::Result<()> {
    let mut word = Vec::with_capacity(MAX_WORD);
    loop {
        let bytes = file.fill_buf()?;
        let (length, is_last) = (bytes.len(), bytes.is_empty());
        for &byte in bytes {
            if !byte.is_ascii_whitespace() && byte != 0 {
                if word.len() <= MAX_WORD {
                    word.push(byte);
                }
            } else if !word.is_empty() {
                if !take(&word) {
                    return Ok(());
                }
                word.clear();
            }
        }
        file.consume(length);
        if is_last {
            if !word.is_empty() {
                take(&word);
            }
            return Ok(());
        }
    }
}

/// A number as grids spell it: also `nan`, `1.#QNAN` (Windows), and `1,5` in no way.
pub fn number(word: &str) -> Option<f64> {
    let is_windows_nan = || word.contains("#QNAN") || word.contains("#IND") || word.contains("#INF");
    word.parse().ok().or_else(|| is_windows_nan().then_some(f64::NAN))
}
