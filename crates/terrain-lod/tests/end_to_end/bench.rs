//! The bench end to end, without a GPU: sound on every DEM and flight, the same every time, and pinned on one DEM.

use std::path::Path;

use crate::program::{Row, bench, read_rows, shared_dem, terrain_lod};

const METHODS: [&str; 5] = ["tin", "tin", "htp", "htp-instanced", "full-grid"];
const FLIGHTS: [&str; 4] = ["ground-level", "fly-over", "turn", "stop-and-go"];

/// What `--methods decimated,rqt,geomipmap,greedy` flies: decimation by 2, 4 and 8.
const BASELINES: [&str; 6] = ["decimated", "decimated", "decimated", "rqt", "geomipmap", "greedy"];

/// Flies all four flights with the methods of the quick suite, and with the baselines.
fn flies_without_cracks(dem: &[&str], frames: &str) {
    for flight in FLIGHTS {
        let arguments = [dem, &["--flight", flight, "--frames", frames]].concat();
        check_rows(&arguments, &METHODS);
        check_rows(&[&arguments[..], &["--methods", "decimated,rqt,geomipmap,greedy"]].concat(), &BASELINES);
    }
}

/// No frame may have a crack, and a bound is a bound.
fn check_rows(arguments: &[&str], expected: &[&str]) {
    let rows = bench(arguments);
    let methods: Vec<&str> = rows.iter().map(|row| row["method"].as_str()).collect();
    assert_eq!(methods, expected, "{arguments:?}");
    for row in rows {
        assert_eq!((row["cracks"].as_str(), row["err"].as_str()), ("0", ""), "{arguments:?}: {row:?}");
        let says = |setting: &&str| row["setting"].contains(setting);
        let is_bounded = ["selector=bounded", "metric=error"].iter().any(says);
        if is_bounded || ["rqt", "geomipmap"].contains(&row["method"].as_str()) {
            let [error_px, tolerance_px] = ["error_px_max", "tolerance_px"].map(|c| row[c].parse::<f64>().unwrap());
            assert!(error_px <= 1.001 * tolerance_px, "{arguments:?}: no bound: {row:?}");
        }
    }
}

/// HTP's levels by error are a bound however its patches become draws, and with any k.
#[test]
fn htp_by_error_keeps_its_tolerance_with_every_batching() {
    for batching in ["per-patch", "merged-cell", "instanced"] {
        for k in ["2", "3", "4"] {
            let setting = ["--batching", batching, "--metric", "error", "--k", k, "--tolerance", "0.5,1,2,4"];
            let rows = bench(&[&["--methods", "htp", "--frames", "20", "--flight", "fly-over"], &setting[..]].concat());
            assert_eq!(rows.len(), 4, "a row for each tolerance");
            for row in rows {
                let [error_px, tolerance_px] = ["error_px_max", "tolerance_px"].map(|c| row[c].parse::<f64>().unwrap());
                assert!(error_px <= 1.001 * tolerance_px && row["cracks"] == "0" && row["err"].is_empty(), "{row:?}");
                assert!(
                    row["setting"].contains(&format!("metric=error k={k} layers=4 batching={batching}")),
                    "{row:?}"
                );
            }
        }
    }
}

/// With all cells in the window the rows are those of the DEM in memory; with few they are sound, and say what they lack.
#[test]
fn htp_over_cells_draws_what_it_does_over_the_dem() {
    let fly = |extra: &[&str]| bench(&[&["--methods", "htp-instanced", "--frames", "20"], extra].concat()).remove(0);
    let (memory, cells) = (fly(&[]), fly(&["--window-mib", "64"]));
    for column in ["triangles_mean", "triangles_max", "draws_mean", "error_px_max", "error_px_rms", "cracks", "err"] {
        assert_eq!(memory[column], cells[column], "{column}");
    }
    let says = ["stand_in_frames_share", "unheld_px_max", "resident_bytes"].map(|column| cells[column].as_str());
    assert!(says[..2] == ["0.0", "0.0"] && says[2].parse::<u64>().unwrap() <= 64 << 20, "{says:?}");
    assert_eq!(memory["resident_bytes"], "");
    let few = fly(&["--window-mib", "1", "--k", "2"]);
    assert_eq!((few["cracks"].as_str(), few["err"].as_str()), ("0", ""));
}

