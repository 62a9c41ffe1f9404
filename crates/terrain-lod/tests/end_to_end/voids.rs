//! `--voids`: what is measured, exported and recorded of a DEM with a hole.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::mesh::read_ply;
use crate::program::{Row, bench, shared_dem, terrain_lod};

const METHODS: &str = "tin,htp,htp-instanced,rqt,geomipmap,greedy,decimated,full-grid";
const SIZE: [i32; 2] = [33, 25];

/// 9 x 7 voids in the middle.
fn is_void(column: i32, row: i32) -> bool {
    (column - 16).abs() <= 4 && (row - 12).abs() <= 3
}

fn is_void_quad(column: i32, row: i32) -> bool {
    [(0, 0), (1, 0), (0, 1), (1, 1)].iter().any(|(c, r)| is_void(column + c, row + r))
}

/// Rough ground with the hole, as an ESRI grid of 30 m.
fn write_grid(folder: &Path) -> PathBuf {
    let height = |c: i32, r: i32| if is_void(c, r) { -9999 } else { 100 + (c * 37 + r * 91) % 60 };
    let row = |r| (0..SIZE[0]).map(|c| height(c, r).to_string()).collect::<Vec<_>>().join(" ");
    let rows: Vec<String> = (0..SIZE[1]).map(row).collect();
    let header = "ncols 33\nnrows 25\nxllcorner 0\nyllcorner 0\ncellsize 30\nNODATA_value -9999\n";
    let path = folder.join("hole.asc");
    std::fs::write(&path, format!("{header}{}\n", rows.join("\n"))).unwrap();
    path
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {:?}", row[column]))
}

/// The mesh is the same as with `fill`, and the voids are neither measured nor a crack.
fn assert_voids_are_not_measured(open: &[Row], filled: &[Row]) {
    assert_eq!(open.len(), filled.len());
    for (open, filled) in open.iter().zip(filled) {
        let method = &open["method"];
        assert_eq!([&open["cracks"][..], &filled["cracks"]], ["0", "0"], "{method}");
        for column in ["triangles_mean", "triangles_max", "draws_mean", "upload_bytes_mean", "changed_triangles_mean"] {
            assert_eq!(open[column], filled[column], "{method}: {column}");
        }
        let [measured, voids] = ["samples_mean", "void_samples_mean"].map(|column| number(open, column));
        assert_eq!(number(filled, "void_samples_mean"), 0.0, "{method}");
        assert!((measured + voids - number(filled, "samples_mean")).abs() < 1e-5, "{method}: {measured} and {voids}");
        for column in ["error_px_max", "error_m_max", "displacement_px_max", "popping_px_max", "popping_samples_mean"] {
            assert!(number(open, column) <= number(filled, column), "{method}: {column}");
        }
    }
}

#[test]
fn every_method_flies_over_a_hole_that_is_not_measured() {
    let place = tempfile::tempdir().unwrap();
    let path = write_grid(place.path());
    let fly = |voids| {
        let dem = path.to_str().unwrap();
        bench(&["--dem", dem, "--voids", voids, "--methods", METHODS, "--flight", "fly-over", "--frames", "8"])
    };
    let [open, filled] = ["hole", "fill"].map(fly);
    assert_voids_are_not_measured(&open, &filled);
    for (open, filled) in open.iter().zip(&filled) {
        assert!(number(open, "void_samples_mean") > 1.0, "{}", open["method"]);
        if open["method"] == "decimated" {
            assert_ne!(open["error_px_rms"], filled["error_px_rms"], "it is off at the fill as well");
        }
    }
}

