//! The same grid in many variants has the same heights: floats bit by bit, integers exactly.

use terrain_dem::{ColourCode, Crop, Dem, HeightUnit, RawLayout, ReadOptions, VoidPolicy, read, read_bytes};

use crate::tiff_writer::{Kind, SIDE, TiffFile, UTM_KEYS, Value, Variant};
use crate::writers::{self, GRID};

fn load(name: &str, bytes: Vec<u8>) -> Dem {
    load_with(name, bytes, ReadOptions::default())
}

fn load_with(name: &str, bytes: Vec<u8>, options: ReadOptions) -> Dem {
    read_bytes(name, bytes, &options).unwrap_or_else(|e| panic!("{e}"))
}

fn heights(dem: &Dem) -> &[f32] {
    dem.heightmap.heights_m()
}

fn grid() -> Vec<f32> {
    GRID.as_flattened().iter().map(|height| *height as f32).collect()
}

fn tiff_grid(kind: Kind) -> Vec<f32> {
    (0..SIDE[1]).flat_map(|row| (0..SIDE[0]).map(move |column| kind.sample(column, row) as f32)).collect()
}

fn bits(heights: &[f32]) -> Vec<u32> {
    heights.iter().map(|height| height.to_bits()).collect()
}

/// Every type, order, container, compression, predictor, and chunk shape with every other.
#[test]
fn tiff_in_all_combinations() {
    let mut count = 0;
    for kind in Kind::ALL {
        let expected = bits(&tiff_grid(kind));
        for (is_big_endian, is_big) in [(false, false), (true, false), (false, true), (true, true)] {
            for (compression, predictors) in
                [(1, 1..=1), (5, 1..=3), (8, 1..=3), (32946, 1..=1), (32773, 1..=1), (50000, 1..=3)]
            {
                for predictor in predictors.filter(|predictor| *predictor != 3 || kind.is_float()) {
                    // Strips of 3 rows end with the picture, so that those of several bands follow each other as whole ones.
                    let strips = [3, 4].map(|strip| (None, strip));
                    let tiles = [[16, 16], [4, 16], [5, 3]].map(|tile| (Some(tile), 4));
                    for (tile, strip) in strips.into_iter().chain(tiles) {
                        for (bands, is_planar) in [(1, false), (3, false), (3, true)] {
                            let order = Variant { is_big_endian, is_big, ..Variant::plain(kind) };
                            let variant = Variant { compression, predictor, tile, strip, bands, is_planar, ..order };
                            let dem = load("a.tif", variant.file().bytes());
                            assert_eq!(bits(heights(&dem)), expected, "{variant:?}");
                            assert_eq!(dem.heightmap.spacing_m(), [30.0, 40.0], "{variant:?}");
                            count += 1;
                        }
                    }
                }
            }
        }
    }
    println!("{count} variants");
    assert!(count > 3000);
}

/// An encoder that is not ours.
#[test]
fn tiff_by_another_encoder() {
    use tiff::encoder::{Compression, TiffEncoder, colortype as c};
    macro_rules! check {
        ($number:ty, $kind:expr, $colour:ty) => {
            let samples: Vec<$number> = (0..SIDE[1])
                .flat_map(|row| (0..SIDE[0]).map(move |column| $kind.sample(column, row) as $number))
                .collect();
            for compression in
                [Compression::Uncompressed, Compression::Packbits, Compression::Deflate(Default::default())]
            {
                let mut file = std::io::Cursor::new(Vec::new());
                let mut encoder = TiffEncoder::new(&mut file).unwrap().with_compression(compression);
                encoder.write_image::<$colour>(SIDE[0] as u32, SIDE[1] as u32, &samples).unwrap();
                let spaced = ReadOptions { spacing_m: Some([1.0; 2]), ..ReadOptions::default() };
                let dem = load_with("a.tif", file.into_inner(), spaced);
                assert_eq!(bits(heights(&dem)), bits(&tiff_grid($kind)), "{:?}", $kind);
            }
        };
    }
    check!(u8, Kind::U8, c::Gray8);
    check!(i8, Kind::I8, c::GrayI8);
    check!(u16, Kind::U16, c::Gray16);
    check!(i16, Kind::I16, c::GrayI16);
    check!(u32, Kind::U32, c::Gray32);
    check!(i32, Kind::I32, c::GrayI32);
    check!(f32, Kind::F32, c::Gray32Float);
    check!(f64, Kind::F64, c::Gray64Float);
}

