//! A flight laid over a DEM: one camera a frame.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::key::{Direction, Key, Position};
use super::{Flight, FlightError, MAX_FRAMES, spline};
use crate::source::LineColumn;
use crate::{Camera, Heightmap, Lens, View, ViewError};

/// Rounding in the spline must not refuse a flight along the DEM's rim.
const ROUNDING_M: f64 = 1e-6;

/// Every frame's camera, resolved and checked before the first is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct FlightPath {
    cameras: Vec<Camera>,
    fov_y: f64,
    step_s: f64,
}

impl FlightPath {
    /// Distance of the near plane in metres. With reversed depth a small one costs no precision far away; half a metre
    /// lets the camera pass close above the ground.
    pub const NEAR_M: f64 = 0.5;

    /// Lays `flight` over a DEM in `frames` frames, evenly spaced in time from its first key to its last (a single
    /// frame stands at the first). [`Flight::default_frames`] keeps the flight's own time step.
    ///
    /// Refuses a camera outside of the DEM or below its ground in any frame, unless the flight allows it.
    pub fn new(flight: &Flight, heightmap: &Heightmap, frames: u32) -> Result<Self, FlightError> {
        if !(1..=MAX_FRAMES).contains(&frames) {
            let reason = format!("{frames} frames; expected 1 to {MAX_FRAMES}");
            return Err(flight.error_at(LineColumn { line: 1, column: 1 }, reason));
        }
        let track = Track::new(flight, heightmap);
        let cameras = (0..frames).map(|frame| track.camera(Moment::of(flight, frame, frames)));
        let step_s = flight.duration_s() / (frames - 1).max(1) as f64;
        Ok(Self { cameras: cameras.collect::<Result<_, _>>()?, fov_y: flight.fov_y, step_s })
    }

    /// Number of frames, at least 1.
    pub fn len(&self) -> u32 {
        self.cameras.len() as u32
    }

    /// Never: a path has at least one frame.
    pub fn is_empty(&self) -> bool {
        self.cameras.is_empty()
    }

    /// The camera at a frame, which must be less than [`Self::len`].
    pub fn camera(&self, frame: u32) -> Camera {
        self.cameras[frame as usize]
    }

    /// Vertical field of view in radians.
    pub fn fov_y(&self) -> f64 {
        self.fov_y
    }

    /// Seconds of the flight from one frame to the next, above 0; the whole flight where it has one frame.
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// The view at a frame for a picture of that width and height in pixels; refuses an empty picture.
    pub fn view(&self, frame: u32, size_px: [u32; 2]) -> Result<View, ViewError> {
        View::new(&self.camera(frame), &Lens { fov_y: self.fov_y, size_px, near_m: Self::NEAR_M })
    }
}

/// A frame's place on the flight's time line.
#[derive(Clone, Copy)]
struct Moment {
    frame: u32,
    time_s: f64,
    /// Index of the key before it, which is never the last.
    segment: usize,
    /// Share of the segment's time that has passed, 0 to 1.
    u: f64,
}

impl Moment {
    fn of(flight: &Flight, frame: u32, frames: u32) -> Self {
        let keys = &flight.keys;
        let share = frame as f64 / (frames - 1).max(1) as f64;
        let time_s = keys[0].time_s + share * flight.duration_s();
        let segment = keys.partition_point(|key| key.time_s <= time_s).clamp(1, keys.len() - 1) - 1;
        let (start_s, end_s) = (keys[segment].time_s, keys[segment + 1].time_s);
        Self { frame, time_s, segment, u: ((time_s - start_s) / (end_s - start_s)).clamp(0.0, 1.0) }
    }
}

/// The flight's two curves over one DEM.
struct Track<'a> {
    flight: &'a Flight,
    heightmap: &'a Heightmap,
    positions: Vec<DVec3>,
    directions: Vec<DVec3>,
}

