//! A minimal TIFF writer that can also write what is wrong: all tags are free.

use std::collections::BTreeMap;
use std::io::Write;

pub const SIDE: [usize; 2] = [13, 9];

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F16,
    F32,
    F64,
}

impl Kind {
    pub const ALL: [Self; 9] =
        [Self::U8, Self::I8, Self::U16, Self::I16, Self::U32, Self::I32, Self::F16, Self::F32, Self::F64];

    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64)
    }

    /// The number in the tag `SampleFormat`.
    fn format(self) -> u16 {
        match self {
            Self::U8 | Self::U16 | Self::U32 => 1,
            Self::I8 | Self::I16 | Self::I32 => 2,
            _ => 3,
        }
    }

    /// A sample, in all its bits: different at every place, negative where it can be.
    pub fn sample(self, column: usize, row: usize) -> f64 {
        let i = (row * SIDE[0] + column) as f64;
        match self {
            Self::U8 => i,
            Self::I8 => i - 60.0,
            Self::U16 => i * 511.0,
            Self::I16 => i * 151.0 - 9000.0,
            Self::U32 => i * 70_001.0,
            Self::I32 => i * 70_001.0 - 4e6,
            // Eleven bits are exact.
            Self::F16 => i * 4.0 - 200.0,
            Self::F32 => (i * 1.1 - 30.0) as f32 as f64,
            Self::F64 => i * 1.1 - 30.0,
        }
    }

    fn little_endian(self, value: f64) -> Vec<u8> {
        match self {
            Self::U8 => vec![value as u8],
            Self::I8 => (value as i8).to_le_bytes().to_vec(),
            Self::U16 => (value as u16).to_le_bytes().to_vec(),
            Self::I16 => (value as i16).to_le_bytes().to_vec(),
            Self::U32 => (value as u32).to_le_bytes().to_vec(),
            Self::I32 => (value as i32).to_le_bytes().to_vec(),
            Self::F16 => half(value).to_le_bytes().to_vec(),
            Self::F32 => (value as f32).to_le_bytes().to_vec(),
            Self::F64 => value.to_le_bytes().to_vec(),
        }
    }

    pub fn encode(self, value: f64, is_big_endian: bool) -> Vec<u8> {
        let mut bytes = self.little_endian(value);
        if is_big_endian {
            bytes.reverse();
        }
        bytes
    }
}

/// A normal number of at most eleven bits as a half-precision float.
fn half(value: f64) -> u16 {
    if value == 0.0 {
        return 0;
    }
    let bits = (value as f32).to_bits();
    let exponent = (bits >> 23 & 255) as i32 - 127 + 15;
    (bits >> 16 & 0x8000) as u16 | (exponent as u16) << 10 | (bits >> 13 & 1023) as u16
}

#[derive(Clone, Debug)]
pub enum Value {
    Shorts(Vec<u16>),
    Longs(Vec<u32>),
    Longs8(Vec<u64>),
    Doubles(Vec<f64>),
    Text(String),
}

/// How a TIFF is written.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    pub kind: Kind,
    pub is_big_endian: bool,
    pub is_big: bool,
    /// The number in the tag.
    pub compression: u16,
    pub predictor: u16,
    /// Columns and rows of a tile, if there are tiles.
    pub tile: Option<[usize; 2]>,
    /// Rows of a strip otherwise.
    pub strip: usize,
    pub bands: usize,
    pub is_planar: bool,
}

impl Variant {
    pub fn plain(kind: Kind) -> Self {
        Self {
            kind,
            is_big_endian: false,
            is_big: false,
            compression: 1,
            predictor: 1,
            tile: None,
            strip: 4,
            bands: 1,
            is_planar: false,
        }
    }

    fn chunk_size(&self) -> [usize; 2] {
        self.tile.unwrap_or([SIDE[0], self.strip])
    }

    /// The samples of one row of a chunk, padded by the last ones.
    fn row(&self, first_column: usize, row: usize, band: Option<usize>) -> Vec<u8> {
        let mut bytes = Vec::new();
        for column in first_column..first_column + self.chunk_size()[0] {
            let (column, row) = (column.min(SIDE[0] - 1), row.min(SIDE[1] - 1));
            let bands = band.map_or(0..self.bands, |band| band..band + 1);
            for band in bands {
                // The other bands are of other numbers, so that a mix-up shows.
                let value = if band == 0 { self.kind.sample(column, row) } else { band as f64 };
                bytes.extend(self.kind.encode(value, self.is_big_endian));
            }
        }
        let apart = if band.is_some() { 1 } else { self.bands };
        match self.predictor {
            2 => differences(&mut bytes, apart, self.kind.bytes(), self.is_big_endian),
            3 => float_differences(&mut bytes, apart, self.kind.bytes(), self.is_big_endian),
            _ => {}
        }
        bytes
    }