fn int16() -> TiffFile {
    Variant::plain(Kind::I16).file()
}

#[test]
fn a_band_is_chosen() {
    for (is_planar, strip) in [(false, 3), (false, 4), (true, 3), (true, 4)] {
        let file = Variant { bands: 3, is_planar, strip, ..Variant::plain(Kind::I16) }.file();
        let dem = load_with("a.tif", file.bytes(), ReadOptions { band: Some(3), ..ReadOptions::default() });
        assert!(heights(&dem).iter().all(|height| *height == 2.0) && dem.reading.bands == 3);
        let first = load("a.tif", file.bytes());
        assert_eq!(first.reading.warnings, ["3 bands: the first is read; --band chooses another"]);
    }
}

#[test]
fn heights_are_never_turned_where_white_is_zero() {
    let dem = load("a.tif", int16().with(262, Value::Shorts(vec![0])).bytes());
    assert_eq!(heights(&dem), tiff_grid(Kind::I16));
}

#[test]
fn gdal_tags_give_scale_offset_unit_and_voids() {
    let metadata = "<GDALMetadata>\n  <Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.1</Item>\n  \
                    <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">-10</Item>\n  \
                    <Item name=\"SCALE\" sample=\"1\" role=\"scale\">7</Item>\n  \
                    <Item name=\"UNITTYPE\" sample=\"0\" role=\"unittype\">ft</Item>\n</GDALMetadata>";
    let second = Kind::I16.sample(1, 0);
    let file = int16().with(42112, Value::Text(metadata.into())).with(42113, Value::Text(format!("{second} ")));
    let dem = load("a.tif", file.bytes());
    let expected = (Kind::I16.sample(2, 0) * (0.1 * 0.3048) + -10.0 * 0.3048) as f32;
    assert_eq!((heights(&dem)[2], dem.reading.unit), (expected, Some(HeightUnit::Foot)));
    assert!(dem.voids.as_ref().is_some_and(|voids| voids.count() == 1 && voids.is_void(1, 0)));
    // What the user says wins.
    let options = ReadOptions { unit: Some(HeightUnit::Metre), nodata: Some(5.5), ..ReadOptions::default() };
    let dem = load_with("a.tif", file.bytes(), options);
    assert_eq!((heights(&dem)[1], dem.voids), ((second * 0.1 - 10.0) as f32, None));
    let dem = load_with(
        "a.tif",
        file.bytes(),
        ReadOptions { scale: Some(1.0), offset_m: Some(0.0), ..ReadOptions::default() },
    );
    assert_eq!(heights(&dem)[2], Kind::I16.sample(2, 0) as f32);
}

