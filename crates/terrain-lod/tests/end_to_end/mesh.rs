//! The exported mesh: it is the DEM's, it is whole, and the line on stdout says how it was seen.

use terrain_core::LodMethod;

use crate::program::{bench, terrain_lod};

/// Vertices and triangles of a binary little-endian PLY as this program writes it.
pub fn read_ply(bytes: &[u8]) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let end = b"end_header\n";
    let header_length = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
    let header = std::str::from_utf8(&bytes[..header_length]).unwrap();
    let count = |element: &str| -> usize {
        let line = header.lines().find_map(|line| line.strip_prefix(&format!("element {element} "))).unwrap();
        line.parse().unwrap()
    };
    let (vertices, faces) = bytes[header_length..].split_at(12 * count("vertex"));
    let word = |at: &[u8]| <[u8; 4]>::try_from(at).unwrap();
    let vertex = |v: &[u8]| [0, 4, 8].map(|i| f32::from_le_bytes(word(&v[i..i + 4])));
    let face = |f: &[u8]| {
        assert_eq!(f[0], 3);
        [1, 5, 9].map(|i| u32::from_le_bytes(word(&f[i..i + 4])))
    };
    assert_eq!(faces.len(), 13 * count("face"));
    (vertices.chunks(12).map(vertex).collect(), faces.chunks(13).map(face).collect())
}

#[test]
fn every_method_exports_the_whole_dem() {
    let place = tempfile::tempdir().unwrap();
    let dem = terrain_dem::open("jacksboro", &Default::default()).unwrap().heightmap;
    let [width_m, depth_m] = dem.extent_m();
    for method in ["tin", "htp", "htp-instanced", "full-grid"] {
        let arguments = ["mesh", "--method", method, "--flight", "turn", "--frame", "7", "--out", "mesh.ply"];
        let output = terrain_lod(place.path(), &arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let line: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let (vertices, triangles) = read_ply(&std::fs::read(place.path().join("mesh.ply")).unwrap());
        assert_eq!(line["vertices"], vertices.len());
        assert_eq!(line["triangles"], triangles.len());
        assert_eq!((&line["width"], &line["height"], &line["fov_y"]), (&640.into(), &360.into(), &60.0.into()));

        // The eye is where clip_from_world has w = 0 and x = y = 0.
        let m: Vec<f64> = line["clip_from_world"].as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect();
        let eye: Vec<f64> = line["eye"].as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect();
        for row in [0, 1, 3] {
            let clip = m[row] * eye[0] + m[4 + row] * eye[1] + m[8 + row] * eye[2] + m[12 + row];
            assert!(clip.abs() < 1e-6, "{method}: row {row} gives {clip}");
        }

        // Areas seen from above are positive and sum to the DEM's; heights are the DEM's.
        let mut doubled_area_m2 = 0.0;
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|i| vertices[i as usize].map(f64::from));
            let area = (c[0] - a[0]) * (b[2] - a[2]) - (b[0] - a[0]) * (c[2] - a[2]);
            assert!(area > 0.0, "{method}: {triangle:?}");
            doubled_area_m2 += area;
        }
        assert!((doubled_area_m2 / (2.0 * width_m * depth_m) - 1.0).abs() < 1e-6, "{method}");
        assert!(
            vertices.iter().all(|v| (dem.ground_m(v[0].into(), v[2].into()) - v[1] as f64).abs() < 0.01),
            "{method}"
        );
        let mut sorted: Vec<_> = vertices.iter().map(|v| v.map(f32::to_bits)).collect();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), vertices.len(), "{method}: shared vertices are shared");
    }
}

/// Found by a review: with culling off from the first frame on, the TIN's history was another one than in the bench.
#[test]
fn the_mesh_has_as_many_triangles_in_view_as_the_bench_draws() {
    let rows = bench(&["--methods", "tin", "--selector", "bounded", "--frames", "30"]);
    let place = tempfile::tempdir().unwrap();
    let arguments = ["mesh", "--method", "tin", "--frames", "30", "--frame", "29", "--out", "mesh.ply"];
    let output = terrain_lod(place.path(), &arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));

    // The bench's own mesh of that frame, culled and not.
    let dem = terrain_dem::open("jacksboro", &Default::default()).unwrap().heightmap;
    let flight = terrain_core::Flight::built_in("ground-level").unwrap();
    let path = terrain_core::FlightPath::new(&flight, &dem, 30).unwrap();
    let mut tin = tin_lod::Tin::new(dem.clone(), Default::default()).unwrap();
    let mut plan = Default::default();
    let mut drawn = Vec::new();
    for frame in 0..30 {
        tin.plan(&path.view(frame, [640, 360]).unwrap(), &mut plan);
        drawn.push(terrain_core::FrameStats::of(&plan).triangles);
    }
    assert_eq!(rows[0]["triangles_max"], drawn.iter().max().unwrap().to_string());
    tin.set_culling(false);
    tin.plan(&path.view(29, [640, 360]).unwrap(), &mut plan);
    let line: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(line["triangles"], terrain_core::FrameStats::of(&plan).triangles);
}

/// The bytes of each format are checked where they are written; here the ending chooses.
#[test]
fn the_ending_chooses_the_format() {
    let place = tempfile::tempdir().unwrap();
    let export = |out: &str| {
        let arguments = ["mesh", "--method", "tin", "--dem", "synthetic:65x65:2", "--out", out];
        terrain_lod(place.path(), &arguments)
    };
    for (out, starts) in [("a.ply", &b"ply\n"[..]), ("a.obj", b"# x east"), ("a.stl", b"terrain: "), ("a.glb", b"glTF")]
    {
        assert!(export(out).status.success());
        assert!(std::fs::read(place.path().join(out)).unwrap().starts_with(starts), "{out}");
    }
    let refused = export("a.fbx");
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(said, "error: a.fbx: expected a name that ends in .ply, .obj, .stl or .glb\n");
    assert_eq!(refused.status.code(), Some(2));
    assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 4, "nothing else is left");
}
