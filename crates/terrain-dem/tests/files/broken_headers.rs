//! Files of all other formats that are wrong.

use terrain_dem::{ColourCode, RawLayout, ReadOptions};

use crate::broken::Case;
use crate::writers;

pub fn cases() -> Vec<Case> {
    [ascii(), tiles(), headers(), arrays(), greymaps(), pictures(), archives(), raw(), usgs(), strangers()]
        .into_iter()
        .flatten()
        .collect()
}

fn ascii() -> Vec<Case> {
    let case = |what: &str, text: String| Case::new(&format!("asc {what}"), "a.asc", text);
    let change = |from: &str, to: &str| {
        let text = writers::asc();
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    };
    vec![
        case("cut short", writers::asc()[..writers::asc().len() - 12].to_owned()),
        case("without heights", writers::ASC_HEADER.to_owned()),
        case("with a height too many", writers::asc() + "5\n"),
        case("with a word among the heights", change("\n4000 ", "\nhigh ")),
        case("with decimal commas", change("\n4000 ", "\n4000,5 ")),
        case("without rows", change("nrows 3\n", "")),
        case("of no columns", change("ncols 4", "ncols 0")),
        case("of half a row", change("nrows 3", "nrows 2.5")),
        case("of negative rows", change("nrows 3", "nrows -3")),
        case("of an absurd size", change("nrows 3", "nrows 4000000000")),
        case("of a size that the file cannot hold", change("ncols 4", "ncols 400")),
        case("of a size in letters", change("ncols 4", "ncols four")),
        case("without a cell size", change("cellsize 30\n", "")),
        case("of cell size 0", change("cellsize 30", "cellsize 0")),
        case("of a negative cell size", change("cellsize 30", "cellsize -30")),
        case("of cell size NaN", change("cellsize 30", "cellsize nan")),
        case("of one row", format!("ncols 4\nnrows 1\ncellsize 1\n{}", "1 2 3 4")),
        case("of voids alone", format!("{}{}", writers::ASC_HEADER, "-9999 ".repeat(12))),
        case("with a corner in letters", change("yllcorner 4000000", "yllcorner north")),
        case("with a number of a million digits", change("\n4000 ", &format!("\n{} ", "9".repeat(1_000_000)))),
    ]
}