#[test]
fn south_up_files_are_turned() {
    let mut turned = tiff_grid(Kind::I16);
    let rows: Vec<Vec<f32>> = turned.chunks(SIDE[0]).rev().map(<[f32]>::to_vec).collect();
    turned = rows.concat();
    let transformation = vec![30.0, 0.0, 0.0, 0.0, 0.0, 40.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let by_matrix = int16().without(33550).with(34264, Value::Doubles(transformation));
    assert_eq!(heights(&load("a.tif", by_matrix.bytes())), turned);
}

/// As GDAL does unless GTIFF_HONOUR_NEGATIVE_SCALEY is set: its writers mean nothing by the sign.
#[test]
fn a_negative_scale_is_north_up() {
    let negative = int16().with(33550, Value::Doubles(vec![30.0, -40.0, 0.0]));
    let dem = load("a.tif", negative.bytes());
    assert_eq!((heights(&dem), dem.heightmap.spacing_m()), (tiff_grid(Kind::I16).as_slice(), [30.0, 40.0]));
    assert_eq!(dem.reading.warnings, ["its scale in y is negative: taken as north-up, as GDAL takes it"]);
}

/// Three arc-seconds around latitude 45, as areas and as points: a degree is 78,846.8 m and 111,131.8 m there.
#[test]
fn degrees_become_metres_at_the_middle() {
    let step = 1.0 / 1200.0;
    for (raster, half) in [(1, SIDE[1] as f64 / 2.0), (2, (SIDE[1] - 1) as f64 / 2.0)] {
        let mut file = int16();
        file.place([step; 2], [7.0, 45.0 + half * step], &[[1024, 0, 1, 2], [1025, 0, 1, raster], [2048, 0, 1, 4326]]);
        let dem = load("a.tif", file.bytes());
        let [x, z] = dem.heightmap.spacing_m();
        assert!((x * 1200.0 - 78_846.8).abs() < 0.05 && (z * 1200.0 - 111_131.8).abs() < 0.05, "{x} x {z}");
        assert_eq!(dem.reading.spacing_from, "the file: 3 x 3 arc-seconds at latitude 45.0000");
        assert_eq!(dem.reading.crs.as_deref(), Some("EPSG:4326"));
    }
}

#[test]
fn feet_on_the_ground_are_not_feet_of_height() {
    let mut file = int16();
    file.place([100.0, 100.0], [0.0, 0.0], &[[1024, 0, 1, 1], [3076, 0, 1, 9003]]);
    let dem = load("a.tif", file.bytes());
    assert_eq!(dem.heightmap.spacing_m(), [100.0 * (1200.0 / 3937.0); 2]);
    assert_eq!(heights(&dem), tiff_grid(Kind::I16));
    assert_eq!(dem.reading.warnings.len(), 1);
    let with_unit = [UTM_KEYS, &[[4099, 0, 1, 9002]]].concat();
    file.place([30.0; 2], [0.0; 2], &with_unit);
    assert_eq!(heights(&load("a.tif", file.bytes()))[0], (Kind::I16.sample(0, 0) * 0.3048) as f32);
}

#[test]
fn tiles_that_are_left_out_are_voids() {
    let mut file = Variant { tile: Some([4, 4]), compression: 8, ..Variant::plain(Kind::I16) }.file();
    file.chunks[1].clear();
    let dem = load("a.tif", file.bytes());
    assert_eq!(dem.voids.unwrap().count(), 16);
    assert_eq!(
        dem.reading.warnings,
        ["16 of 117 samples (13.675 %) are voids: left open (--voids fill fills them from their rim)"]
    );
}

/// Strips that follow each other are read as one. Those that do not are found one by one: longer than their rows, in another
/// order, or left out where there would be room for them.
#[test]
fn strips_wherever_they_are() {
    for kind in [Kind::F32, Kind::I16] {
        let file = Variant::plain(kind).file();
        let lengths: Vec<u32> = file.chunks.iter().map(|chunk| chunk.len() as u32).collect();
        // Behind the header of 8 bytes.
        let starts = |lengths: &[u32]| (0..3).map(|i| 8 + lengths[..i].iter().sum::<u32>()).collect::<Vec<u32>>();
        let load_at = |file: &TiffFile, offsets: Vec<u32>, lengths: &[u32]| {
            let file = TiffFile { tags: file.tags.clone(), chunks: file.chunks.clone(), ..*file };
            load("a.tif", file.with(273, Value::Longs(offsets)).with(279, Value::Longs(lengths.to_vec())).bytes())
        };
        let turned = |mut values: Vec<u32>| {
            values.reverse();
            values
        };
        let mut backwards = Variant::plain(kind).file();
        backwards.chunks.reverse();
        let offsets = turned(starts(&turned(lengths.clone())));
        let expected = bits(&tiff_grid(kind));
        assert_eq!(bits(heights(&load_at(&backwards, offsets, &lengths))), expected, "{kind:?}");
        for strip in 0..3 {
            let with = |length: u32| {
                let mut lengths = lengths.clone();
                lengths[strip] = length;
                lengths
            };
            let longer = load_at(&file, starts(&lengths), &with(lengths[strip] + 5));
            assert_eq!(bits(heights(&longer)), expected, "{kind:?}, {strip} longer");
            let voids = load_at(&file, starts(&lengths), &with(0)).voids.expect("a strip is missing");
            let rows = strip * 4..SIDE[1].min(strip * 4 + 4);
            let are_voids = rows.clone().all(|row| (0..SIDE[0]).all(|column| voids.is_void(column as u32, row as u32)));
            assert!(are_voids && voids.count() as usize == rows.len() * SIDE[0], "{kind:?}, without {strip}");
        }
    }
}

/// As if they were not compressed.
#[test]
fn compressed_strips_as_long_as_plain_ones() {
    let variant = Variant { strip: 3, compression: 8, predictor: 2, ..Variant::plain(Kind::U32) };
    let mut file = variant.file();
    for chunk in &mut file.chunks {
        assert!(chunk.len() < 3 * SIDE[0] * 4);
        chunk.resize(3 * SIDE[0] * 4, 0);
    }
    assert_eq!(bits(heights(&load("a.tif", file.bytes()))), bits(&tiff_grid(variant.kind)));
}

/// 43 strips of 8,400 bytes become three longer ones, of which a part may be all that is wanted.
#[test]
fn strips_that_are_read_together() {
    const SIDE: usize = 300;
    let height_m = |i: usize| (i % 977) as f32 * 1.25 + 100.0;
    let chunk = |rows: std::ops::Range<usize>| -> Vec<u8> {
        (rows.start * SIDE..rows.end * SIDE).flat_map(|i| height_m(i).to_le_bytes()).collect()
    };
    let mut file = Variant::plain(Kind::F32).file();
    file.chunks = (0..SIDE).step_by(7).map(|row| chunk(row..SIDE.min(row + 7))).collect();
    for (tag, value) in [(256, SIDE), (257, SIDE), (278, 7)] {
        file.tags.insert(tag, Value::Shorts(vec![value as u16]));
    }
    let all: Vec<f32> = (0..SIDE * SIDE).map(height_m).collect();
    let whole = load("a.tif", file.bytes());
    assert_eq!((heights(&whole), whole.reading.format.as_str()), (&*all, "GeoTIFF, strips of 7, uncompressed"));
    for [first, rows] in [[0, 2], [111, 3], [112, 100], [223, 5], [224, 76], [298, 2]] {
        let crop = Crop::parse(&format!("290x{rows}+4+{first}"));
        let part = load_with("a.tif", file.bytes(), ReadOptions { crop, ..ReadOptions::default() });
        let expected: Vec<f32> = (first..first + rows).flat_map(|row| all[row * SIDE + 4..][..290].to_vec()).collect();
        assert_eq!(heights(&part), expected, "{rows} rows from {first}");
    }
}

#[test]
fn voids_that_nobody_declares() {
    let mut file = Variant::plain(Kind::F32).file();
    for (i, value) in [f32::NAN, f32::INFINITY, -3.4e38, -32_768.0].into_iter().enumerate() {
        file.chunks[1][8 * i..8 * i + 4].copy_from_slice(&value.to_le_bytes());
    }
    let dem = load("a.tif", file.bytes());
    assert_eq!(dem.voids.unwrap().count(), 4);
    let expected = "4 of 117 samples (3.419 %) are voids, 1 of them -32768, which the file does not declare, 3 of them NaN, \
                    infinite or beyond 1e30: left open (--voids fill fills them from their rim)";
    assert_eq!(dem.reading.warnings, [expected]);
    assert!(dem.heightmap.heights_m().iter().all(|height| height.abs() < 200.0));
}

/// The same grid in the dialects of the text format.
#[test]
fn esri_ascii_grids() {
    let header = writers::ASC_HEADER;
    let files = [
        writers::asc(),
        format!("{header}{}", writers::words(" ", " ")),
        format!("{header}{}\n\n", writers::words("\n", "\n")),
        format!("\u{feff}{header}{}", writers::words("\t", "\t\n  ")),
        writers::asc().replace('\n', "\r\n"),
        writers::asc().to_uppercase(),
        writers::asc().replace("corner", "center").replace("ncols 4", "NCOLS\t4.0"),
        writers::asc().replace("cellsize 30", "dx 30\ndy 30"),
        writers::asc().replace("2345", "2.345e+3").replace(" 6 ", " +6.000 "),
        format!("NODATA_value 1e20\nnrows 3\nncols 4\ncellsize 3.0E1\n{}", writers::words(" ", "\n")),
    ];
    for file in files {
        let dem = load("a.asc", file.clone().into_bytes());
        assert_eq!((heights(&dem), dem.heightmap.spacing_m()), (grid().as_slice(), [30.0; 2]), "{file}");
    }
    let voids = load("a.asc", writers::asc().replace("4000 -5", "-9999 nan").into_bytes());
    assert_eq!(voids.voids.unwrap().count(), 2);
    let degrees = writers::asc().replace("cellsize 30", "cellsize 0.001").replace("yllcorner 4000000", "yllcorner 45");
    let dem = load("a.asc", degrees.replace("xllcorner 500000", "xllcorner 7").into_bytes());
    assert!((dem.heightmap.spacing_m()[0] - 78.8).abs() < 0.1 && dem.reading.warnings.len() == 1);
}

#[test]
fn srtm_tiles_plain_and_packed() {
    let check = |name: &str, bytes: Vec<u8>| {
        let dem = load(name, bytes);
        assert_eq!(heights(&dem)[..6], [0.0, 100.0, 200.0, 300.0, 400.0, 500.0], "{name}");
        // A degree in four steps, around latitude 44.5.
        let [x, z] = dem.heightmap.spacing_m();
        assert!((x * 4.0 - 79_500.0).abs() < 100.0 && (z * 4.0 - 111_120.0).abs() < 10.0, "{name}: {x} x {z}");
    };
    check("N44W122.hgt", writers::hgt());
    check("N44W122.SRTMGL1.hgt.gz", writers::gzip(&writers::hgt()));
    check("tile.zip", writers::zip(&[("N44W122.hgt", &writers::hgt())]));
    check("tile.zip", writers::zip(&[("read.me", b"hello"), ("data/N44W122.hgt", &writers::hgt())]));
    // As NASADEM comes: with counts of scenes and a mask of water, which are grids of the same size.
    let [counts, water] = [[7; 25], [0; 25]];
    let members = [("n44w122.num", &counts[..]), ("n44w122.hgt", &writers::hgt()), ("n44w122.swb", &water[..])];
    check("NASADEM_HGT_n44w122.zip", writers::zip(&members));
    let spaced = ReadOptions { spacing_m: Some([90.0; 2]), ..ReadOptions::default() };
    assert_eq!(load_with("oregon", writers::hgt_of(1201), spaced).heightmap.columns(), 1201);
}

#[test]
fn dted_tiles_are_columns_from_the_south() {
    let dem = load("a.dt0", writers::dted());
    assert_eq!(heights(&dem), grid());
    let [x, z] = dem.heightmap.spacing_m();
    assert!((x * 4.0 - 78_846.8).abs() < 0.1 && (z * 4.0 - 111_131.8).abs() < 0.1, "{x} x {z}");
}

#[test]
fn other_formats_in_archives() {
    assert_eq!(heights(&load("a.asc.gz", writers::gzip(writers::asc().as_bytes()))), grid());
    let tiff = int16().bytes();
    assert_eq!(heights(&load("a.zip", writers::zip(&[("b.tfw", b"30"), ("b.tif", &tiff)]))), tiff_grid(Kind::I16));
}

#[test]
fn samples_with_a_header_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let big =
        |bytes: Vec<u8>, size: usize| bytes.chunks(size).flat_map(|s| s.iter().rev().copied()).collect::<Vec<u8>>();
    let padded = writers::bil().chunks(8).flat_map(|row| [b"####", row, b"!!"].concat()).collect::<Vec<u8>>();
    let bil = writers::BIL_HEADER;
    let variants = [
        ("a", "bil", writers::bil(), bil.to_owned()),
        ("b", "BIL", big(writers::bil(), 2), bil.replace("BYTEORDER I", "byteorder\tM")),
        ("c", "bil", padded, format!("{bil}SKIPBYTES 4\nTOTALROWBYTES 14\n")),
        ("d", "flt", writers::flt(), writers::FLT_HEADER.to_owned()),
        ("e", "flt", big(writers::flt(), 4), writers::FLT_HEADER.replace("LSBFIRST", "MSBFIRST")),
        ("f", "bil", writers::bil(), bil.replace("PIXELTYPE SIGNEDINT\n", "").replace('\n', "\r\n")),
    ];
    for (name, ending, samples, header) in variants {
        let path = folder.path().join(format!("{name}.{ending}"));
        std::fs::write(&path, samples).unwrap();
        std::fs::write(path.with_extension("hdr"), header).unwrap();
        for path in [path.clone(), path.with_extension("hdr")] {
            let dem = read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!((heights(&dem), dem.heightmap.spacing_m()), (grid().as_slice(), [30.0; 2]), "{name}");
        }
    }
    // A coordinate system in degrees, beside it too.
    std::fs::write(folder.path().join("a.prj"), "GEOGCS[\"WGS 84\",UNIT[\"degree\",0.0174532925199433]]").unwrap();
    let degrees = bil.replace("DIM 30", "DIM 0.5").replace("4000000", "45");
    std::fs::write(folder.path().join("a.hdr"), degrees).unwrap();
    let dem = read(&folder.path().join("a.bil"), &ReadOptions::default()).unwrap();
    assert!(dem.heightmap.spacing_m()[1] > 50_000.0 && dem.reading.crs.as_deref() == Some("WGS 84"));
}

