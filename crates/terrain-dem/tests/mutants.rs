//! Files with random damage: whatever comes of them, no panic, no more memory than allowed, an error of one line.
//!
//! A failure prints its seed. In a binary of its own, since it looks at the memory of the whole process.

use std::panic::{AssertUnwindSafe, catch_unwind};

use terrain_core::SplitMix64;
use terrain_core::damage::damage;
use terrain_dem::{ColourCode, RawLayout, ReadOptions, read, read_bytes};

#[allow(dead_code)]
#[path = "files/tiff_writer.rs"]
mod tiff_writer;
#[allow(dead_code)]
#[path = "files/writers.rs"]
mod writers;

use tiff_writer::{Kind, Value, Variant};

/// Mutants of each file, unless `TERRAIN_MUTANTS` says how many.
const ROUNDS: u64 = 3000;

const MAX_SAMPLES: u64 = 1 << 16;

/// What reading any of these files may take, in KiB: far less than what their headers can promise.
const MAX_GROWTH_KIB: u64 = 160 << 10;

struct Subject {
    name: &'static str,
    bytes: Vec<u8>,
    /// Of the `.hdr` beside it, which is damaged too.
    header: Option<&'static str>,
    options: ReadOptions,
}

fn subject(name: &'static str, bytes: Vec<u8>) -> Subject {
    let options = ReadOptions { max_samples: Some(MAX_SAMPLES), ..ReadOptions::default() };
    Subject { name, bytes, header: None, options }
}

fn tiffs() -> Vec<Subject> {
    let plain = Variant::plain(Kind::F32);
    let variants = [
        plain,
        Variant { compression: 8, predictor: 3, tile: Some([16, 16]), is_big_endian: true, ..plain },
        Variant { compression: 5, predictor: 2, tile: Some([4, 4]), kind: Kind::I16, ..plain },
        Variant { compression: 32773, is_big: true, kind: Kind::U16, bands: 3, is_planar: true, ..plain },
        Variant { compression: 50000, kind: Kind::F64, is_big: true, is_big_endian: true, ..plain },
    ];
    let metadata = "<GDALMetadata><Item name=\"a\" sample=\"0\" role=\"scale\">0.1</Item></GDALMetadata>";
    let keys = &[[1024, 0, 1, 2], [1025, 0, 1, 1], [1026, 34737, 6, 0], [3077, 34736, 1, 0]];
    let file = |variant: Variant| {
        let mut file = variant.file();
        file.place([0.001; 2], [7.0, 45.0], keys);
        let file = file.with(34737, Value::Text("place|".into())).with(34736, Value::Doubles(vec![1.0]));
        file.with(42112, Value::Text(metadata.into())).with(42113, Value::Text("7".into())).bytes()
    };
    variants.map(|variant| subject("a.tif", file(variant))).into()
}

fn others() -> Vec<Subject> {
    use image::{ExtendedColorType, ImageEncoder};
    let mut png = Vec::new();
    image::codecs::png::PngEncoder::new(&mut png).write_image(&[9; 64], 8, 4, ExtendedColorType::L16).unwrap();
    let mut coded = Vec::new();
    image::codecs::png::PngEncoder::new(&mut coded).write_image(&[9; 96], 8, 4, ExtendedColorType::Rgb8).unwrap();
    let with = |options: fn(&mut ReadOptions), mut subject: Subject| {
        options(&mut subject.options);
        subject
    };
    let spaced = |subject| with(|options| options.spacing_m = Some([1.0; 2]), subject);
    let headed = |header, subject| Subject { header: Some(header), ..subject };
    vec![
        subject("a.asc", writers::asc().into_bytes()),
        subject("N44W122.hgt", writers::hgt()),
        subject("a.dt0", writers::dted()),
        subject("a.dem", writers::usgs(1024)),
        subject("N44W122.hgt.gz", writers::gzip(&writers::hgt())),
        subject("a.zip", writers::zip(&[("N44W122.hgt", &writers::hgt())])),
        spaced(subject("a.pgm", writers::pgm("P5 4 3 65535 "))),
        spaced(subject("a.pgm", format!("P2 4 3 65535 {}", writers::words(" ", " ").replace('-', "")).into_bytes())),
        spaced(subject("a.npy", writers::npy_i2())),
        spaced(subject("a.png", png)),
        with(|options| options.colours = Some(ColourCode::Mapbox), spaced(subject("a.png", coded))),
        with(|options| options.raw = RawLayout::parse("4x3:int16"), spaced(subject("a.raw", writers::bil()))),
        headed(writers::BIL_HEADER, subject("a.bil", writers::bil())),
        headed(writers::FLT_HEADER, subject("b.flt", writers::flt())),
    ]
}

