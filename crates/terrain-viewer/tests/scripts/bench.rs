//! The HUD's numbers are the bench's.

use std::ffi::OsString;

use crate::stage::{SIZE, Stage};

/// The first frame of a flight: the bench flies it with one frame, the viewer stands there.
#[test]
fn the_hud_says_what_the_bench_measures_at_the_same_camera() {
    let script = "do left tin schedule=blocking tolerance_px=0.7\ndo right htp-instanced\nwait converged\nnumbers numbers.toml\n";
    let Some(stage) = Stage::run(script, &["--flight", "low-and-slow"]) else { return };
    let said = stage.numbers("numbers.toml");
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    for (side, method, tolerance) in [("left", "tin", "0.7"), ("right", "htp-instanced", "1")] {
        let out = stage.path(method);
        let bench =
            ["terrain-lod", "bench", "--no-gpu", "--flight", "low-and-slow", "--frames", "1", "--methods", method];
        let rest = ["--selector", "bounded", "--tolerance", tolerance, "--size", &size, "--out", out.to_str().unwrap()];
        let _ = terrain_lod::main_with(bench.into_iter().chain(rest).map(OsString::from));
        let row = error_row(&out);
        let numbers = said[side].as_table().unwrap();
        for (name, column) in [
            ("triangles", "triangles"),
            ("draws", "draws"),
            ("draw_calls", "draws"),
            ("uploaded_bytes", "upload_bytes"),
            ("cracks", "cracks"),
        ] {
            assert_eq!(numbers[name].as_integer().unwrap().to_string(), row[column], "{method}: {name}");
        }
        for name in ["error_px_max", "error_px_p99", "error_px_rms"] {
            let expected: f64 = row[name].parse().unwrap();
            assert_eq!(numbers[name].as_float().unwrap(), expected, "{method}: {name}");
        }
        assert!(numbers["error_px_max"].as_float().unwrap() > 0.1, "an error of nothing proves nothing");
    }
}

/// The only row of the error pass.
fn error_row(out: &std::path::Path) -> std::collections::HashMap<String, String> {
    let mut files = std::fs::read_dir(out.join("frames")).unwrap().map(|entry| entry.unwrap().path());
    let path = files.find(|path| path.to_str().unwrap().ends_with("-error.csv")).unwrap();
    let mut reader = csv::Reader::from_path(path).unwrap();
    let rows: Vec<std::collections::HashMap<String, String>> = reader.deserialize().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 1);
    rows.into_iter().next().unwrap()
}

#[test]
fn a_recorded_flight_is_one_that_the_bench_takes() {
    let script = "do above-ground\nkey R\nhold W 60\nhold ArrowRight 30\nkey R\nnumbers end.toml\nkey P\nwait 20\nnumbers playing.toml\n";
    let Some(stage) = Stage::run(script, &[]) else { return };
    let text = std::fs::read_to_string(stage.path("flight-001.toml")).unwrap();
    let flight = terrain_core::Flight::parse("flight-001.toml", &text).unwrap();
    assert!((flight.duration_s() - 1.5).abs() < 0.2, "{}", flight.duration_s());
    let frame = |name| stage.numbers(name)["flight_frame"].as_integer().unwrap();
    assert_eq!(frame("end.toml"), 0, "it is there to be played");
    assert!((15..=25).contains(&frame("playing.toml")), "{}", frame("playing.toml"));
    let out = stage.path("flown");
    let args = ["terrain-lod", "bench", "--no-gpu", "--frames", "3", "--methods", "full-grid", "--flight"];
    let rest = [stage.path("flight-001.toml").into_os_string(), "--out".into(), out.clone().into_os_string()];
    let _ = terrain_lod::main_with(args.into_iter().map(OsString::from).chain(rest));
    assert!(out.join("summary.csv").is_file() && !out.join("INCOMPLETE").exists());
}
