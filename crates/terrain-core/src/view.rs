//! The camera at one frame, and the one place where metres become pixels.

mod frustum;

use frustum::frustum;
use glam::{DMat4, DQuat, DVec3, DVec4};

pub use frustum::Planes;

/// A box along the world's axes, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest x, y, z.
    pub min: [f64; 3],
    /// Largest x, y, z.
    pub max: [f64; 3],
}

/// Position and direction of the camera. Angles are in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World position in metres.
    pub eye_world: DVec3,
    /// Clockwise from north (-z): 0 looks north, a quarter turn looks east (+x).
    pub heading: f64,
    /// Above the horizon; -pi/2 looks straight down.
    pub pitch: f64,
}

/// The projection: picture size and field of view. The near plane is the only depth limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Vertical field of view in radians, between 0 and pi (exclusive).
    pub fov_y: f64,
    /// Picture width and height in pixels, each at least 1.
    pub size_px: [u32; 2],
    /// Distance of the near plane in metres. There is no far plane.
    pub near_m: f64,
}

/// A camera that cannot be used: some number of it is not finite or out of range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("unusable camera: {0}")]
pub struct ViewError(String);

/// Everything that a method may know of the camera: where it is, what it sees, and how large a metre is there.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Position of the eye in metres.
    pub eye_world: DVec3,
    /// World to clip space: right-handed, reversed depth (1 at the near plane, 0 at infinity).
    pub clip_from_world: DMat4,
    /// The same without the translation, for positions relative to the eye: exact on the GPU in f32.
    pub clip_from_eye: DMat4,
    /// Vertical field of view in radians.
    pub fov_y: f64,
    /// Picture width and height in pixels.
    pub size_px: [u32; 2],
    /// Pixels for an error of one metre at a distance of one metre.
    pixels_per_radian: f64,
    /// Left, right, bottom, top, near: a point p is inside where `plane.xyz . p + plane.w >= 0` for all five.
    frustum_world: [DVec4; 5],
}

/// The way back from a picture to the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Unprojection {
    eye_world: DVec3,
    eye_from_clip: DMat4,
    size_px: [f64; 2],
    near_m: f64,
}

impl Unprojection {
    /// The world point at a place of the picture, in pixels from its upper left corner, whose reversed depth is `depth`:
    /// above 0, and 1 on the near plane.
    pub fn point(&self, at_px: [f64; 2], depth: f64) -> DVec3 {
        let distance_m = self.near_m / depth; // along the view's axis: w in clip space
        let x = (2.0 * at_px[0] / self.size_px[0] - 1.0) * distance_m;
        let y = (1.0 - 2.0 * at_px[1] / self.size_px[1]) * distance_m;
        self.eye_world + (self.eye_from_clip * DVec4::new(x, y, self.near_m, distance_m)).truncate()
    }
}

impl View {
    /// The view of `camera` through `lens`; refuses numbers that are not finite or out of range.
    pub fn new(camera: &Camera, lens: &Lens) -> Result<Self, ViewError> {
        check(camera, lens)?;
        let DVec3 { x, y, z } = camera.eye_world;
        // Looking along -z is north. Heading turns clockwise seen from above, pitch lifts the nose.
        let world_from_eye = DQuat::from_rotation_y(-camera.heading) * DQuat::from_rotation_x(camera.pitch);
        let eye_from_direction = DMat4::from_quat(world_from_eye.conjugate());
        let clip_from_eye = clip_from_view(lens) * eye_from_direction;
        let clip_from_world = clip_from_eye * DMat4::from_translation(-DVec3::new(x, y, z));
        Ok(Self {
            eye_world: camera.eye_world,
            clip_from_world,
            clip_from_eye,
            fov_y: lens.fov_y,
            size_px: lens.size_px,
            pixels_per_radian: lens.size_px[1] as f64 / (2.0 * libm::tan(0.5 * lens.fov_y)),
            frustum_world: frustum(&clip_from_eye, camera.eye_world),
        })
    }

