//! Triangles, error and planning time of the baselines at three fixed eyes over a DEM:
//!
//! ```text
//! cargo run --release -p lod-baselines --example views -- DEM.png SPACING_M SCALE_M TOLERANCE_PX ...
//! ```
//!
//! 1280 x 720 pixels, 60 degrees. *middle*: 100 m above the DEM's middle, east, 5 degrees down. *corner*: 100 m above
//! the north-western corner, south-east, 5 degrees down. *high*: 10 km above the middle, east, 30 degrees down.
//! The error is the largest of all samples of the DEM, in view or not.

use cpu_time::ProcessTime;
use lod_baselines::{Geomipmap, Rqt};
use terrain_core::error::ErrorOracle;
use terrain_core::{Camera, FramePlan, FrameStats, Heightmap, Lens, LodMethod, MeshMirror, Sample, View};
use terrain_dem::ReadOptions;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize| -> f64 { args[i].parse().expect("a number") };
    let read = ReadOptions { spacing_m: Some([number(1); 2]), scale: Some(number(2)), ..Default::default() };
    let dem = terrain_dem::open(&args[0], &read).expect("a readable DEM").heightmap;
    println!("method      px    eye     triangles   in view  draws  max px  plan ms  in view ms");
    for tolerance_px in (3..args.len()).map(number) {
        for name in ["rqt", "geomipmap"] {
            for (eye, view) in views(&dem) {
                let method = build(name, &dem, tolerance_px);
                println!("{name:10} {tolerance_px:<5} {eye:7} {}", measure(method, &dem, &view));
            }
        }
    }
}

fn build(name: &str, dem: &Heightmap, tolerance_px: f64) -> Box<dyn LodMethod> {
    match name {
        "rqt" => Box::new(Rqt::new(dem, tolerance_px).expect("a usable tolerance")),
        "geomipmap" => Box::new(Geomipmap::new(dem, tolerance_px).expect("a usable tolerance")),
        _ => unreachable!("{name} is in the list"),
    }
}

fn views(dem: &Heightmap) -> [(&'static str, View); 3] {
    let [width_m, depth_m] = dem.extent_m();
    let view = |[x, z]: [f64; 2], above_m: f64, heading: f64, pitch: f64| {
        let eye_world = [x, dem.ground_m(x, z) + above_m, z].into();
        let camera = Camera { eye_world, heading: heading.to_radians(), pitch: pitch.to_radians() };
        let lens = Lens { fov_y: 60f64.to_radians(), size_px: [1280, 720], near_m: 1.0 };
        View::new(&camera, &lens).expect("a finite camera")
    };
    let middle = [0.5 * width_m, 0.5 * depth_m];
    [
        ("middle", view(middle, 100.0, 90.0, -5.0)),
        ("corner", view([0.0; 2], 100.0, 135.0, -5.0)),
        ("high", view(middle, 10_000.0, 90.0, -30.0)),
    ]
}

fn measure(mut method: Box<dyn LodMethod>, dem: &Heightmap, view: &View) -> String {
    let mut mirror = MeshMirror::new(&method.buffers(), dem);
    let mut plan = FramePlan::default();
    method.set_culling(false);
    method.plan(view, &mut plan);
    mirror.replay(&plan).expect("a sound plan");
    let mut oracle = ErrorOracle::new(dem);
    oracle.set_mesh(mirror.triangles());
    let (whole, whole_ms) = (FrameStats::of(&plan).triangles, plan_ms(method.as_mut(), view));
    method.set_culling(true);
    let in_view_ms = plan_ms(method.as_mut(), view);
    method.plan(view, &mut plan);
    let FrameStats { triangles, draws, .. } = FrameStats::of(&plan);
    let error_px = largest_px(dem, &oracle, view);
    format!("{whole:>10} {triangles:>9} {draws:>6}  {error_px:.4} {whole_ms:8.2} {in_view_ms:8.2}")
}

/// The median of nine.
fn plan_ms(method: &mut dyn LodMethod, view: &View) -> f64 {
    let mut plan = FramePlan::default();
    let mut once = || {
        let start = ProcessTime::now();
        method.plan(view, &mut plan);
        start.elapsed().as_secs_f64() * 1e3
    };
    let mut times = [(); 9].map(|()| once());
    times.sort_by(f64::total_cmp);
    times[4]
}

fn largest_px(dem: &Heightmap, oracle: &ErrorOracle, view: &View) -> f64 {
    let error_px = |(i, deviation_m): (usize, f32)| {
        let at = Sample { column: i as u32 % dem.columns(), row: i as u32 / dem.columns() };
        view.pixels(deviation_m as f64, view.eye_world.distance(dem.world(at).into()))
    };
    oracle.deviations_m().enumerate().map(error_px).fold(0.0, f64::max)
}
