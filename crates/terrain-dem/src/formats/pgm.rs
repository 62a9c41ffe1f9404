//! Portable greymap (PGM): `P5`, binary with the high byte first, and `P2`, text.

use std::ops::Range;

use crate::DemError;
use crate::formats::packed::{PackedGrid, Rows};
use crate::formats::words::WordGrid;
use crate::input::Input;
use crate::raster::{Facts, Grid};
use crate::samples::{ByteOrder, Packing, SampleType};

const EXPECTED: &str = "width, height and a maximum of 256 to 65535";

pub fn is_one(input: &Input) -> bool {
    matches!(input.start.as_slice(), [b'P', b'2' | b'5', next, ..] if next.is_ascii_whitespace() || *next == b'#')
}

pub fn open(input: Input, allow_8_bit: bool) -> Result<Box<dyn Grid>, DemError> {
    let Some((numbers, end)) = header(&input.start) else {
        return Err(input.refuse(format!("a PGM with a broken header; expected {EXPECTED}: convert it again")));
    };
    let [columns, rows, maximum] = numbers;
    if !(1..=65535).contains(&maximum) {
        return Err(input.refuse(format!("a PGM with a maximum of {maximum}; expected {EXPECTED}: convert it again")));
    }
    if maximum < 256 && !allow_8_bit {
        let reason = "an 8-bit PGM, whose 256 heights show as steps; expected 16 bits, or --allow-8-bit";
        return Err(input.refuse(reason));
    }
    if input.start[1] == b'2' {
        let facts = Facts::new("PGM, text", columns, rows, SampleType::Text);
        return Ok(Box::new(WordGrid::new(input, facts, end as u64)?));
    }
    let samples = if maximum < 256 { SampleType::U8 } else { SampleType::U16 };
    let facts = Facts::new("PGM", columns, rows, samples);
    let packing = Packing { samples, order: ByteOrder::Big, stride: samples.bytes() };
    // A single white space ends the header.
    let rows = Rows { packing, first_byte: end as u64 + 1, row_bytes: columns as u64 * packing.stride as u64 };
    Ok(Box::new(PackedGrid::new(input, facts, rows)?))
}

/// Width, height and maximum, and the byte after them.
fn header(start: &[u8]) -> Option<([u32; 3], usize)> {
    let (mut numbers, mut at) = ([0; 3], 2);
    for number in &mut numbers {
        let word = word(start, at)?;
        *number = std::str::from_utf8(&start[word.clone()]).ok()?.parse().ok()?;
        at = word.end;
    }
    Some((numbers, at))
}

/// The next word, with comments left out, if it ends within the bytes.
fn word(bytes: &[u8], mut at: usize) -> Option<Range<usize>> {
    loop {
        match *bytes.get(at)? {
            b'#' => at += bytes[at..].iter().position(|byte| *byte == b'\n')?,
            byte if byte.is_ascii_whitespace() => at += 1,
            _ => break,
        }
    }
    let length = bytes[at..].iter().position(|byte| byte.is_ascii_whitespace() || *byte == b'#')?;
    Some(at..at + length)
}