/// Reads one mutant; true if it still was a DEM.
fn check(subject: &Subject, seed: u64, folder: &std::path::Path) -> bool {
    let mut random = SplitMix64::new(seed);
    let bytes = damage(&subject.bytes, &mut random);
    let result = match subject.header {
        None => read_bytes(subject.name, bytes, &subject.options),
        Some(header) => {
            let path = folder.join(subject.name);
            // The samples alone break in few ways.
            let broken = damage(header.as_bytes(), &mut random);
            std::fs::write(&path, if random.below(4) == 0 { &bytes } else { &subject.bytes }).unwrap();
            std::fs::write(path.with_extension("hdr"), broken).unwrap();
            read(&path, &subject.options)
        }
    };
    match result {
        Ok(ref dem) => assert!(dem.heightmap.heights_m().len() as u64 <= MAX_SAMPLES),
        Err(ref error) => assert!(!error.is_io() && !error.to_string().contains('\n'), "{error}"),
    }
    result.is_ok()
}

/// The most memory that the process ever had mapped, touched or not; `None` where the system does not say.
fn peak_kib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmPeak:"))?.split_whitespace().next()?.parse().ok()
}

#[test]
fn damaged_files_neither_panic_nor_swell() {
    let folder = tempfile::tempdir().unwrap();
    let rounds = std::env::var("TERRAIN_MUTANTS").map_or(ROUNDS, |rounds| rounds.parse().unwrap());
    for subject in tiffs().into_iter().chain(others()) {
        assert!(read_once(&subject, folder.path()), "{} is broken before it is damaged", subject.name);
        let (before, mut sound) = (peak_kib(), 0);
        for seed in 0..rounds {
            let outcome = catch_unwind(AssertUnwindSafe(|| check(&subject, seed, folder.path())));
            sound += u64::from(outcome.unwrap_or_else(|_| panic!("{}: seed {seed}", subject.name)));
            if let Some((before, now)) = before.zip(peak_kib()) {
                assert!(now - before < MAX_GROWTH_KIB, "{}: seed {seed}: {} KiB", subject.name, now - before);
            }
        }
        println!(
            "{}: {sound} of {rounds} still load, {:?} KiB",
            subject.name,
            peak_kib().zip(before).map(|(n, b)| n - b)
        );
        assert!(sound < rounds);
    }
    // The gauge works: it sees memory that was only asked for.
    let before = peak_kib();
    drop(std::hint::black_box(Vec::<u8>::with_capacity(1 << 29)));
    assert!(before.zip(peak_kib()).is_none_or(|(before, now)| now - before > MAX_GROWTH_KIB));
}

fn read_once(subject: &Subject, folder: &std::path::Path) -> bool {
    match subject.header {
        None => read_bytes(subject.name, subject.bytes.clone(), &subject.options).is_ok(),
        Some(header) => {
            let path = folder.join(subject.name);
            std::fs::write(&path, &subject.bytes).unwrap();
            std::fs::write(path.with_extension("hdr"), header).unwrap();
            read(&path, &subject.options).is_ok()
        }
    }
}

/// What fuzzers begin with: one file a subject, in a folder for each target of `fuzz/`.
#[test]
#[ignore = "writes into fuzz/corpus"]
fn seeds_for_fuzzers() {
    let corpus = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    for (number, subject) in tiffs().into_iter().chain(others()).enumerate() {
        let (target, bytes) = seed(&subject);
        let folder = corpus.join(target);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join(format!("seed-{number}")), bytes).unwrap();
    }
}

/// The target for a subject, and its input.
fn seed(subject: &Subject) -> (&'static str, Vec<u8>) {
    let Subject { name, bytes, header, options } = subject;
    let target = match name.rsplit_once('.').unwrap().1 {
        _ if header.is_some() => "headed",
        "png" if options.colours.is_some() => "png_colours",
        "tif" => "tiff",
        "asc" => "ascii_grid",
        "dt0" => "dted",
        "dem" => "usgs_dem",
        "gz" | "zip" => "archive",
        ending => ending,
    };
    let Some(header) = header else { return (target, bytes.clone()) };
    let length = (header.len() as u16).to_le_bytes();
    (target, [&[name.ends_with("flt") as u8], &length[..], header.as_bytes(), bytes].concat())
}
