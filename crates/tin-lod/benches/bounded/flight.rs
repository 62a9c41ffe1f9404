//! The time of `plan()` with a camera that flies and one that is set down somewhere else.

use std::sync::Arc;

use terrain_core::{Camera, FramePlan, Heightmap, Lens, LodMethod, View};
use tin_lod::{Options, Tin};

const FRAMES: u32 = 3_000;

/// Setting by setting in turn, so that a busy machine is busy for all.
pub fn compare(dem: &Arc<Heightmap>, settings: &[(&str, Options)]) {
    for speed_m_s in [100.0, 1000.0] {
        for culling in [true, false] {
            println!("flight at {speed_m_s} m/s, 60 Hz, {FRAMES} frames, culling {culling}: CPU us of plan()");
            let mut flights: Vec<Flight> =
                settings.iter().map(|(_, options)| Flight::new(dem, *options, culling)).collect();
            for frame in 0..FRAMES {
                let view = view(dem, frame as f64 / 60.0 * speed_m_s);
                flights.iter_mut().for_each(|flight| flight.plan(&view));
            }
            for ((name, _), flight) in settings.iter().zip(&mut flights) {
                flight.report(name);
            }
        }
    }
}

struct Flight {
    tin: Tin,
    plan: FramePlan,
    cpu_us: Vec<f64>,
    triangles: u64,
    draws: usize,
    nodes: u64,
}

impl Flight {
    fn new(dem: &Arc<Heightmap>, options: Options, culling: bool) -> Self {
        let mut tin = Tin::new(dem.clone(), options).unwrap();
        tin.set_culling(culling);
        Self { tin, plan: FramePlan::default(), cpu_us: Vec::new(), triangles: 0, draws: 0, nodes: 0 }
    }

    fn plan(&mut self, view: &View) {
        let start_ms = super::cpu_ms();
        self.tin.plan(view, &mut self.plan);
        self.cpu_us.push(1e3 * (super::cpu_ms() - start_ms));
        self.draws += self.plan.draws.len();
        self.triangles += self.plan.draws.iter().map(|draw| draw.triangles()).sum::<u64>();
        self.nodes += self.plan.work.iter().map(|work| work.patches as u64).sum::<u64>();
    }

    /// The first two frames upload the DEM and all of the first view.
    fn report(&mut self, name: &str) {
        let first_us = self.cpu_us[0] + self.cpu_us[1];
        let frames = &mut self.cpu_us[2..];
        frames.sort_by(f64::total_cmp);
        let at = |share: f64| frames[((frames.len() - 1) as f64 * share) as usize];
        let mean = |sum: f64| sum / FRAMES as f64;
        println!(
            "  {name:28} P50 {:4.0}, P99 {:4.0}, max {:5.0}; first {first_us:.0}; {:.0} triangles, {:.0} draws, {:.2} \
             patches made a frame",
            at(0.5),
            at(0.99),
            at(1.0),
            mean(self.triangles as f64),
            mean(self.draws as f64),
            mean(self.nodes as f64),
        );
    }
}

/// 100 m above the ground, east by south and a little to the south, from a tenth of the width on.
fn view(dem: &Heightmap, flown_m: f64) -> View {
    let [width_m, depth_m] = dem.extent_m();
    let [x, z] = [(0.1 * width_m + flown_m * 0.96) % width_m, (0.4 * depth_m + flown_m * 0.28) % depth_m];
    let camera = Camera { eye_world: [x, dem.ground_m(x, z) + 100.0, z].into(), heading: 1.85, pitch: -0.1 };
    View::new(&camera, &Lens { fov_y: 60f64.to_radians(), size_px: [1280, 720], near_m: 1.0 }).unwrap()
}

/// The whole DEM anew, without culling: from the middle to a corner and back.
pub fn teleport(dem: &Arc<Heightmap>, settings: &[(&str, Options)]) {
    println!("teleport between two ends of the DEM, no culling: CPU ms of plan(), median of {}", super::FRAMES);
    let mut flights: Vec<Flight> = settings.iter().map(|(_, options)| Flight::new(dem, *options, false)).collect();
    for frame in 0..super::FRAMES {
        let view = view(dem, if frame % 2 == 0 { 0.0 } else { 0.8 * dem.extent_m()[0] });
        flights.iter_mut().for_each(|flight| flight.plan(&view));
    }
    for ((name, _), flight) in settings.iter().zip(&mut flights) {
        let frames = &mut flight.cpu_us[2..];
        frames.sort_by(f64::total_cmp);
        println!("  {name:28} {:.2}", 1e-3 * frames[frames.len() / 2]);
    }
}
