#![no_main]

use terrain_dem::ReadOptions;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    terrain_fuzz::read("a.png", bytes, ReadOptions { allow_8_bit: true, ..ReadOptions::default() });
});