fn tiles() -> Vec<Case> {
    let case = |what: &str, name, bytes: Vec<u8>| Case::new(&format!("hgt {what}"), name, bytes);
    let patched = |at: usize, bytes: &[u8]| {
        let mut file = writers::dted();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let voids = (0..25).flat_map(|_| [0x80, 0]).collect();
    vec![
        case("cut short", "N44W122.hgt", writers::hgt()[..40].to_vec()),
        case("of an odd length", "N44W122.hgt", [writers::hgt(), vec![0]].concat()),
        case("of one sample", "N44W122.hgt", vec![0, 1]),
        case("empty", "N44W122.hgt", Vec::new()),
        case("without a place in its name", "tile.hgt", writers::hgt()),
        case("with a place beyond the pole", "N91W122.hgt", writers::hgt()),
        case("of voids alone", "N44W122.hgt", voids),
        Case::new("dted cut short", "a.dt0", writers::dted()[..3480].to_vec()),
        Case::new("dted cut in its header", "a.dt0", writers::dted()[..60].to_vec()),
        Case::new("dted of counts in letters", "a.dt0", patched(47, b"four")),
        Case::new("dted of an absurd size", "a.dt0", patched(47, b"99999999")),
        Case::new("dted of spacing 0", "a.dt0", patched(20, b"0000")),
        Case::new("dted beyond the pole", "a.dt0", patched(12, b"0895959N")),
        Case::new("dted without a mark", "a.dt0", patched(3428 + 18, &[0])),
    ]
}

fn headers() -> Vec<Case> {
    let bil =
        |what: &str, header: String| Case::new(&format!("bil {what}"), "a.bil", writers::bil()).with_header(header);
    let change = |from: &str, to: &str| {
        assert!(writers::BIL_HEADER.contains(from), "{from}");
        writers::BIL_HEADER.replacen(from, to, 1)
    };
    let flt = |what: &str, bytes: Vec<u8>| {
        Case::new(&format!("flt {what}"), "b.flt", bytes).with_header(writers::FLT_HEADER.replace("MSB", "LSB"))
    };
    vec![
        bil("of more rows than samples", change("NROWS 3", "NROWS 4")),
        bil("of an absurd size", change("NROWS 3", "NROWS 4294967295").replace("NCOLS 4", "NCOLS 4294967295")),
        bil("of no rows", change("NROWS 3", "NROWS 0")),
        bil("without columns", change("NCOLS 4\n", "")),
        bil("of 24 bits", change("NBITS 16", "NBITS 24")),
        bil("of 64-bit integers", change("NBITS 16", "NBITS 64")),
        bil("of three bands", change("NBANDS 1", "NBANDS 3")),
        bil("of an unknown byte order", change("BYTEORDER I", "BYTEORDER X")),
        bil("with rows shorter than their samples", change("XDIM", "TOTALROWBYTES 6\nXDIM")),
        bil("with rows as long as numbers go", change("XDIM", "TOTALROWBYTES 18446744073709551615\nXDIM")),
        bil("with a start beyond its end", change("XDIM", "SKIPBYTES 18446744073709551615\nXDIM")),
        bil("with a start in letters", change("XDIM", "SKIPBYTES ten\nXDIM")),
        bil("of spacing 0", change("XDIM 30", "XDIM 0")),
        bil("of ENVI", "ENVI\nsamples = 4\nlines = 3\n".into()),
        bil("with a header that is none", "\u{0}\u{1}\u{2}".into()),
        bil("with a header of a megabyte", " ".repeat(1 << 20)),
        flt("cut short", writers::flt()[..40].to_vec()),
        flt("empty", Vec::new()),
        Case::new("hdr alone", "c.hdr", writers::BIL_HEADER),
    ]
}

fn arrays() -> Vec<Case> {
    let case = |what: &str, bytes: Vec<u8>| Case::new(&format!("npy {what}"), "a.npy", bytes);
    let of = |kind: &str, fortran: &str, shape: &str| {
        let dictionary = format!("{{'descr': '{kind}', 'fortran_order': {fortran}, 'shape': {shape}, }}");
        writers::npy(&dictionary, &writers::bil())
    };
    let whole = writers::npy_i2();
    vec![
        case("cut in its magic", whole[..7].to_vec()),
        case("cut in its header", whole[..30].to_vec()),
        case("cut short", whole[..whole.len() - 1].to_vec()),
        case("of version 9", [b"\x93NUMPY\x09", &whole[7..]].concat()),
        case("of a header as long as numbers go", [b"\x93NUMPY\x02\0\xff\xff\xff\xff", &whole[10..]].concat()),
        case("of complex numbers", of("<c8", "False", "(3, 4)")),
        case("of text", of("|S5", "False", "(3, 4)")),
        case("in Fortran order", of("<i2", "True", "(3, 4)")),
        case("of one dimension", of("<i2", "False", "(12,)")),
        case("of three dimensions", of("<i2", "False", "(1, 3, 4)")),
        case("of an absurd size", of("<i2", "False", "(4294967295, 4294967295)")),
        case("of a negative size", of("<i2", "False", "(-3, 4)")),
        case("without a dictionary", writers::npy("no dictionary", &[])),
        case("without a spacing", whole),
    ]
}

fn greymaps() -> Vec<Case> {
    let case = |what: &str, header: &str| Case::new(&format!("pgm {what}"), "a.pgm", writers::pgm(header));
    vec![
        case("of 8 bits", "P5 4 3 255 "),
        case("of a maximum of 0", "P5 4 3 0 "),
        case("of a maximum beyond 16 bits", "P5 4 3 65536 "),
        case("of letters", "P5 four 3 65535 "),
        case("of an absurd size", "P5 4294967295 4294967295 65535 "),
        case("of more rows than samples", "P5 4 4 65535 "),
        case("of a comment without end", &format!("P5 #{}", "x".repeat(1000))),
        Case::new("pgm of text that ends too soon", "a.pgm", "P2 4 3 65535 1 2 3 4 5 6 7 8 9 10 1123"),
    ]
}

fn pictures() -> Vec<Case> {
    use image::{ExtendedColorType, ImageEncoder};
    let png = |kind: ExtendedColorType, bytes: &[u8]| {
        let mut file = Vec::new();
        image::codecs::png::PngEncoder::new(&mut file).write_image(bytes, 2, 2, kind).unwrap();
        file
    };
    let spaced = || ReadOptions { spacing_m: Some([1.0; 2]), ..ReadOptions::default() };
    let case = |what: &str, bytes: Vec<u8>| Case::new(&format!("png {what}"), "a.png", bytes).with_options(spaced());
    let grey = png(ExtendedColorType::L16, &[0; 8]);
    let coded = ReadOptions { colours: Some(ColourCode::Mapbox), ..spaced() };
    vec![
        case("of 8 bits", png(ExtendedColorType::L8, &[0; 4])),
        case("of colours", png(ExtendedColorType::Rgb16, &[0; 24])),
        case("of transparency alone", png(ExtendedColorType::La16, &[0; 16])),
        case("cut in its header", grey[..20].to_vec()),
        case("cut short", grey[..grey.len() - 20].to_vec()),
        case(
            "of more samples than its bytes can hold",
            [&grey[..16], &[0, 0, 89, 216].repeat(2), &grey[24..]].concat(),
        ),
        case("with a wrong checksum", [&grey[..29], &[1, 2, 3, 4], &grey[33..]].concat()),
        case("of grey where colours are coded", grey).with_options(coded),
    ]
}

fn archives() -> Vec<Case> {
    let case = |what: &str, name, bytes: Vec<u8>| Case::new(what, name, bytes);
    let gzip = writers::gzip(&writers::hgt_of(40));
    let zip = writers::zip(&[("N44W122.hgt", &writers::hgt())]);
    let mut method = zip.clone();
    let list = zip.windows(4).position(|w| w == b"PK\x01\x02").unwrap();
    method[list + 10] = 12;
    let mut astray = zip.clone();
    astray[list + 42] = 7;
    let mut changed = zip.clone();
    changed[list + 16] ^= 1;
    let small = ReadOptions { max_samples: Some(25), ..ReadOptions::default() };
    let bomb = writers::gzip(&vec![0; 10 << 20]);
    vec![
        case("gzip cut short", "N44W122.hgt.gz", gzip[..gzip.len() - 20].to_vec()),
        case("gzip with a wrong checksum", "N44W122.hgt.gz", {
            let end = gzip.len();
            [&gzip[..end - 8], &[1, 2, 3, 4], &gzip[end - 4..]].concat()
        }),
        case("gzip of nothing known", "a.gz", writers::gzip(b"hello, this is text")),
        case("gzip in a gzip", "a.gz.gz", writers::gzip(&gzip)),
        case("gzip that swells beyond the limit", "N44W122.hgt.gz", bomb).with_options(small),
        case("gzip that swells beyond what heights do", "N44W122.hgt.gz", writers::gzip(&vec![0; 80 << 20])),
        case("zip cut short", "a.zip", zip[..zip.len() - 30].to_vec()),
        case("zip of two tiles", "a.zip", {
            writers::zip(&[("N44W122.hgt", &writers::hgt()), ("N45W122.hgt", &writers::hgt())])
        }),
        case("zip of nothing", "a.zip", [b"PK\x03\x04".as_slice(), &writers::zip(&[])].concat()),
        case("zip of another method", "a.zip", method),
        case("zip whose list points elsewhere", "a.zip", astray),
        case("zip with a wrong checksum", "a.zip", changed),
        case("zip of a grid and its .prj", "a.zip", writers::zip(&[("a.asc", b"ncols 2"), ("a.prj", b"PROJCS")])),
    ]
}

fn raw() -> Vec<Case> {
    let asked = |layout| ReadOptions { raw: RawLayout::parse(layout), ..ReadOptions::default() };
    let case =
        |what: &str, layout| Case::new(&format!("raw {what}"), "a.r16", writers::bil()).with_options(asked(layout));
    vec![
        case("too short", "4x4:uint16"),
        case("too long", "4x2:uint16"),
        case("of an absurd size", "4294967295x4294967295:float64"),
        case("without a spacing", "4x3:int16"),
    ]
}

fn usgs() -> Vec<Case> {
    let sound = writers::usgs(1024);
    let with = |at: usize, text: &str| {
        let mut file = sound.clone();
        file[at..at + text.len()].copy_from_slice(text.as_bytes());
        file
    };
    let case = |what: &str, bytes: Vec<u8>| Case::new(&format!("usgs {what}"), "a.dem", bytes);
    vec![
        case("cut in its header", sound[..900].to_vec()),
        case("cut in a profile", sound[..2 * 1024 + 150].to_vec()),
        case("of radians", with(528, "     0")),
        case("of no columns", with(858, "     0")),
        case("of more columns than it holds", with(858, "999999")),
        case("of a step of nothing", with(816, " 0.00000E+00")),
        case("with a profile of no heights", with(1024 + 12, "     0")),
        case("with a profile of letters", with(1024 + 24, "  here  ")),
        case("with a profile beside the grid", with(1024 + 24, "  0.500010000000000D+06")),
        case("with a height of letters", with(1024 + 144, "  tall")),
        case("in lines", writers::usgs(1025)),
    ]
}

/// Files of formats that are not read.
fn strangers() -> Vec<Case> {
    let case = |what: &str, start: &[u8]| {
        Case::new(&format!("stranger: {what}"), "a.dem", [start, b" and so on, and so on"].concat())
    };
    vec![
        case("DTED from a tape", b"HDR1"),
        case("NetCDF", b"CDF\x01"),
        case("HDF5", b"\x89HDF\r\n\x1a\n"),
        case("LAS", b"LASF"),
        case("JPEG", b"\xff\xd8\xff\xe0"),
        case("JPEG 2000", b"\0\0\0\x0cjP  "),
        case("a web page", b"\n<!DOCTYPE html>"),
        case("a Git LFS pointer", b"version https://git-lfs.github.com/spec/v1"),
        case("a 7z archive", b"7z\xbc\xaf\x27\x1c"),
        case("a virtual raster", b"<VRTDataset rasterXSize=\"4\">"),
        case("bytes", &[1, 2, 3, 250, 251, 252]),
        Case::new("stranger: zeros", "a.dem", vec![0; 5000]),
        Case::new("stranger: nothing", "a.dem", Vec::new()),
    ]
}
