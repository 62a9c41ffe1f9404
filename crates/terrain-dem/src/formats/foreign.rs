//! Files that people have and that are not read: named for what they are, with the way out.

use crate::formats::convert;
use crate::input::Input;

/// First bytes, and what a file that begins so is.
const CONVERTIBLE: [(&[u8], &str); 10] = [
    (b"HDR1", "a DTED tile with the labels of a tape"),
    (b"CDF\x01", "a NetCDF file"),
    (b"CDF\x02", "a NetCDF file"),
    (b"\x89HDF", "an HDF5 or NetCDF file"),
    (b"EHFA_HEADER_TAG", "an ERDAS Imagine file"),
    (b"\x00\x00\x00\x0cjP  ", "a JPEG 2000 picture"),
    (b"Lerc", "a LERC blob"),
    (b"CntZImage", "a LERC blob"),
    (b"DSBB", "a Surfer grid"),
    (b"DSRB", "a Surfer grid"),
];

const OTHERS: [(&[u8], &str); 9] = [
    (b"LASF", "a LAS point cloud; expected a grid: rasterise it first"),
    (b"\xff\xd8\xff", "a JPEG picture, which holds no heights"),
    (b"GIF8", "a GIF picture, which holds no heights"),
    (b"%PDF", "a PDF"),
    (b"ply\n", "a PLY mesh; expected a grid"),
    (b"version https://git-lfs", "a Git LFS pointer; expected the file itself: git lfs pull"),
    (b"7z\xbc\xaf", "a 7z archive; expected the file in it: unpack it"),
    (b"BZh", "a bzip2 archive; expected the file in it: unpack it"),
    (b"\xfd7zXZ", "an xz archive; expected the file in it: unpack it"),
];

/// Why a file that is of no known format is refused.
pub fn reason(input: &Input, expected: &str) -> String {
    let start = input.start.as_slice();
    let starts = |magic: &[u8]| start.starts_with(magic);
    if start.is_empty() {
        return format!("an empty file; expected {expected}");
    }
    if let Some((_, what)) = CONVERTIBLE.iter().find(|(magic, _)| starts(magic)) {
        return format!("{what}; expected {expected}: {}", convert(&input.shown));
    }
    if let Some((_, what)) = OTHERS.iter().find(|(magic, _)| starts(magic)) {
        return (*what).to_owned();
    }
    let text = String::from_utf8_lossy(start).trim_start().to_lowercase();
    if text.starts_with("<!doctype html") || text.starts_with("<html") {
        return "a web page, perhaps one that asks to log in; expected the file itself: fetch it again".to_owned();
    }
    if text.starts_with("<vrtdataset") {
        return format!("a GDAL virtual raster; expected {expected}: {}", convert(&input.shown));
    }
    if start.iter().all(|byte| *byte == 0) {
        return format!("starts with {} zero bytes; expected {expected}: fetch it again", start.len());
    }
    let shown = start[..start.len().min(12)].escape_ascii();
    format!("of no known format (starts with \"{shown}\"); expected {expected}, or --raw for samples without a header")
}
