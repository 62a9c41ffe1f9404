//! A Delaunay triangulation of a patch that grows point by point.
//!
//! Bowyer and Watson: all triangles whose circle holds the new point go, and the hole becomes a fan around it.
//!
//! ```text
//!   +-------+-------+       +-------+-------+      triangle t: slots 4t, 4t + 1, 4t + 2 are its half-edges,
//!   | \   / | \     |       | \   /   \     |      counter-clockwise seen from above
//!   |   +   | p +   |  ->   |   +---p---+   |
//!   | /   \ | /     |       | /   /   \     |      slot 4i + 3: the outside of the outline's edge that starts at
//!   +-------+-------+       +-------+-------+      place i, counted counter-clockwise from the north-western corner
//! ```
//!
//! The fan must be star-shaped, and the result must not depend on the order of the points: both hold because ties are
//! broken by a consistent lifting (Edelsbrunner and Muecke, "Simulation of simplicity", ACM TOG 1990), the same one as
//! at run time.

use crate::lattice::{Vertex, must_flip, position, vertex};

/// Slot of a half-edge.
type HalfEdge = u16;
/// Number of a triangle.
pub(super) type TriangleId = u16;

/// Triangles of the largest patch with all of its samples.
pub(super) const MAX_TRIANGLES: usize = 2 * 64 * 64;

/// Every slot that a `HalfEdge` can name, so that no access needs a bounds check.
const SLOTS: usize = 1 << 16;

/// See the module.
pub(super) struct Mesh {
    origin: Box<[Vertex; SLOTS]>,
    twin: Box<[HalfEdge; SLOTS]>,
    triangles: TriangleId,
    width: u32,
    depth: u32,
    /// Half-edges at the edge of the hole that are still to be looked across.
    pending: Vec<HalfEdge>,
    /// The rim of the hole, counter-clockwise: where its edges start, and what lies beyond them.
    rim: Vec<(Vertex, HalfEdge)>,
    /// Triangles that the last insertion removed.
    removed: Vec<TriangleId>,
    /// Triangles that it made; they reuse the numbers of the removed ones.
    made: Vec<TriangleId>,
}

fn next(e: HalfEdge) -> HalfEdge {
    e & !3 | 0b00_10_01 >> (2 * (e & 3)) & 3
}

fn previous(e: HalfEdge) -> HalfEdge {
    e & !3 | 0b01_00_10 >> (2 * (e & 3)) & 3
}

fn is_outside(e: HalfEdge) -> bool {
    e & 3 == 3
}

impl Mesh {
    pub fn new() -> Self {
        let slots = || vec![0; SLOTS].into_boxed_slice().try_into().expect("the length is that of the array");
        Self {
            origin: slots(),
            twin: slots(),
            triangles: 0,
            width: 0,
            depth: 0,
            pending: Vec::new(),
            rim: Vec::new(),
            removed: Vec::new(),
            made: Vec::new(),
        }
    }

    /// Starts anew with the four corners. They lie on a circle: the south-eastern one has the largest key and counts
    /// as lifted, so the diagonal must not touch it.
    ///
    /// ```text
    ///   nw ---- ne
    ///    |  0 / |
    ///    |  / 1 |
    ///   sw ---- se
    /// ```
    pub fn start(&mut self, width: u32, depth: u32) {
        (self.width, self.depth) = (width, depth);
        let [nw, sw, se, ne] = [vertex(0, 0), vertex(0, depth), vertex(width, depth), vertex(width, 0)];
        self.triangles = 2;
        self.removed.clear();
        self.made.clear();
        self.made.extend([0, 1]);
        for place in 0..2 * (width + depth) {
            let outside = (4 * place + 3) as HalfEdge;
            self.link(outside, outside);
        }
        self.set(0, [nw, sw, ne]);
        self.set(4, [se, ne, sw]);
        for (e, outside) in [(0, nw), (4, se), (2, ne), (6, sw)] {
            self.link(e, self.outside(outside));
        }
        self.link(1, 5);
    }

    /// What the last insertion removed. Do away with all that refers to them, then look at [`Self::made`].
    pub fn removed(&self) -> &[TriangleId] {
        &self.removed
    }

    /// What the last insertion made.
    pub fn made(&self) -> &[TriangleId] {
        &self.made
    }

    pub fn corners(&self, triangle: TriangleId) -> [Vertex; 3] {
        [0, 1, 2].map(|i| self.origin[(4 * triangle + i) as usize])
    }