/// Found by a review: cells were cut in memory for every flight, also where the DEM was a file of cells, and whatever step
/// its heights were whole multiples of.
#[test]
fn htp_flies_over_the_cells_of_the_file_that_it_is_given() {
    let place = tempfile::tempdir().unwrap();
    let run = |line: &str| terrain_lod(place.path(), &line.split(' ').collect::<Vec<_>>());
    assert!(run("dem synth a.png --size 193x160 --seed 3").status.success());
    assert!(run("dem cells a.png a.cells --k 3 --layers 3").status.success());
    let fly = |dem: &str, out: &str| {
        let line = format!(
            "bench --no-gpu --repeats 1 -m htp-instanced --frames 12 --layers 3 --window-mib 8 --dem {dem} --out {out}"
        );
        let output = run(&line);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        crate::program::read_rows(&place.path().join(out).join("summary.csv")).remove(0)
    };
    let (file, memory) = (fly("a.cells", "file"), fly("a.png", "memory"));
    for column in ["triangles_mean", "upload_bytes_mean", "error_px_max", "resident_bytes", "cracks"] {
        assert_eq!(file[column], memory[column], "{column}");
    }
    assert_eq!([&file["reads_failed"], &file["read_retries"]], ["0", "0"]);
    assert!(file["cells_loaded"].parse::<u64>().unwrap() > 0 && memory["live_reads_failed"].is_empty());
    // With a byte of a finest level changed.
    let cells = place.path().join("a.cells");
    let mut bytes = std::fs::read(&cells).unwrap();
    let last = bytes.len() - 9;
    bytes[last] ^= 1;
    std::fs::write(&cells, bytes).unwrap();
    let refused = run("bench --no-gpu -m htp-instanced --layers 3 --window-mib 8 --dem a.cells --out broken");
    assert_eq!(refused.status.code(), Some(4), "the DEM itself is read from it, too");
}

/// The DEM itself is read from the finest level: a coarser one that is damaged does not keep the bench from flying.
#[test]
fn cells_that_cannot_be_read_are_told_and_counted() {
    let place = tempfile::tempdir().unwrap();
    let run = |line: &str| terrain_lod(place.path(), &line.split(' ').collect::<Vec<_>>());
    assert!(run("dem synth a.png --size 193x160 --seed 3").status.success());
    assert!(run("dem cells a.png a.cells --k 3 --layers 3").status.success());
    let cells = place.path().join("a.cells");
    let mut bytes = std::fs::read(&cells).unwrap();
    let first = htp_lod::CellFile::open(std::sync::Arc::new(bytes.clone())).unwrap().0.resident_bytes() as usize;
    bytes[first + 20] ^= 1;
    std::fs::write(&cells, bytes).unwrap();
    let line =
        "bench --no-gpu --repeats 1 -m htp-instanced --frames 12 --layers 3 --window-mib 8 --dem a.cells --out all";
    let output = run(line);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    let told = "cell (0, 0), level 1: damaged: level 1, cell (0, 0); expected bytes with their checksum: copy or cut it again; \
                coarser levels stand in for it, and it is read again after 8 to 1024 plans, ever later";
    // Once in the error pass, once in the speed pass.
    assert_eq!(said.matches(told).count(), 2, "{said}");
    let row = crate::program::read_rows(&place.path().join("all/summary.csv")).remove(0);
    let counts = ["reads_failed", "read_retries", "cracks"].map(|column| row[column].as_str());
    assert_eq!(counts, ["2", "1", "0"]);
    let mut frames = std::fs::read_dir(place.path().join("all/frames")).unwrap().map(|entry| entry.unwrap().path());
    let frames = frames.find(|path| path.to_string_lossy().ends_with("-error.csv")).unwrap();
    let last = crate::program::read_rows(&frames).pop().unwrap();
    assert_eq!(["reads_failed", "read_retries", "cells_due"].map(|column| last[column].as_str()), ["2", "1", "0"]);
}

/// Found by a review: only the flight refused them, after everything was prepared.
#[test]
fn what_a_window_cannot_do_is_refused_before_anything_is_written() {
    let place = tempfile::tempdir().unwrap();
    for (flags, expected) in [
        ("-m htp --window-mib 8", "cells that are loaded one by one are drawn by instances alone"),
        ("-m htp-instanced --window-mib 8 --layers 1", "cells that are loaded one by one need 2 layers or more"),
        (
            "-m htp-instanced --window-mib 8 --metric distance --geomorph",
            "geomorphing with cells that are loaded one by one: expected the whole DEM in memory",
        ),
        (
            "-m htp-instanced --window-mib 1 --layers 6 --k 3 --dem synthetic:1300x1300:1",
            "window of 1 MiB: expected at least",
        ),
    ] {
        let line = format!("bench --no-gpu --out results {flags}");
        let output = terrain_lod(place.path(), &line.split(' ').collect::<Vec<_>>());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{flags}: {said}");
        assert!(said.lines().last().unwrap().starts_with(&format!("error: {expected}")), "{flags}: {said}");
        assert!(!place.path().join("results").exists());
    }
}

