//! The camera in the user's hands: it flies, orbits, stays above the ground, and is written as one line of text.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;
use terrain_core::{Camera, FlightPath, Heightmap, Lens, View, ViewError};

/// Metres that the camera keeps above the ground; the near plane is half a metre away.
const CLEARANCE_M: f64 = 2.0;
/// Fields of view that the wheel can reach, in radians.
const FOV_Y: [f64; 2] = [0.05, 2.4];
/// Metres a second that the wheel can reach.
const SPEED_M_S: [f64; 2] = [0.5, 1e5];
/// A dragged pixel turns the camera by this many pixels of the picture.
const TURN: f64 = 1.0;

/// A camera with its lens and its manners.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    pub camera: Camera,
    /// Vertical field of view in radians.
    pub fov_y: f64,
    /// Metres a second of flight.
    pub speed_m_s: f64,
    /// Whether it stays above the ground.
    pub above_ground: bool,
    /// The point that it circles, in orbit mode.
    pub orbit: Option<DVec3>,
}

/// What the keys ask for, each from -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    pub forward: f64,
    pub right: f64,
    pub up: f64,
    /// Clockwise, and upwards.
    pub turn: [f64; 2],
    /// Whether it goes five times as fast.
    pub fast: bool,
}

impl Rig {
    /// From the south, over the whole DEM.
    pub fn over(heightmap: &Heightmap) -> Self {
        let [x_m, z_m] = heightmap.extent_m();
        let side_m = x_m.max(z_m);
        let (x, z) = (0.5 * x_m, 0.98 * z_m);
        let eye_world = DVec3::new(x, heightmap.ground_m(x, z) + 0.14 * side_m, z);
        let camera = Camera { eye_world, heading: 0.0, pitch: -0.32 };
        Self { camera, fov_y: 60_f64.to_radians(), speed_m_s: side_m / 20.0, above_ground: true, orbit: None }
    }

    pub fn view(&self, size_px: [u32; 2]) -> Result<View, ViewError> {
        View::new(&self.camera, &Lens { fov_y: self.fov_y, size_px, near_m: FlightPath::NEAR_M })
    }

    /// Where the camera looks: a unit vector.
    pub fn forward(&self) -> DVec3 {
        let Camera { heading, pitch, .. } = self.camera;
        DVec3::new(heading.sin() * pitch.cos(), pitch.sin(), -heading.cos() * pitch.cos())
    }

    fn right(&self) -> DVec3 {
        DVec3::new(self.camera.heading.cos(), 0.0, self.camera.heading.sin())
    }

    /// Moves by what the keys ask for in `dt_s` seconds.
    pub fn fly(&mut self, heightmap: &Heightmap, motion: &Motion, dt_s: f64) {
        let [turn_right, turn_up] = motion.turn.map(|share| share * 1.2 * dt_s);
        self.turn(turn_right, turn_up);
        let way = motion.forward * self.forward() + motion.right * self.right() + motion.up * DVec3::Y;
        let step_m = self.speed_m_s * if motion.fast { 5.0 } else { 1.0 } * dt_s;
        if way != DVec3::ZERO {
            self.camera.eye_world += way.clamp_length_max(1.0) * step_m;
            self.face_orbit();
        }
        self.keep_above(heightmap);
    }

    /// A drag over a picture of that height: the ground follows the pointer, or the camera circles its point.
    pub fn drag(&mut self, [x_px, y_px]: [f64; 2], height_px: f64) {
        let radians = |px: f64| TURN * px * self.fov_y / height_px;
        let (right, up) = (radians(-x_px), radians(y_px));
        match self.orbit {
            None => self.turn(right, up),
            Some(_) => self.turn(-4.0 * right, -4.0 * up),
        }
    }

    /// Turns clockwise and upwards by radians; in orbit mode around the point.
    fn turn(&mut self, right: f64, up: f64) {
        self.camera.heading = (self.camera.heading + right).rem_euclid(TAU);
        self.camera.pitch = (self.camera.pitch + up).clamp(-FRAC_PI_2, FRAC_PI_2);
        if let Some(centre) = self.orbit {
            let distance_m = centre.distance(self.camera.eye_world);
            self.camera.eye_world = centre - distance_m * self.forward();
        }
    }

    /// One notch of the wheel, up or down.
    pub fn change_speed(&mut self, notches: f64) {
        self.speed_m_s = (self.speed_m_s * 1.25_f64.powf(notches)).clamp(SPEED_M_S[0], SPEED_M_S[1]);
    }