#[test]
fn plain_formats_that_need_a_spacing() {
    let spaced = ReadOptions { spacing_m: Some([1.0; 2]), ..ReadOptions::default() };
    let unsigned: Vec<f32> = grid().iter().map(|height| height.abs()).collect();
    for header in ["P5\n4 3\n65535\n", "P5 4 3 32767 ", "P5#c\n# more\n4\t3 # and\n65535\n"] {
        assert_eq!(heights(&load_with("a.pgm", writers::pgm(header), spaced)), unsigned, "{header}");
    }
    let text = format!("P2\n# text\n4 3\n65535\n{}\n", writers::words(" ", "\n").replace('-', ""));
    assert_eq!(heights(&load_with("a.pgm", text.into_bytes(), spaced)), unsigned);

    assert_eq!(heights(&load_with("a.npy", writers::npy_i2(), spaced)), grid());
    let doubles: Vec<u8> = grid().iter().flat_map(|height| (*height as f64).to_be_bytes()).collect();
    let array = writers::npy("{'descr': '>f8', 'fortran_order': False, 'shape': (3, 4), }", &doubles);
    assert_eq!(heights(&load_with("a.npy", array, spaced)), grid());

    let raw = |layout: &str| ReadOptions { raw: Some(RawLayout::parse(layout).unwrap()), ..spaced };
    assert_eq!(heights(&load_with("a.r16", writers::bil(), raw("4x3:int16"))), grid());
    assert_eq!(heights(&load_with("a.r32", writers::flt(), raw("4x3:float32le"))), grid());
    let turned: Vec<u8> = writers::bil().chunks(2).flat_map(|s| [s[1], s[0]]).collect();
    assert_eq!(heights(&load_with("a.raw", turned, raw("4x3:int16be"))), grid());
}

