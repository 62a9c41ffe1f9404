//! GeoTIFF of one float32 band (TIFF 6.0; OGC 19-008r4): header, directory, what its tags point at, then strips of plain
//! rows. All places are known before the first sample, so that it is written in one go.

use std::io::{self, Write};

use crate::Dem;
use crate::georef::{GeoKeys, Georeference, Place};

/// About the bytes of a strip.
const STRIP_BYTES: u32 = 1 << 16;

const SHORT: u16 = 3;
const LONG: u16 = 4;
const DOUBLE: u16 = 12;
const ASCII: u16 = 2;

struct Tag {
    tag: u16,
    kind: u16,
    count: u32,
    bytes: Vec<u8>,
}

/// A DEM in metres: less than 4 GiB, since it has at most [`MAX_SAMPLES`](crate::MAX_SAMPLES).
pub fn write(out: &mut dyn Write, dem: &Dem) -> io::Result<()> {
    let map = &dem.heightmap;
    let (columns, rows) = (map.columns(), map.rows());
    let strip_rows = (STRIP_BYTES / (columns * 4)).clamp(1, rows);
    // Their lengths do not depend on what they hold.
    let before = head(&tags(dem, strip_rows, 0)).len() as u32;
    out.write_all(&head(&tags(dem, strip_rows, before)))?;
    (0..rows).try_for_each(|row| out.write_all(&super::row_f32(dem, row)))
}

/// `first` is the place of the first strip.
fn tags(dem: &Dem, strip_rows: u32, first: u32) -> Vec<Tag> {
    let map = &dem.heightmap;
    let (columns, rows, [x, z]) = (map.columns(), map.rows(), map.spacing_m());
    let strips = rows.div_ceil(strip_rows);
    let strip_bytes = strip_rows * columns * 4;
    let counts = (0..strips).map(|strip| strip_rows.min(rows - strip * strip_rows) * columns * 4).collect();
    let longs = |tag, values: Vec<u32>| tag_of(tag, LONG, values.len(), values.iter().flat_map(|v| v.to_le_bytes()));
    let short = |tag, value: u16| tag_of(tag, SHORT, 1, value.to_le_bytes());
    let doubles = |tag, values: &[f64]| tag_of(tag, DOUBLE, values.len(), values.iter().flat_map(|v| v.to_le_bytes()));
    let Georeference { place, keys } = dem.georeference.clone().unwrap_or_else(|| from_the_south_west(rows, [x, z]));
    let GeoKeys { entries, doubles: key_doubles, texts } = keys.of_samples_in_metres();
    let directory = [&[1, 1, 0, entries.len() as u16], entries.as_flattened()].concat();
    let mut tags = vec![
        longs(256, vec![columns]),
        longs(257, vec![rows]),
        short(258, 32),
        short(259, 1),
        short(262, 1),
        longs(273, (0..strips).map(|strip| first + strip * strip_bytes).collect()),
        short(277, 1),
        longs(278, vec![strip_rows]),
        longs(279, counts),
        short(339, 3),
        doubles(33550, &[place.step[0], place.step[1], 0.0]),
        doubles(33922, &[0.0, 0.0, 0.0, place.west, place.north, 0.0]),
        tag_of(34735, SHORT, directory.len(), directory.iter().flat_map(|v| v.to_le_bytes())),
    ];
    if !key_doubles.is_empty() {
        tags.push(doubles(34736, &key_doubles));
    }
    if !texts.is_empty() {
        tags.push(tag_of(34737, ASCII, texts.len() + 1, [texts.as_bytes(), b"\0"].concat()));
    }
    tags.push(tag_of(42113, ASCII, 4, *b"nan\0"));
    tags
}

/// A DEM of which nobody knows where it lies.
fn from_the_south_west(rows: u32, step: [f64; 2]) -> Georeference {
    let place = Place { west: 0.0, north: f64::from(rows - 1) * step[1], step };
    Georeference { place, keys: GeoKeys::metres() }
}

fn tag_of(tag: u16, kind: u16, count: usize, bytes: impl IntoIterator<Item = u8>) -> Tag {
    Tag { tag, kind, count: count as u32, bytes: bytes.into_iter().collect() }
}

/// The header, the directory, and the values that are longer than its fields.
fn head(tags: &[Tag]) -> Vec<u8> {
    let mut head = b"II\x2a\0\x08\0\0\0".to_vec();
    head.extend((tags.len() as u16).to_le_bytes());
    let mut values: Vec<u8> = Vec::new();
    let after = head.len() + tags.len() * 12 + 4;
    for tag in tags {
        head.extend([tag.tag.to_le_bytes(), tag.kind.to_le_bytes()].concat());
        head.extend(tag.count.to_le_bytes());
        let mut field = tag.bytes.clone();
        if field.len() > 4 {
            field = ((after + values.len()) as u32).to_le_bytes().into();
            values.extend(&tag.bytes);
        }
        field.resize(4, 0);
        head.extend(field);
    }
    head.extend([0; 4]);
    head.extend(values);
    head
}
