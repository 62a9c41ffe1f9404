//! What of the world may be in the picture.

use super::{Aabb, View};
use glam::{DMat4, DVec3, DVec4};

/// Some of the five planes of a frustum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Planes(u8);

impl Planes {
    /// Nothing is cut.
    pub const NONE: Self = Self(0);
    /// The sides and the near plane.
    pub const ALL: Self = Self(0b1_1111);
}

impl View {
    /// Whether a world point is inside the frustum (its planes included).
    pub fn sees_point(&self, point_world: DVec3) -> bool {
        self.frustum_world.iter().all(|plane| is_inside(plane, point_world))
    }

    /// Whether some of a segment is deeper inside the frustum than `slack_m`, the metres that rounding may cost.
    pub fn sees_segment(&self, a_world: DVec3, b_world: DVec3, slack_m: f64) -> bool {
        // The part of the segment that is inside, from 0 at a to 1 at b.
        let (mut start, mut end) = (0.0_f64, 1.0_f64);
        for plane in &self.frustum_world {
            let [a, b] = [a_world, b_world].map(|point| plane.truncate().dot(point) + plane.w - slack_m);
            match (a < 0.0, b < 0.0) {
                (true, true) => return false,
                (true, false) => start = start.max(a / (a - b)),
                (false, true) => end = end.min(a / (a - b)),
                (false, false) => {}
            }
        }
        start < end
    }

    /// Whether a box may be in sight: `false` only where it lies wholly behind one plane of the frustum.
    pub fn sees(&self, bounds: &Aabb) -> bool {
        self.planes_across(bounds, Planes::ALL).is_some()
    }

    /// Whether all points of a box are inside the frustum, and so whatever the box holds.
    pub fn sees_whole(&self, bounds: &Aabb) -> bool {
        self.planes_across(bounds, Planes::ALL) == Some(Planes::NONE)
    }

    /// Those of some planes that cut a box; none of all where it lies wholly behind one of them. A plane that does not cut
    /// a box cuts none inside of it, so that a tree of boxes is culled by ever fewer planes (plane masking, Bishop et al.
    /// 1998), with the same answers to the last bit: rounding keeps the order of what is added here.
    #[inline]
    pub fn planes_across(&self, bounds: &Aabb, planes: Planes) -> Option<Planes> {
        let mut across = 0;
        for (i, plane) in self.frustum_world.iter().enumerate().filter(|(i, _)| planes.0 >> i & 1 != 0) {
            // Of the corners, the one deepest inside, and the one farthest outside.
            let (mut deepest, mut farthest) = (0.0, 0.0);
            for (axis, normal) in plane.truncate().to_array().into_iter().enumerate() {
                let [low, high] = [normal * bounds.min[axis], normal * bounds.max[axis]];
                let (low, high) = if high < low { (high, low) } else { (low, high) };
                (deepest, farthest) = (deepest + high, farthest + low);
            }
            if deepest + plane.w < 0.0 {
                return None;
            }
            across |= u8::from(farthest + plane.w < 0.0) << i;
        }
        Some(Planes(across))
    }
}

fn is_inside(plane: &DVec4, point_world: DVec3) -> bool {
    plane.truncate().dot(point_world) + plane.w >= 0.0
}

