//! A crop of a file is that part of the whole, though less of the file is read.

use std::sync::Arc;

use terrain_core::Heightmap;
use terrain_dem::{Crop, Dem, RawLayout, ReadOptions, read_bytes};

use crate::tiff_writer::{Kind, Value, Variant};
use crate::writers;

fn load(name: &str, bytes: &[u8], crop: Option<&str>) -> Dem {
    let raw = name.ends_with(".raw").then(|| RawLayout::parse("4x3:int16").unwrap());
    let crop = crop.map(|text| Crop::parse(text).unwrap());
    read_bytes(name, bytes.to_vec(), &ReadOptions { raw, crop, spacing_m: Some([7.0, 8.0]), ..ReadOptions::default() })
        .unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// All crops of two and more samples a side.
fn check_all(name: &str, bytes: &[u8]) {
    let whole = load(name, bytes, None).heightmap;
    let [columns, rows] = [whole.columns(), whole.rows()];
    let firsts = (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| [column, row]));
    for [column, row] in firsts {
        for (width, height) in [(2, 2), (columns - column, rows - row), (3.min(columns - column), 2)] {
            let text = format!("{width}x{height}+{column}+{row}");
            let part = load(name, bytes, Some(&text));
            assert_eq!(part.heightmap, part_of(&whole, [column, row], [width, height]), "{name}: {text}");
        }
    }
}

fn part_of(whole: &Heightmap, [column, row]: [u32; 2], [width, height]: [u32; 2]) -> Arc<Heightmap> {
    let (columns, [column, row]) = (whole.columns() as usize, [column, row].map(|at| at as usize));
    let rows = whole.heights_m().chunks(columns).skip(row).take(height as usize);
    let heights_m = rows.flat_map(|row_m| &row_m[column..column + width as usize]).copied().collect();
    Arc::new(Heightmap::new(width, height, whole.spacing_m(), heights_m).unwrap())
}

#[test]
fn of_strips_and_tiles() {
    let plain = Variant::plain(Kind::I16);
    for tile in [None, Some([16, 16]), Some([4, 16]), Some([5, 3])] {
        for (bands, is_planar) in [(1, false), (3, false), (3, true)] {
            let variant = Variant { compression: 8, predictor: 2, tile, bands, is_planar, ..plain };
            check_all("a.tif", &variant.file().bytes());
        }
        let transformation = vec![30.0, 0.0, 0.0, 0.0, 0.0, 40.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
        let south_up = Variant { tile, ..plain }.file().without(33550).with(34264, Value::Doubles(transformation));
        check_all("a.tif", &south_up.bytes());
    }
}

#[test]
fn of_other_formats() {
    let big_endian: Vec<u8> = writers::bil().chunks(2).flat_map(|sample| [sample[1], sample[0]]).collect();
    for (name, bytes) in [
        ("a.raw", writers::bil()),
        ("a.npy", writers::npy_i2()),
        ("a.pgm", writers::pgm("P5 4 3 65535 ")),
        ("a.asc", writers::asc().into_bytes()),
        ("a.dt0", writers::dted()),
        ("N44W122.hgt", writers::hgt()),
        ("N44W122.hgt.gz", writers::gzip(&writers::hgt())),
        ("a.png", grey_png(&big_endian)),
    ] {
        check_all(name, &bytes);
    }
}

fn grey_png(samples: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 4, 3);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.write_header().unwrap().write_image_data(samples).unwrap();
    file
}

/// Tiles beside the crop may be broken, and a file may have more samples than are allowed: neither is looked at.
#[test]
fn what_lies_beside_a_crop_is_not_read() {
    let variant = Variant { compression: 8, tile: Some([4, 16]), ..Variant::plain(Kind::I16) };
    let mut file = variant.file();
    file.chunks[3] = b"no zlib".to_vec();
    let read = |crop: &str, max_samples| {
        let options = ReadOptions { crop: Crop::parse(crop), max_samples: Some(max_samples), ..ReadOptions::default() };
        read_bytes("a.tif", file.bytes(), &options)
    };
    assert_eq!(read("12x9+0+0", 108).unwrap().heightmap.columns(), 12);
    assert!(read("13x9+0+0", 117).unwrap_err().to_string().contains("tile 3 is broken"));
    assert!(read("12x9+0+0", 107).unwrap_err().to_string().contains("12 x 9 samples; expected"));
}
