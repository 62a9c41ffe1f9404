//! Read row by row, every file has the heights and the meaning that it has as a whole.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use terrain_dem::{ColourCode, DemRows, RawLayout, ReadOptions, VoidPolicy, open, open_rows};

use crate::tiff_writer::{Kind, Value, Variant};
use crate::writers;

fn spaced() -> ReadOptions {
    ReadOptions { spacing_m: Some([30.0, 20.0]), ..ReadOptions::default() }
}

fn rows_of(rows: &DemRows) -> Vec<u32> {
    let mut bits = Vec::new();
    let all = rows.for_each(&mut |row_m| {
        assert_eq!(row_m.len(), rows.samples[0] as usize);
        bits.extend(row_m.iter().map(|height_m| height_m.to_bits()));
        ControlFlow::Continue(())
    });
    assert!(all.unwrap());
    bits
}

/// Compares both ways of reading; says what is known of the DEM.
fn compare(spec: &str, options: &ReadOptions) -> DemRows {
    let (dem, rows) = (open(spec, options).unwrap(), open_rows(spec, options).unwrap());
    let expected: Vec<u32> = dem.heightmap.heights_m().iter().map(|height_m| height_m.to_bits()).collect();
    assert_eq!(rows_of(&rows), expected, "{spec}");
    assert_eq!(rows_of(&rows), expected, "{spec}, once more");
    assert_eq!(rows.samples, [dem.heightmap.columns(), dem.heightmap.rows()], "{spec}");
    assert_eq!((rows.spacing_m, &rows.name), (dem.heightmap.spacing_m(), &dem.name), "{spec}");
    assert_eq!(rows.reading, dem.reading, "{spec}");
    rows
}

fn compare_file(path: PathBuf, bytes: &[u8], options: &ReadOptions) -> DemRows {
    std::fs::write(&path, bytes).unwrap();
    compare(path.to_str().unwrap(), options)
}

/// Whether the DEM is read anew in each pass; otherwise it is in memory.
fn is_by_rows(rows: &DemRows) -> bool {
    !format!("{rows:?}").contains("Whole")
}

fn png(kind: image::ExtendedColorType, bytes: &[u8]) -> Vec<u8> {
    use image::ImageEncoder;
    let mut file = Vec::new();
    image::codecs::png::PngEncoder::new(&mut file).write_image(bytes, 8, 4, kind).unwrap();
    file
}

#[test]
fn every_format_gives_the_same_rows() {
    let folder = tempfile::tempdir().unwrap();
    let bytes: Vec<u8> = (0..96).map(|i: u32| (i * 37 % 251) as u8).collect();
    let check = |name: &str, bytes: &[u8], options: ReadOptions, expected: bool| {
        let rows = compare_file(folder.path().join(name), bytes, &options);
        assert_eq!(is_by_rows(&rows), expected, "{name}");
    };
    let plain = ReadOptions::default();
    let scaled = ReadOptions { scale: Some(0.1), offset_m: Some(-7.0), ..spaced() };
    let mapbox = ReadOptions { colours: Some(ColourCode::Mapbox), ..spaced() };
    check("a.png", &png(image::ExtendedColorType::L16, &bytes[..64]), scaled, true);
    check(
        "b.png",
        &png(image::ExtendedColorType::L8, &bytes[..32]),
        ReadOptions { allow_8_bit: true, ..spaced() },
        true,
    );
    check("c.png", &png(image::ExtendedColorType::Rgb8, &bytes), mapbox, true);
    let raw = |layout| ReadOptions { raw: RawLayout::parse(layout), ..spaced() };
    let floats: Vec<u8> = (0..24).flat_map(|i| (i as f32 * 1.7 - 9.0).to_be_bytes()).collect();
    check("a.r16", &bytes, raw("8x6:uint16"), true);
    check("b.r16", &bytes, raw("6x8:int16be"), true);
    check("a.r32", &floats, raw("8x3:float32be"), true);
    for (name, header, bytes) in
        [("a.bil", writers::BIL_HEADER, writers::bil()), ("b.flt", writers::FLT_HEADER, writers::flt())]
    {
        std::fs::write(folder.path().join(name).with_extension("hdr"), header).unwrap();
        check(name, &bytes, plain, true);
    }
    check("N44W122.hgt", &writers::hgt(), plain, true);
    check("N44W122.hgt.gz", &writers::gzip(&writers::hgt()), plain, true);
    check("a.asc", writers::asc().as_bytes(), plain, true);
    check("a.npy", &writers::npy_i2(), spaced(), true);
    check("a.pgm", &writers::pgm("P5 4 3 65535 "), spaced(), true);
    check("a.dt0", &writers::dted(), plain, false);
}

