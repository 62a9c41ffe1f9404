#![no_main]

use std::fs;

use terrain_dem::ReadOptions;

// Samples and the `.hdr` beside them: which of both kinds, the header's length in two bytes, the header, the samples.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&[kind, low, high], rest)) = bytes.split_first_chunk() else { return };
    let Some((header, samples)) = rest.split_at_checked(u16::from_le_bytes([low, high]).into()) else { return };
    let folder = std::env::temp_dir().join(format!("terrain-fuzz-{}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder for the pair");
    let path = folder.join(["a.bil", "a.flt"][usize::from(kind & 1)]);
    fs::write(&path, samples).expect("the samples are written");
    fs::write(path.with_extension("hdr"), header).expect("the header is written");
    terrain_fuzz::read_file(&path, ReadOptions::default());
});
