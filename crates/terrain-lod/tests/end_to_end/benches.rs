//! Suites of several benches: a folder each, one summary and one set of tables over all.

use std::path::Path;
use std::process::Output;

use crate::program::{read_rows, terrain_lod};

const SUITE: &str = r#"
methods = ["htp", "decimated"]
step = [2, 4]
size_px = [160, 90]
frames = 4
repeats = 2

[[tables]]
title = "Triangles by bench"
rows = ["bench", "method"]
columns = "k"
values = ["triangles_mean"]

[[tables]]
title = "Of one bench"
only = { bench = "large", method = "decimated" }
rows = ["step"]
values = ["triangles_mean"]

[[equal_error]]
title = "At equal error"
errors_px = [20, 100]
measures = ["error_px_max"]
costs = ["triangles_mean", "plan_ms_p50"]

[[benches]]
name = "small"
dem = "synthetic:33x33:1"
k = [2, 3]

[[benches]]
name = "large"
dem = "synthetic:97x97:1"
crop = "65x65"

[[benches]]
name = "huge"
dem = "synthetic:129x129:1"
optional = true
"#;

/// A folder with the suite in it.
fn place_with(suite: &str) -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("two.toml"), suite).unwrap();
    place
}

fn fly(place: &Path, more: &[&str]) -> Output {
    terrain_lod(place, &[&["bench", "--no-gpu", "--suite", "two.toml", "--out", "results"], more].concat())
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Which bench, what and how many: of each row of a summary what no clock has made.
fn counts(summary: &Path) -> Vec<[String; 5]> {
    let columns = ["bench", "run", "dem", "triangles_mean", "error_px_max"];
    read_rows(summary).iter().map(|row| columns.map(|name| row.get(name).cloned().unwrap_or_default())).collect()
}

#[test]
fn each_bench_has_a_folder_and_all_have_one_summary() {
    let place = place_with(SUITE);
    let output = fly(place.path(), &[]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let results = place.path().join("results");
    let rows = counts(&results.join("summary.csv"));
    let benches: Vec<&str> = rows.iter().map(|row| row[0].as_str()).collect();
    assert_eq!(benches, ["small", "small", "small", "small", "large", "large", "large"]);
    assert_eq!(rows[4][2], "synthetic-97x97-1-65x65+16+16", "{rows:?}");
    for name in ["small", "large"] {
        let own = counts(&results.join(name).join("summary.csv"));
        let ours: Vec<_> = rows.iter().filter(|row| row[0] == name).map(|row| row[1..].to_vec()).collect();
        assert_eq!(own.iter().map(|row| row[1..].to_vec()).collect::<Vec<_>>(), ours);
        assert!(!results.join(name).join("INCOMPLETE").exists());
        let report = terrain_lod(place.path(), &["report", &format!("results/{name}")]);
        assert!(report.status.success(), "{}", text(&report.stderr));
    }
    assert!(!results.join("huge").exists() && !results.join("INCOMPLETE").exists());
    let said = text(&output.stdout);
    let tables = std::fs::read_to_string(results.join("tables.md")).unwrap();
    assert!(said.contains("## large\n") && said.contains(&tables), "{said}");
    assert!(tables.contains("| small | htp ") && tables.contains("### Of one bench\n\n| step | triangles mean |"));
    let equal = read_rows(&results.join("equal-error.csv"));
    assert_eq!(equal.len(), 5 * 2 * 2, "three families in one bench, two in the other, by error and cost");
}

#[test]
fn a_suite_goes_on_with_the_first_bench_that_is_not_complete() {
    let place = place_with(SUITE);
    assert!(fly(place.path(), &[]).status.success());
    let results = place.path().join("results");
    let whole = counts(&results.join("summary.csv"));
    // As a kill in the second bench leaves it: the marker, and frames of one run missing.
    for name in ["INCOMPLETE", "large/INCOMPLETE"] {
        std::fs::write(results.join(name), "").unwrap();
    }
    std::fs::remove_file(results.join("large/summary.csv")).unwrap();
    std::fs::remove_file(results.join("large/frames/decimated-step2-speed.csv")).unwrap();
    let first = std::fs::metadata(results.join("small/summary.csv")).unwrap().modified().unwrap();
    let output = terrain_lod(place.path(), &["bench", "--resume", "results"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("## small\n\nComplete before."), "{}", text(&output.stdout));
    assert_eq!(counts(&results.join("summary.csv")), whole);
    assert_eq!(std::fs::metadata(results.join("small/summary.csv")).unwrap().modified().unwrap(), first, "untouched");
    let again = terrain_lod(place.path(), &["bench", "--resume", "results"]);
    assert_eq!(again.status.code(), Some(2), "complete: {}", text(&again.stderr));
    // One bench alone goes on as well, by its own folder.
    std::fs::write(results.join("small/INCOMPLETE"), "").unwrap();
    let one = terrain_lod(place.path(), &["bench", "--resume", "results/small"]);
    assert!(one.status.success() && !results.join("small/INCOMPLETE").exists(), "{}", text(&one.stderr));
}

/// A kill between the making of a bench's folder and its `machine.json` costs nothing.
#[test]
fn a_bench_that_was_killed_at_its_start_is_begun_again() {
    let place = place_with(SUITE);
    assert!(fly(place.path(), &[]).status.success());
    let results = place.path().join("results");
    let whole = counts(&results.join("summary.csv"));
    std::fs::write(results.join("INCOMPLETE"), "").unwrap();
    std::fs::remove_dir_all(results.join("large")).unwrap();
    std::fs::create_dir_all(results.join("large")).unwrap();
    std::fs::write(results.join("large/INCOMPLETE"), "").unwrap();
    let output = terrain_lod(place.path(), &["bench", "--resume", "results"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(counts(&results.join("summary.csv")), whole);
}

#[test]
fn flags_override_every_bench_and_choose_among_them() {
    let place = place_with(SUITE);
    let output = fly(place.path(), &["--methods", "htp", "--k", "4", "--benches", "huge,small"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let rows = counts(&place.path().join("results/summary.csv"));
    let found: Vec<[&str; 2]> = rows.iter().map(|row| [row[0].as_str(), row[1].as_str()]).collect();
    assert_eq!(
        found,
        [["small", "htp-distance-leg8px-k4-l3-per-patch"], ["huge", "htp-distance-leg8px-k4-l3-per-patch"]]
    );
    let listed = text(&terrain_lod(place.path(), &["bench", "--no-gpu", "--suite", "two.toml", "--dry-run"]).stdout);
    assert!(listed.contains("## small\n") && listed.contains("## large\n") && !listed.contains("huge"), "{listed}");
}

#[test]
fn what_is_wrong_with_a_bench_is_said_in_one_line() {
    let wrong = [
        ("crop = \"65x65\"", "crop = \"650x65\"", "synthetic:97x97:1", 4),
        ("crop = \"65x65\"", "crop = 65", "two.toml: bench \"large\": invalid type: integer `65`", 4),
        ("k = [2, 3]", "thin = 0", "suite two.toml: bench \"small\": thin = 0; expected 1 to 65535", 4),
        ("[[benches]]\nname = \"small\"", "[[benches]]", "two.toml: bench 1 of 3: missing field `name`", 4),
        ("dem = \"synthetic:33x33:1\"", "dem = \"puget\"\nstand_in = \"none\"", "none", 4),
    ];
    for (from, to, expected, code) in wrong {
        let place = place_with(&SUITE.replace(from, to));
        let output = fly(place.path(), &[]);
        let said = text(&output.stderr);
        assert_eq!((output.status.code(), said.lines().count()), (Some(code), 1), "{to}: {said}");
        assert!(said.contains(expected), "{to}: {said}");
        assert!(!place.path().join("results").exists(), "{to}: nothing is begun");
    }
    let place = place_with(SUITE);
    for flags in [["--benches", "none"], ["--puget", "ps.png"], ["--filter", "nothing"]] {
        assert_eq!(fly(place.path(), &flags).status.code(), Some(2), "{flags:?}");
    }
}

/// Without the file a bench over Puget Sound flies over its stand-in and says so, or is left out and says so.
#[test]
fn puget_sound_has_stand_ins() {
    let puget =
        SUITE.replace("synthetic:33x33:1\"", "puget\"\nstand_in = \"synthetic:33x33:2\"\nspacing_m = [160, 160]");
    let place = place_with(&puget.replace("synthetic:97x97:1", "puget"));
    assert!(fly(place.path(), &[]).status.success());
    let tables = std::fs::read_to_string(place.path().join("results/tables.md")).unwrap();
    assert!(
        tables.starts_with("- small: DEM synthetic-33x33-2 (33 x 33 samples), flight ground-level, 4 frames"),
        "{tables}"
    );
    assert!(tables.contains("- small: synthetic:33x33:2 stands in for Puget Sound"), "{tables}");
    assert!(tables.contains("- large is not flown: it needs Puget Sound; --puget FILE names it"), "{tables}");
    assert_eq!(counts(&place.path().join("results/summary.csv")).len(), 4);
}