#[test]
fn heights_packed_in_colours() {
    use image::ImageEncoder;
    let png = |pixels: &[u8]| {
        let mut file = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut file);
        encoder.write_image(pixels, 2, 2, image::ExtendedColorType::Rgb8).unwrap();
        file
    };
    let options = |code| ReadOptions { colours: Some(code), spacing_m: Some([1.0; 2]), ..ReadOptions::default() };
    let terrarium = png(&[128, 0, 0, 128, 1, 128, 127, 255, 0, 162, 144, 0]);
    assert_eq!(heights(&load_with("a.png", terrarium, options(ColourCode::Terrarium))), [0.0, 1.5, -1.0, 8848.0]);
    let mapbox = png(&[1, 134, 160, 1, 134, 170, 0, 0, 0, 2, 223, 192]);
    assert_eq!(heights(&load_with("a.png", mapbox, options(ColourCode::Mapbox))), [0.0, 1.0, -10_000.0, 8835.2]);
}

#[test]
fn usgs_dems_of_ragged_profiles() {
    let dem = load("a.dem", writers::usgs(1024));
    let (map, voids) = (&dem.heightmap, dem.voids.as_ref().unwrap());
    assert_eq!((map.columns(), map.rows(), map.spacing_m()), (4, 3, [30.0, 40.0]));
    assert_eq!((voids.count(), voids.is_void(1, 2), voids.is_void(2, 0)), (2, true, true));
    for (i, height) in GRID.as_flattened().iter().enumerate().filter(|(i, _)| ![2, 9].contains(i)) {
        let expected = ((f64::from(*height) * 0.5 + 10.0) * 0.3048) as f32;
        assert_eq!(map.heights_m()[i], expected, "{i}");
    }
    assert_eq!(dem.reading.crs.as_deref(), Some("UTM zone 11"));
}

