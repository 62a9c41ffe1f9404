//! NumPy arrays (`.npy`): a dictionary in Python's spelling, then the samples (NEP 1).

use crate::DemError;
use crate::formats::packed::{PackedGrid, Rows};
use crate::input::Input;
use crate::raster::Facts;
use crate::samples::{ByteOrder, Packing, SampleType};

pub const MAGIC: &[u8] = b"\x93NUMPY";

/// Longer headers are not read, in bytes.
const MAX_HEADER: u64 = 1 << 16;

pub fn open(mut input: Input) -> Result<PackedGrid, DemError> {
    let (header, first_byte) = header(&mut input)?;
    let (packing, rows, columns) = parse(&header).map_err(|reason| input.refuse(format!("a .npy file: {reason}")))?;
    let facts = Facts::new("NumPy array (.npy)", columns, rows, packing.samples);
    let row_bytes = columns as u64 * packing.stride as u64;
    PackedGrid::new(input, facts, Rows { packing, first_byte, row_bytes })
}

/// The dictionary, and the byte after it.
fn header(input: &mut Input) -> Result<(String, u64), DemError> {
    let (length, from) = match input.start.get(6..12) {
        Some(&[1, _, low, high, ..]) => (u16::from_le_bytes([low, high]) as u64, 10),
        Some(&[2 | 3, _, a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]) as u64, 12),
        Some(&[version, ..]) => return Err(input.refuse(format!("a .npy file of version {version}; expected 1 to 3"))),
        _ => return Err(input.refuse("a .npy file that ends in its header; expected a whole file: save it again")),
    };
    if length > MAX_HEADER {
        return Err(input.refuse(format!("a .npy header of {length} bytes; expected at most {MAX_HEADER}")));
    }
    let header = String::from_utf8_lossy(&input.bytes_at(from, length)?).into_owned();
    Ok((header, from + length))
}

/// `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2), }`
fn parse(header: &str) -> Result<(Packing, u32, u32), String> {
    let value = |key: &str| {
        let after = header.split_once(&format!("'{key}':"))?.1;
        Some(after.trim_start())
    };
    let kind = value("descr").and_then(|v| v.strip_prefix('\'')?.split('\'').next()).unwrap_or_default();
    let Some(packing) = packing(kind) else {
        let kind = kind.escape_debug();
        return Err(format!("of type '{kind}'; expected integers or floats: save it as a.astype('float32')"));
    };
    if !value("fortran_order").is_some_and(|v| v.starts_with("False")) {
        return Err("in Fortran order; expected rows: save it as numpy.ascontiguousarray(a)".to_owned());
    }
    let shape = value("shape").and_then(|v| v.strip_prefix('(')?.split(')').next()).unwrap_or_default();
    let sides: Option<Vec<u32>> =
        shape.split(',').map(str::trim).filter(|side| !side.is_empty()).map(|side| side.parse().ok()).collect();
    match sides.as_deref() {
        Some(&[rows, columns]) => Ok((packing, rows, columns)),
        _ => Err(format!("of shape ({}); expected (rows, columns)", shape.escape_debug())),
    }
}

fn packing(kind: &str) -> Option<Packing> {
    let order = match kind.get(..1)? {
        ">" => ByteOrder::Big,
        "<" | "|" => ByteOrder::Little,
        _ => return None,
    };
    let samples = match kind.get(1..)? {
        "u1" => SampleType::U8,
        "i1" => SampleType::I8,
        "u2" => SampleType::U16,
        "i2" => SampleType::I16,
        "u4" => SampleType::U32,
        "i4" => SampleType::I32,
        "u8" => SampleType::U64,
        "i8" => SampleType::I64,
        "f2" => SampleType::F16,
        "f4" => SampleType::F32,
        "f8" => SampleType::F64,
        _ => return None,
    };
    Some(Packing { samples, order, stride: samples.bytes() })
}
