//! Synthetic ground in files, and DEMs cut into cells.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::program::terrain_lod;

/// Runs a command that succeeds; what it says on stdout.
fn run(place: &Path, arguments: &[&str]) -> String {
    let output = terrain_lod(place, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A folder with `a.png`, 130 x 100 samples in several rows of cells, and `a.cells` of it.
fn folder() -> tempfile::TempDir {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), &["dem", "synth", "a.png", "--size", "130x100", "--seed", "5"]);
    cut(place.path(), "a.png", "a.cells");
    place
}

fn cut(place: &Path, from: &str, to: &str) -> String {
    run(place, &["dem", "cells", from, to, "--layers", "3"])
}

/// The exit code, and the line on stderr.
fn refused(output: Output) -> (i32, String) {
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(said.lines().count(), 1, "{said}");
    (output.status.code().unwrap(), said.trim_end().to_owned())
}

#[test]
fn cells_are_a_dem_with_the_heights_that_were_cut() {
    let place = folder();
    let place = place.path();
    let json: serde_json::Value =
        serde_json::from_str(&run(place, &["dem", "info", "a.cells", "--format", "json"])).unwrap();
    let expected = serde_json::json!([130, 100, "uint16", 0.05, [30.0, 30.0]]);
    let found = ["columns", "rows", "sample_type", "scale", "spacing_m"].map(|key| json[key].clone());
    assert_eq!(serde_json::json!(found), expected);

    let mesh = |dem: &str| {
        run(place, &["mesh", "--dem", dem, "--method", "full-grid", "--out", "mesh.ply"]);
        fs::read(place.join("mesh.ply")).unwrap()
    };
    assert!(mesh("a.cells") == mesh("a.png"));
    // Cells can be cut again, for another hierarchy too.
    let again = |from: &str| {
        run(place, &["dem", "cells", from, "b", "--k", "2", "--layers", "4"]);
        fs::read(place.join("b.cells")).unwrap()
    };
    assert!(again("a.cells") == again("a.png"));
}

#[test]
fn cells_say_where_their_dem_comes_from() {
    let place = folder();
    let place = place.path();
    let info = |dem: &str| run(place, &["dem", "info", dem]);
    let sidecar = fs::read_to_string(place.join("a.toml")).unwrap();
    fs::write(place.join("a.toml"), format!("{sidecar}licence = \"free\"\nnotice = \"measured by nobody\"\n")).unwrap();
    cut(place, "a.png", "a.cells");
    for line in ["licence  free", "notice   measured by nobody"] {
        assert!(info("a.png").contains(line) && info("a.cells").contains(line), "{line}: {}", info("a.cells"));
    }
    assert!(
        info("a.png")
            .lines()
            .filter(|line| line.contains("source "))
            .eq(info("a.cells").lines().filter(|line| line.contains("source ")))
    );
    // Cells that are cut of cells keep it; a flag takes its place.
    cut(place, "a.cells", "b.cells");
    assert!(info("b.cells").contains("licence  free"));
    run(place, &["dem", "cells", "a.png", "b.cells", "--layers", "3", "--notice", "another"]);
    assert!(info("b.cells").contains("notice   another"));
    let long = "n".repeat(65_536);
    let refused = refused(terrain_lod(place, &["dem", "cells", "a.png", "b.cells", "--notice", &long]));
    let expected = "bytes of source, licence, notice and place: expected at most 65536";
    assert!(refused.0 == 2 && refused.1.ends_with(expected), "{refused:?}");
}

#[test]
fn one_line_says_what_was_cut() {
    let place = folder();
    let line = cut(place.path(), "a.png", "a.cells");
    let bytes = fs::metadata(place.path().join("a.cells")).unwrap().len();
    let expected = format!(
        "a.cells: 130 x 100 samples of 16 bits in 5 x 4 cells of 27 x 27 intervals; {:.1} MB, 0.0 of them resident, {:.2} \
         bytes a sample; ",
        bytes as f64 / 1e6,
        bytes as f64 / 13_000.0
    );
    assert!(line.starts_with(&expected) && line.ends_with(" s\n") && line.lines().count() == 1, "{line}");
}

#[test]
fn synthetic_ground_is_the_same_in_every_file() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    for kind in ["ridged", "hills", "coast", "spikes"] {
        let synth = |out: &str| run(place, &["dem", "synth", out, "--size", "90x70", "--kind", kind]);
        assert_eq!(synth("a.png"), "a.png: 90 x 70 samples of 0.05 m a step\n");
        assert_eq!(synth("b.r16"), "b.r16: 90 x 70 samples of 0.05 m a step\n");
        run(place, &["dem", "cells", "a.png", "a.cells", "--layers", "3"]);
        run(place, &["dem", "cells", "b.r16", "b.cells", "--layers", "3"]);
        assert!(fs::read(place.join("a.cells")).unwrap() == fs::read(place.join("b.cells")).unwrap(), "{kind}");
        assert!(run(place, &["dem", "info", "a.png"]).contains(&format!("--size 90x70 --seed 1 --kind {kind}")));
    }
}