/// 170 heights a block after the first one's 146.
#[test]
fn usgs_profiles_of_several_blocks() {
    let (rows, value) = (400, |row: usize, column: usize| (row * 3 + column) as i32);
    let mut file = writers::usgs(1024);
    file.truncate(1024);
    file[858..864].copy_from_slice(b"     2");
    for column in 0..2 {
        let start = file.len();
        let place = format!("{:>24}{:>24}{:>24}{:>48}", column * 30, 0, 0, "");
        let mut heights = (0..rows).rev().map(|row| format!("{:>6}", value(row, column)));
        let first: String = heights.by_ref().take(146).collect();
        file.extend(format!("{:>6}{:>6}{rows:>6}{:>6}{place}{first}", 1, column + 1, 1).bytes());
        file.resize(start + 1024, b' ');
        for block in 1..3 {
            file.extend(heights.by_ref().take(170).collect::<String>().bytes());
            file.resize(start + (1 + block) * 1024, b' ');
        }
    }
    let dem = load_with("a.dem", file, ReadOptions { unit: Some(HeightUnit::Metre), ..ReadOptions::default() });
    let expected: Vec<f32> =
        (0..rows).flat_map(|row| (0..2).map(move |column| value(row, column) as f32 * 0.5)).collect();
    assert_eq!(heights(&dem), expected);
}

