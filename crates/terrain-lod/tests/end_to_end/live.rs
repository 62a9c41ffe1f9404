//! The live pass end to end: what it writes, and for which runs.

use crate::program::{Row, read_rows, terrain_lod};

/// Half a second over hilly ground: 31 frames at 60 a second.
const FLIGHT: &str = "
name = \"short\"
[[key]]
time_s = 0
at = [0.2, 0.5]
above_ground_m = 100
look_at = [0.9, 0.5]
[[key]]
time_s = 0.5
at = [0.6, 0.5]
above_ground_m = 100
look_at = [0.9, 0.6]
";

/// The columns that only the live pass fills.
const LIVE: [&str; 8] = [
    "live_fps",
    "stale_frames_share",
    "stale_patches_max",
    "live_plan_ms_max",
    "live_error_px_max",
    "live_error_px_rms",
    "live_over_tolerance_share",
    "late_frames",
];

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} is {:?} in {row:?}", row[column]))
}

#[test]
fn live_runs_are_measured_as_they_are_drawn_and_the_others_are_not() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("short.toml"), FLIGHT).unwrap();
    let flight = ["--flight", "short.toml", "--repeats", "2", "--out", "results"];
    let output = terrain_lod(place.path(), &[&["bench", "--no-gpu", "--suite", "live"], &flight[..]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows = read_rows(&place.path().join("results/summary.csv"));
    let runs: Vec<&str> = rows.iter().map(|row| row["setting"].as_str()).collect();
    assert_eq!(rows.len(), 6, "two schedules of two triangulators, and of bounded, which has one: {runs:#?}");
    let is_live = |row: &&Row| row["setting"].contains("schedule=live");
    assert_eq!(rows.iter().filter(is_live).count(), 3, "{runs:#?}");
    for row in &rows {
        assert_eq!((row["cracks"].as_str(), row["err"].as_str()), ("0", ""), "{row:?}");
        let filled: Vec<bool> = LIVE.iter().map(|column| !row[*column].is_empty()).collect();
        assert_eq!(filled, [is_live(&row); LIVE.len()], "{row:?}");
    }
    for row in rows.iter().filter(is_live) {
        assert_eq!((row["live_cracks"].as_str(), row["live_fps"].as_str()), ("0", "60.0"), "{row:?}");
        assert!(number(row, "live_error_px_max") > 0.0, "{row:?}");
    }
    let frames =
        read_rows(&place.path().join("results/frames/tin-algorithm1-1px-patch32-spade-live-threads2-live.csv"));
    assert_eq!(frames.len(), 2 * 31, "every frame of both flights");
    let stale = frames.iter().filter(|frame| frame["stale_patches"] != "0").count();
    let share = number(rows.iter().find(is_live).unwrap(), "stale_frames_share");
    assert!((share - stale as f64 / 62.0).abs() < 1e-6, "{stale} stale frames of 62, a share of {share}");
}