#[test]
fn built_in_dem() {
    flies_without_cracks(&[], "60");
}

#[test]
fn synthetic_dem() {
    flies_without_cracks(&["--dem", "synthetic:193x250:7"], "60");
}

#[test]
fn puget_sound() {
    if let Some(path) = shared_dem("ps_1025.png") {
        flies_without_cracks(&["--dem", path.to_str().unwrap(), "--spacing", "160", "--scale", "0.1"], "20");
    }
}

#[test]
fn mount_st_helens() {
    if let Some(path) = shared_dem("sthelens_30m_native.png") {
        flies_without_cracks(&["--dem", path.to_str().unwrap(), "--spacing", "30", "--scale", "0.1"], "60");
    }
}

#[test]
fn jitter_and_smoothing_are_settings_and_open_no_crack() {
    let papers = ["--methods", "tin", "--selector", "algorithm1", "--triangulator", "delaunator", "--frames", "20"];
    let plain = bench(&papers);
    let rows = bench(&[&papers[..], &["--jitter", "7", "--smoothing"]].concat());
    assert_eq!(rows[0]["setting"], format!("{} jitter=7 smoothing=true", plain[0]["setting"]));
    assert_eq!((rows[0]["cracks"].as_str(), rows[0]["err"].as_str()), ("0", ""), "{rows:?}");
    assert_eq!(rows[0]["triangles_mean"], plain[0]["triangles_mean"], "neither selects other samples");
    assert_ne!(rows[0]["error_px_rms"], plain[0]["error_px_rms"]);
}

/// What must not depend on time, threads or luck.
const REPRODUCIBLE: [&str; 30] = [
    "method",
    "setting",
    "dem",
    "tolerance_px",
    "patch",
    "frames",
    "triangles_mean",
    "triangles_max",
    "draws_mean",
    "upload_bytes_mean",
    "first_upload_bytes",
    "updated_patches_mean",
    "index_bytes_reserved",
    "index_bytes_used",
    "error_px_max",
    "error_px_p999",
    "error_px_p99",
    "error_px_p95",
    "error_px_rms",
    "over_tolerance_share",
    "error_m_max",
    "cracks",
    "displacement_px_max",
    "displacement_px_p99",
    "popping_samples_mean",
    "popping_px_max",
    "popping_px_p99",
    "popping_displacement_px_max",
    "popping_displacement_px_p99",
    "changed_triangles_mean",
];

fn project(rows: &[Row], columns: &[&str]) -> String {
    let line = |row: &Row| columns.iter().map(|column| row[*column].as_str()).collect::<Vec<_>>().join(",") + "\n";
    columns.join(",") + "\n" + &rows.iter().map(line).collect::<String>()
}

#[test]
fn counts_and_errors_are_equal_between_runs_and_thread_counts() {
    let flown = ["1", "1", "2", "8"].map(|threads| {
        let rows = bench(&["--frames", "30", "--tolerance", "0.5,2", "--threads", threads]);
        // The names of a run say how many threads it has.
        project(&rows, &REPRODUCIBLE)
            .replace(&format!(" threads={threads}"), "")
            .replace(&format!("-threads{threads}"), "")
    });
    assert!(flown.iter().all(|other| *other == flown[0]), "{flown:#?}");
}

