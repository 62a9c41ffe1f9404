//! Loading beside the raw decoder of the same file: what voids, heights and places cost on top of the crates `png` and
//! `tiff`, which only fill a buffer.
//!
//! `cargo bench -p terrain-dem --bench load [-- SIDE...]`; without arguments 1025, 2049 and 4097 samples a side. The two
//! take turns, on one thread, the file in the page cache; each figure is the least of at least seven rounds, of small files of as many
//! as half a second has: the machine's memory is fast in some moments and slow in others.

use std::fs::File;
use std::hint::black_box;
use std::io::BufReader;
use std::path::Path;
use std::time::{Duration, Instant};

use terrain_dem::{ReadOptions, read, synthetic, write_png16};

#[allow(dead_code)]
#[path = "../tests/files/tiff_writer.rs"]
mod tiff_writer;

use tiff_writer::{TiffFile, Value, compress};

const ROUNDS: u32 = 7;
const AT_LEAST: Duration = Duration::from_millis(500);

/// Columns and rows of a tile, as GDAL makes them.
const TILE: usize = 256;

fn main() {
    let asked: Vec<u32> = std::env::args().skip(1).filter_map(|side| side.parse().ok()).collect();
    let sides = if asked.is_empty() { vec![1025, 2049, 4097] } else { asked };
    let folder = tempfile::tempdir().expect("a folder");
    println!("{:>6}  {:<28} {:>9} {:>9} {:>6}", "side", "file", "raw ms", "load ms", "ratio");
    for side in sides {
        let heights_m = synthetic::generate(side, side, 1).heights_m().to_vec();
        let path = folder.path().join("a.png");
        let values: Vec<u16> = heights_m.iter().map(|height_m| (height_m * 10.0) as u16).collect();
        write_png16(&path, side, side, &values).expect("a PNG");
        compare(side, "PNG, uint16", &path, raw_png);
        for (name, compression, is_tiled, is_float) in [
            ("TIFF, float32, strips", 1, false, true),
            ("TIFF, float32, deflate tiles", 8, true, true),
            ("TIFF, int16, deflate tiles", 8, true, false),
        ] {
            let path = folder.path().join("a.tif");
            std::fs::write(&path, tiff(side, &heights_m, compression, is_tiled, is_float)).expect("a TIFF");
            compare(side, name, &path, raw_tiff);
        }
    }
}

fn compare(side: u32, name: &str, path: &Path, raw: fn(&Path)) {
    let options = ReadOptions { spacing_m: Some([30.0; 2]), ..ReadOptions::default() };
    let load = || drop(black_box(read(path, &options).expect("a sound file")));
    let (mut raw_time, mut load_time) = (Duration::MAX, Duration::MAX);
    let (mut rounds, start) = (0, Instant::now());
    while rounds < ROUNDS || start.elapsed() < AT_LEAST {
        rounds += 1;
        raw_time = raw_time.min(time(|| raw(path)));
        load_time = load_time.min(time(load));
    }
    let [raw_ms, load_ms] = [raw_time, load_time].map(|time| time.as_secs_f64() * 1e3);
    println!("{side:>6}  {name:<28} {raw_ms:>9.2} {load_ms:>9.2} {:>6.2}", load_ms / raw_ms);
}

fn time(work: impl FnOnce()) -> Duration {
    let start = Instant::now();
    work();
    start.elapsed()
}

fn raw_png(path: &Path) {
    let file = BufReader::new(File::open(path).expect("a file"));
    let mut reader = png::Decoder::new(file).read_info().expect("a header");
    let mut picture = vec![0; reader.output_buffer_size().expect("a size")];
    reader.next_frame(&mut picture).expect("a picture");
    black_box(picture);
}

fn raw_tiff(path: &Path) {
    let file = BufReader::new(File::open(path).expect("a file"));
    let limits = tiff::decoder::Limits::unlimited();
    let mut decoder = tiff::decoder::Decoder::new(file).expect("a header").with_limits(limits);
    black_box(decoder.read_image().expect("a picture"));
}

/// A GeoTIFF with strips of 16 rows or tiles of 256 x 256.
fn tiff(side: u32, heights_m: &[f32], compression: u16, is_tiled: bool, is_float: bool) -> Vec<u8> {
    let side = side as usize;
    let [width, height] = if is_tiled { [TILE; 2] } else { [side, 16] };
    let sample = |column: usize, row: usize| {
        let height_m = heights_m[row.min(side - 1) * side + column.min(side - 1)];
        let bytes = if is_float { height_m.to_le_bytes().to_vec() } else { (height_m as i16).to_le_bytes().to_vec() };
        bytes.into_iter()
    };
    let chunk = |column: usize, row: usize| {
        let rows = row..if is_tiled { row + height } else { (row + height).min(side) };
        let plain: Vec<u8> =
            rows.flat_map(|row| (column..column + width).flat_map(move |column| sample(column, row))).collect();
        compress(compression, &plain)
    };
    let corners = (0..side).step_by(height).flat_map(|row| (0..side).step_by(width).map(move |column| (column, row)));
    let chunks = corners.map(|(column, row)| chunk(column, row)).collect();
    let short = |value: u16| Value::Shorts(vec![value]);
    let (bits, format) = if is_float { (32, 3) } else { (16, 2) };
    let all =
        [(256, side as u16), (257, side as u16), (258, bits), (259, compression), (262, 1), (277, 1), (339, format)];
    let shape = if is_tiled { vec![(322, TILE as u16), (323, TILE as u16)] } else { vec![(278, height as u16)] };
    let tags = all.into_iter().chain(shape).map(|(tag, value)| (tag, short(value))).collect();
    TiffFile { is_big_endian: false, is_big: false, is_tiled, tags, chunks }.bytes()
}
