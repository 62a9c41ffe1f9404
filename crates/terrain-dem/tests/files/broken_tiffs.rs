//! TIFFs that are wrong.

use terrain_dem::{ReadOptions, VoidPolicy};

use crate::broken::Case;
use crate::tiff_writer::{Kind, TiffFile, Value, Variant};

use Value::{Doubles, Longs, Longs8, Shorts, Text};

fn file() -> TiffFile {
    Variant::plain(Kind::I16).file()
}

fn packed(compression: u16) -> TiffFile {
    Variant { compression, ..Variant::plain(Kind::I16) }.file()
}

fn float() -> TiffFile {
    Variant::plain(Kind::F32).file()
}

/// A file with other bytes at one place.
fn patched(file: &TiffFile, at: usize, bytes: &[u8]) -> Vec<u8> {
    let mut whole = file.bytes();
    whole[at..at + bytes.len()].copy_from_slice(bytes);
    whole
}

fn geographic(latitude: f64, extra: [u16; 4]) -> TiffFile {
    let mut file = file();
    file.place([0.001, 0.001], [7.0, latitude], &[[1024, 0, 1, 2], extra]);
    file
}

/// Two numbers in a matrix: those that turn it.
fn affine(step: [f64; 2], turn: [f64; 2]) -> TiffFile {
    let ([x, z], [b, c]) = (step, turn);
    file().with(34264, Doubles(vec![x, b, 0.0, 0.0, c, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]))
}

fn case(what: &str, file: TiffFile) -> Case {
    Case::new(&format!("tiff {what}"), "a.tif", file.bytes())
}

fn raw(what: &str, bytes: Vec<u8>) -> Case {
    Case::new(&format!("tiff {what}"), "a.tif", bytes)
}

pub fn cases() -> Vec<Case> {
    [containers(), layouts(), chunks(), places(), asked()].into_iter().flatten().collect()
}

fn containers() -> Vec<Case> {
    let whole = file().bytes();
    let big = || Variant { is_big: true, ..Variant::plain(Kind::I16) }.file();
    let at = u32::from_le_bytes(whole[4..8].try_into().unwrap()) as usize;
    let many = [&whole[..at], &[255, 255]].concat();
    vec![
        raw("of four bytes", b"II*\0".to_vec()),
        raw("that ends in its header", whole[..7].to_vec()),
        raw("cut in half", whole[..whole.len() / 2].to_vec()),
        raw("cut before its last tag", whole[..whole.len() - 10].to_vec()),
        raw("with its directory beyond the end", patched(&file(), 4, &[255, 255, 255, 127])),
        raw("with the other byte order's mark", patched(&file(), 0, b"MM\0*")),
        raw("of too many tags", many),
        raw("big, cut in its header", big().bytes()[..12].to_vec()),
        raw("big, with its directory beyond the end", patched(&big(), 8, &[255; 8])),
        raw("without a directory", patched(&file(), 4, &[0; 4])),
    ]
}

fn layouts() -> Vec<Case> {
    let tiled = || Variant { tile: Some([16, 16]), ..Variant::plain(Kind::I16) }.file();
    vec![
        case("without a width", file().without(256)),
        case("of no rows", file().with(257, Shorts(vec![0]))),
        case("wider than 32 bits", file().with(256, Longs8(vec![1 << 40]))),
        case("of one column", file().with(256, Shorts(vec![1]))),
        case("of a side beyond the limit", file().with(256, Longs(vec![70_000]))),
        case("of an absurd size", file().with(256, Longs(vec![u32::MAX])).with(257, Longs(vec![u32::MAX]))),
        case("of 12 bits", file().with(258, Shorts(vec![12]))),
        case("of one bit", file().without(258)),
        case("of complex numbers", file().with(258, Shorts(vec![64])).with(339, Shorts(vec![6]))),
        case("of mixed bands", file().with(258, Shorts(vec![16, 8])).with(277, Shorts(vec![2]))),
        case("of a palette", file().with(262, Shorts(vec![3]))),
        case("of bits in reverse", file().with(266, Shorts(vec![2]))),
        case("of colours", Variant { bands: 3, ..Variant::plain(Kind::U8) }.file().with(262, Shorts(vec![2]))),
        case("in JPEG", file().with(259, Shorts(vec![7]))),
        case("in LERC", file().with(259, Shorts(vec![34887]))),
        case("in LZMA", file().with(259, Shorts(vec![34925]))),
        case("in WebP", file().with(259, Shorts(vec![50001]))),
        case("in an unknown compression", file().with(259, Shorts(vec![9999]))),
        case("of an unknown predictor", file().with(317, Shorts(vec![4]))),
        case("of integers with the floats' predictor", file().with(317, Shorts(vec![3]))),
        case("of no columns a tile", tiled().with(322, Shorts(vec![0]))),
        case("of endless rows", tiled().with(322, Longs(vec![u32::MAX]))),
        case("of too many bands", file().with(277, Shorts(vec![65_535]))),
    ]
}

