//! Samples and nothing else (`.r16`, `.r32`, `.raw`): the user says what they are.

use crate::formats::packed::{PackedGrid, Rows};
use crate::input::Input;
use crate::raster::Facts;
use crate::samples::Packing;
use crate::{DemError, RawLayout};

pub fn open(input: Input, layout: RawLayout) -> Result<PackedGrid, DemError> {
    let RawLayout { columns, rows, samples, order } = layout;
    let packing = Packing { samples, order, stride: samples.bytes() };
    let row_bytes = columns as u64 * samples.bytes() as u64;
    if row_bytes.checked_mul(rows as u64) != Some(input.length) {
        let reason = format!(
            "{} bytes; expected {columns} x {rows} samples of {} and nothing else: mend --raw",
            input.length,
            samples.name()
        );
        return Err(input.refuse(reason));
    }
    PackedGrid::new(
        input,
        Facts::new("raw samples", columns, rows, samples),
        Rows { packing, first_byte: 0, row_bytes },
    )
}