fn grey_png(colour: png::ColorType, transparent: Option<u16>, bytes: &[u8]) -> Dem {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 2, 2);
    encoder.set_color(colour);
    encoder.set_depth(png::BitDepth::Sixteen);
    if let Some(value) = transparent {
        encoder.set_trns(value.to_be_bytes().to_vec());
    }
    // Neither may change a height.
    encoder.set_source_gamma(png::ScaledFloat::new(0.45));
    encoder.write_header().unwrap().write_image_data(bytes).unwrap();
    load_with("a.png", file, ReadOptions { spacing_m: Some([1.0; 2]), ..ReadOptions::default() })
}

#[test]
fn transparent_samples_of_a_png_are_voids() {
    let alpha = [[1u16, 65535], [300, 1], [7, 0], [0, 65535]].concat();
    let bytes: Vec<u8> = alpha.iter().flat_map(|value| value.to_be_bytes()).collect();
    let dem = grey_png(png::ColorType::GrayscaleAlpha, None, &bytes);
    assert_eq!((heights(&dem)[..2].to_vec(), heights(&dem)[3]), (vec![1.0, 300.0], 0.0));
    assert!(dem.voids.as_ref().is_some_and(|voids| voids.count() == 1 && voids.is_void(0, 1)));
    let bytes: Vec<u8> = [1u16, 2, 3, 65_535].iter().flat_map(|value| value.to_be_bytes()).collect();
    let dem = grey_png(png::ColorType::Grayscale, Some(3), &bytes);
    assert_eq!((dem.reading.nodata, dem.voids.as_ref().map(|voids| voids.count())), (Some(3.0), Some(1)));
    assert!(dem.voids.as_ref().is_some_and(|voids| voids.is_void(0, 1)));
    assert_eq!(heights(&grey_png(png::ColorType::Grayscale, None, &bytes)), [1.0, 2.0, 3.0, 65_535.0]);
}

#[test]
fn spikes_are_named_and_become_voids() {
    let row = |spike: &str| format!("{spike} {}\n", "250 ".repeat(14));
    let rows: String = (0..15).map(|z| row(if z == 7 { "32767" } else { "-3" })).collect();
    let text = format!("ncols 15\nnrows 15\nxllcorner 0\nyllcorner 0\ncellsize 30\n{rows}");
    let dem = load("a.asc", text.clone().into_bytes());
    assert!(dem.voids.as_ref().is_some_and(|voids| voids.count() == 1 && voids.is_void(0, 7)));
    let [warning] = dem.reading.warnings.as_slice() else { panic!("{:?}", dem.reading.warnings) };
    let expected = "1 of 225 samples (0.444 %) are voids, 1 of them spikes, such as 32767 m at column 0, row 7";
    assert!(warning.starts_with(expected), "{warning}");
    let error = read_bytes("a.asc", text.into(), &ReadOptions { voids: VoidPolicy::Error, ..ReadOptions::default() });
    assert!(error.unwrap_err().to_string().contains("1 of them spikes"));
}
