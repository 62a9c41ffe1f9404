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
        let (columns, count) = (self.facts.columns as usize, self.facts.count());
        let mut numbers = Numbers { columns, count, read: 0, row: Vec::with_capacity(columns), heights };
        let mut taken = Ok(());
        let file = self.input.from(self.first_byte)?;
        let ended = each_word(file, |word| {
            taken = numbers.take(word);
            taken.is_ok() && !numbers.heights.is_stopped()
        });
        let (read, is_stopped) = (numbers.read, numbers.heights.is_stopped());
        ended.map_err(|e| self.input.read_error(e))?;
        taken.map_err(|reason| self.input.refuse(reason))?;
        if read < count && !is_stopped {
            let reason = format!("ends after {read} of {count} numbers; expected a whole file: fetch it again");
            return Err(self.input.refuse(reason));
        }
        Ok(())
    }

    fn is_by_rows(&self) -> bool {
        !self.facts.south_up
    }
}

/// The numbers of a text as they come.
struct Numbers<'a, 'h> {
    columns: usize,
    /// How many the header promises.
    count: u64,
    read: u64,
    /// The row that is being filled.
    row: Vec<f64>,
    heights: &'a mut Heights<'h>,
}

impl Numbers<'_, '_> {
    fn take(&mut self, word: &[u8]) -> Result<(), String> {
        let (column, row) = (self.read % self.columns as u64, self.read / self.columns as u64);
        let text = std::str::from_utf8(word).ok().filter(|word| word.len() <= MAX_WORD);
        let Some(value) = text.and_then(number) else {
            let found = word[..word.len().min(20)].escape_ascii();
            return Err(format!("\"{found}\" at column {column}, row {row}; expected a number"));
        };
        if self.read == self.count {
            return Err(format!("more than {} numbers; expected as many as the header says: mend it", self.count));
        }
        self.read += 1;
        self.row.push(value);
        if self.row.len() == self.columns {
            self.heights.put(row as u32, 0, self.row.drain(..));
        }
        Ok(())
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
