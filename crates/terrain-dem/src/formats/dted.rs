//! DTED tiles (MIL-PRF-89020B): three headers of fixed length, then one record a column, the western one first, each
//! from south to north.

use crate::DemError;
use crate::georef::Spacing;
use crate::input::Input;
use crate::raster::{Facts, Grid, Heights};
use crate::samples::SampleType;

pub const MAGIC: &[u8] = b"UHL1";

/// The headers together: UHL, DSI, ACC.
const HEADERS: u64 = 80 + 648 + 2700;

/// In each record before its samples (mark, counts) and after them (checksum).
const BEFORE: u64 = 8;
const AFTER: u64 = 4;

/// The first byte of a record.
const MARK: u8 = 0xaa;

pub struct DtedGrid {
    input: Input,
    facts: Facts,
}

pub fn open(input: Input) -> Result<DtedGrid, DemError> {
    let Some(facts) = facts(&input.start) else {
        return Err(
            input.refuse("a DTED tile with a broken header; expected intervals and counts in digits: fetch it again")
        );
    };
    let needed = HEADERS + facts.columns as u64 * (BEFORE + facts.rows as u64 * 2 + AFTER);
    if needed > input.length {
        let (Facts { columns, rows, .. }, length) = (&facts, input.length);
        let reason =
            format!("a DTED tile of {length} bytes; expected {needed} for {columns} x {rows} samples: fetch it again");
        return Err(input.refuse(reason));
    }
    Ok(DtedGrid { input, facts })
}

/// By the User Header Label (table II of the specification).
fn facts(header: &[u8]) -> Option<Facts> {
    let text = std::str::from_utf8(header.get(..80)?).ok()?;
    let number = |from: usize, to: usize| text.get(from..to)?.trim().parse::<u32>().ok();
    // Tenths of arc-seconds.
    let [step_x, step_z] = [number(20, 24)?, number(24, 28)?].map(|tenths| tenths as f64 / 36_000.0);
    let mut facts = Facts::new("DTED tile", number(47, 51)?, number(51, 55)?, SampleType::I16);
    // DDDMMSSH, of the south-western sample.
    let south = number(12, 15)? as f64 + number(15, 17)? as f64 / 60.0 + number(17, 19)? as f64 / 3600.0;
    let south = if text.as_bytes()[19] == b'S' { -south } else { south };
    let latitude = south + facts.rows.saturating_sub(1) as f64 * step_z / 2.0;
    facts.spacing = Some(Spacing::Degrees { degrees: [step_x, step_z], latitude });
    facts.nodata = Some(-32_767.0);
    facts.crs = Some("EPSG:4326 (as all DTED)".to_owned());
    Some(facts)
}

impl Grid for DtedGrid {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn decode(&mut self, heights: &mut Heights) -> Result<(), DemError> {
        let rows = self.facts.rows;
        let length = BEFORE + rows as u64 * 2 + AFTER;
        let mut record = Vec::new();
        for column in 0..self.facts.columns {
            self.input.read_at(HEADERS + column as u64 * length, length, &mut record)?;
            if record[0] != MARK {
                return Err(self.input.refuse(format!(
                    "a DTED tile whose record {column} begins with {}; expected {MARK}: fetch it again",
                    record[0]
                )));
            }
            for (i, sample) in record[BEFORE as usize..].as_chunks().0.iter().take(rows as usize).enumerate() {
                heights.put(rows - 1 - i as u32, column, std::iter::once(signed(*sample)));
            }
        }
        Ok(())
    }
}

/// The highest bit is the sign of the others.
fn signed(bytes: [u8; 2]) -> f64 {
    let bits = u16::from_be_bytes(bytes);
    let magnitude = (bits & 0x7fff) as f64;
    if bits >> 15 == 1 { -magnitude } else { magnitude }
}