    /// In orbit mode: nearer or farther.
    pub fn approach(&mut self, notches: f64) {
        if let Some(centre) = self.orbit {
            self.camera.eye_world = centre + (self.camera.eye_world - centre) * 0.85_f64.powf(notches);
        }
    }

    pub fn zoom(&mut self, notches: f64) {
        self.fov_y = (self.fov_y * 0.9_f64.powf(notches)).clamp(FOV_Y[0], FOV_Y[1]);
    }

    /// Circles the point in the middle of the picture, or flies freely again.
    pub fn toggle_orbit(&mut self, heightmap: &Heightmap) {
        self.orbit = match self.orbit {
            Some(_) => None,
            None => self.ground_along(heightmap, self.forward()),
        };
    }

    /// Flies to a point on the ground that a pixel shows: nine tenths of the way there.
    pub fn jump(&mut self, heightmap: &Heightmap, at_px: [f64; 2], size_px: [u32; 2]) {
        if let Some(point) = self.ground_along(heightmap, self.direction_of(at_px, size_px)) {
            self.camera.eye_world = self.camera.eye_world.lerp(point, 0.9);
            self.orbit = self.orbit.map(|_| point);
            self.face_orbit();
            self.keep_above(heightmap);
        }
    }

    /// The direction that a pixel shows.
    fn direction_of(&self, [x_px, y_px]: [f64; 2], size_px: [u32; 2]) -> DVec3 {
        let [width, height] = size_px.map(f64::from);
        let tan = (0.5 * self.fov_y).tan() / (0.5 * height);
        let (forward, right) = (self.forward(), self.right());
        let up = right.cross(forward);
        (forward + (x_px - 0.5 * width) * tan * right + (0.5 * height - y_px) * tan * up).normalize()
    }

    /// The first point of the ground along a ray from the eye, found in steps of less than a grid interval nearby.
    fn ground_along(&self, heightmap: &Heightmap, direction: DVec3) -> Option<DVec3> {
        let ([x_m, z_m], spacing_m) = (heightmap.extent_m(), heightmap.spacing_m());
        let at = |distance_m: f64| self.camera.eye_world + distance_m * direction;
        let is_below = |p: DVec3| {
            let inside = (0.0..=x_m).contains(&p.x) && (0.0..=z_m).contains(&p.z);
            inside && p.y < heightmap.ground_m(p.x, p.z)
        };
        let (mut near_m, mut far_m) = (0.0, 0.0);
        let limit_m = 4.0 * (x_m.hypot(z_m) + self.camera.eye_world.length());
        while !is_below(at(far_m)) {
            near_m = far_m;
            far_m += (0.5 * spacing_m[0].min(spacing_m[1])).max(2e-3 * far_m);
            if far_m > limit_m {
                return None;
            }
        }
        for _ in 0..40 {
            let middle_m = 0.5 * (near_m + far_m);
            *if is_below(at(middle_m)) { &mut far_m } else { &mut near_m } = middle_m;
        }
        Some(at(near_m))
    }

    fn face_orbit(&mut self) {
        if let Some(centre) = self.orbit {
            let to = centre - self.camera.eye_world;
            if to.length() > 1e-3 {
                self.camera.heading = to.x.atan2(-to.z).rem_euclid(TAU);
                self.camera.pitch = to.y.atan2(to.x.hypot(to.z));
            }
        }
    }

    fn keep_above(&mut self, heightmap: &Heightmap) {
        let eye = &mut self.camera.eye_world;
        if self.above_ground {
            eye.y = eye.y.max(heightmap.ground_m(eye.x, eye.z) + CLEARANCE_M);
        }
    }

    /// Camera and lens as text, which [`Rig::take_link`] takes: x, y, z in metres, heading, pitch, field of view in degrees.
    pub fn link(&self) -> String {
        let Camera { eye_world: DVec3 { x, y, z }, heading, pitch } = self.camera;
        let [heading, pitch, fov_y] = [heading, pitch, self.fov_y].map(f64::to_degrees);
        format!("{x:.3},{y:.3},{z:.3},{heading:.4},{pitch:.4},{fov_y:.4}")
    }

