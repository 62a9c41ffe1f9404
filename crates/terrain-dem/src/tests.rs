use std::fs;
use std::path::{Path, PathBuf};

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use tempfile::TempDir;
use terrain_core::Sample;

use super::*;

fn spaced() -> ReadOptions {
    ReadOptions { spacing_m: Some([30.0, 30.0]), ..ReadOptions::default() }
}

/// A folder with `dem.png`, 3 x 2 samples with the values 0 to 50000.
fn folder() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dem.png");
    write_png16(&path, 3, 2, &[0, 1, 2, 300, 4000, 50_000]).unwrap();
    (folder, path)
}

/// A PNG of another kind.
fn write_png(path: &Path, size: [u32; 2], kind: ExtendedColorType, bytes: &[u8]) {
    PngEncoder::new(fs::File::create(path).unwrap()).write_image(bytes, size[0], size[1], kind).unwrap();
}

/// The message without the folder's name.
fn refusal(path: &Path, options: &ReadOptions) -> String {
    let refused = read(path, options).unwrap_err();
    refused.to_string().replace(&format!("{}/", path.parent().unwrap().display()), "")
}

#[test]
fn values_become_heights_by_the_sidecar() {
    let (folder, path) = folder();
    let sidecar = "spacing_m = [74.5, 93]\nscale = 0.1\noffset_m = -10\nsource = 'SRTM'\nlicence = 'free'\n";
    fs::write(folder.path().join("dem.toml"), sidecar).unwrap();
    let dem = read(&path, &ReadOptions::default()).unwrap();
    let heights_m = vec![-10.0, -9.9, -9.8, 20.0, 390.0, 4990.0];
    assert_eq!(*dem.heightmap, Heightmap::new(3, 2, [74.5, 93.0], heights_m).unwrap());
    assert_eq!((dem.name.as_str(), dem.source.as_deref(), dem.licence.as_deref()), ("dem", Some("SRTM"), Some("free")));
}

#[test]
fn options_override_the_sidecar() {
    let (folder, path) = folder();
    fs::write(folder.path().join("dem.toml"), "spacing_m = 9\nscale = 5\noffset_m = 5\n").unwrap();
    let options = ReadOptions { scale: Some(2.0), offset_m: Some(-1.0), ..spaced() };
    let heights_m = vec![-1.0, 1.0, 3.0, 599.0, 7999.0, 99_999.0];
    assert_eq!(*read(&path, &options).unwrap().heightmap, Heightmap::new(3, 2, [30.0; 2], heights_m).unwrap());
}

#[test]
fn no_spacing_is_refused() {
    let expected = "dem.png: no spacing; expected `spacing_m = [30.0, 30.0]` (metres) in a file of the same name that ends \
                    in .toml, or --spacing 30";
    assert_eq!(refusal(&folder().1, &ReadOptions::default()), expected);
}

#[test]
fn sidecar_mistakes_are_refused_with_line_and_column() {
    let (folder, path) = folder();
    fs::write(folder.path().join("dem.toml"), "spacing_m = 30\nscale = nan\n").unwrap();
    assert_eq!(refusal(&path, &spaced()), "dem.toml:2:9: `scale` is NaN; expected a finite number");
}

#[test]
fn numbers_that_give_no_heights_are_refused() {
    let (_folder, path) = folder();
    let refuse = |options| refusal(&path, &options);
    let expected = "dem.png: spacing 30 x -1 m: expected two positive, finite numbers";
    assert_eq!(refuse(ReadOptions { spacing_m: Some([30.0, -1.0]), ..spaced() }), expected);
    let expected = "dem.png: scale NaN, offset 0: expected two finite numbers";
    assert_eq!(refuse(ReadOptions { scale: Some(f64::NAN), ..spaced() }), expected);
}

#[test]
fn eight_bits_are_taken_only_on_demand() {
    let (_folder, path) = folder();
    write_png(&path, [2, 2], ExtendedColorType::L8, &[0, 1, 2, 255]);
    let expected = "dem.png: an 8-bit greyscale PNG, whose 256 heights show as steps; expected a 16-bit greyscale PNG, or \
                    --allow-8-bit";
    assert_eq!(refusal(&path, &spaced()), expected);
    let dem = read(&path, &ReadOptions { allow_8_bit: true, ..spaced() }).unwrap();
    assert_eq!(dem.heightmap.heights_m(), [0.0, 1.0, 2.0, 255.0]);
}