/// Of cells the same is measured as of the DEM that they were cut from, and the same is exported.
#[test]
fn cells_keep_the_voids_and_the_place_of_their_dem() {
    let place = tempfile::tempdir().unwrap();
    write_grid(place.path());
    let run = |arguments: &[&str]| {
        let output = terrain_lod(place.path(), arguments);
        (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    let (code, said) = run(&["dem", "convert", "hole.asc", "hole.cells"]);
    assert!(code == Some(0) && said.contains("63 of 825 samples (7.636 %) are voids: left open"), "{said}");
    assert_eq!(run(&["dem", "cells", "hole.asc", "k2.cells", "--k", "2", "--layers", "3"]).0, Some(0));
    let fly = |dem: &str, more: &[&str]| {
        let dem = place.path().join(dem);
        let flight = ["--dem", dem.to_str().unwrap(), "--flight", "fly-over", "--frames", "8"];
        bench(&[&flight[..], more].concat())
    };
    let measured = |row: &Row, name: &str| row[name].clone();
    let columns = ["cracks", "triangles_max", "samples_mean", "void_samples_mean", "error_px_max", "error_px_rms"];
    let compare = |dem: &[Row], cells: &[Row]| {
        assert_eq!(dem.len(), cells.len());
        for (dem, cells) in dem.iter().zip(cells) {
            assert!(number(dem, "void_samples_mean") > 1.0);
            columns.iter().for_each(|name| assert_eq!(measured(dem, name), measured(cells, name), "{name}"));
        }
    };
    let all = ["--methods", METHODS];
    compare(&fly("hole.asc", &all), &fly("hole.cells", &all));
    let streamed = ["--methods", "htp-instanced", "--window-mib", "1", "--k", "2", "--layers", "3"];
    compare(&fly("hole.asc", &streamed), &fly("k2.cells", &streamed));

    let again = |from: &str, to: &str| {
        let (code, said) = run(&["dem", "convert", from, to]);
        assert_eq!(code, Some(0), "{said}");
        std::fs::read(place.path().join(to)).unwrap()
    };
    assert!(again("hole.asc", "a.tif") == again("hole.cells", "b.tif"), "heights, voids and place");
    assert!(again("hole.cells", "c.cells") == std::fs::read(place.path().join("hole.cells")).unwrap());

    let (code, said) = run(&["dem", "info", "hole.cells", "--voids", "error"]);
    let expected = "error: hole.cells: 63 of 825 samples (7.636 %) are voids; expected none, or --voids hole or fill\n";
    assert_eq!((code, &said[..]), (Some(4), expected));
    let (_, said) = run(&["dem", "info", "hole.cells", "--voids", "fill"]);
    assert!(said.contains("voids    63 (none declared; policy: fill)"), "{said}");
    let filled = fly("hole.cells", &["--methods", "full-grid", "--voids", "fill"]);
    assert_eq!(number(&filled[0], "void_samples_mean"), 0.0);
}

/// A suite says what becomes of the voids of its DEM, and the flag says it louder.
#[test]
fn suites_have_a_policy_for_voids() {
    let place = tempfile::tempdir().unwrap();
    write_grid(place.path());
    let suite = "dem = \"hole.asc\"\nvoids = \"fill\"\nmethods = [\"full-grid\"]\nframes = 1\nflight = \"fly-over\"\n";
    std::fs::write(place.path().join("filled.toml"), suite).unwrap();
    let fly = |flags: &[&str]| {
        let output = terrain_lod(place.path(), &[&["bench", "--no-gpu", "--suite", "filled.toml"], flags].concat());
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, said) = fly(&["--out", "a"]);
    assert!(code == Some(0) && said.contains("are voids: filled from their rim"), "{said}");
    let (code, said) = fly(&["--out", "b", "--voids", "hole"]);
    assert!(code == Some(0) && said.contains("are voids: left open"), "{said}");
    assert_eq!(fly(&["--out", "c", "--voids", "error"]).0, Some(4));
}

/// SRTM with 392 voids in the shade of peaks.
#[test]
fn every_method_flies_over_a_real_tile_with_voids() {
    let Some(path) = shared_dem("N44W122.hgt") else { return };
    let methods = "tin,htp,htp-instanced,rqt,geomipmap,decimated,full-grid";
    let fly = |voids| {
        let dem = path.to_str().unwrap();
        bench(&["--dem", dem, "--voids", voids, "--methods", methods, "--flight", "fly-over", "--frames", "2"])
    };
    let [open, filled] = ["hole", "fill"].map(fly);
    assert_voids_are_not_measured(&open, &filled);
    for row in open.iter().filter(|row| ["htp-instanced", "rqt", "geomipmap"].contains(&&row["method"][..])) {
        assert!(number(row, "error_px_max") <= number(row, "tolerance_px"), "{row:?}");
    }
}

#[test]
fn exported_meshes_end_at_the_sides_of_void_quads() {
    let place = tempfile::tempdir().unwrap();
    write_grid(place.path());
    for method in METHODS.split(',') {
        let export = |voids| {
            let arguments = ["mesh", "--dem", "hole.asc", "--method", method, "--voids", voids, "--out", "mesh.ply"];
            let output = terrain_lod(place.path(), &arguments);
            assert!(output.status.success(), "{method}: {}", String::from_utf8_lossy(&output.stderr));
            let line: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
            (line, read_ply(&std::fs::read(place.path().join("mesh.ply")).unwrap()))
        };
        let (open, (vertices, triangles)) = export("hole");
        let (filled, (_, all)) = export("fill");
        let count = |line: &serde_json::Value, name: &str| line[name].as_u64().unwrap() as usize;
        assert_eq!([count(&filled, "left_out"), count(&filled, "cut")], [0, 0], "{method}");
        assert!(count(&open, "left_out") > 0, "{method}: the hole has room for some");
        if method == "full-grid" {
            // 10 x 8 quads have a void at a corner.
            assert_eq!((count(&open, "left_out"), count(&open, "cut"), all.len()), (2 * 10 * 8, 0, 2 * 32 * 24));
            assert_eq!(triangles.len(), all.len() - 2 * 10 * 8);
        }
        let corners: Vec<_> = triangles.iter().map(|t| t.map(|i| vertices[i as usize])).collect();
        for (column, row) in (0..SIZE[1] - 1).flat_map(|row| (0..SIZE[0] - 1).map(move |column| (column, row))) {
            // Both halves of a quad, whichever way it is cut.
            let points = [[0.2, 0.61], [0.62, 0.2], [0.4, 0.83], [0.84, 0.4]];
            let points = points.map(|[x, z]| [30.0 * (column as f32 + x), 30.0 * (row as f32 + z)]);
            let is_covered = points.map(|point| corners.iter().any(|corners| is_inside(corners, point)));
            assert_eq!(is_covered, [!is_void_quad(column, row); 4], "{method}: quad {column}, {row}");
        }
        assert_is_watertight(&triangles, &vertices, method);
    }
}

/// Each side but those around the DEM and the hole has its twin.
fn assert_is_watertight(triangles: &[[u32; 3]], vertices: &[[f32; 3]], method: &str) {
    let directed = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let sides: BTreeSet<[u32; 2]> = triangles.iter().flat_map(directed).collect();
    assert_eq!(sides.len(), 3 * triangles.len(), "{method}: no side twice");
    for [from, to] in sides.iter().filter(|[from, to]| !sides.contains(&[*to, *from])) {
        let [a, b] = [from, to].map(|vertex| vertices[*vertex as usize]);
        let both = |axis: usize, intervals: i32| [a, b].iter().all(|at| at[axis] == 30.0 * intervals as f32);
        let is_outline = both(0, 0) || both(0, SIZE[0] - 1) || both(2, 0) || both(2, SIZE[1] - 1);
        let is_rim = both(0, 11) || both(0, 21) || both(2, 8) || both(2, 16);
        assert!(is_outline || is_rim, "{method}: {a:?} to {b:?}");
    }
}

/// Seen from above.
fn is_inside(corners: &[[f32; 3]; 3], [x, z]: [f32; 2]) -> bool {
    (0..3).all(|i| {
        let ([ax, _, az], [bx, _, bz]) = (corners[i], corners[(i + 1) % 3]);
        (x - ax) * (bz - az) - (bx - ax) * (z - az) >= 0.0
    })
}

#[test]
fn a_mesh_of_which_nothing_is_left_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let grid = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 30\nNODATA_value -9\n1 -9\n3 4\n";
    std::fs::write(place.path().join("a.asc"), grid).unwrap();
    let refused = terrain_lod(place.path(), &["mesh", "--dem", "a.asc", "--method", "full-grid", "--out", "a.ply"]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(
        said.ends_with("error: a: all 2 triangles lie in voids; expected some elsewhere, or --voids fill\n"),
        "{said}"
    );
    assert_eq!((refused.status.code(), place.path().join("a.ply").exists()), (Some(4), false));
}

/// The two are different benches: one does not go on with the other.
#[test]
fn the_machines_facts_tell_holes_from_fills() {
    let place = tempfile::tempdir().unwrap();
    write_grid(place.path());
    let [open, filled] = ["hole", "fill"].map(|voids| {
        let flight = ["--methods", "full-grid", "--frames", "1"];
        let bench = ["bench", "--no-gpu", "--dem", "hole.asc", "--voids", voids, "--out", voids];
        let output = terrain_lod(place.path(), &[&bench[..], &flight].concat());
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && said.contains("63 of 825 samples (7.636 %) are voids: "), "{said}");
        let file = std::fs::read(place.path().join(voids).join("machine.json")).unwrap();
        serde_json::from_slice::<serde_json::Value>(&file).unwrap()
    });
    assert_eq!((&open["dem_voids"], &filled["dem_voids"]), (&63.into(), &0.into()));
    assert_ne!(open["dem_sha256"], filled["dem_sha256"]);
}
