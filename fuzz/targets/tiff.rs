#![no_main]

use terrain_dem::ReadOptions;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    terrain_fuzz::read("a.tif", bytes, ReadOptions::default());
});
