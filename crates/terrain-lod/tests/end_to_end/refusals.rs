//! Bad input: one clear line on stderr, the documented exit code, and nothing left behind that looks like a result.

use std::path::Path;

use crate::program::terrain_lod;

/// A folder with files that are wrong in one way each.
fn wrong_files() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
    write("text.png", "these are no pixels");
    write(
        "nan.toml",
        "name = \"f\"\n[[key]]\ntime_s = nan\nat = [0.5, 0.5]\nabove_ground_m = 9\nheading_deg = 0\npitch_deg = 0\n",
    );
    write("no-key.toml", "name = \"f\"\n");
    write("suite.toml", "dem = \"jacksboro\"\nflihgt = \"turn\"\n");
    write("occupied.txt", "");
    place
}

/// Runs the program; returns its exit code and its one line.
fn refuse(place: &Path, arguments: &[&str]) -> (i32, String) {
    let before = entries(place);
    let output = terrain_lod(place, arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    let lines: Vec<&str> = said.lines().filter(|line| !line.contains("XDG_RUNTIME_DIR")).collect();
    assert_eq!(lines.len(), 1, "{arguments:?} said {said:?}");
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "", "{arguments:?} printed results");
    assert_eq!(entries(place), before, "{arguments:?} left something behind");
    (output.status.code().unwrap(), lines[0].to_string())
}

fn entries(place: &Path) -> Vec<std::ffi::OsString> {
    let mut names: Vec<_> = std::fs::read_dir(place).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    names
}

#[test]
fn every_refusal_is_one_line_with_its_exit_code() {
    let place = wrong_files();
    let cases: [(&[&str], i32, &str); 23] = [
        (&["--dem", "none.png"], 4, "error: none.png: no such file; expected an elevation file (GeoTIFF"),
        (&["--dem", "text.png", "--spacing", "30"], 4, "error: text.png: of no known format (starts with"),
        (&["--dem", "synthetic:1x9:7"], 4, "error: synthetic:1x9:7: no synthetic terrain; expected"),
        (&["--methods", "tin,roam"], 2, "error: invalid value 'roam' for '--methods"),
        (
            &["--flight", "none.toml"],
            4,
            "error: cannot read none.toml: No such file or directory (os error 2); expected a flight file",
        ),
        (&["--flight", "nan.toml"], 4, "error: nan.toml:3:10: "),
        (&["--flight", "no-key.toml"], 4, "error: no-key.toml:1:1: "),
        (
            &["--suite", "none"],
            4,
            "error: cannot read none: No such file or directory (os error 2); expected a suite file",
        ),
        (&["--suite", "suite.toml"], 4, "error: suite.toml:2:1: unknown field `flihgt`"),
        (&["--patch", "12"], 2, "error: patch of 12 intervals: expected 8, 16, 32 or 64"),
        (
            &["--selector", "bounded", "--triangulator", "spade"],
            2,
            "error: the bounded selector needs the triangulator grid",
        ),
        (&["--keep-maps"], 2, "error: jacksboro: no file to keep threshold maps beside; expected a DEM in a file"),
        (&["--group", "3"], 2, "error: group of 3 x 3 patches of 32 intervals: expected 1, 2 or 4"),
        (&["--methods", "htp-instanced", "--geomorph"], 2, "error: geomorph needs the metric distance"),
        (&["--smoothing", "--selector", "bounded"], 2, "error: smoothing needs the selector algorithm1"),
        (
            &["--jitter", "1", "--selector", "algorithm1"],
            2,
            "error: the jitter needs the triangulator delaunator or spade",
        ),
        (&["--max-spacing", "99"], 2, "error: maximum spacing of 99 intervals: expected 1 to 32"),
        (&["--tolerance", "0"], 2, "error: invalid value '0' for '--tolerance"),
        (&["--k", "1"], 2, "error: "),
        (&["--layers", "7"], 2, "error: "),
        (&["--size", "640"], 2, "error: invalid value '640' for '--size"),
        (&["--out", "."], 6, "error: . is not empty"),
        (&["--out", "/proc/none"], 6, "error: cannot write /proc/none: "),
    ];
    for (arguments, code, start) in cases {
        let all = [&["bench", "--no-gpu"], arguments].concat();
        let (found, line) = refuse(place.path(), &all);
        assert!(found == code && line.starts_with(start), "{arguments:?}: exit code {found}, {line}");
    }
}

/// Found by a review: what the command line refuses, a suite file could say.
#[test]
fn a_suite_keeps_the_ranges_of_the_flags() {
    let place = wrong_files();
    let cases = [
        ("methods = []", "methods is empty; expected at least one"),
        ("triangulator = []", "triangulator is empty; expected at least one"),
        ("step = [2, 0]", "step = 0; expected 1 to 65535"),
        ("tolerance_px = []", "tolerance_px is empty; expected at least one"),
        ("tolerance_px = [1.0, nan]", "tolerance_px = NaN; expected 1e-6 to 1e6"),
        ("leg_px = [-1.0]", "leg_px = -1; expected 1e-6 to 1e6"),
        ("repeats = 0", "repeats = 0; expected 1 to 1000"),
        ("size_px = [640, 0]", "size_px = 0; expected 1 to 16384"),
        ("frames = 0", "frames = 0; expected 1 to 1000000"),
        ("threads = 60000", "threads = 60000; expected 1 to 256"),
    ];
    for (text, reason) in cases {
        std::fs::write(place.path().join("bad.toml"), text).unwrap();
        let refused = refuse(place.path(), &["bench", "--no-gpu", "--suite", "bad.toml"]);
        assert_eq!(refused, (4, format!("error: suite bad.toml: {reason}")));
    }
}

#[test]
fn a_call_without_a_command_says_what_there_is() {
    let place = wrong_files();
    let expected = "error: no command; expected bench, report, cmp, mesh, adapters or dem; --help has examples";
    assert_eq!(refuse(place.path(), &[]), (2, expected.to_string()));
}

#[test]
fn mesh_refuses_in_the_same_way() {
    let place = wrong_files();
    let cases: [(&[&str], i32, &str); 3] = [
        (&["--frame", "120", "--out", "a.ply"], 2, "error: frame 120 of 120 frames: expected 0 to 119"),
        (&["--dem", "none.png", "--out", "a.ply"], 4, "error: none.png: no such file"),
        (&["--out", "none/a.ply"], 6, "error: cannot write none/a.ply: "),
    ];
    for (arguments, code, start) in cases {
        let all = [&["mesh", "--method", "tin"], arguments].concat();
        let (found, line) = refuse(place.path(), &all);
        assert!(found == code && line.starts_with(start), "{arguments:?}: exit code {found}, {line}");
    }
}

#[test]
fn a_dry_run_checks_and_writes_nothing() {
    let place = tempfile::tempdir().unwrap();
    let output = terrain_lod(place.path(), &["bench", "--suite", "smoke", "--no-gpu", "--dry-run"]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && said.contains("full-grid") && said.contains("in all"), "{said}");
    assert!(entries(place.path()).is_empty());
}

/// A bug: `--help | head -1` ended in a panic.
#[test]
fn help_to_a_reader_that_has_gone_is_no_failure() {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_terrain-lod"));
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output =
        command.args(["bench", "--help"]).stdout(writer).stderr(std::process::Stdio::piped()).output().unwrap();
    assert_eq!((output.status.code(), String::from_utf8_lossy(&output.stderr).as_ref()), (Some(0), ""));
}
