//! DTED tiles (MIL-PRF-89020B): three headers of fixed length, then one record a column, the western one first, each
//! from south to north.

use crate::DemError;
use crate::georef::{GeoKeys, Place, Spacing};
use crate::input::Input;
use crate::raster::{Facts, Grid, Heights};
use crate::samples::SampleType;

pub const MAGIC: &[u8] = b"UHL1";

/// The headers together: UHL, DSI, ACC.
const HEADERS: u64 = 80 + 648 + 2700;

/// In each record before its samples (mark, counts) and after them (checksum).
const BEFORE: u64 = 8;
const AFTER: u64 = 4;

/// The specification's void: all bits set.
const VOID: i16 = -32_767;

/// No ground lies lower, in metres; as GDAL has it.
const DEEPEST: i16 = -16_000;

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
    let angle = |at: usize| {
        let parts = [number(at, at + 3)?, number(at + 3, at + 5)?, number(at + 5, at + 7)?].map(f64::from);
        let degrees = parts[0] + parts[1] / 60.0 + parts[2] / 3600.0;
        Some(if matches!(text.as_bytes()[at + 7], b'S' | b'W') { -degrees } else { degrees })
    };
    let (west, south) = (angle(4), angle(12)?);
    let depth = facts.rows.saturating_sub(1) as f64 * step_z;
    let step = [step_x, step_z];
    facts.spacing = Some(Spacing::Degrees { degrees: step, latitude: south + depth / 2.0 });
    facts.place = west.map(|west| Place { west, north: south + depth, step });
    facts.nodata = Some(f64::from(VOID));
    facts.crs = Some("EPSG:4326 (as all DTED)".to_owned());
    facts.keys = Some(GeoKeys::wgs84());
    Some(facts)
}

impl Grid for DtedGrid {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn decode(&mut self, heights: &mut Heights) -> Result<(), DemError> {
        let (rows, mut complements) = (self.facts.rows, 0u64);
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
                let (height, is_complement) = signed(*sample);
                complements += u64::from(is_complement);
                heights.put(rows - 1 - i as u32, column, std::iter::once(height));
            }
        }
        if complements > 0 {
            let note = "below the sea's floor as DTED signs them: taken as two's complement, as some programs write it";
            heights.note(format!("{complements} samples are {note}"));
        }
        Ok(())
    }
}

/// The highest bit is the sign of the others. What would be deeper than [`DEEPEST`] is two's complement, and true.
fn signed(bytes: [u8; 2]) -> (f64, bool) {
    let bits = u16::from_be_bytes(bytes);
    let magnitude = (bits & 0x7fff) as i16;
    let height = if bits >> 15 == 1 { -magnitude } else { magnitude };
    match height < DEEPEST && height != VOID {
        true => (f64::from(bits as i16), true),
        false => (f64::from(height), false),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_of_negative_heights() {
        let cases = [
            (5, (5.0, false)),
            (0x8005, (-5.0, false)),
            (-5i16 as u16, (-5.0, true)),
            (-430i16 as u16, (-430.0, true)),
            (0xffff, (-32_767.0, false)),
            (0x8000, (0.0, false)),
            (0x7fff, (32_767.0, false)),
        ];
        for (bits, expected) in cases {
            assert_eq!(signed(u16::to_be_bytes(bits)), expected, "{bits:x}");
        }
    }
}