/// A PNG of 2 x 2 samples in three of the seven passes: its first sample, the one beside it, then the second row.
fn interlaced() -> Vec<u8> {
    use std::io::Write;
    let chunk = |name: &[u8; 4], content: &[u8]| {
        let named = [name, content].concat();
        let mut crc = flate2::Crc::new();
        crc.update(&named);
        [&(content.len() as u32).to_be_bytes(), named.as_slice(), &crc.sum().to_be_bytes()].concat()
    };
    let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), Default::default());
    zlib.write_all(&[0, 0, 7, 0, 0, 8, 0, 1, 0, 1, 1]).unwrap();
    let header = [0, 0, 0, 2, 0, 0, 0, 2, 16, 0, 0, 0, 1];
    let chunks = [chunk(b"IHDR", &header), chunk(b"IDAT", &zlib.finish().unwrap()), chunk(b"IEND", &[])];
    [b"\x89PNG\r\n\x1a\n".as_slice(), &chunks.concat()].concat()
}

#[test]
fn interlaced_pictures_are_whole() {
    let folder = tempfile::tempdir().unwrap();
    let rows = compare_file(folder.path().join("a.png"), &interlaced(), &spaced());
    assert_eq!(rows_of(&rows), [7.0_f32, 8.0, 256.0, 257.0].map(f32::to_bits));
    assert!(!is_by_rows(&rows));
}

#[test]
fn sidecars_mean_the_same() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.toml"), "spacing_m = [7, 8]\nscale = 0.25\noffset_m = -3\n").unwrap();
    let bytes = png(image::ExtendedColorType::L16, &[9; 64]);
    let rows = compare_file(folder.path().join("a.png"), &bytes, &ReadOptions::default());
    assert_eq!((rows.spacing_m, rows.reading.scale), ([7.0, 8.0], 0.25));
}

#[test]
fn names_mean_the_same() {
    assert!(is_by_rows(&compare("jacksboro", &ReadOptions::default())));
    assert!(is_by_rows(&compare("synthetic:70x50:3", &spaced())));
    assert!(!is_by_rows(&compare("synthetic:70x50:3", &ReadOptions { scale: Some(0.5), ..ReadOptions::default() })));
}

#[test]
fn tiffs_in_strips_go_row_by_row() {
    let folder = tempfile::tempdir().unwrap();
    for kind in Kind::ALL {
        for (compression, predictor) in [(1, 1), (5, 2), (8, 1), (32773, 1), (50000, 2)] {
            for tile in [None, Some([16, 16])] {
                for (bands, is_planar) in [(1, false), (3, false), (3, true)] {
                    let plain = Variant { kind, compression, predictor, tile, bands, ..Variant::plain(kind) };
                    let bytes = Variant { is_planar, ..plain }.file().bytes();
                    let rows = compare_file(folder.path().join("a.tif"), &bytes, &ReadOptions::default());
                    assert_eq!(is_by_rows(&rows), tile.is_none());
                }
            }
        }
    }
}

#[test]
fn voids_are_filled_as_ever_and_a_mask_says_where() {
    let folder = tempfile::tempdir().unwrap();
    let void = Kind::I16.sample(3, 2);
    let file = Variant::plain(Kind::I16).file().with(42113, Value::Text(format!("{void} ")));
    let (path, fill) = (folder.path().join("a.tif"), ReadOptions { voids: VoidPolicy::Fill, ..ReadOptions::default() });
    let rows = compare_file(path.clone(), &file.bytes(), &fill);
    assert!(!is_by_rows(&rows) && rows.reading.warnings[0].ends_with("are voids: filled from their rim"));
    assert_eq!(rows.voids, None, "the fill counts");
    let holes = compare_file(path, &file.bytes(), &ReadOptions::default());
    let mask = holes.voids.as_ref().unwrap();
    assert!(holes.reading.warnings[0].contains("are voids: left open") && mask.is_void(3, 2), "{mask:?}");
}

#[test]
fn rows_end_when_nobody_wants_more() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    std::fs::write(&path, Variant::plain(Kind::I16).file().bytes()).unwrap();
    for spec in [path.to_str().unwrap(), "jacksboro", "synthetic:20x30:1"] {
        let (rows, mut count) = (open_rows(spec, &ReadOptions::default()).unwrap(), 0);
        let all = rows.for_each(&mut |_| {
            count += 1;
            if count == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!((all.unwrap(), count), (false, 3), "{spec}");
    }
}

#[test]
fn a_file_that_changes_between_two_passes_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.r16");
    let options = |layout| ReadOptions { raw: RawLayout::parse(layout), ..spaced() };
    std::fs::write(&path, [1; 96]).unwrap();
    let rows = open_rows(path.to_str().unwrap(), &options("8x6:int16")).unwrap();
    let refused = |path: &Path, bytes: &[u8]| {
        std::fs::write(path, bytes).unwrap();
        rows.for_each(&mut |_| ControlFlow::Continue(())).unwrap_err().to_string()
    };
    // The lowest int16 is a void, which nobody has filled.
    let with_void: Vec<u8> = [1; 90].into_iter().chain([0x00, 0x80, 1, 1, 1, 1]).collect();
    let changed = "changed while it was read; expected the same file in every pass";
    assert_eq!(refused(&path, &with_void), format!("{}: {changed}", path.display()));
    assert!(refused(&path, &[1; 40]).contains("40 bytes; expected 8 x 6 samples"));
}
