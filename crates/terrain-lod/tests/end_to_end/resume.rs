//! A bench that is killed or interrupted, and goes on with `--resume`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use terrain_core::SplitMix64;

use crate::program::{read_rows, terrain_lod};

/// A bench of a second or so: eight runs, four timed flights of each.
const BENCH: [&str; 12] = [
    "bench",
    "--no-gpu",
    "--suite",
    "smoke",
    "--frames",
    "40",
    "--repeats",
    "4",
    "--size",
    "160x90",
    "--out",
    "results",
];

const RUNS: usize = 8;

/// The bytes of all error frames, by file.
fn error_frames(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder.join("frames")).unwrap().map(|entry| entry.unwrap().path());
    let errors = entries.filter(|path| path.to_string_lossy().ends_with("-error.csv"));
    errors.map(|path| (path.file_name().unwrap().to_string_lossy().into(), std::fs::read(&path).unwrap())).collect()
}

/// The columns of the summary that have nothing to do with a clock, as text.
fn counters(folder: &Path) -> String {
    let is_timed = |column: &str| column.contains("_ms_") || column.starts_with("live_") || column == "load_average";
    let rows = read_rows(&folder.join("summary.csv"));
    rows.iter()
        .map(|row| format!("{:?}\n", row.iter().filter(|(name, _)| !is_timed(name)).collect::<Vec<_>>()))
        .collect()
}

/// Starts the bench, or goes on with it where it has begun, and kills it after a while. Whether it was still running.
fn fly_and_kill(place: &Path, after: Duration) -> bool {
    let begun = place.join("results/machine.json").exists();
    if !begun {
        // Killed before it had written what it is: nothing was flown.
        let _ = std::fs::remove_dir_all(place.join("results"));
    }
    let arguments: &[&str] = if begun { &["bench", "--resume", "results"] } else { &BENCH };
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrain-lod"));
    command.current_dir(place).args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let start = Instant::now();
    while start.elapsed() < after && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let is_running = child.try_wait().unwrap().is_none();
    child.kill().unwrap();
    child.wait().unwrap();
    is_running
}

#[test]
fn twenty_kills_leave_the_counters_as_they_are() {
    const SEED: u64 = 20;
    let whole = tempfile::tempdir().unwrap();
    let start = Instant::now();
    assert!(terrain_lod(whole.path(), &BENCH).status.success());
    let at_most = start.elapsed().as_micros() as u64 / 2;
    let mut random = SplitMix64::new(SEED);
    let (mut kills, mut kills_with_parts, mut place) = (0, 0, tempfile::tempdir().unwrap());
    while kills < 20 {
        if fly_and_kill(place.path(), Duration::from_micros(random.below(at_most))) {
            kills += 1;
            assert!(are_interleaved(place.path()), "seed {SEED}, kill {kills}: not A B A B");
            kills_with_parts += usize::from(place.path().join("results/parts").read_dir().is_ok_and(|p| p.count() > 0));
        } else {
            // It has come to its end: the next kills are another bench's.
            compare_with(whole.path(), place.path());
            place = tempfile::tempdir().unwrap();
        }
    }
    println!("{kills_with_parts} of {kills} kills had something to go on with (seed {SEED})");
    while fly_and_kill(place.path(), Duration::from_secs(20)) {}
    compare_with(whole.path(), place.path());
}

/// Whether no run of the speed pass is more than one flight ahead of another.
fn are_interleaved(place: &Path) -> bool {
    let Ok(entries) = place.join("results/frames").read_dir() else { return true };
    let files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    let speeds: Vec<_> = files.iter().filter(|path| path.to_string_lossy().ends_with("-speed.csv")).collect();
    let repeats = |path: &&PathBuf| read_rows(path).last().unwrap()["repeat"].parse::<u32>().unwrap() + 1;
    let most = speeds.iter().map(repeats).max().unwrap_or(0);
    let fewest = if speeds.len() < RUNS { 0 } else { speeds.iter().map(repeats).min().unwrap_or(0) };
    most - fewest <= 1
}

fn compare_with(whole: &Path, killed: &Path) {
    let [whole, killed] = [whole, killed].map(|place| place.join("results"));
    assert!(!killed.join("INCOMPLETE").exists());
    assert_eq!(error_frames(&killed), error_frames(&whole));
    assert_eq!(counters(&killed), counters(&whole));
    for row in read_rows(&killed.join("summary.csv")) {
        assert_eq!(row["repeats"], "4", "{row:?}");
    }
}

/// A folder in which the error pass is done and one flight of the speed pass is missing.
fn interrupted() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    assert!(terrain_lod(place.path(), &BENCH).status.success());
    let results = place.path().join("results");
    std::fs::write(results.join("INCOMPLETE"), "").unwrap();
    let speed = results.join("frames/full-grid-speed.csv");
    let lines: Vec<String> = std::fs::read_to_string(&speed).unwrap().lines().map(str::to_string).collect();
    std::fs::write(&speed, lines[..=3 * 40].join("\n") + "\n").unwrap();
    place
}

