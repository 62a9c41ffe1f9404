//! Samples in one file, their layout in a `.hdr` beside it: `.bil` (ESRI's band formats) and `.flt` (GridFloat).

use std::path::PathBuf;

use crate::DemError;
use crate::formats::keys::Keys;
use crate::formats::packed::{PackedGrid, Rows};
use crate::formats::place;
use crate::input::Input;
use crate::raster::Facts;
use crate::samples::{ByteOrder, Packing, SampleType};

/// What the files of samples are called.
const SAMPLES: [&str; 6] = ["bil", "flt", "bip", "bsq", "bin", "dem"];

/// The keys of a header that are numbers, whole or not.
const NUMBERS: [&str; 9] =
    ["cellsize", "xdim", "ydim", "xllcorner", "yllcorner", "ulxmap", "ulymap", "nodata", "nodata_value"];

/// Longer headers are not read, in bytes.
const MAX_HEADER: u64 = 1 << 16;

/// The header that goes with a file of samples, if there is one.
pub fn header_of(input: &Input) -> Option<PathBuf> {
    input.sibling(&["hdr"]).filter(|_| input.ending() != "hdr")
}

/// Whether the file is a header itself.
pub fn is_header(input: &Input) -> bool {
    input.ending() == "hdr" && input.start.is_ascii()
}

/// Opens the samples that a header goes with.
pub fn open_by_header(header: &Input) -> Result<PackedGrid, DemError> {
    let Some(samples) = header.sibling(&SAMPLES) else {
        let reason = "a header without samples; expected a .bil or .flt file of the same name beside it";
        return Err(header.refuse(reason));
    };
    open(Input::open(&samples)?, header.path.clone().expect("a header with a sibling has a path"))
}

pub fn open(input: Input, header: PathBuf) -> Result<PackedGrid, DemError> {
    let mut header = Input::open(&header)?;
    let text = header.text(MAX_HEADER)?;
    if text.starts_with("ENVI") {
        let reason = format!("an ENVI header; expected one by ESRI: {}", super::convert(&input.shown));
        return Err(header.refuse(reason));
    }
    let keys = Keys::parse(&text);
    keys.check_numbers(&NUMBERS).map_err(|reason| header.refuse(reason))?;
    let layout = Layout::of(&keys).map_err(|reason| header.refuse(reason))?;
    let mut facts = Facts::new(layout.format, layout.columns, layout.rows, layout.packing.samples);
    facts.nodata = keys.number("nodata_value").or(keys.number("nodata")).map(|nodata| facts.samples.rounded(nodata));
    if !layout.says_order {
        facts.warnings.push("the header does not say the byte order: the low byte is taken to come first".to_owned());
    }
    place::set(&mut facts, &keys, &input);
    let rows = Rows { packing: layout.packing, first_byte: layout.first_byte, row_bytes: layout.row_bytes };
    PackedGrid::new(input, facts, rows)
}

struct Layout {
    format: &'static str,
    columns: u32,
    rows: u32,
    packing: Packing,
    says_order: bool,
    first_byte: u64,
    row_bytes: u64,
}

impl Layout {
    fn of(keys: &Keys) -> Result<Self, String> {
        let bands = keys.whole("nbands", 1)?;
        if bands != 1 {
            return Err(format!("{bands} bands; expected 1: gdal_translate -b 1 IN OUT.tif"));
        }
        // GridFloat says no more than the size of the grid.
        let is_float = keys.word("nbits").is_none() && keys.word("ulymap").is_none();
        let samples = if is_float { SampleType::F32 } else { band_type(keys)? };
        let (order, says_order) = match keys.word("byteorder").map(str::to_uppercase).as_deref() {
            Some("I" | "LSBFIRST" | "INTEL" | "LITTLE") => (ByteOrder::Little, true),
            Some("M" | "MSBFIRST" | "MOTOROLA" | "BIG") => (ByteOrder::Big, true),
            None => (ByteOrder::Little, samples.bytes() == 1),
            Some(other) => return Err(format!("`byteorder` is {}; expected I or M", other.escape_debug())),
        };
        let columns = keys.cells("ncols")?;
        let packing = Packing { samples, order, stride: samples.bytes() };
        let own_bytes = columns as u64 * samples.bytes() as u64;
        let row_bytes = keys.whole("totalrowbytes", keys.whole("bandrowbytes", own_bytes)?)?;
        if row_bytes < own_bytes {
            return Err(format!("`totalrowbytes` is {row_bytes}; expected at least {own_bytes} for {columns} columns"));
        }
        let format = if is_float { "GridFloat (.flt)" } else { "ESRI band file (.bil)" };
        let (rows, first_byte) = (keys.cells("nrows")?, keys.whole("skipbytes", 0)?);
        Ok(Self { format, columns, rows, packing, says_order, first_byte, row_bytes })
    }
}

/// 16 bits are signed unless the header says otherwise: so are those of the SRTM.
fn band_type(keys: &Keys) -> Result<SampleType, String> {
    let kind = keys.word("pixeltype").unwrap_or_default().to_uppercase();
    match (keys.whole("nbits", 8)?, kind.as_str()) {
        (8, "SIGNEDINT") => Ok(SampleType::I8),
        (8, _) => Ok(SampleType::U8),
        (16, "UNSIGNEDINT") => Ok(SampleType::U16),
        (16, _) => Ok(SampleType::I16),
        (32, "UNSIGNEDINT") => Ok(SampleType::U32),
        (32, "FLOAT") => Ok(SampleType::F32),
        (32, _) => Ok(SampleType::I32),
        (64, "FLOAT") => Ok(SampleType::F64),
        (bits, _) => Err(format!("`nbits` is {bits}; expected 8, 16 or 32, or 64 for floats")),
    }
}
