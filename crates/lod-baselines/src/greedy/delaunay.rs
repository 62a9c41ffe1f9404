//! An exact Delaunay triangulation of points of a grid, one point after the other.
//!
//! ```text
//!   o-------o             o-------o     A new point removes the triangles whose circle holds it, and is joined to
//!   | \   / |             | \   / |     the rim of the hole (Bowyer; Watson: both The Computer Journal 24(2), 1981).
//!   |   o   |             |  \ /  |     On the outline the hole is open: the fan has two ends there.
//!   | / x \ |     ->      |   x   |
//!   o-------o             o-------o     (the inner point above stays: it is a corner of the rim)
//! ```
//!
//! With coordinates below 2^14, no value of the in-circle test exceeds 2^60. Nothing is shared with the kernel of
//! `tin-lod`, whose meshes are measured against these.

/// Column and row, 0 to [`MAX_COORDINATE`].
pub(crate) type Point = [i64; 2];
/// Number of a triangle. Those of removed triangles are used again.
pub(crate) type TriangleId = usize;

/// The largest coordinate for which the in-circle test fits in 64 bits.
pub(crate) const MAX_COORDINATE: i64 = (1 << 14) - 1;

/// A triangulation of a rectangle.
pub(crate) struct Delaunay {
    /// Counter-clockwise seen from above: columns run east, rows south.
    corners: Vec<[Point; 3]>,
    /// What lies beyond the edges from each corner to the next; nothing beyond the outline.
    beyond: Vec<[Option<TriangleId>; 3]>,
    hole: Vec<TriangleId>,
    rim: Vec<RimEdge>,
}

#[derive(Clone, Copy)]
struct RimEdge {
    start: Point,
    end: Point,
    beyond: Option<TriangleId>,
}

impl Delaunay {
    /// The four corners of a rectangle of so many grid intervals.
    pub fn new(width: i64, depth: i64) -> Self {
        assert!(width.max(depth) <= MAX_COORDINATE, "{width} x {depth} intervals: the in-circle test would overflow");
        let [nw, sw, se, ne] = [[0, 0], [0, depth], [width, depth], [width, 0]];
        Self {
            corners: vec![[nw, sw, ne], [se, ne, sw]],
            beyond: vec![[None, Some(1), None], [None, Some(0), None]],
            hole: Vec::new(),
            rim: Vec::new(),
        }
    }

    /// The corners of all triangles, by their numbers.
    pub fn triangles(&self) -> &[[Point; 3]] {
        &self.corners
    }

    /// Adds a point that lies in a triangle or on one of its sides, and is no corner. Returns the triangles that are
    /// new: all that have the point as a corner.
    pub fn insert(&mut self, point: Point, triangle: TriangleId) -> Vec<TriangleId> {
        self.dig(point, triangle);
        self.fill(point)
    }

    /// Finds the triangles whose circle holds the point, and the edges around them, in any order.
    fn dig(&mut self, point: Point, triangle: TriangleId) {
        self.rim.clear();
        self.hole.clear();
        self.hole.push(triangle);
        let mut seen = 0;
        while seen < self.hole.len() {
            let (corners, beyond) = (self.corners[self.hole[seen]], self.beyond[self.hole[seen]]);
            seen += 1;
            for i in 0..3 {
                let (start, end) = (corners[i], corners[(i + 1) % 3]);
                match beyond[i] {
                    Some(other) if self.hole.contains(&other) => {}
                    Some(other) if in_circle(self.corners[other], point) => self.hole.push(other),
                    // The edge of the outline on which the point lies.
                    None if doubled_area([start, end, point]) == 0 => {}
                    beyond => self.rim.push(RimEdge { start, end, beyond }),
                }
            }
        }
    }

