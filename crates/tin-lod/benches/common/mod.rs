//! The terrain, the camera and the clocks of the benches.

use std::path::{Path, PathBuf};

use cpu_time::ProcessTime;
use terrain_core::{Camera, Heightmap, Lens, View};
use terrain_dem::ReadOptions;

/// The DEM that the command line names, or the Puget Sound DEM that lies beside the project on some machines, or else
/// synthetic terrain of the same size. With its name.
pub fn open() -> (String, Heightmap) {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/dem/ps_1025.png");
    let (path, spacing_m, scale) = match &arguments[..] {
        [path, spacing, scale] => (PathBuf::from(path), spacing.parse().unwrap(), scale.parse().unwrap()),
        _ => (beside, 160.0, 0.1),
    };
    if !path.is_file() {
        return ("synthetic".to_owned(), terrain_dem::synthetic::generate(1025, 1025, 1));
    }
    let options = ReadOptions { spacing_m: Some([spacing_m; 2]), scale: Some(scale), ..Default::default() };
    let dem = terrain_dem::read(&path, &options).unwrap();
    (dem.name, dem.heightmap.as_ref().clone())
}

/// 1280 x 720 pixels, 60 degrees.
pub fn lens() -> Lens {
    Lens { fov_y: 60f64.to_radians(), size_px: [1280, 720], near_m: 1.0 }
}

/// 100 m above the ground at the middle.
pub fn above_the_middle(dem: &Heightmap) -> View {
    let [x, z] = dem.extent_m().map(|extent| extent / 2.0);
    let camera = Camera { eye_world: [x, dem.ground_m(x, z) + 100.0, z].into(), heading: 0.0, pitch: 0.0 };
    View::new(&camera, &lens()).unwrap()
}

/// Of all threads of this program: other programs do not count.
pub fn cpu_ms() -> f64 {
    ProcessTime::now().as_duration().as_secs_f64() * 1e3
}
