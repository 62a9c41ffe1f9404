//! A seeded camera that goes everywhere a user would, and where no user would: for the contract and for tests.

use glam::DVec3;

use crate::{Camera, Heightmap, Lens, SplitMix64, View};

/// An endless, seeded walk: glides, turns, stands still, dives and teleports over (and a little beyond) a DEM.
pub struct RandomWalk<'a> {
    heightmap: &'a Heightmap,
    random: SplitMix64,
    camera: Camera,
    /// Metres in x and z, radians of heading and pitch, a frame.
    velocity: [f64; 4],
    clearance_m: f64,
}

impl<'a> RandomWalk<'a> {
    /// Picture and field of view of all views of the walk.
    pub const LENS: Lens = Lens { fov_y: std::f64::consts::FRAC_PI_3, size_px: [640, 360], near_m: 0.5 };

    /// The same seed and DEM give the same walk.
    pub fn new(seed: u64, heightmap: &'a Heightmap) -> Self {
        let camera = Camera { eye_world: DVec3::ZERO, heading: 0.0, pitch: 0.0 };
        let random = SplitMix64::new(seed);
        let mut walk = Self { heightmap, random, camera, velocity: [0.0; 4], clearance_m: 1.0 };
        walk.teleport();
        walk
    }

    fn teleport(&mut self) {
        let [width_m, depth_m] = self.heightmap.extent_m();
        let side_m = width_m.max(depth_m);
        self.camera.eye_world.x = self.random.range(-0.1, 1.1) * width_m;
        self.camera.eye_world.z = self.random.range(-0.1, 1.1) * depth_m;
        self.camera.heading = self.random.range(-4.0, 4.0);
        self.camera.pitch = self.random.range(-1.0, 1.0).powi(3) * std::f64::consts::FRAC_PI_2;
        // From a metre above the ground (or in it) up to the DEM's side, on a scale of powers.
        self.clearance_m = side_m * self.random.range(0.0, 1.0).powi(4) - 1.0;
        self.steer();
    }

    fn steer(&mut self) {
        let [width_m, depth_m] = self.heightmap.extent_m();
        let step = 0.02 * self.random.range(0.0, 1.0).powi(2);
        self.velocity = [
            self.random.range(-step, step) * width_m,
            self.random.range(-step, step) * depth_m,
            self.random.range(-0.1, 0.1),
            self.random.range(-0.02, 0.02),
        ];
    }
}

impl Iterator for RandomWalk<'_> {
    type Item = View;

    fn next(&mut self) -> Option<View> {
        match self.random.below(100) {
            0..5 => self.teleport(),
            5..15 => self.steer(),
            15..20 => self.velocity = [0.0; 4],
            _ => {}
        }
        let [x, z, heading, pitch] = self.velocity;
        self.camera.eye_world += DVec3::new(x, 0.0, z);
        let DVec3 { x, z, .. } = self.camera.eye_world;
        self.camera.eye_world.y = self.heightmap.ground_m(x, z) + self.clearance_m;
        self.camera.heading += heading;
        self.camera.pitch = (self.camera.pitch + pitch).clamp(-1.57, 1.57);
        Some(View::new(&self.camera, &Self::LENS).expect("a walk stays finite"))
    }
}
