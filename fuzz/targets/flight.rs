#![no_main]

use terrain_core::Heightmap;
use terrain_core::flight::{Flight, FlightPath};

libfuzzer_sys::fuzz_target!(|text: &str| {
    match Flight::parse("a.toml", text) {
        Ok(flight) => {
            let heightmap = Heightmap::new(5, 4, [30.0; 2], vec![7.0; 20]).expect("a small DEM");
            // It may be refused: a camera below the ground, say.
            let _ = FlightPath::new(&flight, &heightmap, 10);
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
});