/// The planes -w <= x <= w, -w <= y <= w, z <= w, taken relative to the eye first: no cancellation far from the origin.
pub(super) fn frustum(clip_from_eye: &DMat4, eye_world: DVec3) -> [DVec4; 5] {
    let rows = clip_from_eye.transpose();
    let (x, y, z, w) = (rows.x_axis, rows.y_axis, rows.z_axis, rows.w_axis);
    [w + x, w - x, w + y, w - y, w - z].map(|plane| {
        let normal = plane.truncate();
        let length = normal.length();
        (normal / length).extend(plane.w / length - (normal / length).dot(eye_world))
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::view;
    use super::*;
    use crate::SplitMix64;

    #[test]
    fn frustum_agrees_with_clip_space() {
        let v = view(17.0, -23.0);
        let mut random = SplitMix64::new(1);
        let mut inside = 0;
        for _ in 0..10_000 {
            let p = v.eye_world + DVec3::from([(); 3].map(|_| random.range(-100.0, 100.0)));
            let c = v.clip_from_world * p.extend(1.0);
            let expected = c.x.abs() <= c.w && c.y.abs() <= c.w && c.z <= c.w && c.w > 0.0;
            assert_eq!(v.sees_point(p), expected, "{p}");
            inside += expected as u32;
        }
        assert!(inside > 1000);
    }

    #[test]
    fn boxes_are_in_sight_as_their_points_are() {
        let v = view(17.0, -23.0);
        let mut random = SplitMix64::new(2);
        let mut boxes = [0; 3];
        for _ in 0..3_000 {
            let side_m = random.range(0.1, 100.0);
            let min = v.eye_world + DVec3::from([(); 3].map(|_| random.range(-150.0, 50.0)));
            let max = min + DVec3::from([(); 3].map(|_| random.range(0.0, side_m)));
            let bounds = Aabb { min: min.into(), max: max.into() };
            let (sees, whole) = (v.sees(&bounds), v.sees_whole(&bounds));
            let ends = [min, max];
            let corner = |i: usize| DVec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z);
            assert_eq!(whole, (0..8).all(|i| v.sees_point(corner(i))), "{bounds:?}");
            for _ in 0..20 {
                let point = DVec3::from([0, 1, 2].map(|axis| random.range(min[axis], max[axis])));
                let seen = v.sees_point(point);
                assert!((sees || !seen) && (seen || !whole), "{point} of {bounds:?}");
            }
            boxes[sees as usize + whole as usize] += 1;
        }
        assert!(boxes.iter().all(|count| *count > 100), "out of sight, in part, whole: {boxes:?}");
    }

    #[test]
    fn a_segment_is_seen_where_one_of_its_points_is() {
        let v = view(17.0, -23.0);
        let mut random = SplitMix64::new(2);
        let mut point = || v.eye_world + DVec3::from([(); 3].map(|_| random.range(-100.0, 100.0)));
        let mut crossing = 0;
        for _ in 0..2_000 {
            let (a, b) = (point(), point());
            let expected = (0..=1_000).any(|i| v.sees_point(a.lerp(b, i as f64 / 1e3)));
            // Points in steps may miss a corner of the frustum that the segment cuts.
            assert!(v.sees_segment(a, b, 0.0) || !expected, "{a} {b}");
            assert!(!v.sees_segment(a, b, 0.3) || expected, "{a} {b}");
            crossing += (expected && !v.sees_point(a) && !v.sees_point(b)) as u32;
        }
        assert!(crossing > 50);
    }

    /// Boxes in boxes: what is known of the outer one changes no answer for the inner one.
    #[test]
    fn planes_that_do_not_cut_a_box_cut_none_inside_of_it() {
        let (v, mut random, mut spared) = (view(17.0, -23.0), SplitMix64::new(4), 0);
        for _ in 0..20_000 {
            let side_m = random.range(0.1, 100.0);
            let mut outer = Aabb { min: [0.0; 3], max: [0.0; 3] };
            let mut inner = outer;
            for axis in 0..3 {
                let start = v.eye_world[axis] + random.range(-150.0, 50.0);
                let mut ends = [(); 4].map(|_| start + random.range(0.0, side_m));
                ends.sort_by(f64::total_cmp);
                [outer.min[axis], inner.min[axis], inner.max[axis], outer.max[axis]] = ends;
            }
            let Some(planes) = v.planes_across(&outer, Planes::ALL) else {
                assert!(!v.sees(&inner), "{inner:?} in {outer:?}");
                continue;
            };
            assert_eq!(v.planes_across(&inner, planes), v.planes_across(&inner, Planes::ALL), "{inner:?} in {outer:?}");
            spared += u32::from(planes != Planes::ALL);
        }
        assert!(spared > 1_000);
    }
}