#[test]
fn a_sidecar_written_by_hand_is_not_overwritten() {
    let place = folder();
    let sidecar = place.path().join("b.toml");
    fs::write(&sidecar, "scale = 2\n").unwrap();
    let (code, said) = refused(terrain_lod(place.path(), &["dem", "synth", "b.png", "--size", "9x9"]));
    assert!(code == 6 && said.starts_with("error: cannot write b.toml: it is there, and not by"), "{code}, {said}");
    assert!(fs::read_to_string(&sidecar).unwrap() == "scale = 2\n" && !place.path().join("b.png").exists());
    // Its own it replaces.
    run(place.path(), &["dem", "synth", "a.png", "--size", "9x9"]);
}

#[test]
fn a_cut_that_was_ended_goes_on() {
    let place = folder();
    let (place, partial) = (place.path(), place.path().join("a.cells.partial"));
    let whole = fs::read(place.join("a.cells")).unwrap();
    // The last two rows of cells are missing.
    let mut ended = whole.clone();
    let end = ended.len();
    ended[end * 7 / 10..].fill(0);
    fs::write(&partial, ended).unwrap();
    let line = cut(place, "a.png", "a.cells");
    assert!(line.ends_with(", 2 of 4 rows of cells were there\n"), "{line}");
    assert!(fs::read(place.join("a.cells")).unwrap() == whole && !partial.exists());

    run(place, &["dem", "synth", "b.png", "--size", "130x100", "--seed", "6"]);
    fs::write(&partial, &whole).unwrap();
    assert!(!cut(place, "b.png", "a.cells").contains("were there"), "of another DEM");
    fs::write(&partial, "of something else").unwrap();
    assert!(!cut(place, "a.png", "a.cells").contains("were there"));
    assert!(fs::read(place.join("a.cells")).unwrap() == whole);
}

#[test]
fn what_cannot_be_cut_or_written_is_refused_in_one_line() {
    let place = folder();
    let place = place.path();
    fs::create_dir(place.join("folder")).unwrap();
    let cells = |more: &[&str]| refused(terrain_lod(place, &[&["dem", "cells", "a.png"], more].concat()));
    let expected = "error: 1 layer: expected at least 2, a resident one above those that are loaded";
    assert_eq!(cells(&["b.cells", "--layers", "1"]), (2, expected.to_owned()));
    let expected = "error: k of 4 with 6 layers makes cells of 4096 sample intervals: expected at most 1024";
    assert_eq!(cells(&["b.cells", "--k", "4", "--layers", "6"]), (2, expected.to_owned()));
    let (code, said) = cells(&["none/b.cells"]);
    assert!(code == 6 && said.starts_with("error: cannot write none/b.cells: "), "{code}, {said}");
    let (code, said) = cells(&["folder/"]);
    assert!(code == 6 && said.contains("expected a path that ends in a file name"), "{code}, {said}");
    let (code, said) = refused(terrain_lod(place, &["dem", "synth", "a.tif", "--size", "9x9"]));
    assert_eq!((code, said.as_str()), (2, "error: a.tif: expected a name that ends in .png or .r16"));
    assert!(!place.join("b.cells.partial").exists());
}

#[test]
fn damaged_cells_are_refused_in_one_line() {
    let place = folder();
    let place = place.path();
    let whole = fs::read(place.join("a.cells")).unwrap();
    let load = |bytes: &[u8]| {
        fs::write(place.join("a.cells"), bytes).unwrap();
        refused(terrain_lod(place, &["mesh", "--dem", "a.cells", "--method", "full-grid", "--out", "mesh.ply"]))
    };
    let mut changed = whole.clone();
    *changed.last_mut().unwrap() ^= 1;
    let expected =
        "error: a.cells: damaged: level 0, cell (4, 3); expected bytes with their checksum: copy or cut it again";
    assert_eq!(load(&changed), (4, expected.to_owned()));
    let (all, short) = (whole.len(), whole.len() - 1);
    let expected = format!("error: a.cells: {short} bytes; expected {all} by the file's header: copy or cut it again");
    assert_eq!(load(&whole[..short]), (4, expected));
    fs::write(place.join("a.cells"), &whole).unwrap();
    let (code, said) = refused(terrain_lod(place, &["dem", "info", "a.cells", "--scale", "2"]));
    assert!(code == 2 && said.contains("expected --max-samples and --voids alone of the reading options"), "{said}");
}
