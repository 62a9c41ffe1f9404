//! What a triangulation of a patch must be, decided by other means than the kernel's.

use super::patches::Patch;

/// Column and row.
pub type Point = [i64; 2];
/// Counter-clockwise seen from above.
pub type Triangle = [Point; 3];

/// The triangles behind indices into the vertex buffer.
pub fn triangles(indices: &[u32]) -> Vec<Triangle> {
    let point = |index: &u32| {
        let at = (index - Patch::FIRST_INDEX) as i64;
        [at % Patch::ROW_STRIDE as i64, at / Patch::ROW_STRIDE as i64]
    };
    let (corners, rest) = indices.as_chunks::<3>();
    assert!(rest.is_empty());
    corners.iter().map(|corners| corners.each_ref().map(point)).collect()
}

/// Twice the signed area, positive when counter-clockwise seen from above: rows run south.
pub fn doubled_area([a, b, c]: Triangle) -> i64 {
    (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1])
}

/// Whether `d` lies inside the circle through a counter-clockwise triangle, points on one circle being lifted.
///
/// The determinant of the four points on the paraboloid. Where it is 0 it is taken anew with points that are lifted
/// a little more the later they come by (row, column). The lifts are numbers here and not a rule: `2^20` from one to
/// the next exceeds every product of coordinates, `2^80` a unit of the paraboloid exceeds every lift.
fn in_circle(triangle: Triangle, d: Point) -> bool {
    let square = |p: Point| (p[0] * p[0] + p[1] * p[1]) as i128;
    let plain = below_plane(triangle, d, square);
    if plain != 0 {
        return plain > 0;
    }
    let mut order = [triangle[0], triangle[1], triangle[2], d];
    order.sort_by_key(|p| [p[1], p[0]]);
    let lifted = |p: Point| {
        let rank = order.iter().position(|q| *q == p).unwrap();
        (square(p) << 80) + (1 << (20 * rank))
    };
    let with_lifts = below_plane(triangle, d, lifted);
    assert_ne!(with_lifts, 0);
    with_lifts > 0
}

/// Positive when `d` lies below the plane through a counter-clockwise triangle, all at the given heights.
fn below_plane(triangle: Triangle, d: Point, height: impl Fn(Point) -> i128) -> i128 {
    let [[ax, az, ah], [bx, bz, bh], [cx, cz, ch]] =
        triangle.map(|p| [(p[0] - d[0]) as i128, (p[1] - d[1]) as i128, height(p) - height(d)]);
    // The usual determinant has rows to the north: here they run south, so the sign turns.
    -(ah * (bx * cz - bz * cx) - bh * (ax * cz - az * cx) + ch * (ax * bz - az * bx))
}

/// Directed edges, each with the third corner of its triangle, sorted. A number an edge, as the tests sort millions.
pub struct Edges(Vec<u64>);

impl Edges {
    fn new(triangles: &[Triangle]) -> Self {
        let turns = |[a, b, c]: &Triangle| [[*a, *b, *c], [*b, *c, *a], [*c, *a, *b]];
        let number = |points: [Point; 3]| points.iter().fold(0, |number, p| number << 16 | (p[0] << 8 | p[1]) as u64);
        let mut edges: Vec<_> = triangles.iter().flat_map(turns).map(number).collect();
        edges.sort_unstable();
        assert!(edges.windows(2).all(|two| two[0] >> 16 != two[1] >> 16), "an edge twice");
        Self(edges)
    }

    /// Start, end and third corner of all directed edges, with the third corner beyond where there is one.
    fn all(&self) -> impl Iterator<Item = ([Point; 3], Option<Point>)> {
        let point = |number: u64| [(number >> 8 & 0xff) as i64, (number & 0xff) as i64];
        self.0.iter().map(move |edge| {
            let (start, end) = (edge >> 32, edge >> 16 & 0xffff);
            let twin = end << 16 | start;
            let beyond = self.0.binary_search_by_key(&twin, |edge| edge >> 16).ok();
            ([start, end, *edge].map(point), beyond.map(|i| point(self.0[i])))
        })
    }

