//! The figures of a suite, and the measures of pictures.

use std::path::Path;
use std::process::Output;

use crate::program::{read_rows, terrain_lod};

const SUITE: &str = r#"
dem = "synthetic:65x65:4"
flight = "fly-over"
methods = ["tin", "full-grid"]
selector = ["algorithm1"]
patch = [16]
tolerance_px = [4]
size_px = [160, 90]
frames = 7
repeats = 1

[[figures]]
name = "layers"
kind = "htp-layers"
title = "Layers"
caption = "All of them, \"in quotes\""

[[figures]]
name = "mesh"
title = "Mesh"
caption = "Two looks."
size_px = [120, 80]
panels = [{ label = "lines", run = "tin", wireframe = true }, { label = "full", run = "full-grid" }]

[[figures]]
name = "of-nobody"
title = "Nobody"
panels = [{ label = "x", run = "no such run" }]
"#;

fn place() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("small.toml"), SUITE).unwrap();
    place
}

fn fly(place: &Path, line: &str) -> Output {
    terrain_lod(place, &line.split(' ').collect::<Vec<_>>())
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Whether there is an adapter; otherwise the test says so and passes.
fn has_gpu(place: &Path) -> bool {
    let found = terrain_lod(place, &["adapters"]).status.success();
    if !found {
        eprintln!("skipped: no graphics adapter on this machine");
    }
    found
}

#[test]
fn without_a_gpu_drawings_are_made_and_pictures_are_left_out_with_a_note() {
    let place = place();
    let listed = fly(place.path(), "bench --no-gpu --suite small.toml --dry-run");
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    assert!(listed.contains("Figure figures/layers.svg: Layers\n"), "{listed}");
    assert!(listed.contains("Figure figures/mesh.png: Mesh  (left out: without a GPU)\n"), "{listed}");

    let output = fly(place.path(), "bench --no-gpu --suite small.toml --out a");
    assert!(output.status.success(), "{}", said(&output));
    assert!(said(&output).contains("note: figure mesh is left out: without a GPU\n"), "{}", said(&output));
    let rows = read_rows(&place.path().join("a/figures.csv"));
    assert_eq!(rows.len(), 1);
    assert_eq!((rows[0]["file"].as_str(), rows[0]["title"].as_str()), ("figures/layers.svg", "Layers"));
    assert_eq!(rows[0]["caption"], "All of them, \"in quotes\"");
    assert_eq!(rows[0]["command"], "cargo xtask bench --no-gpu --suite small.toml --out a");
    let svg = std::fs::read_to_string(place.path().join("a/figures/layers.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    assert!(!place.path().join("a/pictures.csv").exists(), "nothing was measured");
}

#[test]
fn pictures_are_measured_mapped_and_made_once() {
    let place = place();
    if !has_gpu(place.path()) {
        return;
    }
    let output = fly(place.path(), "bench --suite small.toml --out a");
    assert!(output.status.success(), "{}", said(&output));
    assert!(
        said(&output).contains("note: figure of-nobody is left out: no run matches 'no such run'"),
        "{}",
        said(&output)
    );
    let results = place.path().join("a");
    let rows = read_rows(&results.join("pictures.csv"));
    let frames: Vec<&str> = rows.iter().map(|row| row["frame"].as_str()).collect();
    assert_eq!(frames, ["1", "3", "5", "1", "3", "5"]);
    for row in &rows[3..] {
        assert_eq!((row["method"].as_str(), row["tolerance_px"].as_str()), ("full-grid", ""));
        let measures = ["flat_rmse", "shaded_rmse", "depth_rmse_m", "outline_share", "ridge_share"];
        assert!(measures.iter().all(|name| row[*name] == "0.0"), "the reference is equal to itself: {row:?}");
        assert_eq!((row["flat_mssim"].as_str(), row["shaded_mssim"].as_str()), ("1.0", "1.0"));
    }
    let number = |name: &str| rows[0][name].parse::<f64>().unwrap();
    assert!(number("flat_rmse") > 0.0 && number("depth_rmse_m") > 0.0 && number("flat_mssim") < 1.0, "{:?}", rows[0]);
    // The mean of the three stands in the summary.
    let mean = (0..3).map(|i| rows[i]["flat_rmse"].parse::<f64>().unwrap()).sum::<f64>() / 3.0;
    let summary = read_rows(&results.join("summary.csv"));
    assert!((summary[0]["picture_flat_rmse"].parse::<f64>().unwrap() - mean).abs() < 2e-6);
    for look in ["shaded", "error"] {
        let shots = std::fs::read_dir(results.join("shots")).unwrap();
        let ending = format!("-{look}.png");
        let found = shots.filter(|shot| shot.as_ref().unwrap().file_name().to_string_lossy().ends_with(&ending));
        assert_eq!(found.count(), 6, "{look}");
    }
    let files: Vec<String> = read_rows(&results.join("figures.csv")).iter().map(|row| row["file"].clone()).collect();
    assert_eq!(files, ["figures/layers.svg", "figures/mesh.png"]);

    // Interrupted before its end, with one figure made: that one is left as it is, the other is made.
    std::fs::write(results.join("INCOMPLETE"), "").unwrap();
    std::fs::remove_file(results.join("figures/layers.svg")).unwrap();
    std::fs::write(results.join("figures/mesh.png"), "made before").unwrap();
    let output = fly(place.path(), "bench --resume a");
    assert!(output.status.success(), "{}", said(&output));
    assert_eq!(std::fs::read(results.join("figures/mesh.png")).unwrap(), b"made before");
    assert!(results.join("figures/layers.svg").exists());
    let resumed: Vec<String> =
        read_rows(&results.join("figures.csv")).iter().map(|row| row["command"].clone()).collect();
    assert_eq!(resumed, ["cargo xtask bench --suite small.toml --out a"; 2], "the command that it was begun with");
}

/// At the top of a suite of several benches, in its own folder and not in theirs; of the first bench that is flown.
#[test]
fn figures_of_several_benches_stand_at_the_top() {
    let place = tempfile::tempdir().unwrap();
    let drawing = "[[figures]]\nname = 'blocks'\nkind = 'htp-blocks'\ntitle = 'Blocks'\n";
    let benches =
        "[[benches]]\nname = 'a'\ndem = 'synthetic:33x33:1'\n[[benches]]\nname = 'b'\ndem = 'synthetic:33x33:2'\n";
    let suite = format!("methods = ['decimated']\nframes = 3\nrepeats = 1\nsize_px = [80, 60]\n{drawing}{benches}");
    std::fs::write(place.path().join("two.toml"), &suite).unwrap();
    let output = fly(place.path(), "bench --no-gpu --suite two.toml --out results");
    assert!(output.status.success(), "{}", said(&output));
    assert!(place.path().join("results/figures/blocks.svg").exists());
    assert!(!place.path().join("results/a/figures").exists());
    for (wrong, expected) in [
        (format!("{suite}[[benches.figures]]\nname = 'x'\n"), "bench \"b\": figures; expected at the top"),
        (
            format!("{suite}{drawing}bench = ['c']\n").replacen("blocks", "other", 1),
            "figure \"blocks\": bench c; expected of a, b",
        ),
        (format!("{suite}{drawing}"), "figure \"blocks\": the name is taken"),
    ] {
        std::fs::write(place.path().join("wrong.toml"), wrong).unwrap();
        let refused = fly(place.path(), "bench --no-gpu --suite wrong.toml --out other");
        assert!(refused.status.code() == Some(4) && said(&refused).contains(expected), "{}", said(&refused));
    }
}