    pub fn take_link(&mut self, link: &str) -> Result<(), String> {
        let numbers: Option<Vec<f64>> = link.split(',').map(|number| number.trim().parse().ok()).collect();
        let Some([x, y, z, heading, pitch, fov_y]) = numbers.as_deref() else {
            return Err(format!("camera '{link}': expected X,Y,Z,HEADING,PITCH,FOV in metres and degrees"));
        };
        let camera =
            Camera { eye_world: DVec3::new(*x, *y, *z), heading: heading.to_radians(), pitch: pitch.to_radians() };
        let taken = Self { camera, fov_y: fov_y.to_radians(), orbit: None, ..self.clone() };
        taken.view([1, 1]).map_err(|error| format!("camera '{link}': {error}"))?;
        *self = taken;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane at 100 m, 1 km wide.
    fn plane() -> Heightmap {
        Heightmap::new(101, 101, [10.0; 2], vec![100.0; 101 * 101]).unwrap()
    }

    fn rig() -> Rig {
        Rig::over(&plane())
    }

    #[test]
    fn a_link_leads_back_to_the_same_camera() {
        let mut there = rig();
        there.drag([123.0, -45.0], 360.0);
        let mut back = Rig { fov_y: 1.0, ..rig() };
        back.take_link(&there.link()).unwrap();
        assert_eq!(back.link(), there.link());
        assert!(back.take_link("1,2,3").unwrap_err().contains("expected X,Y,Z"));
        assert!(back.take_link("1,2,3,0,0,200").unwrap_err().contains("field of view"));
        assert_eq!(back.link(), there.link(), "what is refused changes nothing");
    }

    #[test]
    fn the_camera_flies_where_its_view_looks() {
        let mut rig = rig();
        (rig.camera.heading, rig.camera.pitch) = (0.7, -0.2);
        let view = rig.view([640, 360]).unwrap();
        let ahead = view.clip_from_world * (rig.camera.eye_world + rig.forward()).extend(1.0);
        assert!((ahead.x.abs() + ahead.y.abs()) < 1e-9 && ahead.w > 0.0, "{ahead}");
        let right = view.clip_from_world * (rig.camera.eye_world + rig.forward() + rig.right()).extend(1.0);
        assert!(right.x > 0.1 && right.y.abs() < 1e-9, "{right}");
    }

    #[test]
    fn a_pixel_shows_the_point_that_a_double_click_jumps_to() {
        let (dem, mut rig) = (plane(), rig());
        let (size, pixel) = ([640, 360], [410.0, 300.0]);
        let point = rig.ground_along(&dem, rig.direction_of(pixel, size)).unwrap();
        let clip = rig.view(size).unwrap().clip_from_world * point.extend(1.0);
        let seen = [(clip.x / clip.w + 1.0) * 320.0, (1.0 - clip.y / clip.w) * 180.0];
        assert!((point.y - 100.0).abs() < 1e-3 && (seen[0] - 410.0).abs() < 1e-3 && (seen[1] - 300.0).abs() < 1e-3);
        let before_m = rig.camera.eye_world.distance(point);
        rig.jump(&dem, pixel, size);
        assert!((rig.camera.eye_world.distance(point) / before_m - 0.1).abs() < 0.02);
        rig.camera.pitch = 0.5;
        assert_eq!(rig.ground_along(&dem, rig.forward()), None, "the sky");
    }

    #[test]
    fn it_stays_above_the_ground_until_it_is_told_otherwise() {
        let (dem, mut rig) = (plane(), rig());
        let down = Motion { up: -1.0, fast: true, ..Default::default() };
        rig.fly(&dem, &down, 100.0);
        assert_eq!(rig.camera.eye_world.y, 100.0 + CLEARANCE_M);
        rig.above_ground = false;
        rig.fly(&dem, &down, 100.0);
        assert!(rig.camera.eye_world.y < 100.0);
    }

    #[test]
    fn an_orbit_keeps_its_distance_and_faces_its_point() {
        let (dem, mut rig) = (plane(), rig());
        rig.toggle_orbit(&dem);
        let centre = rig.orbit.unwrap();
        let distance_m = centre.distance(rig.camera.eye_world);
        rig.drag([30.0, -5.0], 360.0);
        assert!((centre.distance(rig.camera.eye_world) - distance_m).abs() < 1e-6);
        assert!((rig.camera.eye_world + distance_m * rig.forward()).distance(centre) < 1e-6);
        rig.approach(1.0);
        assert!(centre.distance(rig.camera.eye_world) < 0.9 * distance_m);
    }
}