    /// Panics where the far corner of an inner edge lies inside a triangle's circle. On the circle it may lie.
    pub fn check_delaunay_but_for_ties(&self) {
        let square = |p: Point| (p[0] * p[0] + p[1] * p[1]) as i128;
        for (triangle, far) in self.all().filter_map(|(triangle, far)| far.map(|far| (triangle, far))) {
            assert!(below_plane(triangle, far, square) <= 0, "{triangle:?} and {far:?}");
        }
    }

    /// The first inner edge that is not Delaunay: its start and end, and the third corners on both sides.
    fn find_wrong(&self) -> Option<[Point; 4]> {
        let inner = self.all().filter_map(|([a, b, apex], far)| far.map(|far| [a, b, apex, far]));
        inner.filter(|[a, b, ..]| a < b).find(|[a, b, apex, far]| in_circle([*a, *b, *apex], *far))
    }
}

/// Panics unless the triangles are *the* triangulation of a patch: its kept samples and no others, its area once,
/// each inner edge shared by two, and Delaunay (of two diagonals on a circle, the one that the lifts leave).
pub fn check(patch: &Patch, triangles: &[Triangle]) {
    let edges = check_tiling(patch, triangles);
    assert_eq!(edges.find_wrong(), None, "edge and the corners beside it");
}

/// Panics unless the triangles cover the patch once, edge to edge, with all of its kept samples and no others.
pub fn check_tiling(patch: &Patch, triangles: &[Triangle]) -> Edges {
    let mut corners: Vec<Point> = triangles.iter().flatten().copied().collect();
    corners.sort_unstable();
    corners.dedup();
    let mut kept: Vec<Point> = patch.kept().positions().map(|(x, z)| [x as i64, z as i64]).collect();
    kept.sort_unstable();
    assert_eq!(corners, kept);

    let (width, depth) = (patch.width as i64, patch.depth as i64);
    assert!(triangles.iter().all(|t| doubled_area(*t) > 0), "a triangle without area or turned over");
    assert_eq!(triangles.iter().map(|t| doubled_area(*t)).sum::<i64>(), 2 * width * depth);

    let on_side = |p: Point, q: Point| {
        let on = |axis: usize, end| p[axis] == q[axis] && (p[axis] == 0 || p[axis] == end);
        on(0, width) || on(1, depth)
    };
    let edges = Edges::new(triangles);
    let outer: Vec<_> = edges.all().filter(|(_, far)| far.is_none()).collect();
    assert!(outer.iter().all(|([a, b, _], _)| on_side(*a, *b)), "an edge with one triangle inside the patch");
    let on_outline = kept.iter().filter(|p| on_side(**p, **p)).count();
    assert_eq!(outer.len(), on_outline);
    // Euler's formula.
    assert_eq!(triangles.len(), 2 * kept.len() - 2 - on_outline);
    edges
}

/// The Delaunay triangulation by the lifts, the slow way: from any triangulation, flip until no edge is wrong.
pub fn flipped_until_right(mut triangles: Vec<Triangle>) -> Vec<Triangle> {
    while let Some([a, b, apex, far]) = Edges::new(&triangles).find_wrong() {
        triangles.retain(|t| !(t.contains(&a) && t.contains(&b)));
        triangles.extend([[apex, a, far], [far, b, apex]]);
    }
    sorted(triangles)
}

/// A form in which equal triangulations are equal.
pub fn sorted(mut triangles: Vec<Triangle>) -> Vec<Triangle> {
    for triangle in &mut triangles {
        let first = (0..3).min_by_key(|i| triangle[*i]).unwrap();
        triangle.rotate_left(first);
    }
    triangles.sort_unstable();
    triangles
}