#[test]
fn other_files_are_refused_for_what_they_are() {
    let (folder, path) = folder();
    let refuse = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        refusal(&path, &spaced())
    };
    let expected = format!(
        "dem.png: of no known format (starts with \"north 1 2\\n3 \"); expected {}, or --raw for samples without a header",
        formats::EXPECTED
    );
    assert_eq!(refuse(b"north 1 2\n3 4 5 6"), expected);
    assert_eq!(refuse(b""), format!("dem.png: an empty file; expected {}", formats::EXPECTED));
    let expected = "dem.png: a PNG without a header; expected a 16-bit greyscale PNG: fetch it again";
    assert_eq!(refuse(b"\x89PNG\r\n\x1a\n"), expected);

    write_png(&path, [2, 2], ExtendedColorType::Rgb8, &[0; 12]);
    assert_eq!(
        refusal(&path, &spaced()),
        "dem.png: a PNG of 8-bit colour; expected a 16-bit greyscale PNG: convert it"
    );
    write_png(&path, [2, 2], ExtendedColorType::La16, &[0; 16]);
    let expected = "dem.png: none of its 4 samples has a height; expected some: mend --nodata, or fetch it again";
    assert_eq!(refusal(&path, &spaced()), expected, "all of it is transparent");
    write_png(&path, [1, 9], ExtendedColorType::L16, &[0; 18]);
    let expected = "dem.png: 1 x 9 samples; expected 2 to 65535 a side and at most 536870912 in all: crop it";
    assert_eq!(refusal(&path, &spaced()), expected);

    fs::create_dir(folder.path().join("folder.png")).unwrap();
    let expected = format!("folder.png: not a file; expected {}", formats::EXPECTED);
    assert_eq!(refusal(&folder.path().join("folder.png"), &spaced()), expected);
}

/// A small file must not make us allocate what its header promises.
#[test]
fn sizes_beyond_the_file_are_refused_by_the_header() {
    let (_folder, path) = folder();
    let mut bytes = fs::read(&path).unwrap();
    bytes[16..24].copy_from_slice(&[0, 0, 255, 255, 0, 0, 255, 255]);
    fs::write(&path, &bytes).unwrap();
    let expected =
        format!("dem.png: a PNG of {} bytes; expected more for 65535 x 65535 samples: fetch it again", bytes.len());
    assert_eq!(refusal(&path, &spaced()), expected);
}

#[test]
fn a_file_that_is_not_there_is_bad_input_and_one_that_cannot_be_written_is_not() {
    let (folder, path) = folder();
    let expected = format!(
        "none.png: no such file; expected {}, synthetic:COLUMNSxROWS:SEED, or a built-in DEM: jacksboro",
        formats::EXPECTED
    );
    assert_eq!(refusal(&folder.path().join("none.png"), &spaced()), expected);
    fs::write(&path, "text").unwrap();
    assert!(!read(&path, &spaced()).unwrap_err().is_io());
    assert!(write_png16(&folder.path().join("none/a.png"), 2, 2, &[0; 4]).unwrap_err().is_io());
}

/// Cut short or with any bit flipped, a file is refused as bad input; it never panics, and never gives other heights.
#[test]
fn broken_files_are_refused() {
    let (_folder, path) = folder();
    let (whole, dem) = (fs::read(&path).unwrap(), read(&path, &spaced()).unwrap());
    let check = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        match read(&path, &spaced()) {
            Ok(read) => assert_eq!(read, dem),
            Err(e) => assert!(!e.is_io() && !e.to_string().contains('\n'), "{e}"),
        }
    };
    (0..whole.len()).for_each(|length| check(&whole[..length]));
    for bit in 0..whole.len() * 8 {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        check(&bytes);
    }
    fs::write(&path, &whole[..whole.len() - 24]).unwrap();
    let expected = "dem.png: the PNG ends before its last row; expected a whole file: fetch it again";
    assert_eq!(refusal(&path, &spaced()), expected);
}

#[test]
fn built_in_names_open_anywhere() {
    assert_eq!(built_in_names().collect::<Vec<_>>(), ["jacksboro"]);
    let dem = open("jacksboro", &ReadOptions::default()).unwrap();
    let map = &dem.heightmap;
    assert_eq!((map.columns(), map.rows(), map.spacing_m()), (403, 344, [74.8480, 92.4705]));
    assert_eq!(map.height_range_m(Sample { column: 0, row: 0 }, Sample { column: 402, row: 343 }), [236.0, 1076.0]);
    // The summit of Cross Mountain, in the south of the map: the first row is the northern one.
    assert_eq!(map.height_m(Sample { column: 219, row: 297 }), 1076.0);
    assert_eq!(dem.licence.as_deref(), Some("public domain (work of the US Government)"));
}

#[test]
fn synthetic_terrain_opens_by_its_size_and_seed() {
    let dem = open("synthetic:64x48:9", &ReadOptions::default()).unwrap();
    assert_eq!((dem.name.as_str(), &*dem.heightmap), ("synthetic-64x48-9", &synthetic::generate(64, 48, 9)));
    let halved = open("synthetic:64x48:9", &ReadOptions { scale: Some(0.5), ..ReadOptions::default() }).unwrap();
    assert_eq!(halved.heightmap.heights_m()[5], dem.heightmap.heights_m()[5] * 0.5);
    let expected = "synthetic:1x9:1: no synthetic terrain; expected synthetic:COLUMNSxROWS:SEED with 2 to 65535 samples a \
                    side and at most 536870912 in all, such as synthetic:193x250:7";
    assert_eq!(open("synthetic:1x9:1", &ReadOptions::default()).unwrap_err().to_string(), expected);
}

