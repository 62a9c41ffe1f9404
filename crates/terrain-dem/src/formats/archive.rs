//! One file in a gzip or zip: tiles are published so. It is unpacked in memory.

use std::io::{Cursor, Read};

use flate2::Crc;
use flate2::read::{DeflateDecoder, MultiGzDecoder};

use crate::DemError;
use crate::input::Input;

/// With deflate, the only method there is.
const GZIP: &[u8] = b"\x1f\x8b\x08";
const ZIP: &[u8] = b"PK\x03\x04";

/// Where a zip's list of files may end at the latest: its last record, and a comment of 64 KiB.
const MAX_END: u64 = 22 + 65_535;

/// The most that is read of the list of files, in bytes: it is one that we unpack, not a library.
const MAX_LIST: u64 = 1 << 20;

pub fn is_one(input: &Input) -> bool {
    input.start.starts_with(GZIP) || input.start.starts_with(ZIP)
}

/// The file in an archive, of at most `limit` bytes.
pub fn unpack(mut input: Input, limit: u64) -> Result<Input, DemError> {
    if input.start.starts_with(ZIP) {
        return unzip(input, limit);
    }
    let name = input.file_name.trim_end_matches(".gz").trim_end_matches(".GZ").to_owned();
    let file = input.from(0)?;
    let bytes = read_within(MultiGzDecoder::new(file), limit);
    finish(input, name, bytes, limit)
}

fn unzip(mut input: Input, limit: u64) -> Result<Input, DemError> {
    let file = the_file(&mut input)?;
    // The list and the file's own header differ in what they add to the name.
    let header = input.bytes_at(file.offset, 30)?;
    if !header.starts_with(ZIP) {
        return Err(input.refuse("a zip whose list points elsewhere; expected a whole zip: fetch it again"));
    }
    let [name, extra] = [26, 28].map(|at| u16::from_le_bytes([header[at], header[at + 1]]) as u64);
    let packed = input.bytes_at(file.offset + 30 + name + extra, file.packed_bytes)?;
    if file.bytes > limit {
        return Err(too_long(&input, limit));
    }
    // One byte more than the list says shows that it is wrong.
    let limit = file.bytes;
    let bytes = match file.method {
        0 => read_within(Cursor::new(packed), limit),
        8 => read_within(DeflateDecoder::new(Cursor::new(packed)), limit),
        method => return Err(input.refuse(format!("a zip of method {method}; expected deflate: unzip it"))),
    };
    if let Ok(bytes) = &bytes
        && (bytes.len() as u64 != file.bytes || !cfg!(fuzzing) && crc(bytes) != file.crc)
    {
        return Err(
            input.refuse("a zip whose file has other bytes than its list says; expected a whole zip: fetch it again")
        );
    }
    finish(input, file.name, bytes, limit)
}

fn crc(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

fn too_long(input: &Input, limit: u64) -> DemError {
    input.refuse(format!("an archive of more than {limit} bytes; expected at most that: unpack it"))
}

/// One byte beyond the limit, so that what is too long can be told.
fn read_within(file: impl Read, limit: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map(|_| bytes)
}

fn finish(input: Input, name: String, bytes: std::io::Result<Vec<u8>>, limit: u64) -> Result<Input, DemError> {
    let bytes =
        bytes.map_err(|e| input.refuse(format!("a broken archive ({e}); expected a whole one: fetch it again")))?;
    if bytes.len() as u64 > limit {
        return Err(too_long(&input, limit));
    }
    let name = name.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
    let shown = format!("{}, {}", input.shown, name.escape_debug());
    Input::memory(shown, name, bytes)
}

/// One line of a zip's list.
struct Packed {
    name: String,
    method: u16,
    crc: u32,
    packed_bytes: u64,
    bytes: u64,
    offset: u64,
}

/// The only file of the zip, or its only `.hgt`, `.tif`, `.asc`.
fn the_file(input: &mut Input) -> Result<Packed, DemError> {
    let mut files = list(input)?;
    files.retain(|file| !file.name.ends_with('/'));
    if files.iter().any(|file| file.name.to_lowercase().ends_with(".prj")) {
        let reason =
            "a zip with a .prj, which says in what unit the cells are; expected the files themselves: unzip it";
        return Err(input.refuse(reason));
    }
    if files.len() > 1 {
        let is_dem = |file: &Packed| {
            let name = file.name.to_lowercase();
            [".hgt", ".tif", ".tiff", ".asc"].iter().any(|ending| name.ends_with(ending))
        };
        files.retain(is_dem);
    }
    match files.pop() {
        Some(file) if files.is_empty() => Ok(file),
        _ => Err(input.refuse("a zip that does not hold exactly one .hgt, .tif or .asc; expected one: unzip it")),
    }
}

/// The list at a zip's end (PKWARE APPNOTE 4.3.12 and 4.3.16). Zips beyond 4 GiB are not read.
fn list(input: &mut Input) -> Result<Vec<Packed>, DemError> {
    let broken = "a zip that ends without its list of files; expected a whole zip: fetch it again";
    let tail_from = input.length.saturating_sub(MAX_END);
    let tail = input.bytes_at(tail_from, input.length - tail_from)?;
    let end =
        tail.windows(22).rposition(|window| window.starts_with(b"PK\x05\x06")).ok_or_else(|| input.refuse(broken))?;
    let (length, offset) = (u32_at(&tail, end + 12) as u64, u32_at(&tail, end + 16) as u64);
    if length > MAX_LIST {
        return Err(input.refuse("a zip of too many files; expected a single .hgt: unzip it"));
    }
    let list = input.bytes_at(offset, length)?;
    let (mut files, mut rest) = (Vec::new(), list.as_slice());
    while rest.len() >= 46 && rest.starts_with(b"PK\x01\x02") {
        let [name, extra, comment] = [28, 30, 32].map(|at| u16_at(rest, at) as usize);
        let Some(name_bytes) = rest.get(46..46 + name) else { break };
        files.push(Packed {
            name: String::from_utf8_lossy(name_bytes).into_owned(),
            method: u16_at(rest, 10),
            crc: u32_at(rest, 16),
            packed_bytes: u32_at(rest, 20) as u64,
            bytes: u32_at(rest, 24) as u64,
            offset: u32_at(rest, 42) as u64,
        });
        rest = rest.get(46 + name + extra + comment..).unwrap_or_default();
    }
    Ok(files)
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}
