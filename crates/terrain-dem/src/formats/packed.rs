//! Grids of samples in plain rows, as many formats hold them behind a header of their own.

use crate::DemError;
use crate::input::Input;
use crate::raster::{Facts, Grid, Heights};
use crate::samples::Packing;

/// Where the rows are.
#[derive(Clone, Copy, Debug)]
pub struct Rows {
    pub packing: Packing,
    /// The first sample of the band that is read.
    pub first_byte: u64,
    /// From one row to the next.
    pub row_bytes: u64,
}

pub struct PackedGrid {
    input: Input,
    facts: Facts,
    rows: Rows,
}

impl PackedGrid {
    /// Refuses a header that promises more than the file holds.
    pub fn new(input: Input, facts: Facts, rows: Rows) -> Result<Self, DemError> {
        let own = own_bytes(&facts, rows.packing);
        let before = rows.row_bytes.checked_mul(facts.rows.saturating_sub(1) as u64);
        let needed = before.and_then(|before| before.checked_add(own)?.checked_add(rows.first_byte));
        if needed.is_none_or(|needed| needed > input.length) {
            let Facts { format, columns, rows, samples, .. } = &facts;
            let needed = needed.map_or("more bytes than any file has".to_owned(), |needed| format!("{needed} bytes"));
            let reason = format!(
                "{format} of {} bytes; expected {needed} for {columns} x {rows} samples of {}: fetch it again",
                input.length,
                samples.name()
            );
            return Err(input.refuse(reason));
        }
        Ok(Self { input, facts, rows })
    }

    /// Bytes from the first sample of the band to the end of the last one, in one row.
    fn row_span(&self) -> u64 {
        own_bytes(&self.facts, self.rows.packing)
    }
}

fn own_bytes(facts: &Facts, packing: Packing) -> u64 {
    // Column counts are 32 bits and strides small, so that this cannot overflow.
    facts.columns.saturating_sub(1) as u64 * packing.stride as u64 + packing.samples.bytes() as u64
}

impl Grid for PackedGrid {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn decode(&mut self, heights: &mut Heights) -> Result<(), DemError> {
        let mut bytes = Vec::new();
        let span = self.row_span();
        let is_dense = span == self.rows.row_bytes && !heights.is_part();
        if is_dense {
            self.input.from(self.rows.first_byte)?;
            bytes.resize(span as usize, 0);
        }
        for row in 0..self.facts.rows {
            if !heights.wants(row..row + 1, 0..self.facts.columns) {
                continue;
            }
            match is_dense {
                true => self.input.read_exact(&mut bytes)?,
                false => {
                    self.input.read_at(self.rows.first_byte + row as u64 * self.rows.row_bytes, span, &mut bytes)?
                }
            }
            self.rows.packing.put(heights, row, 0, &bytes);
            if heights.is_stopped() {
                break;
            }
        }
        Ok(())
    }

    fn is_by_rows(&self) -> bool {
        !self.facts.south_up
    }
}
