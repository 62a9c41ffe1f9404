#![no_main]

// A suite file, with all that it inherits, and the runs of each bench.
libfuzzer_sys::fuzz_target!(|text: &str| {
    if let Err(fault) = terrain_lod::check_suite("a.toml", text) {
        assert!(!fault.to_string().contains('\n'), "{fault}");
    }
});
