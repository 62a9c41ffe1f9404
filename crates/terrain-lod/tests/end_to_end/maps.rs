//! Threshold maps that are kept beside the DEM.

use std::fs;
use std::path::Path;

use crate::program::terrain_lod;

/// The mesh of a frame, and what the program says on stderr.
fn mesh(place: &Path, more: &[&str]) -> (Vec<u8>, String) {
    let arguments = ["mesh", "--dem", "hills.png", "--method", "tin", "--patch", "16", "--out", "mesh.ply"];
    let output = terrain_lod(place, &[&arguments[..], more].concat());
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    (fs::read(place.join("mesh.ply")).unwrap(), said)
}

#[test]
fn maps_are_kept_used_and_computed_anew_when_stale_or_damaged() {
    let place = tempfile::tempdir().unwrap();
    let write_dem = |seed| {
        let hills = terrain_dem::synthetic::generate(90, 70, seed);
        let values: Vec<u16> = hills.heights_m().iter().map(|height_m| *height_m as u16).collect();
        terrain_dem::write_png16(&place.path().join("hills.png"), 90, 70, &values).unwrap();
    };
    write_dem(1);
    fs::write(place.path().join("hills.toml"), "spacing_m = 30").unwrap();
    let maps = place.path().join("hills.png.patch16-group4.tin-maps");
    let (expected, _) = mesh(place.path(), &[]);
    assert!(!maps.exists(), "nobody asked for it");
    for round in 0..2 {
        assert!(mesh(place.path(), &["--keep-maps"]) == (expected.clone(), String::new()), "round {round}");
    }
    let kept = fs::read(&maps).unwrap();

    let mut damaged = kept.clone();
    *damaged.last_mut().unwrap() ^= 1;
    fs::write(&maps, damaged).unwrap();
    let (found, said) = mesh(place.path(), &["--keep-maps"]);
    assert!(found == expected && said.ends_with("damaged threshold maps; computed anew\n"), "{said}");
    assert!(fs::read(&maps).unwrap() == kept);

    write_dem(2);
    let (other, said) = mesh(place.path(), &["--keep-maps"]);
    assert!(other != expected && said.ends_with("of another DEM or of other patches; computed anew\n"), "{said}");
}