    fn chunks(&self) -> Vec<Vec<u8>> {
        let [width, height] = self.chunk_size();
        let planes: Vec<Option<usize>> = if self.is_planar { (0..self.bands).map(Some).collect() } else { vec![None] };
        let mut chunks = Vec::new();
        for plane in planes {
            for first_row in (0..SIDE[1]).step_by(height) {
                for first_column in (0..SIDE[0]).step_by(width) {
                    // The last strip ends with the picture, tiles are always whole.
                    let rows = if self.tile.is_some() { height } else { height.min(SIDE[1] - first_row) };
                    let plain: Vec<u8> =
                        (first_row..first_row + rows).flat_map(|row| self.row(first_column, row, plane)).collect();
                    chunks.push(compress(self.compression, &plain));
                }
            }
        }
        chunks
    }

    pub fn file(&self) -> TiffFile {
        use Value::{Longs, Shorts};
        let mut tags = BTreeMap::from([
            (256, Shorts(vec![SIDE[0] as u16])),
            (257, Shorts(vec![SIDE[1] as u16])),
            (258, Shorts(vec![self.kind.bytes() as u16 * 8; self.bands])),
            (259, Shorts(vec![self.compression])),
            (262, Shorts(vec![1])),
            (277, Shorts(vec![self.bands as u16])),
            (284, Shorts(vec![if self.is_planar { 2 } else { 1 }])),
            (317, Shorts(vec![self.predictor])),
            (339, Shorts(vec![self.kind.format(); self.bands])),
        ]);
        match self.tile {
            Some([width, height]) => {
                tags.extend([(322, Shorts(vec![width as u16])), (323, Longs(vec![height as u32]))]);
            }
            None => drop(tags.insert(278, Shorts(vec![self.strip as u16]))),
        }
        let mut file = TiffFile {
            is_big_endian: self.is_big_endian,
            is_big: self.is_big,
            tags,
            chunks: self.chunks(),
            is_tiled: self.tile.is_some(),
        };
        file.place([30.0, 40.0], [1000.0, 2000.0], UTM_KEYS);
        file
    }
}

/// Model: projected; raster: area; EPSG:32611.
pub const UTM_KEYS: &[[u16; 4]] = &[[1024, 0, 1, 1], [1025, 0, 1, 1], [3072, 0, 1, 32611]];

pub struct TiffFile {
    pub is_big_endian: bool,
    pub is_big: bool,
    pub is_tiled: bool,
    pub tags: BTreeMap<u16, Value>,
    pub chunks: Vec<Vec<u8>>,
}

impl TiffFile {
    /// Spacing, north-western corner, GeoTIFF keys.
    pub fn place(&mut self, spacing: [f64; 2], corner: [f64; 2], keys: &[[u16; 4]]) {
        let [x, y] = corner;
        let mut directory = vec![1, 1, 0, keys.len() as u16];
        directory.extend(keys.as_flattened());
        self.tags.insert(33550, Value::Doubles(vec![spacing[0], spacing[1], 0.0]));
        self.tags.insert(33922, Value::Doubles(vec![0.0, 0.0, 0.0, x, y, 0.0]));
        self.tags.insert(34735, Value::Shorts(directory));
    }

    pub fn with(mut self, tag: u16, value: Value) -> Self {
        self.tags.insert(tag, value);
        self
    }

    pub fn without(mut self, tag: u16) -> Self {
        self.tags.remove(&tag);
        self
    }

