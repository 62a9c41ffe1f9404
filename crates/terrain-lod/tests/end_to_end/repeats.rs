//! What is flown, and how often: filters, repeats, the A/A check.

use crate::program::{bench, read_rows, terrain_lod};

#[test]
fn a_filter_looks_at_the_lines_of_the_dry_run() {
    let rows = bench(&["--suite", "smoke", "-f", "bounded.*tolerance 2 px|full-grid"]);
    let flown: Vec<(&str, &str)> =
        rows.iter().map(|row| (row["method"].as_str(), row["tolerance_px"].as_str())).collect();
    assert_eq!(flown, [("tin", "2.0"), ("full-grid", "0.5"), ("full-grid", "2.0")]);
    let place = tempfile::tempdir().unwrap();
    for (filter, reason) in [("roam", "no run matches the filter 'roam'"), ("(", "filter '(': ")] {
        let output = terrain_lod(place.path(), &["bench", "--no-gpu", "-f", filter]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.lines().count() == 1, "{said}");
        assert!(said.starts_with(&format!("error: {reason}")), "{said}");
    }
}

/// How many repeats it takes is the machine's matter; that they end, and are said, is ours.
#[test]
fn repeats_go_on_until_the_intervals_are_narrow_or_the_bound_is_reached() {
    let place = tempfile::tempdir().unwrap();
    let until = ["--repeats", "2", "--until-ci", "0.1%", "--max-repeats", "4"];
    let all =
        [&["bench", "--no-gpu", "--suite", "smoke", "-m", "tin,full-grid", "--out", "results"], &until[..]].concat();
    let output = terrain_lod(place.path(), &all);
    assert!(output.status.success());
    let rows = read_rows(&place.path().join("results/summary.csv"));
    let repeats: u32 = rows[0]["repeats"].parse().unwrap();
    assert!((2..=4).contains(&repeats) && rows.iter().all(|row| row["repeats"] == rows[0]["repeats"]), "{rows:?}");
    let said = String::from_utf8(output.stdout).unwrap();
    let ends = [format!("After {repeats} repeats the intervals"), "Stopped at 4 repeats (--max-repeats)".into()];
    assert_eq!(ends.iter().filter(|end| said.contains(end.as_str())).count(), 1, "{said}");
}

/// Whether they are the same is the machine's matter, too: the exit code must agree with what is said.
#[test]
fn an_aa_check_flies_each_run_twice_and_its_exit_code_is_its_answer() {
    let place = tempfile::tempdir().unwrap();
    let all = ["bench", "--no-gpu", "--suite", "smoke", "-m", "htp,full-grid", "--aa", "--out", "results"];
    let output = terrain_lod(place.path(), &all);
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(said.matches(": plan_ms_p50 B / A = ").count(), 2, "{said}");
    assert_eq!(output.status.code(), Some(i32::from(said.contains("DIFFERENT"))), "{said}");
    let frames = |file: &str| std::fs::read_to_string(place.path().join("results/frames").join(file)).unwrap();
    let [a, b] = ["full-grid-speed.csv", "full-grid-speed-b.csv"].map(frames);
    assert!(a != b && a.lines().count() == b.lines().count());
}
