//! Several files as one DEM, against the function that their heights were taken from.

use std::path::Path;

use terrain_dem::{Dem, DemError, ReadOptions, VoidPolicy, open, open_rows};

use crate::writers;

/// The height of a place in the grid over all tiles; no two are alike.
fn height(column: u32, row: u32) -> i16 {
    (column * 100 + row) as i16
}

/// Samples a side of the SRTM tiles here: neighbours share a row or column.
const SIDE: u32 = 5;

/// A tile whose north-western sample is this column and row.
fn hgt(column: u32, row: u32) -> Vec<u8> {
    let samples = (0..SIDE * SIDE).map(|i| height(column + i % SIDE, row + i / SIDE));
    samples.flat_map(i16::to_be_bytes).collect()
}

fn asc(corner: [u32; 2], size: [u32; 2], first: [u32; 2], cell: &str) -> String {
    let [columns, rows] = size;
    let row =
        |row| (0..columns).map(|column| height(first[0] + column, first[1] + row).to_string()).collect::<Vec<_>>();
    let numbers: Vec<String> = (0..rows).map(|z| row(z).join(" ")).collect();
    format!(
        "ncols {columns}\nnrows {rows}\nxllcorner {}\nyllcorner {}\ncellsize {cell}\n{}\n",
        corner[0],
        corner[1],
        numbers.join("\n")
    )
}

fn write(folder: &Path, files: &[(&str, Vec<u8>)]) {
    for (name, bytes) in files {
        std::fs::write(folder.join(name), bytes).unwrap();
    }
}

fn joined(folder: &Path, pattern: &str) -> Result<Dem, DemError> {
    open(folder.join(pattern).to_str().unwrap(), &ReadOptions::default())
}

/// Every sample is a void or has the height of its place.
fn check(dem: &Dem, is_void: impl Fn(u32, u32) -> bool) {
    let map = &dem.heightmap;
    for row in 0..map.rows() {
        for column in 0..map.columns() {
            let found_void = dem.voids.as_ref().is_some_and(|voids| voids.is_void(column, row));
            assert_eq!(found_void, is_void(column, row), "{column}, {row}");
            let height_m = map.heights_m()[(row * map.columns() + column) as usize];
            assert!(found_void || height_m == f32::from(height(column, row)), "{column}, {row}: {height_m}");
        }
    }
}

