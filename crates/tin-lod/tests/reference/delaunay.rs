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
//! Nothing is shared with the kernel. With coordinates below 2^14, no value of the in-circle test exceeds 2^60.

/// Column and row, 0 to [`MAX_COORDINATE`].
pub type Point = [i64; 2];
/// Number of a triangle. Those of removed triangles are used again.
pub type TriangleId = usize;

/// The largest coordinate for which the in-circle test fits in 64 bits.
pub const MAX_COORDINATE: i64 = (1 << 14) - 1;

/// A triangulation of a rectangle.
pub struct Delaunay {
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
pub fn doubled_area([a, b, c]: [Point; 3]) -> i64 {
    (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1])
}

/// Whether a point lies inside the circle through the corners of a counter-clockwise triangle; on it is not inside.
fn in_circle(corners: [Point; 3], point: Point) -> bool {
    let [a, b, c] = corners.map(|corner| [corner[0] - point[0], corner[1] - point[1]]);
    let square = |u: Point| u[0] * u[0] + u[1] * u[1];
    let cross = |u: Point, v: Point| v[0] * u[1] - u[0] * v[1];
    square(a) * cross(b, c) + square(b) * cross(c, a) + square(c) * cross(a, b) > 0
}