impl<'a> Track<'a> {
    fn new(flight: &'a Flight, heightmap: &'a Heightmap) -> Self {
        let keys = || flight.keys.iter();
        Self {
            flight,
            heightmap,
            positions: keys().map(|key| key.position.control_point(heightmap)).collect(),
            directions: keys().map(|key| key.direction.control_point(heightmap)).collect(),
        }
    }

    fn camera(&self, moment: Moment) -> Result<Camera, FlightError> {
        let eye_world = self.eye_world(moment);
        self.check_eye(eye_world, moment)?;
        let point = spline::point(&self.directions, moment.segment, moment.u);
        let [heading, pitch] = match self.key(moment).direction {
            // The spline can leave the range of its keys a little.
            Direction::Angles { .. } => [point.x, point.y.clamp(-FRAC_PI_2, FRAC_PI_2)],
            Direction::LookAtWorld(_) => self.look(eye_world, point, moment)?,
            Direction::LookAtGround(..) => self.look(eye_world, self.above_ground(point), moment)?,
        };
        Ok(Camera { eye_world, heading, pitch })
    }

    fn eye_world(&self, moment: Moment) -> DVec3 {
        let point = spline::point(&self.positions, moment.segment, moment.u);
        match self.key(moment).position {
            Position::World(_) => point,
            Position::OverGround(..) => self.above_ground(point),
        }
    }

    /// The key before a moment.
    fn key(&self, moment: Moment) -> &Key {
        &self.flight.keys[moment.segment]
    }

    /// Adds the ground's height to a point whose y is a height above ground.
    fn above_ground(&self, point: DVec3) -> DVec3 {
        point.with_y(self.heightmap.ground_m(point.x, point.z) + point.y)
    }

    /// Heading and pitch from `eye_world` to `target_world`. Straight up and down keep north at the picture's top.
    fn look(&self, eye_world: DVec3, target_world: DVec3, moment: Moment) -> Result<[f64; 2], FlightError> {
        let (east, north) = (target_world.x - eye_world.x, eye_world.z - target_world.z);
        let up = target_world.y - eye_world.y;
        if (east, north, up) == (0.0, 0.0, 0.0) {
            let reason = "the camera stands on the point that it looks at; expected two different points";
            return Err(self.refuse(moment, reason.to_owned()));
        }
        Ok([libm::atan2(east, north), libm::atan2(up, libm::hypot(east, north))])
    }

    fn check_eye(&self, eye_world: DVec3, moment: Moment) -> Result<(), FlightError> {
        let refuse = |reason| Err(self.refuse(moment, reason));
        let DVec3 { x, y, z } = eye_world;
        if !eye_world.is_finite() {
            return refuse(format!("the camera is at ({x}, {y}, {z}); expected finite numbers"));
        }
        let outside_m = self.outside_m(eye_world);
        if outside_m > ROUNDING_M {
            let [x_m, z_m] = self.heightmap.extent_m();
            let place = format!("the camera is {outside_m:.1} m outside of the DEM, at x = {x:.1} m, z = {z:.1} m");
            let expected = format!("expected 0 to {x_m:.1} and 0 to {z_m:.1}, or allow_outside = true");
            return if self.flight.allow_outside { Ok(()) } else { refuse(format!("{place}; {expected}")) };
        }
        let below_m = self.heightmap.ground_m(x, z) - y;
        if below_m > ROUNDING_M && !self.flight.allow_below_ground {
            let expected = "expected a higher camera, or allow_below_ground = true";
            return refuse(format!("the camera is {below_m:.1} m below ground; {expected}"));
        }
        Ok(())
    }

    /// Distance to the DEM's outline, seen from above; 0 inside.
    fn outside_m(&self, point: DVec3) -> f64 {
        let [x_m, z_m] = self.heightmap.extent_m();
        (point.x - point.x.clamp(0.0, x_m)).hypot(point.z - point.z.clamp(0.0, z_m))
    }

    fn refuse(&self, moment: Moment, reason: String) -> FlightError {
        let Moment { frame, time_s, .. } = moment;
        self.flight.error_at(
            self.key(moment).written_at,
            format!("after this key, in frame {frame} ({time_s:.2} s), {reason}"),
        )
    }
}