#[test]
fn tiles_by_name_become_one_dem_with_a_gap() {
    let folder = tempfile::tempdir().unwrap();
    let tiles = [("N45W122.hgt", hgt(0, 0)), ("N44W122.hgt", hgt(0, 4)), ("n44_w121_1arc_v3.hgt", hgt(4, 4))];
    write(folder.path(), &tiles);
    for pattern in ["", "*.hgt", "[Nn]4*[Ww]12?*"] {
        let dem = joined(folder.path(), pattern).unwrap();
        let [x, z] = dem.heightmap.spacing_m();
        assert_eq!((dem.heightmap.columns(), dem.heightmap.rows()), (9, 9));
        // Half a degree around latitude 45, where one is 78,846.8 m and 111,131.8 m.
        assert!((x * 4.0 - 78_846.8).abs() < 0.1 && (z * 4.0 - 111_131.8).abs() < 0.1, "{x} x {z}");
        check(&dem, |column, row| column > 4 && row < 4);
        assert_eq!(dem.reading.format, "3 tiles: SRTM tile (.hgt)");
        let [warning] = dem.reading.warnings.as_slice() else { panic!("{:?}", dem.reading.warnings) };
        assert!(
            warning.starts_with("16 of 81 samples (19.753 %) are voids, 16 of them between the tiles"),
            "{warning}"
        );
    }
    let dem = joined(folder.path(), "*.hgt").unwrap();
    assert_eq!(dem.name, "N44W122-of-3");
    // Row by row they are the same DEM.
    let rows = open_rows(folder.path().to_str().unwrap(), &ReadOptions::default()).unwrap();
    let mut found = Vec::new();
    rows.for_each(&mut |row_m| {
        found.extend_from_slice(row_m);
        std::ops::ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(found, dem.heightmap.heights_m());
}

#[test]
fn rims_that_disagree_are_told_and_the_first_tile_stays() {
    let folder = tempfile::tempdir().unwrap();
    let mut other = hgt(4, 0);
    // The third sample of its western rim: 402 becomes 405; and one beyond the rim.
    other[20..22].copy_from_slice(&405i16.to_be_bytes());
    write(folder.path(), &[("N45W122.hgt", hgt(0, 0)), ("N45W121.hgt", other)]);
    // N45W121 comes first by name.
    let dem = joined(folder.path(), "N*.hgt").unwrap();
    let said = dem.reading.warnings.join("\n");
    let expected =
        "N45W122.hgt: 1 of 5 samples that it shares with tiles before it differ, by at most 3 m; theirs are kept";
    assert!(said.ends_with(expected), "{said}");
    assert_eq!(dem.heightmap.heights_m()[2 * 9 + 4], 405.0);
}

#[test]
fn one_tile_fills_the_voids_of_another() {
    let folder = tempfile::tempdir().unwrap();
    let mut other = hgt(4, 0);
    other[20..22].copy_from_slice(&i16::MIN.to_be_bytes());
    write(folder.path(), &[("N45W122.hgt", hgt(0, 0)), ("N45W121.hgt", other)]);
    let dem = joined(folder.path(), "").unwrap();
    check(&dem, |_, _| false);
    assert_eq!(dem.reading.warnings, [""; 0]);
}

#[test]
fn cells_side_by_side_share_no_rim() {
    let folder = tempfile::tempdir().unwrap();
    let files = [
        ("a.asc", asc([500_000, 4_000_000], [4, 3], [0, 2], "30").into_bytes()),
        ("b.asc", asc([500_120, 4_000_000], [2, 5], [4, 0], "30").into_bytes()),
        ("a.txt", b"what the tiles are".to_vec()),
    ];
    write(folder.path(), &files);
    let dem = joined(folder.path(), "").unwrap();
    assert_eq!((dem.heightmap.columns(), dem.heightmap.rows(), dem.heightmap.spacing_m()), (6, 5, [30.0; 2]));
    check(&dem, |column, row| column < 4 && row < 2);
}

#[test]
fn one_height_grid_in_two_formats() {
    let folder = tempfile::tempdir().unwrap();
    // Quarters of a degree, as the DTED tile has them; that begins at 7 E and 44.75 N.
    let west = "ncols 4\nnrows 3\nxllcenter 6\nyllcenter 44.75\ncellsize 0.25\n";
    let files = [
        ("a.dt0", writers::dted()),
        ("b.asc", format!("{west}{}\n", writers::words(" ", "\n")).into_bytes()),
        ("b.prj", b"GEOGCS[\"WGS 84\"]".to_vec()),
    ];
    write(folder.path(), &files);
    let dem = joined(folder.path(), "?.[da]*").unwrap();
    assert_eq!((dem.heightmap.columns(), dem.heightmap.rows()), (8, 3));
    for (row, heights) in writers::GRID.iter().enumerate() {
        let expected: Vec<f32> = [heights.as_slice(), heights].concat().iter().map(|&h| f32::from(h)).collect();
        assert_eq!(&dem.heightmap.heights_m()[row * 8..row * 8 + 8], expected);
    }
}

#[test]
fn tiles_that_do_not_fit_are_refused_by_name() {
    let place = [500_000, 4_000_000];
    let fits = asc(place, [4, 3], [0, 0], "30").into_bytes();
    let plain: [(&str, Vec<u8>, &str); 4] = [
        (
            "b.asc",
            asc([500_130, 4_000_000], [4, 3], [0, 0], "30").into_bytes(),
            "lies 0.33 x 0.00 samples off the grid",
        ),
        ("b.asc", asc(place, [4, 3], [0, 0], "10").into_bytes(), "steps of 10 x 10, and "),
        ("b.hgt", hgt(0, 0), "no spacing; expected"),
        ("b.dt0", writers::dted(), "steps of 0.25 x 0.25, and "),
    ];
    for (name, bytes, said) in plain {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &[("a.asc", fits.clone()), (name, bytes)]);
        let error = joined(folder.path(), "").unwrap_err();
        assert!(error.to_string().contains(&format!("{name}: {said}")) && !error.is_io(), "{error}");
    }
    let folder = tempfile::tempdir().unwrap();
    let far = asc([900_000_020, 4_000_000], [4, 3], [0, 0], "30").into_bytes();
    write(folder.path(), &[("a.asc", fits.clone()), ("b.asc", far)]);
    let error = joined(folder.path(), "").unwrap_err().to_string();
    assert!(error.contains("samples; expected 2 to 65535 a side"), "{error}");
    let spaced = ReadOptions { spacing_m: Some([30.0; 2]), ..ReadOptions::default() };
    write(folder.path(), &[("b.asc", writers::npy_i2())]);
    let error = open(folder.path().to_str().unwrap(), &spaced).unwrap_err().to_string();
    assert!(error.contains("b.asc: nothing says where it lies"), "{error}");
    let refusing = ReadOptions { voids: VoidPolicy::Error, ..ReadOptions::default() };
    write(folder.path(), &[("b.asc", asc([500_000, 4_000_300], [4, 3], [0, 0], "30").into_bytes())]);
    let error = open(folder.path().to_str().unwrap(), &refusing).unwrap_err().to_string();
    assert!(error.contains("28 of them between the tiles"), "{error}");
}
