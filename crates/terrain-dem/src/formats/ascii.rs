//! ESRI ASCII grid (`.asc`): keys and values, then one number a cell, the northern row first.
//!
//! Dialects: corner or centre of the first cell, `dx` and `dy` in place of `cellsize`, keys in any order and spelling,
//! no `NODATA_value`, wrapped lines, tabs, CRLF, a byte order mark.

use crate::DemError;
use crate::formats::keys::Keys;
use crate::formats::place;
use crate::formats::words::WordGrid;
use crate::input::Input;
use crate::raster::Facts;
use crate::samples::SampleType;

/// The void of a grid that declares none (ESRI's documentation of the format).
const DEFAULT_NODATA: f64 = -9999.0;

/// Longer headers are not read.
const MAX_HEADER: u64 = 4096;

const KEYS: [&str; 10] =
    ["ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "dx", "dy", "nodata_value"];

pub fn is_one(input: &Input) -> bool {
    let start = String::from_utf8_lossy(&input.start);
    let first = start.trim_start_matches('\u{feff}').split_ascii_whitespace().next().unwrap_or_default();
    KEYS.contains(&first.to_lowercase().as_str())
}

pub fn open(mut input: Input) -> Result<WordGrid, DemError> {
    let start = input.bytes_at(0, input.length.min(MAX_HEADER))?;
    let (header, first_byte) = header(&start);
    let keys = Keys::parse(&header);
    keys.check_numbers(&KEYS).map_err(|reason| input.refuse(format!("ESRI ASCII grid: {reason}")))?;
    let cells = |key: &str| keys.cells(key).map_err(|reason| input.refuse(format!("ESRI ASCII grid: {reason}")));
    let mut facts = Facts::new("ESRI ASCII grid", cells("ncols")?, cells("nrows")?, SampleType::Text);
    facts.nodata = keys.number("nodata_value").or(Some(DEFAULT_NODATA));
    place::set(&mut facts, &keys, &input);
    WordGrid::new(input, facts, first_byte as u64)
}

/// The lines that begin with a letter, and the byte after them.
fn header(start: &[u8]) -> (String, usize) {
    let mut end = 0;
    for line in start.split_inclusive(|byte| *byte == b'\n') {
        let first = line.iter().find(|byte| byte.is_ascii_graphic()).copied().unwrap_or(b'x');
        // NaN may be the first height.
        if !first.is_ascii_alphabetic()
            || line.trim_ascii_start().get(..3).is_some_and(|w| w.eq_ignore_ascii_case(b"nan"))
        {
            break;
        }
        end += line.len();
    }
    (String::from_utf8_lossy(&start[..end]).into_owned(), end)
}