    /// **The** projection formula: how many pixels `error_m` metres at `distance_m` from the eye cover in the middle of
    /// the picture, seen from the side. Towards its rim they can cover more.
    ///
    /// `error_m * viewport height / (2 tan(fov_y / 2) * distance)`; it does not change when the camera turns.
    pub fn pixels(&self, error_m: f64, distance_m: f64) -> f64 {
        error_m * self.pixels_per_radian / distance_m
    }

    /// The inverse of [`View::pixels`]: the largest error in metres that stays within `error_px` at that distance.
    pub fn metres(&self, error_px: f64, distance_m: f64) -> f64 {
        error_px * distance_m / self.pixels_per_radian
    }

    /// Pixels on the screen between a point and the one `up_m` metres above it: exact where [`View::pixels`] is the usual
    /// estimate.
    ///
    /// Only what is in front of the near plane is on the screen. Where one of the points is behind it, the way counts
    /// from where the vertical between them crosses it; where both are, there is nothing to see and the answer is 0.
    #[inline] // called for every sample in view, of every frame
    pub fn displacement_px(&self, point_world: DVec3, up_m: f64) -> f64 {
        let near_m = self.clip_from_eye.w_axis.z; // reversed depth: z of every point in clip space
        let mut from = self.clip_from_eye * (point_world - self.eye_world).extend(1.0);
        let mut way = up_m * self.clip_from_eye.y_axis;
        let share_to_near = |from: DVec4| (near_m - from.w) / way.w;
        match (from.w < near_m, from.w + way.w < near_m) {
            (false, false) => {}
            (true, true) => return 0.0,
            (false, true) => way *= share_to_near(from),
            (true, false) => {
                let share = share_to_near(from);
                (from, way) = (from + share * way, (1.0 - share) * way);
            }
        }
        // (from + way) / w - from / w, without the difference of two nearly equal numbers.
        let over = 1.0 / (from.w * (from.w + way.w));
        let [x, y] = [way.x * from.w - from.x * way.w, way.y * from.w - from.y * way.w].map(|clip| clip * over);
        let [width, height] = self.size_px.map(f64::from);
        0.5 * ((x * width).powi(2) + (y * height).powi(2)).sqrt()
    }

    /// What turns depths of this view into points of the world.
    pub fn unprojection(&self) -> Unprojection {
        Unprojection {
            eye_world: self.eye_world,
            eye_from_clip: self.clip_from_eye.inverse(),
            size_px: self.size_px.map(f64::from),
            near_m: self.clip_from_eye.w_axis.z,
        }
    }

    /// Distance in metres from the eye to the nearest point of a box; 0 inside it.
    #[inline]
    pub fn distance_m(&self, bounds: &Aabb) -> f64 {
        let nearest = self.eye_world.clamp(DVec3::from(bounds.min), DVec3::from(bounds.max));
        nearest.distance(self.eye_world)
    }
}

fn check(camera: &Camera, lens: &Lens) -> Result<(), ViewError> {
    let fail = |what: String| Err(ViewError(what));
    if !camera.eye_world.is_finite() || !camera.heading.is_finite() || !camera.pitch.is_finite() {
        return fail(format!("{camera:?} is not finite"));
    }
    if !(lens.fov_y > 0.0 && lens.fov_y < std::f64::consts::PI) {
        return fail(format!(
            "field of view {} degrees: expected more than 0 and less than 180",
            lens.fov_y.to_degrees()
        ));
    }
    if lens.size_px.contains(&0) {
        return fail(format!("picture of {} x {} pixels", lens.size_px[0], lens.size_px[1]));
    }
    if !(lens.near_m > 0.0 && lens.near_m.is_finite()) {
        return fail(format!("near plane at {} m", lens.near_m));
    }
    Ok(())
}

