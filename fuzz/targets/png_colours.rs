#![no_main]

use terrain_dem::{ColourCode, ReadOptions};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    terrain_fuzz::read("a.png", bytes, ReadOptions { colours: Some(ColourCode::Terrarium), ..ReadOptions::default() });
});
