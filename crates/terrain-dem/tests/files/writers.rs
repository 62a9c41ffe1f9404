//! Small files of the other formats.

use std::io::Write;

/// 4 x 3 heights.
pub const GRID: [[i16; 4]; 3] = [[0, 1, -2, 300], [4000, -5, 6, 7], [8, 9, 10, 2_345]];

pub const ASC_HEADER: &str = "ncols 4\nnrows 3\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\n";

/// The numbers of [`GRID`], with something between them and between the rows.
pub fn words(between: &str, rows: &str) -> String {
    GRID.map(|row| row.map(|height| height.to_string()).join(between)).join(rows)
}

pub fn asc() -> String {
    format!("{ASC_HEADER}NODATA_value -9999\n{}\n", words(" ", "\n"))
}

/// An SRTM tile of 5 x 5: the lower its place, the higher its samples.
pub fn hgt() -> Vec<u8> {
    (0..25i16).flat_map(|i| (i * 100).to_be_bytes()).collect()
}

pub fn hgt_of(side: usize) -> Vec<u8> {
    (0..side * side).flat_map(|i| ((i % 4001) as i16).to_be_bytes()).collect()
}

/// The grid as a DTED tile with samples a quarter of a degree apart; its middle is at latitude 45.
pub fn dted() -> Vec<u8> {
    let mut file = b"UHL10070000E0444500N90009000NA  U              00040003".to_vec();
    file.resize(3428, b' ');
    for column in 0..4u8 {
        file.extend([0xaa, 0, 0, column, 0, column, 0, 0]);
        for row in GRID.iter().rev() {
            let height = row[column as usize];
            let sign = if height < 0 { 0x8000 } else { 0 };
            file.extend((height.unsigned_abs() | sign).to_be_bytes());
        }
        file.extend([0; 4]);
    }
    file
}

pub const BIL_HEADER: &str = "BYTEORDER I\nLAYOUT BIL\nNROWS 3\nNCOLS 4\nNBANDS 1\nNBITS 16\nPIXELTYPE SIGNEDINT\n\
                              ULXMAP 500000\nULYMAP 4000000\nXDIM 30\nYDIM 30\nNODATA -9999\n";

pub fn bil() -> Vec<u8> {
    GRID.as_flattened().iter().flat_map(|height| height.to_le_bytes()).collect()
}

pub const FLT_HEADER: &str =
    "ncols 4\nnrows 3\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\nNODATA_value -9999\nbyteorder LSBFIRST\n";

pub fn flt() -> Vec<u8> {
    GRID.as_flattened().iter().flat_map(|height| (*height as f32).to_le_bytes()).collect()
}

pub fn pgm(header: &str) -> Vec<u8> {
    let samples = GRID.as_flattened().iter().flat_map(|height| height.unsigned_abs().to_be_bytes());
    header.bytes().chain(samples).collect()
}

pub fn npy(dictionary: &str, samples: &[u8]) -> Vec<u8> {
    let mut file = b"\x93NUMPY\x01\0".to_vec();
    file.extend((dictionary.len() as u16).to_le_bytes());
    file.extend(dictionary.as_bytes());
    file.extend(samples);
    file
}

pub fn npy_i2() -> Vec<u8> {
    npy("{'descr': '<i2', 'fortran_order': False, 'shape': (3, 4), }\n", &bil())
}

pub fn gzip(plain: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packed.write_all(plain).unwrap();
    packed.finish().unwrap()
}

/// A zip of files, each deflated.
pub fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut out, mut list) = (Vec::new(), Vec::new());
    for (name, plain) in files {
        let mut packed = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::default());
        packed.write_all(plain).unwrap();
        let packed = packed.finish().unwrap();
        let offset = out.len() as u32;
        let mut crc = flate2::Crc::new();
        crc.update(plain);
        let fields = |head: &[u8], extra: &[u8], tail: &[u8]| {
            let mut fields = [head, &20u16.to_le_bytes(), &[0, 0], &8u16.to_le_bytes(), &[0; 4]].concat();
            fields.extend(crc.sum().to_le_bytes());
            fields.extend((packed.len() as u32).to_le_bytes());
            fields.extend((plain.len() as u32).to_le_bytes());
            fields.extend((name.len() as u16).to_le_bytes());
            fields.extend([extra, tail, name.as_bytes()].concat());
            fields
        };
        out.extend(fields(b"PK\x03\x04", &[0, 0], &[]));
        out.extend(&packed);
        list.extend(fields(b"PK\x01\x02\x14\0", &[0; 12], &offset.to_le_bytes()));
    }
    let (offset, length, count) = (out.len() as u32, list.len() as u32, files.len() as u16);
    out.extend(list);
    out.extend([b"PK\x05\x06\0\0\0\0".as_slice(), &count.to_le_bytes(), &count.to_le_bytes()].concat());
    out.extend([length.to_le_bytes(), offset.to_le_bytes()].concat());
    out.extend([0, 0]);
    out
}

/// The grid as a USGS DEM in UTM and feet, in steps of half a foot; its second profile lacks the southern sample and its
/// third one the northern, as those of a quadrangle do. `block` letters a block: 1024, or not as it should be.
pub fn usgs(block: usize) -> Vec<u8> {
    let mut file = Vec::new();
    let mut record = |text: String| {
        let start = file.len();
        file.extend(text.bytes());
        file.resize(start + block, b' ');
    };
    let double = |number: f64| format!("{:>24}", format!("{number:.15e}").replace('e', "D"));
    let header = format!("{:<150}{:>6}{:>6}{:>6}{:<360}", "A QUADRANGLE", 1, 1, 11, "");
    let header = format!("{header}{:>6}{:>6}{:>6}{:<192}{:<48}{:<30}", 2, 1, 4, "", "", "");
    let header = format!("{header}{:>12}{:>12}{:>12}{:>6}{:>6}", "3.000000E+01", "4.000000E+01", "5.000000E-01", 1, 4);
    record(header);
    for (column, east) in [500_000.0, 500_030.0, 500_060.0, 500_090.0].into_iter().enumerate() {
        let (south, north) = (usize::from(column == 1), usize::from(column == 2));
        let rows: Vec<usize> = (north..3 - south).rev().collect();
        let mut text = format!("{:>6}{:>6}{:>6}{:>6}", 1, column + 1, rows.len(), 1);
        text += &double(east);
        text += &double(4_000_000.0 + south as f64 * 40.0);
        // A datum of 10 feet.
        text += &[10.0, 0.0, 0.0].map(double).concat();
        for row in rows {
            text += &format!("{:>6}", GRID[row][column]);
        }
        record(text);
    }
    file
}