/// Rows of floats as they stand are copied; those with a void among them, or in another order or scale, are not. Both ways come
/// to the same.
#[test]
fn floats_that_are_copied_are_the_ones_that_are_computed() {
    use crate::raster::{Decoded, Facts, Heights, Meaning};
    use crate::samples::SampleType;
    let below = f32::from_bits(1e30f32.to_bits() - 1);
    let odd = [f32::NAN, f32::INFINITY, 1e30, -1e30, below, -0.0, -9999.0, -32768.0, -9999.001, 1e-40];
    let row = |row: usize| {
        (0..37).map(move |i| if row.is_multiple_of(2) && i == 3 * row { odd[row % 10] } else { i as f32 - 9.5 })
    };
    let facts = || Facts::new("floats", 37, 12, SampleType::F32);
    let decode = |meaning: Meaning, is_copied: bool, rows: &[usize], column: u32| -> Decoded {
        let mut heights = Heights::new(&facts(), meaning, None);
        for &at in rows {
            let floats: Vec<[u8; 4]> = row(at).map(f32::to_le_bytes).collect();
            match is_copied {
                true => heights.put_floats(at as u32, column, &floats),
                false => heights.put(at as u32, column, row(at).map(f64::from)),
            }
        }
        heights.finish()
    };
    let parts = |decoded: Decoded| {
        let bits: Vec<u32> = decoded.heights_m.iter().map(|height_m| height_m.to_bits()).collect();
        (bits, decoded.found, decoded.range_m, decoded.absurd, decoded.undeclared)
    };
    let orders: [Vec<usize>; 3] = [(0..12).collect(), (0..12).rev().collect(), vec![3, 7, 4]];
    for (scale, nodata) in [(1.0, None), (1.0, Some(-9999.0)), (1.0, Some(-9999.0001)), (0.5, Some(1.5))] {
        let meaning = Meaning { scale, offset_m: 0.0, nodata, undeclared: Some(-32768.0) };
        for (rows, column) in orders.iter().flat_map(|rows| [(rows, 0), (rows, 5)]) {
            let copied = parts(decode(meaning, true, rows, column));
            assert_eq!(copied, parts(decode(meaning, false, rows, column)), "{meaning:?}, {rows:?}, {column}");
            assert_eq!(copied.0.len(), 37 * 12);
            let put = 37 - column as usize;
            assert!(copied.1 as usize <= rows.len() * put, "what was never put is void");
            if column == 0 {
                let mut heights = Heights::new(&facts(), meaning, None);
                for &at in rows {
                    let this = at as u32..at as u32 + 1;
                    let target = heights.rows_to_fill(this.clone()).unwrap();
                    target.iter_mut().zip(row(at)).for_each(|(target, value)| *target = value);
                    heights.judge_rows(this);
                }
                assert_eq!(parts(heights.finish()), copied, "{meaning:?}, {rows:?}, filled in place");
            }
        }
    }
}

/// Reading on, back and far ahead, within what a reader has in its buffer and beyond.
#[test]
fn bytes_are_found_in_any_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bytes");
    let bytes: Vec<u8> = (0..300_000u32).map(|i| (i % 251) as u8).collect();
    fs::write(&path, &bytes).unwrap();
    let mut inputs = [Input::open(&path).unwrap(), Input::memory("a".into(), "a".into(), bytes.clone()).unwrap()];
    for input in &mut inputs {
        for (at, count) in
            [(10, 5), (15, 70_000), (3, 4), (299_000, 1000), (70_100, 200), (70_000, 66_000), (0, 300_000)]
        {
            assert_eq!(input.bytes_at(at, count).unwrap(), bytes[at as usize..][..count as usize], "{count} at {at}");
        }
        assert!(input.bytes_at(299_999, 2).is_err());
        assert_eq!(input.bytes_at(7, 1).unwrap(), [7]);
    }
}

/// Heights near the largest number: whatever a void is filled with, it is one.
#[test]
fn no_fill_is_infinite() {
    let header = "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -1\n";
    for rim in ["3.4e29", "-3.4e29", "0.0 3.4e29 -3.4e29"] {
        let values = rim.split(' ').cycle().take(8).collect::<Vec<_>>();
        let rows = format!("{}\n{} -1 {}\n{}\n", values[..3].join(" "), values[3], values[4], values[5..].join(" "));
        let options = ReadOptions { scale: Some(1e9), ..ReadOptions::default() };
        let dem = read_bytes("a.asc", format!("{header}{rows}").into_bytes(), &options).unwrap();
        assert!(dem.voids.is_some() && dem.heightmap.heights_m().iter().all(|height_m| height_m.is_finite()), "{rim}");
    }
}