    /// The header, the chunks, the values of the tags, and at the end the directory.
    pub fn bytes(&self) -> Vec<u8> {
        let mut out = vec![0; if self.is_big { 16 } else { 8 }];
        let mut places = Vec::new();
        for chunk in &self.chunks {
            places.push([if chunk.is_empty() { 0 } else { out.len() as u64 }, chunk.len() as u64]);
            out.extend(chunk);
        }
        let mut tags = self.tags.clone();
        let (offsets, counts) = if self.is_tiled { (324, 325) } else { (273, 279) };
        let column = |i: usize| places.iter().map(|place| place[i]).collect::<Vec<u64>>();
        let wide = |values: Vec<u64>| match self.is_big {
            true => Value::Longs8(values),
            false => Value::Longs(values.into_iter().map(|value| value as u32).collect()),
        };
        tags.entry(offsets).or_insert(wide(column(0)));
        tags.entry(counts).or_insert(wide(column(1)));

        let inline = if self.is_big { 8 } else { 4 };
        let mut directory = self.number(tags.len() as u64, if self.is_big { 8 } else { 2 });
        for (tag, value) in &tags {
            let (kind, count, mut bytes) = self.value(value);
            directory.extend([self.number(*tag as u64, 2), self.number(kind, 2), self.number(count, inline)].concat());
            if bytes.len() > inline {
                let offset = out.len() as u64;
                out.extend(&bytes);
                bytes = self.number(offset, inline);
            }
            bytes.resize(inline, 0);
            directory.extend(bytes);
        }
        directory.extend(self.number(0, inline));
        let first = self.number(out.len() as u64, inline);
        out.extend(directory);
        let magic: &[u8] = if self.is_big_endian { b"MM" } else { b"II" };
        let version = self.number(if self.is_big { 43 } else { 42 }, 2);
        let sizes = if self.is_big { [self.number(8, 2), self.number(0, 2)].concat() } else { Vec::new() };
        let header = [magic, &version, &sizes, &first].concat();
        out[..header.len()].copy_from_slice(&header);
        out
    }

    fn number(&self, number: u64, bytes: usize) -> Vec<u8> {
        match self.is_big_endian {
            true => number.to_be_bytes()[8 - bytes..].to_vec(),
            false => number.to_le_bytes()[..bytes].to_vec(),
        }
    }

    fn value(&self, value: &Value) -> (u64, u64, Vec<u8>) {
        let all = |numbers: Vec<u64>, bytes| numbers.into_iter().flat_map(|n| self.number(n, bytes)).collect();
        match value {
            Value::Shorts(v) => (3, v.len() as u64, all(v.iter().map(|n| *n as u64).collect(), 2)),
            Value::Longs(v) => (4, v.len() as u64, all(v.iter().map(|n| *n as u64).collect(), 4)),
            Value::Longs8(v) => (16, v.len() as u64, all(v.clone(), 8)),
            Value::Doubles(v) => (12, v.len() as u64, all(v.iter().map(|n| n.to_bits()).collect(), 8)),
            Value::Text(text) => (2, text.len() as u64 + 1, [text.as_bytes(), b"\0"].concat()),
        }
    }
}

pub fn compress(compression: u16, plain: &[u8]) -> Vec<u8> {
    match compression {
        5 => weezl::encode::Encoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8).encode(plain).unwrap(),
        8 | 32946 => {
            let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            packed.write_all(plain).unwrap();
            packed.finish().unwrap()
        }
        32773 => pack_bits(plain),
        50000 => ruzstd::encoding::compress_to_vec(plain, ruzstd::encoding::CompressionLevel::Fastest),
        _ => plain.to_vec(),
    }
}

/// Runs of two or more, literals of one, and a no-op at the start.
fn pack_bits(plain: &[u8]) -> Vec<u8> {
    let mut packed = vec![0x80];
    for run in plain.chunk_by(|a, b| a == b).flat_map(|run| run.chunks(128)) {
        match run {
            [one] => packed.extend([0, *one]),
            _ => packed.extend([(1 - run.len() as i32) as u8, run[0]]),
        }
    }
    packed
}

fn differences(row: &mut [u8], apart: usize, bytes: usize, is_big_endian: bool) {
    let read = |b: &[u8]| {
        let add = |sum: u64, byte: &u8| sum << 8 | *byte as u64;
        if is_big_endian { b.iter().fold(0, add) } else { b.iter().rev().fold(0, add) }
    };
    let numbers: Vec<u64> = row.chunks(bytes).map(read).collect();
    for i in apart..numbers.len() {
        let difference = numbers[i].wrapping_sub(numbers[i - apart]);
        let out = match is_big_endian {
            true => difference.to_be_bytes()[8 - bytes..].to_vec(),
            false => difference.to_le_bytes()[..bytes].to_vec(),
        };
        row[i * bytes..(i + 1) * bytes].copy_from_slice(&out);
    }
}

fn float_differences(row: &mut [u8], apart: usize, bytes: usize, is_big_endian: bool) {
    let count = row.len() / bytes;
    let mut sorted = vec![0; row.len()];
    for i in 0..count {
        for place in 0..bytes {
            let from = if is_big_endian { place } else { bytes - 1 - place };
            sorted[place * count + i] = row[i * bytes + from];
        }
    }
    for i in (apart..sorted.len()).rev() {
        sorted[i] = sorted[i].wrapping_sub(sorted[i - apart]);
    }
    row.copy_from_slice(&sorted);
}
