#![no_main]

use terrain_dem::{RawLayout, ReadOptions};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    terrain_fuzz::read("a.r16", bytes, ReadOptions { raw: RawLayout::parse("4x3:int16"), ..ReadOptions::default() });
});