    /// A triangle from each edge of the rim to the point.
    fn fill(&mut self, point: Point) -> Vec<TriangleId> {
        // The rim has more edges than the hole has triangles.
        let free = self.hole.iter().copied().chain(self.corners.len()..);
        let made: Vec<TriangleId> = free.take(self.rim.len()).collect();
        let slots = self.corners.len() + made.len() - self.hole.len();
        self.corners.resize(slots, [point; 3]);
        self.beyond.resize(slots, [None; 3]);
        for (edge, triangle) in self.rim.iter().zip(&made) {
            let made_where = |is: &dyn Fn(&RimEdge) -> bool| self.rim.iter().position(is).map(|i| made[i]);
            let next = made_where(&|other| other.start == edge.end);
            let previous = made_where(&|other| other.end == edge.start);
            self.corners[*triangle] = [edge.start, edge.end, point];
            self.beyond[*triangle] = [edge.beyond, next, previous];
            if let Some(beyond) = edge.beyond {
                let twin = self.corners[beyond].iter().position(|corner| *corner == edge.end);
                self.beyond[beyond][twin.expect("the edge has a twin")] = Some(*triangle);
            }
        }
        made
    }
}

/// Twice the signed area, positive when counter-clockwise seen from above.
pub(crate) fn doubled_area([a, b, c]: [Point; 3]) -> i64 {
    (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1])
}

/// Whether a point lies inside the circle through the corners of a counter-clockwise triangle; on it is not inside.
fn in_circle(corners: [Point; 3], point: Point) -> bool {
    let [a, b, c] = corners.map(|corner| [corner[0] - point[0], corner[1] - point[1]]);
    let square = |u: Point| u[0] * u[0] + u[1] * u[1];
    let cross = |u: Point, v: Point| v[0] * u[1] - u[0] * v[1];
    square(a) * cross(b, c) + square(b) * cross(c, a) + square(c) * cross(a, b) > 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::SplitMix64;

    /// Whether a point lies inside the circle through three others: by the circle's centre, exactly.
    fn is_inside_circle([a, b, c]: [Point; 3], point: Point) -> bool {
        let from_a = |p: Point| [p[0] - a[0], p[1] - a[1]].map(i128::from);
        let square = |[x, z]: [i128; 2]| x * x + z * z;
        let (b, c, p) = (from_a(b), from_a(c), from_a(point));
        // The centre times `scale`, seen from a.
        let scale = 2 * (b[0] * c[1] - b[1] * c[0]);
        let centre = [c[1] * square(b) - b[1] * square(c), b[0] * square(c) - c[0] * square(b)];
        square([p[0] * scale - centre[0], p[1] * scale - centre[1]]) < square(centre)
    }

    /// No corner of any triangle lies in the circle of another: all against all.
    fn assert_delaunay(triangles: &[[Point; 3]]) {
        let mut points: Vec<Point> = triangles.iter().flatten().copied().collect();
        points.sort_unstable();
        points.dedup();
        for triangle in triangles {
            assert!(doubled_area(*triangle) > 0, "{triangle:?}");
            let inside = points.iter().find(|p| is_inside_circle(*triangle, **p));
            assert_eq!(inside, None, "in the circle of {triangle:?}");
        }
    }

    #[test]
    fn any_points_in_any_order_are_delaunay() {
        for seed in 0..200 {
            let mut random = SplitMix64::new(seed);
            let [width, depth] = [(); 2].map(|_| 1 + random.below(if seed % 4 == 0 { 5 } else { 30 }) as i64);
            let mut mesh = Delaunay::new(width, depth);
            for _ in 0..random.below(120) {
                let point = [random.below(width as u64 + 1) as i64, random.below(depth as u64 + 1) as i64];
                let holds = |[a, b, c]: &[Point; 3]| {
                    [(a, b), (b, c), (c, a)].iter().all(|e| doubled_area([*e.0, *e.1, point]) >= 0)
                };
                let triangle = mesh.triangles().iter().position(holds).unwrap();
                if !mesh.triangles()[triangle].contains(&point) {
                    let made = mesh.insert(point, triangle);
                    assert!(made.iter().all(|t| mesh.triangles()[*t].contains(&point)), "seed {seed}");
                }
            }
            assert_delaunay(mesh.triangles());
            let area: i64 = mesh.triangles().iter().map(|t| doubled_area(*t)).sum();
            assert_eq!(area, 2 * width * depth, "seed {seed}");
        }
    }
}
