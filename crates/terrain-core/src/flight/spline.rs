//! Centripetal Catmull-Rom curves (Yuksel, Schaefer and Keyser, "Parameterization and applications of Catmull-Rom
//! curves", Computer-Aided Design 43(7), 2011).
//!
//! ```text
//!        p1 ----- u ----> p2        knots are sqrt(distance) apart ("centripetal"): the curve passes
//!       /                   \       all points, and makes no cusp and no loop within a segment
//!     p0                     p3
//! ```

use glam::DVec3;

/// The point at `u`, 0 to 1, between `points[segment]` and the next one.
///
/// A missing neighbour at either end is the other one reflected. So is a neighbour that coincides: a camera that
/// stands still between two equal keys leaves the second as if the curve began there.
pub fn point(points: &[DVec3], segment: usize, u: f64) -> DVec3 {
    let (p1, p2) = (points[segment], points[segment + 1]);
    let knot = knot_interval(p1, p2);
    if knot == 0.0 {
        return p1;
    }
    let previous = points[..segment].last().copied().filter(|p| knot_interval(*p, p1) > 0.0);
    let next = points.get(segment + 2).copied().filter(|p| knot_interval(p2, *p) > 0.0);
    let (p0, p3) = (previous.unwrap_or(2.0 * p1 - p2), next.unwrap_or(2.0 * p2 - p1));
    let leaving = knot * slope(p0, p1, p2);
    let arriving = knot * slope(p1, p2, p3);
    hermite([p1, p2], [leaving, arriving], u)
}

fn knot_interval(a: DVec3, b: DVec3) -> f64 {
    a.distance(b).sqrt()
}

/// Derivative at `b` of the parabola through three points at their knots.
fn slope(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    let (ab, bc) = (knot_interval(a, b), knot_interval(b, c));
    (b - a) / ab - (c - a) / (ab + bc) + (c - b) / bc
}

fn hermite([p1, p2]: [DVec3; 2], [leaving, arriving]: [DVec3; 2], u: f64) -> DVec3 {
    let (u2, u3) = (u * u, u * u * u);
    p1 + (p2 - p1) * (3.0 * u2 - 2.0 * u3) + leaving * (u3 - 2.0 * u2 + u) + arriving * (u3 - u2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    #[test]
    fn passes_every_point() {
        let mut random = SplitMix64::new(3);
        let points: Vec<DVec3> =
            (0..50).map(|_| DVec3::from([(); 3].map(|_| random.range(-1e4, 1e4).round()))).collect();
        for segment in 0..points.len() - 1 {
            assert!(point(&points, segment, 0.0).distance(points[segment]) < 1e-9);
            assert!(point(&points, segment, 1.0).distance(points[segment + 1]) < 1e-9);
        }
    }

    #[test]
    fn tangents_agree_on_both_sides_of_a_point() {
        let points = [[0.0, 0.0, 0.0], [10.0, 5.0, 0.0], [11.0, 5.0, 9.0], [30.0, -5.0, 2.0]].map(DVec3::from);
        let step = 1e-6;
        let before = points[1] - point(&points, 0, 1.0 - step);
        let after = point(&points, 1, step) - points[1];
        assert!(before.normalize().distance(after.normalize()) < 1e-4);
    }

    #[test]
    fn two_points_make_a_line_at_even_speed() {
        let points = [DVec3::ZERO, DVec3::new(8.0, 4.0, -2.0)];
        for u in [0.0, 0.25, 0.5, 0.875, 1.0] {
            assert!(point(&points, 0, u).distance(points[1] * u) < 1e-12);
        }
    }

    /// Points on a line, with turns back, stops and uneven gaps: the curve never leaves the segment's own range.
    #[test]
    fn no_overshoot_on_a_line() {
        let mut random = SplitMix64::new(4);
        for _ in 0..2_000 {
            let points: Vec<DVec3> = (0..6).map(|_| DVec3::X * random.below(5) as f64 * 100.0).collect();
            for segment in 0..5 {
                let (a, b) = (points[segment].x, points[segment + 1].x);
                for step in 0..=20 {
                    let x = point(&points, segment, step as f64 / 20.0).x;
                    assert!(x >= a.min(b) - 1e-9 && x <= a.max(b) + 1e-9, "{points:?} segment {segment}: {x}");
                }
            }
        }
    }

    #[test]
    fn coincident_points_stand_still() {
        let stop = DVec3::new(5.0, 6.0, 7.0);
        let points = [DVec3::ZERO, stop, stop, stop, DVec3::X];
        assert_eq!(point(&points, 1, 0.3), stop);
        assert_eq!(point(&points, 2, 0.9), stop);
        assert!(point(&points, 3, 0.5).is_finite());
    }
}