    /// Adds a point inside the patch that lies in, or on a side of, a triangle.
    pub fn insert_inside(&mut self, point: Vertex, triangle: TriangleId) {
        let e = 4 * triangle;
        self.dig(point, triangle, &[e + 2, e + 1, e]);
        let (first, last) = self.fill(point, self.rim[0].0);
        self.link(last, first);
    }

    /// Adds a point of the outline.
    ///
    /// ```text
    ///   before --- point --- after      the fan stays open: its ends are edges of the outline
    /// ```
    pub fn insert_on_outline(&mut self, point: Vertex) {
        let place = self.outside(point);
        let place_before = (0..place).rev().step_by(4).map(|slot| slot - 3).find(|slot| self.has_point(*slot));
        let place_before = place_before.expect("the first corner is always there");
        let e = self.twin[place_before as usize];
        self.dig(point, e >> 2, &[previous(e), next(e)]);
        let (first, last) = self.fill(point, self.origin[e as usize]);
        self.link(first, place);
        self.link(last, place_before);
    }

    /// Removes the triangles whose circle holds the point, from one of them on, across these of its edges, the last
    /// one first.
    fn dig(&mut self, point: Vertex, first: TriangleId, across: &[HalfEdge]) {
        self.removed.clear();
        self.removed.push(first);
        self.rim.clear();
        self.pending.extend(across);
        while let Some(e) = self.pending.pop() {
            let (start, beyond) = (self.origin[e as usize], self.twin[e as usize]);
            if !is_outside(beyond) {
                let (end, far) = (self.origin[beyond as usize], self.origin[previous(beyond) as usize]);
                if must_flip(point, start, end, far) {
                    self.removed.push(beyond >> 2);
                    self.pending.extend([previous(beyond), next(beyond)]);
                    continue;
                }
            }
            self.rim.push((start, beyond));
        }
    }

    /// Joins the point to the rim of the hole, whose last edge ends at `end`. Returns the half-edges from the point
    /// to the first vertex of the rim and from the last one back, which have no twins yet.
    fn fill(&mut self, point: Vertex, end: Vertex) -> (HalfEdge, HalfEdge) {
        self.made.clear();
        self.made.extend(&self.removed);
        let more = (self.rim.len() - self.made.len()) as u16;
        self.made.extend(self.triangles..self.triangles + more);
        self.triangles += more;
        let first = 4 * self.made[0];
        let mut last = first;
        for i in 0..self.rim.len() {
            let ((start, beyond), e) = (self.rim[i], 4 * self.made[i]);
            let stop = self.rim.get(i + 1).map_or(end, |edge| edge.0);
            self.set(e, [point, start, stop]);
            self.link(e + 1, beyond);
            if i > 0 {
                self.link(last, e);
            }
            last = e + 2;
        }
        (first, last)
    }

    fn set(&mut self, first: HalfEdge, corners: [Vertex; 3]) {
        for i in 0..3 {
            self.origin[(first + i) as usize] = corners[i as usize];
        }
    }

    fn link(&mut self, e: HalfEdge, twin: HalfEdge) {
        self.twin[e as usize] = twin;
        self.twin[twin as usize] = e;
    }

    /// The slot for the outline's edge that starts at a point of the outline.
    fn outside(&self, point: Vertex) -> HalfEdge {
        let (width, depth) = (self.width, self.depth);
        let (column, row) = position(point);
        let (column, row) = (column as u32, row as u32);
        let place = if column == 0 {
            row
        } else if row == depth {
            depth + column
        } else if column == width {
            depth + width + (depth - row)
        } else {
            2 * depth + width + (width - column)
        };
        (4 * place + 3) as HalfEdge
    }

