//! Meshes of a few triangles over small, rough DEMs, and their heights by brute force: nothing shared with the oracle.

use glam::{DVec2, DVec3, DVec4};

use crate::{Camera, Heightmap, Lens, Sample, SplitMix64, Triangle, View, VoidMask};

/// 9 x 7 samples of up to 50 m.
pub fn rough_dem(seed: u64) -> Heightmap {
    let mut random = SplitMix64::new(seed);
    let heights = (0..9 * 7).map(|_| random.range(0.0, 50.0) as f32).collect();
    Heightmap::new(9, 7, [10.0, 12.0], heights).unwrap()
}

/// The same DEM with a third of its samples, or so, declared voids; and a flag for each.
pub fn with_voids(dem: Heightmap, seed: u64) -> (Heightmap, Vec<bool>) {
    let mut random = SplitMix64::new(seed);
    let flags: Vec<bool> = dem.heights_m().iter().map(|_| random.below(3) == 0).collect();
    let mask = VoidMask::of_flags(dem.columns(), &flags);
    (dem.with_voids(mask.into()).unwrap(), flags)
}

/// The whole DEM as fans around one inner sample.
pub fn fan(dem: &Heightmap, column: u32, row: u32) -> Vec<Triangle> {
    let corner = |c, r| Sample { column: c, row: r };
    let rim = [corner(0, 0), corner(0, 6), corner(8, 6), corner(8, 0)];
    let triangle = |i: usize| {
        let samples = [corner(column, row), rim[i], rim[(i + 1) % 4]];
        Triangle { samples, heights_m: samples.map(|s| dem.height_m(s)) }
    };
    (0..4).map(triangle).filter(|t| t.doubled_area() != 0).collect()
}

/// Every sample, row by row.
pub fn samples() -> impl Iterator<Item = Sample> {
    (0..63).map(|i| Sample { column: i % 9, row: i / 9 })
}

/// Height of the mesh at a sample, if any triangle covers it, by solving each triangle's plane in floats.
pub fn brute_force_m(dem: &Heightmap, mesh: &[Triangle], at: Sample) -> Option<f64> {
    mesh.iter().find_map(|t| {
        let corner = |i: usize| {
            let [x, _, z] = dem.world(t.samples[i]);
            DVec3::new(x, t.heights_m[i] as f64, z)
        };
        let [a, b, c] = [0, 1, 2].map(corner);
        let p = DVec3::from(dem.world(at));
        let normal = (b - a).cross(c - a);
        let flat = |v: DVec3| DVec3::new(v.x, 0.0, v.z);
        let inside = [(a, b), (b, c), (c, a)].iter().all(|(s, e)| flat(*e - *s).cross(flat(p - *s)).y >= -1e-6);
        inside.then(|| a.y - (normal.x * (p.x - a.x) + normal.z * (p.z - a.z)) / normal.y)
    })
}

/// From above the DEM's middle, nearly straight down.
pub fn view(seed: u64) -> View {
    let mut random = SplitMix64::new(seed);
    let eye_world = DVec3::new(random.range(30.0, 50.0), random.range(150.0, 300.0), random.range(26.0, 46.0));
    let camera = Camera { eye_world, heading: random.range(-3.0, 3.0), pitch: random.range(-1.5, -1.4) };
    View::new(&camera, &Lens { fov_y: 0.2, size_px: [300, 200], near_m: 1.0 }).unwrap()
}

/// In clip space.
pub fn clip(view: &View, world: DVec3) -> DVec4 {
    view.clip_from_world * world.extend(1.0)
}

pub fn is_seen(view: &View, world: DVec3) -> bool {
    let c = clip(view, world);
    c.x.abs() <= c.w && c.y.abs() <= c.w && c.z <= c.w
}

/// Pixels between two points that are both in front of the near plane.
pub fn on_screen_px(view: &View, a: DVec3, b: DVec3) -> f64 {
    let [a, b] = [a, b].map(|point| {
        let c = clip(view, point);
        DVec2::new(150.0 * c.x / c.w, 100.0 * c.y / c.w)
    });
    a.distance(b)
}