#[test]
fn popping_is_counted_in_bins_by_the_frames_and_by_the_flight() {
    let place = tempfile::tempdir().unwrap();
    let flown = ["--methods", "htp,full-grid", "--frames", "20", "--repeats", "1", "--out", "results"];
    let output = terrain_lod(place.path(), &[&["bench", "--no-gpu"], &flown[..]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows = |name: &str| read_rows(&place.path().join("results").join(name));
    let number = |row: &Row, column: &str| row[column].parse::<f64>().unwrap();
    let sum = |rows: &[Row], column: &str| rows.iter().map(|row| number(row, column)).sum::<f64>();

    let (bins, summary) = (rows("popping.csv"), rows("summary.csv"));
    let (htp, full_grid) = bins.split_at(11);
    let frames = rows("frames/htp-distance-leg8px-k3-l3-per-patch-error.csv");
    assert_eq!(sum(htp, "popping_samples"), sum(&frames, "popping_samples"));
    assert_eq!(sum(htp, "displaced_samples"), sum(&frames, "popping_samples"));
    assert_eq!((number(&frames[0], "popping_samples"), number(&frames[0], "changed_triangles")), (0.0, 0.0));
    assert!(sum(&frames, "changed_triangles") > 100.0);

    let popping_px_max = number(&summary[0], "popping_px_max");
    let last = htp.iter().rposition(|bin| bin["popping_samples"] != "0").expect("it pops");
    assert!((number(&htp[last], "from_px")..number(&htp[last], "to_px")).contains(&popping_px_max), "{popping_px_max}");
    assert_eq!((sum(full_grid, "popping_samples"), summary[1]["popping_px_max"].as_str()), (0.0, "0.0"));
    assert_eq!(full_grid[10]["to_px"], "", "the last bin has no end");
}

/// Triangles, draws and errors on the built-in DEM, by method and tolerance. A change that moves them says so in its
/// commit, and renews the file: `TERRAIN_LOD_BLESS=1 cargo test -p terrain-lod --test end_to_end`.
#[test]
fn golden_rows() {
    let columns = [
        "method",
        "setting",
        "tolerance_px",
        "triangles_mean",
        "triangles_max",
        "draws_mean",
        "error_px_max",
        "error_px_rms",
        "error_m_max",
        "displacement_px_max",
        "popping_samples_mean",
        "popping_px_max",
        "popping_px_p99",
        "popping_displacement_px_max",
        "changed_triangles_mean",
    ];
    let found = project(&bench(&["--frames", "40", "--tolerance", "0.5,1,2", "--leg-px", "8,30"]), &columns);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/jacksboro.csv");
    if std::env::var_os("TERRAIN_LOD_BLESS").is_some() {
        std::fs::write(&path, &found).unwrap();
    }
    let expected = std::fs::read_to_string(&path).unwrap();
    assert_eq!(found, expected, "the counts or errors on the built-in DEM have moved");
}

/// The TIN's tolerance is not its error, and the table hides neither.
#[test]
fn the_table_shows_tolerance_and_error_side_by_side() {
    let place = tempfile::tempdir().unwrap();
    let arguments = ["bench", "--no-gpu", "--suite", "smoke", "--out", "results"];
    let output = terrain_lod(place.path(), &arguments);
    let table = String::from_utf8(output.stdout).unwrap();
    let heading = table.lines().find(|line| line.starts_with("| method")).expect("a table on stdout");
    let columns: Vec<&str> = heading.split('|').map(str::trim).collect();
    let tolerance = columns.iter().position(|column| *column == "tolerance px").unwrap();
    assert_eq!(columns[tolerance + 1], "error max px");
    let summary = std::fs::read_to_string(place.path().join("results/summary.md")).unwrap();
    assert!(table.starts_with(&summary), "summary.md is what was printed");
}

/// The suite on HTP flies every batching, metric and k, and its tables hold the summary's numbers.
#[test]
fn the_tables_of_a_suite_show_the_numbers_of_the_summary() {
    let place = tempfile::tempdir().unwrap();
    let arguments = "bench --suite htp --no-gpu --repeats 1 --dem synthetic:97x80:3 --frames 4 --out results";
    let output = terrain_lod(place.path(), &arguments.split(' ').collect::<Vec<_>>());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(place.path().join("results/summary.md")).unwrap();
    let rows = crate::program::read_rows(&place.path().join("results/summary.csv"));
    assert_eq!(rows.len(), 27, "3 metrics x 3 batchings x 3 values of k");
    let (_, table) = text.split_once("### Draw calls by batching and k").expect("the table");
    for batching in ["per-patch", "merged-cell", "instanced"] {
        let line = table.lines().find(|line| line.starts_with(&format!("| {batching}"))).expect("a row a batching");
        let shown: Vec<f64> = line.split('|').skip(2).filter_map(|cell| cell.trim().parse().ok()).collect();
        let setting = |k| format!("metric=error k={k} layers=4 batching={batching}");
        let row = |k| rows.iter().find(|row| row["setting"] == setting(k)).expect("a row of the summary");
        let expected = [2, 3, 4].map(|k| row(k)["draws_mean"].parse::<f64>().unwrap());
        assert_eq!(shown.len(), 3, "{line}");
        assert!(shown.iter().zip(expected).all(|(shown, exact)| (shown - exact).abs() <= 5e-4 * exact), "{line}");
    }
}