fn chunks() -> Vec<Case> {
    let mut no_strips = file();
    no_strips.chunks.iter_mut().for_each(Vec::clear);
    let spoilt = |compression| {
        let mut file = packed(compression);
        let middle = file.chunks[1].len() / 2;
        file.chunks[1][..middle].fill(0xff);
        file
    };
    let short = |compression| {
        let mut file = packed(compression);
        let length = file.chunks[2].len();
        file.chunks[2].truncate(length / 2);
        file
    };
    vec![
        case("with too few strips", file().with(278, Shorts(vec![1]))),
        case("with too many strips", file().with(278, Shorts(vec![9]))),
        case("without strips", no_strips),
        case("without byte counts", file().with(279, Longs(vec![]))),
        case("with byte counts that are doubles", file().with(279, Doubles(vec![104.0, 104.0, 26.0]))),
        case("with a strip beyond the end", file().with(273, Longs(vec![8, 112, 99_999]))),
        case("with a strip longer than the file", file().with(279, Longs(vec![104, 104, 99_999]))),
        case("with a strip that ends beyond all", file().with(273, Longs8(vec![8, 112, u64::MAX - 3]))),
        case("with a strip too short for its samples", file().with(279, Longs(vec![104, 50, 26]))),
        case("that promises more than deflate can", packed(8).with(256, Longs(vec![60_000]))),
        case("that promises more than LZW can", packed(5).with(256, Longs(vec![60_000]))),
        case("that promises more than PackBits can", packed(32773).with(256, Longs(vec![60_000]))),
        case("that is not deflate", spoilt(8)),
        case("that is not LZW", spoilt(5)),
        case("that is not ZSTD", spoilt(50000)),
        case("with deflate cut short", short(8)),
        case("with LZW cut short", short(5)),
        case("with PackBits cut short", short(32773)),
        case("with ZSTD cut short", short(50000)),
    ]
}

fn places() -> Vec<Case> {
    vec![
        case("rotated", affine([20.0, -20.0], [5.0, 5.0])),
        case("mirrored", affine([-30.0, -30.0], [0.0, 0.0])),
        case("of no spacing", file().without(33550)),
        case("of spacing 0", file().with(33550, Doubles(vec![0.0, 30.0, 0.0]))),
        case("of spacing NaN", file().with(33550, Doubles(vec![30.0, f64::NAN, 0.0]))),
        case("of infinite spacing", file().with(33550, Doubles(vec![f64::INFINITY, 30.0, 0.0]))),
        case("beyond the pole", geographic(95.0, [1025, 0, 1, 1])),
        case("in radians", geographic(45.0, [2054, 0, 1, 9101])),
        case("in chains", {
            let mut file = file();
            file.place([30.0; 2], [0.0; 2], &[[1024, 0, 1, 1], [3076, 0, 1, 9097]]);
            file
        }),
        case("geocentric", {
            let mut file = file();
            file.place([30.0; 2], [0.0; 2], &[[1024, 0, 1, 3]]);
            file
        }),
        case("of voids alone", {
            let mut file = file().with(42113, Text("7".into()));
            file.chunks.iter_mut().for_each(|chunk| chunk.chunks_mut(2).for_each(|s| s.copy_from_slice(&[7, 0])));
            file
        }),
        case("of NaN alone", {
            let mut file = float();
            file.chunks.iter_mut().for_each(|chunk| chunk.fill(0xff));
            file
        }),
    ]
}

fn asked() -> Vec<Case> {
    let default = ReadOptions::default;
    let with_void = || file().with(42113, Text(Kind::I16.sample(3, 3).to_string()));
    vec![
        case("asked for band 2", file()).with_options(ReadOptions { band: Some(2), ..default() }),
        case("asked for band 0", file()).with_options(ReadOptions { band: Some(0), ..default() }),
        case("asked for no voids", with_void()).with_options(ReadOptions { voids: VoidPolicy::Error, ..default() }),
        case("asked for fewer samples", file()).with_options(ReadOptions { max_samples: Some(100), ..default() }),
        case("asked for a scale of infinity", file())
            .with_options(ReadOptions { scale: Some(f64::INFINITY), ..default() }),
        case("asked for a scale that leaves no heights", float()).with_options(ReadOptions {
            scale: Some(1e300),
            offset_m: Some(1e300),
            ..default()
        }),
        case("asked for a spacing of 0", file()).with_options(ReadOptions { spacing_m: Some([0.0, 1.0]), ..default() }),
    ]
}
