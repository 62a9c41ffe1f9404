//! Elevation files of other formats than PNG: what is said of them, and that methods fly over them.

use std::path::Path;

use terrain_dem::{ColourCode, ReadOptions};

use crate::program::{bench, shared_dem, terrain_lod};

/// 4 x 3 heights, one of them a void.
const GRID: &str = "ncols 4\nnrows 3\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\nNODATA_value -9999\n\
                    1 2 3 4\n5 -9999 7 8\n9 10 11 12\n";

#[test]
fn info_says_what_a_file_holds_and_what_is_wrong_with_it() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("a.asc"), GRID).unwrap();
    let text = terrain_lod(place.path(), &["dem", "info", "a.asc"]);
    let expected = "a.asc
  format   ESRI ASCII grid, text
  CRS      not said
  size     4 x 3 samples, 0.1 x 0.1 km
  spacing  30 x 30 m (by the file: 30 x 30 m)
  heights  1 to 12 m (unit not said, taken as metres; 1 m a step, 0 m at 0)
  voids    1 (declared: -9999; policy: hole)
  warning  1 of 12 samples (8.333 %) are voids: left open (--voids fill fills them from their rim)
";
    assert_eq!(String::from_utf8(text.stdout).unwrap(), expected);

    let json = terrain_lod(place.path(), &["dem", "info", "a.asc", "--unit", "foot", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((&json["columns"], &json["voids"], &json["unit"]), (&4.into(), &1.into(), &"foot".into()));
    assert_eq!(json["spacing_m"], serde_json::json!([30.0, 30.0]));
    assert_eq!(json["void_policy"], "hole");
    let filled = terrain_lod(place.path(), &["dem", "info", "a.asc", "--voids", "fill"]);
    let said = String::from_utf8(filled.stdout).unwrap();
    assert!(
        said.contains("(declared: -9999; policy: fill)\n  warning  1 of 12 samples (8.333 %) are voids: filled"),
        "{said}"
    );

    let refused = terrain_lod(place.path(), &["dem", "info", "a.asc", "--voids", "error"]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(said, "error: a.asc: 1 of 12 samples (8.333 %) are voids; expected none, or --voids hole or fill\n");
    assert_eq!(refused.status.code(), Some(4));
}

const METHODS: &str = "tin,htp,htp-instanced,rqt,geomipmap,greedy,decimated,full-grid";

/// The DEMs beside the project. Whole and in more frames they take minutes: `bench --no-gpu --dem FILE --methods ... --frames 3`.
const REAL: [&str; 8] = [
    "bigtujunga.tif",
    "N44W122.hgt",
    "ps_1025.png",
    "deathvalley_2049_80m.png",
    "ps_257_crop_rainier.png",
    "ps_513_crop_rainier.png",
    "sthelens_30m_257.png",
    "sthelens_30m_native.png",
];

/// What a `.json` beside a PNG says of it, as flags.
fn flags_of(dem: &Path) -> Vec<String> {
    let Ok(text) = std::fs::read_to_string(dem.with_extension("json")) else { return Vec::new() };
    let facts: serde_json::Value = serde_json::from_str(&text).unwrap();
    let [x, z, scale, offset] =
        ["metres_per_sample_x", "metres_per_sample_y", "scale", "offset"].map(|key| &facts[key]);
    vec![format!("--spacing={x},{z}"), format!("--scale={scale}"), format!("--offset={offset}")]
}

#[test]
fn every_method_flies_over_every_real_dem_without_a_crack() {
    for path in REAL.into_iter().filter_map(shared_dem) {
        let flags = flags_of(&path);
        let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
        let fixed = ["--dem", path.to_str().unwrap(), "--crop", "249x249", "--methods", METHODS, "--frames", "2"];
        let rows = bench(&[&fixed[..], &["--selector", "algorithm1,bounded", "--flight", "turn"], &flags].concat());
        assert_eq!(rows.len(), 11, "{}", path.display());
        for row in rows {
            let number = |key: &str| row[key].parse::<f64>().unwrap();
            let run = format!("{}: {}", path.display(), row["run"]);
            assert_eq!(row["cracks"], "0", "{run}");
            let has_bound =
                ["tin-bounded", "htp-instanced", "rqt", "geomipmap"].iter().any(|name| row["run"].starts_with(name));
            assert!(!has_bound || number("error_px_max") <= number("tolerance_px"), "{run}");
            assert!(row["method"] != "full-grid" || number("error_px_max") == 0.0, "{run}");
            assert!(number("error_px_rms") < 20.0 && number("samples_mean") > 0.0, "{run}");
        }
    }
}

#[test]
fn parts_of_a_dem_are_flown_under_their_own_name() {
    let rows =
        bench(&["--dem", "synthetic:97x80:3", "--crop", "65x65", "--thin", "2", "--methods", "tin", "--frames", "2"]);
    let found = ["dem", "dem_columns", "dem_rows", "cracks"].map(|column| rows[0][column].as_str());
    assert_eq!(found, ["synthetic-97x80-3-65x65+16+7-thin2", "33", "33", "0"]);
}

#[test]
fn converted_files_are_the_same_dem() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    std::fs::write(place.join("a.asc"), GRID).unwrap();
    let said = |arguments: &[&str]| {
        let output = terrain_lod(place, arguments);
        let text = [output.stdout, output.stderr].concat();
        (output.status.code(), String::from_utf8(text).unwrap())
    };
    for (out, kind) in [
        ("b.png", "16-bit PNG in steps of 1 m, all heights exact; 1 voids as 0"),
        ("c.r16", "uint16 in steps of 1 m, all heights exact; 1 voids as 0"),
        ("d.tif", "float32 GeoTIFF; 1 voids as NaN"),
        ("e.r32", "float32; 1 voids as NaN"),
    ] {
        let (code, text) = said(&["dem", "convert", "a.asc", out]);
        assert_eq!(code, Some(0), "{text}");
        assert!(text.contains(&format!("{out}: 4 x 3 samples, 30 x 30 m apart, {kind}\n")), "{text}");
        let (_, json) = said(&["dem", "info", out, "--format", "json"]);
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let found = ["columns", "rows", "voids", "lowest_m", "highest_m", "spacing_m"].map(|key| json[key].to_string());
        assert_eq!(found, ["4", "3", "1", "1.0", "12.0", "[30.0,30.0]"], "{out}");
    }
    let (code, text) = said(&["dem", "convert", "a.asc", "filled.r32", "--voids", "fill"]);
    assert!(code == Some(0) && text.starts_with("filled.r32: 4 x 3 samples, 30 x 30 m apart, float32\n"), "{text}");
    let (code, text) = said(&["dem", "convert", "a.asc", "a.png"]);
    assert!(code == Some(6) && text.contains("a.asc, too; expected another name"), "{text}");
    assert_eq!(said(&["dem", "convert", "a.asc", "b.xyz"]).0, Some(2));
}

#[test]
fn a_shaded_picture_has_a_pixel_a_sample() {
    let place = tempfile::tempdir().unwrap();
    std::fs::write(place.path().join("a.asc"), GRID).unwrap();
    let output = terrain_lod(place.path(), &["dem", "shade", "a.asc", "a-shade.png"]);
    assert_eq!(String::from_utf8(output.stdout).unwrap(), "a-shade.png: 4 x 3 pixels, 1 to 12 m\n");
    // Its colours, packed as heights.
    let packed = ReadOptions { colours: Some(ColourCode::Mapbox), spacing_m: Some([1.0; 2]), ..ReadOptions::default() };
    let picture = terrain_dem::read(&place.path().join("a-shade.png"), &packed).unwrap().heightmap;
    assert_eq!((picture.columns(), picture.rows()), (4, 3));
    let void = f64::from(0xc8_00_c8) * 0.1 - 10_000.0;
    assert_eq!(f64::from(picture.heights_m()[5]), void, "magenta");
}

#[test]
fn tiles_are_flown_as_one_dem() {
    let place = tempfile::tempdir().unwrap();
    let place = place.path();
    for (name, east) in [("a.asc", 500_000), ("b.asc", 500_120)] {
        std::fs::write(place.join(name), GRID.replace("500000", &east.to_string())).unwrap();
    }
    let rows = bench(&["--dem", &format!("{}/?.asc", place.display()), "--methods", "htp,full-grid", "--frames", "2"]);
    for row in rows {
        assert_eq!([&row["dem_columns"], &row["dem_rows"], &row["cracks"]], ["8", "3", "0"]);
    }
}

/// Four parts with shared rims, one of them with a void, in files that have their place from sidecars.
#[test]
fn parts_that_were_converted_join_again() {
    let place = tempfile::tempdir().unwrap();
    let row = |r: u32| (0..9).map(|c| (100 + (c * 37 + r * 91) % 60).to_string()).collect::<Vec<_>>().join(" ");
    let rows: Vec<String> = (0..7).map(row).collect();
    let header = "ncols 9\nnrows 7\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\nNODATA_value 137\n";
    std::fs::write(place.path().join("whole.asc"), format!("{header}{}\n", rows.join("\n"))).unwrap();
    let convert = |arguments: &[&str]| {
        let output = terrain_lod(place.path(), &[&["dem", "convert"], arguments].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stderr).unwrap()
    };
    let read = |name: &str| std::fs::read(place.path().join(name)).unwrap();
    convert(&["whole.asc", "same.r32"]);
    for ending in ["png", "r16", "r32"] {
        let folder = place.path().join(ending);
        std::fs::create_dir(&folder).unwrap();
        for part in ["5x4+0+0", "5x4+4+0", "5x4+0+3", "5x4+4+3"] {
            convert(&["whole.asc", &format!("{ending}/{part}.{ending}"), "--crop", part]);
        }
        let joined = format!("{ending}-joined.r32");
        let said = convert(&[ending, &joined]);
        assert!(read(&joined) == read("same.r32") && !said.contains("differ"), "{ending}: {said}");

        std::fs::remove_file(folder.join(format!("5x4+4+3.{ending}"))).unwrap();
        let said = convert(&[&format!("{ending}/*.{ending}"), &joined]);
        assert!(said.contains("12 of them between the tiles"), "{ending}: {said}");
    }
    // A rim that says otherwise.
    convert(&["whole.asc", "r32/5x4+4+3.r32", "--crop", "5x4+4+3", "--offset", "1"]);
    let said = convert(&["r32", "other.r32"]);
    assert!(said.contains("8 of 8 samples that it shares with tiles before it differ, by at most 1 m"), "{said}");
}
