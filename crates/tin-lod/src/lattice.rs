//! Points of a patch as integers, and what is asked of them: on which side, at what angle, in which circle.
//!
//! **Exact.** No coordinate exceeds 64, so no doubled area within a patch exceeds 2^12, no scalar product 2^13, and
//! no value of the in-circle test 2^27: `i32` holds them.
//!
//! **Unique.** Of four points on a circle the one with the largest key (row, then column) counts as lifted off the
//! paraboloid, by more than all smaller keys together and by less than any distance between integers. No three
//! points on a circle are in line, so the largest lift always decides: of the two diagonals the one that does not
//! touch it is right. As one lifting serves all tests, the result depends on the points alone.
//! So the precomputation of thresholds and the triangulation at run time agree to the last triangle (simulation of
//! simplicity: Edelsbrunner and Muecke, ACM Transactions on Graphics 9(1), 1990).

/// Key of a point: `row << 8 | column`. Keys compare as (row, column).
pub(crate) type Vertex = u16;

pub(crate) fn vertex(column: u32, row: u32) -> Vertex {
    (row << 8 | column) as Vertex
}

/// Column and row.
pub(crate) fn position(vertex: Vertex) -> (i32, i32) {
    ((vertex & 0xff) as i32, (vertex >> 8) as i32)
}

/// Twice the area of a triangle, positive when counter-clockwise seen from above (columns run east, rows south).
#[inline(always)]
pub(crate) fn doubled_area(a: Vertex, b: Vertex, c: Vertex) -> i32 {
    let ((ax, az), (bx, bz), (cx, cz)) = (position(a), position(b), position(c));
    (cx - ax) * (bz - az) - (cz - az) * (bx - ax)
}

/// Scalar product of the ways from a point to two others: positive below a right angle.
#[inline(always)]
pub(crate) fn dot(from: Vertex, b: Vertex, c: Vertex) -> i32 {
    let ((x, z), (bx, bz), (cx, cz)) = (position(from), position(b), position(c));
    (bx - x) * (cx - x) + (bz - z) * (cz - z)
}

/// Whether the edge `a b`, between the triangles `apex a b` and `far b a`, must give way to the edge `apex far`.
///
/// It must when the angles at `apex` and `far` are more than 180 degrees together: their sine, times the lengths of
/// four sides, is below 0.
#[inline(always)]
pub(crate) fn must_flip(apex: Vertex, a: Vertex, b: Vertex, far: Vertex) -> bool {
    let sine = doubled_area(apex, a, b) * dot(far, a, b) + doubled_area(far, b, a) * dot(apex, a, b);
    let touches_lifted = a.max(b) > apex.max(far);
    // One comparison for "below 0, or 0 and touching": this is the most frequent branch of all.
    2 * sine < touches_lifted as i32
}