/// Reversed depth with the far plane at infinity: with a float depth buffer the precision is nearly even over all
/// distances, so neither a ridge at 100 km nor a stone at 1 m needs a tuned range.
fn clip_from_view(lens: &Lens) -> DMat4 {
    let focal = 1.0 / libm::tan(0.5 * lens.fov_y);
    let aspect = lens.size_px[0] as f64 / lens.size_px[1] as f64;
    DMat4::from_cols(
        DVec4::new(focal / aspect, 0.0, 0.0, 0.0),
        DVec4::new(0.0, focal, 0.0, 0.0),
        DVec4::new(0.0, 0.0, 0.0, -1.0),
        DVec4::new(0.0, 0.0, lens.near_m, 0.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    pub(super) fn view(heading_deg: f64, pitch_deg: f64) -> View {
        let camera = Camera {
            eye_world: DVec3::new(100.0, 50.0, 200.0),
            heading: heading_deg.to_radians(),
            pitch: pitch_deg.to_radians(),
        };
        View::new(&camera, &Lens { fov_y: FRAC_PI_2, size_px: [200, 100], near_m: 1.0 }).unwrap()
    }

    #[test]
    fn a_point_comes_back_from_its_place_in_the_picture() {
        for (heading_deg, pitch_deg) in [(0.0, 0.0), (77.0, -20.0), (200.0, 65.0)] {
            let view = view(heading_deg, pitch_deg);
            let way_back = view.unprojection();
            for ahead in [[0.1, -0.2, 1.0], [-0.4, 0.3, 40.0], [0.0, 0.0, 90_000.0]] {
                // In the camera's axes: shares of the distance to the right and upwards, and metres ahead.
                let [x, y, metres] = ahead;
                let axes =
                    DQuat::from_rotation_y(-heading_deg.to_radians()) * DQuat::from_rotation_x(pitch_deg.to_radians());
                let point = view.eye_world + axes * DVec3::new(x * metres, y * metres, -metres);
                let clip = view.clip_from_world * point.extend(1.0);
                let at_px = [100.0 * (1.0 + clip.x / clip.w), 50.0 * (1.0 - clip.y / clip.w)];
                let found = way_back.point(at_px, clip.z / clip.w);
                assert!(found.distance(point) < 1e-9 * metres.max(1.0), "{found} for {point}");
            }
        }
    }

    fn ndc(view: &View, offset: [f64; 3]) -> DVec3 {
        let clip = view.clip_from_world * (view.eye_world + DVec3::from(offset)).extend(1.0);
        clip.truncate() / clip.w
    }

    #[test]
    fn heading_is_clockwise_from_north_and_pitch_lifts() {
        let centre = |v: &View, offset| ndc(v, offset).truncate().length() < 1e-12;
        assert!(centre(&view(0.0, 0.0), [0.0, 0.0, -10.0]), "north");
        assert!(centre(&view(90.0, 0.0), [10.0, 0.0, 0.0]), "east");
        assert!(centre(&view(180.0, 0.0), [0.0, 0.0, 10.0]), "south");
        assert!(centre(&view(90.0, -45.0), [10.0, -10.0, 0.0]), "east, down");
        // Looking north, east is to the right and up is up.
        assert!(ndc(&view(0.0, 0.0), [5.0, 0.0, -10.0]).x > 0.0);
        assert!(ndc(&view(0.0, 0.0), [0.0, 5.0, -10.0]).y > 0.0);
    }

    #[test]
    fn depth_is_one_at_the_near_plane_and_falls_to_zero() {
        let v = view(30.0, -10.0);
        let forward = v.clip_from_eye.transpose().w_axis.truncate();
        let depth = |metres: f64| ndc(&v, (forward * metres).into()).z;
        assert!((depth(1.0) - 1.0).abs() < 1e-12);
        assert!(depth(1e7) > 0.0 && depth(1e7) < 1e-6);
    }

    #[test]
    fn pixels_of_a_vertical_metre_in_the_middle_of_the_picture() {
        let v = view(0.0, 0.0);
        // fov_y of 90 degrees on 100 px: at 50 m, the half height of 50 m covers 50 px.
        assert!((v.pixels(50.0, 50.0) - 50.0).abs() < 1e-12);
        assert!((v.metres(v.pixels(3.0, 70.0), 70.0) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn displacements_of_known_points() {
        // fov_y of 90 degrees on 200 x 100 px: at a depth of 50 m, a metre is a pixel.
        let v = view(0.0, 0.0);
        let px = |v: &View, offset: [f64; 3], up_m: f64| v.displacement_px(v.eye_world + DVec3::from(offset), up_m);
        let is = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
        is(px(&v, [0.0, 0.0, -50.0], 1.0), 1.0);
        is(px(&v, [0.0, 0.0, -50.0], -4.0), 4.0);
        is(px(&v, [0.0, 7.0, -25.0], 0.0), 0.0);
        // At the rim the distance is longer than the depth, and the usual formula says less.
        let rim = [100.0, 50.0, -50.0];
        is(px(&v, rim, 1.0), 1.0);
        assert!(v.pixels(1.0, DVec3::from(rim).length()) < 0.41);
        // Seen from above, a vertical way leads away from the middle of the picture, where it is no way at all.
        let down = view(0.0, -90.0);
        is(px(&down, [0.0, -50.0, 0.0], 1.0), 0.0);
        is(px(&down, [20.0, -50.0, 0.0], 10.0), 50.0 * (20.0 / 40.0 - 20.0 / 50.0));
    }

    #[test]
    fn a_displacement_is_that_of_the_projected_points() {
        let mut random = crate::SplitMix64::new(3);
        for _ in 0..1_000 {
            let v = view(random.range(0.0, 360.0), random.range(-90.0, 90.0));
            let forward = v.clip_from_eye.transpose().w_axis.truncate();
            let offset = 60.0 * forward + DVec3::from([(); 3].map(|_| random.range(-30.0, 30.0)));
            let up_m = random.range(-5.0, 5.0);
            let [a, b] = [offset, offset + up_m * DVec3::Y].map(|at| ndc(&v, at.into()) * DVec3::new(100.0, 50.0, 0.0));
            let found = v.displacement_px(v.eye_world + offset, up_m);
            assert!((found - a.distance(b)).abs() < 1e-9, "{found} for {}", a.distance(b));
        }
    }

    #[test]
    fn a_displacement_ends_at_the_near_plane() {
        // Looking down at 45 degrees, the near plane is 1 m away, where a metre is 50 pixels.
        let v = view(0.0, -45.0);
        let px = |offset: [f64; 3], up_m: f64| v.displacement_px(v.eye_world + DVec3::from(offset), up_m);
        // 2 m to the north, the near plane is at a height of 2 - sqrt(2) m.
        let (low_m, plane_m) = (-2.0, 2.0 - 2.0_f64.sqrt());
        let expected = px([0.0, low_m, -2.0], plane_m - low_m);
        assert!(expected > 10.0);
        assert!((px([0.0, low_m, -2.0], 100.0) - expected).abs() < 1e-9, "from the front to behind");
        assert!((px([0.0, low_m + 100.0, -2.0], -100.0) - expected).abs() < 1e-9, "from behind to the front");
        assert_eq!(px([0.0, 3.0, -2.0], 1.0), 0.0, "both behind");
    }

    #[test]
    fn unusable_cameras_are_refused() {
        let lens = Lens { fov_y: 1.0, size_px: [1, 1], near_m: 1.0 };
        let camera = Camera { eye_world: DVec3::ZERO, heading: 0.0, pitch: 0.0 };
        assert!(View::new(&Camera { heading: f64::NAN, ..camera }, &lens).is_err());
        assert!(View::new(&Camera { eye_world: DVec3::INFINITY, ..camera }, &lens).is_err());
        assert!(View::new(&camera, &Lens { fov_y: 3.2, ..lens }).is_err());
        assert!(View::new(&camera, &Lens { size_px: [0, 1], ..lens }).is_err());
        assert!(View::new(&camera, &Lens { near_m: 0.0, ..lens }).is_err());
    }
}