    /// Whether the triangulation has the point of an outside slot: one without is linked to itself.
    fn has_point(&self, outside: HalfEdge) -> bool {
        self.twin[outside as usize] != outside
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::doubled_area;
    use crate::select::Border;
    use crate::triangulate::{KeptSamples, Triangulator};
    use terrain_core::SplitMix64;

    /// Triangles in a form in which equal triangulations are equal.
    fn sorted(triangles: impl Iterator<Item = [Vertex; 3]>) -> Vec<[Vertex; 3]> {
        let turned = |mut corners: [Vertex; 3]| {
            let least = (0..3).min_by_key(|i| corners[*i]).unwrap();
            corners.rotate_left(least);
            corners
        };
        let mut triangles: Vec<_> = triangles.map(turned).collect();
        triangles.sort_unstable();
        triangles
    }

    impl Mesh {
        /// Every inner edge is Delaunay under the tie-break, twins agree, and the area is the patch's.
        fn validate(&self) {
            let mut area = 0;
            for e in (0..4 * self.triangles).filter(|e| !is_outside(*e)) {
                let twin = self.twin[e as usize];
                assert_eq!(self.twin[twin as usize], e);
                let [from, to] = [e, next(e)].map(|e| self.origin[e as usize]);
                if is_outside(twin) {
                    assert_eq!(self.outside(from), twin);
                } else {
                    assert_eq!([self.origin[twin as usize], self.origin[next(twin) as usize]], [to, from]);
                    let [apex, far] = [e, twin].map(|e| self.origin[previous(e) as usize]);
                    assert!(!must_flip(apex, from, to, far), "{from:x} {to:x}");
                }
                let corners = self.corners(e >> 2);
                area += (e & 3 == 0) as i32 * doubled_area(corners[0], corners[1], corners[2]);
                assert!(doubled_area(corners[0], corners[1], corners[2]) > 0);
            }
            assert_eq!(area as u32, 2 * self.width * self.depth);
        }

        /// The triangulation of the same points by the kernel that runs once a frame.
        fn at_run_time(&self, points: &[Vertex]) -> Vec<[Vertex; 3]> {
            let (mut border, mut interior) = (Border::default(), vec![0; self.depth as usize - 1]);
            for (column, row) in points.iter().map(|p| position(*p)) {
                match (column as u32, row as u32) {
                    (0, _) => border.west |= 1 << row,
                    (_, 0) => border.north |= 1 << column,
                    (x, _) if x == self.width => border.east |= 1 << row,
                    (_, z) if z == self.depth => border.south |= 1 << column,
                    (x, z) => interior[z as usize - 1] |= 1 << x,
                }
            }
            let (width, depth, interior) = (self.width, self.depth, &interior[..]);
            let kept = KeptSamples { width, depth, border, interior, first_index: 0, row_stride: 256 };
            let mut indices = Vec::new();
            Triangulator::Grid.triangulate(&kept, &mut indices);
            sorted(indices.as_chunks().0.iter().map(|corners| corners.map(|v| v as Vertex)))
        }

        fn locate(&self, point: Vertex) -> TriangleId {
            let holds = |t: &TriangleId| {
                let [a, b, c] = self.corners(*t);
                [(a, b), (b, c), (c, a)].iter().all(|(from, to)| doubled_area(*from, *to, point) >= 0)
            };
            (0..self.triangles).find(holds).unwrap()
        }
    }

    /// Any samples but the corners, in the order of their keys.
    fn some_points(random: &mut SplitMix64, width: u32, depth: u32) -> Vec<Vertex> {
        let density = random.range(0.0, 1.2);
        let is_corner = |column, row| (column == 0 || column == width) && (row == 0 || row == depth);
        let all = (0..=depth).flat_map(|row| (0..=width).map(move |column| (column, row)));
        let inner = all.filter(|(column, row)| !is_corner(*column, *row));
        inner.filter(|_| random.range(0.0, 1.0) < density).map(|(column, row)| vertex(column, row)).collect()
    }

    fn insert_all(mesh: &mut Mesh, width: u32, depth: u32, points: &[Vertex]) {
        mesh.start(width, depth);
        for point in points {
            let (column, row) = position(*point);
            if column == 0 || row == 0 || column as u32 == width || row as u32 == depth {
                mesh.insert_on_outline(*point);
            } else {
                mesh.insert_inside(*point, mesh.locate(*point));
            }
        }
    }

    #[test]
    fn any_order_of_points_gives_the_triangulation_of_the_run_time() {
        let mut mesh = Mesh::new();
        for seed in 0..600 {
            let mut random = SplitMix64::new(seed);
            let largest = if seed % 20 == 0 { 64 } else { 12 };
            let (width, depth) = (1 + random.below(largest) as u32, 1 + random.below(largest) as u32);
            let mut points = some_points(&mut random, width, depth);
            insert_all(&mut mesh, width, depth, &points);
            let expected = mesh.at_run_time(&points);
            for _ in 0..3 {
                for i in (1..points.len()).rev() {
                    points.swap(i, random.below(i as u64 + 1) as usize);
                }
                insert_all(&mut mesh, width, depth, &points);
                mesh.validate();
                assert_eq!(sorted((0..mesh.triangles).map(|t| mesh.corners(t))), expected, "seed {seed}");
            }
        }
    }
}