#[test]
fn only_what_is_missing_is_flown() {
    let place = interrupted();
    let speed = |name: &str| std::fs::read_to_string(place.path().join("results/frames").join(name)).unwrap();
    let (kept, cut) = (speed("htp-distance-leg8px-k3-l3-per-patch-speed.csv"), speed("full-grid-speed.csv"));
    let dry = terrain_lod(place.path(), &["bench", "--resume", "results", "--dry-run"]);
    let said = String::from_utf8(dry.stdout).unwrap();
    assert!(said.contains("Repeats: 4, the first 2 frames of each not timed\n"), "{said}");
    let line = said.lines().find(|line| line.contains("full-grid")).unwrap();
    assert!(line.ends_with("(errors to fly, speed 3 of 4 flights done)"), "{said}");
    assert!(terrain_lod(place.path(), &["bench", "--resume", "results"]).status.success());
    assert_eq!(speed("htp-distance-leg8px-k3-l3-per-patch-speed.csv"), kept, "times of flights that are done stay");
    assert!(
        speed("full-grid-speed.csv").starts_with(&cut) && speed("full-grid-speed.csv").lines().count() == 1 + 4 * 40
    );
    let machine: serde_json::Value =
        serde_json::from_slice(&std::fs::read(place.path().join("results/machine.json")).unwrap()).unwrap();
    assert_eq!(machine["resumed"].as_array().unwrap().len(), 1);
}

#[test]
fn another_bench_is_refused_in_one_line() {
    let place = interrupted();
    let refuse = |arguments: &[&str]| {
        let output = terrain_lod(place.path(), &[&["bench"], arguments].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.lines().count() == 1, "{said}");
        said
    };
    let mut as_begun: Vec<&str> = BENCH[1..10].to_vec();
    as_begun.extend(["--resume", "results"]);
    let fewer: Vec<&str> = as_begun.iter().map(|word| if *word == "4" { "3" } else { word }).collect();
    let expected = "error: results: begun with options.repeats 4, now 3; resume it as it was begun, or start another\n";
    assert_eq!(refuse(&fewer), expected);
    assert!(refuse(&["--resume", "none"]).starts_with("error: none: no bench has begun here"));
    assert!(terrain_lod(place.path(), &[&["bench"], &as_begun[..]].concat()).status.success());
    assert_eq!(refuse(&["--resume", "results"]), "error: results: complete; there is nothing to resume\n");
}

/// Found by a review: a changed checkout has the same commit, and `dirty` may differ.
#[test]
fn a_bench_went_on_with_a_modified_program() {
    let place = interrupted();
    let file = place.path().join("results/machine.json");
    let mut machine: serde_json::Value = serde_json::from_slice(&std::fs::read(&file).unwrap()).unwrap();
    assert_eq!(machine["program_sha256"].as_str().map(str::len), Some(64));
    machine["program_sha256"] = "01".into();
    std::fs::write(&file, machine.to_string()).unwrap();
    let output = terrain_lod(place.path(), &["bench", "--resume", "results"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.contains("begun with program_sha256 \"01\", now "), "{said}");
}

/// Ctrl-C in a bench: it ends with 130, marked, and goes on.
#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_marked_result_that_goes_on() {
    let place = tempfile::tempdir().unwrap();
    let long = [&BENCH[..5], &["4000", "--repeats", "1", "-m", "full-grid", "--out", "results"]].concat();
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrain-lod"));
    command.current_dir(place.path()).args(&long).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    while !place.path().join("results/machine.json").exists() {
        assert_eq!(child.try_wait().unwrap(), None, "ended before it began");
        std::thread::sleep(Duration::from_millis(5));
    }
    let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(interrupt.success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(130) && said.contains("bench --resume goes on with it"), "{said}");
    assert!(place.path().join("results/INCOMPLETE").exists());
    assert!(terrain_lod(place.path(), &["bench", "--resume", "results"]).status.success());
    assert!(!place.path().join("results/INCOMPLETE").exists());
}

/// The live flights of a run are one unit: once they are done, they are not flown again.
#[test]
fn live_flights_that_are_done_stay_as_they_are() {
    let place = tempfile::tempdir().unwrap();
    let long = ["--repeats", "2", "--until-ci", "0.01%", "--max-repeats", "60", "--frames", "30", "--out", "results"];
    let live = ["bench", "--no-gpu", "--suite", "smoke", "-f", "bounded.*2 px", "--schedule", "live"];
    let mut command = Command::new(env!("CARGO_BIN_EXE_terrain-lod"));
    command.current_dir(place.path()).args(live).args(long).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let part = place.path().join("results/parts/tin-bounded-2px-patch16-grid-live-live.json");
    while !part.exists() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let frames =
        || std::fs::read(place.path().join("results/frames/tin-bounded-2px-patch16-grid-live-live.csv")).unwrap();
    let flown = frames();
    if place.path().join("results/INCOMPLETE").exists() {
        assert!(terrain_lod(place.path(), &["bench", "--resume", "results"]).status.success());
    }
    assert_eq!(frames(), flown);
    let rows = read_rows(&place.path().join("results/summary.csv"));
    assert!(
        rows[0]["live_cracks"] == "0" && rows[0]["cracks"] == "0" && !rows[0]["plan_ms_p50"].is_empty(),
        "{rows:?}"
    );
}
