//! Triangles on integer points as half-edges, and the flips that make them Delaunay: exact, and to a unique
//! result (`lattice.rs`).
//!
//! ```text
//!           0           Triangle t has four slots. 4t + i is the half-edge from corner i to the next corner,
//!          / \          counter-clockwise seen from above; `origin` is corner i, `twin` the half-edge beyond.
//!         /   \         Slot 4t + 3 is not of this triangle: it is an "open slot", free for other use.
//!        v     \        An edge with no triangle beyond has an open slot as its twin, and that slot's twin is the
//!       1 -----> 2      edge. So linking and flipping need not ask whether there is a neighbour.
//! ```

use crate::lattice::{Vertex, doubled_area, must_flip};

/// Slot of a half-edge.
pub(super) type HalfEdge = u16;

/// Beyond the edges of the patch's outline. The columns of the front have the open slots 0 to 64.
pub(super) const OUTSIDE: HalfEdge = open_slot(65);
/// Beyond the edge from a front vertex to the new vertex straight below it.
pub(super) const PLUMB: HalfEdge = open_slot(66);

/// Every slot that a `HalfEdge` can name, so that no access has a bounds check. The largest patch, 8192 triangles,
/// uses half of them; memory that is not used is never touched.
const SLOTS: usize = 1 << 16;

/// The open slot with a number.
pub(super) const fn open_slot(number: u32) -> HalfEdge {
    (4 * number + 3) as HalfEdge
}

fn is_open(e: HalfEdge) -> bool {
    e & 3 == 3
}

/// The half-edge after one in its triangle.
#[inline(always)]
fn next(e: HalfEdge) -> HalfEdge {
    if e & 3 == 2 { e - 2 } else { e + 1 }
}

/// The half-edge before one in its triangle.
#[inline(always)]
fn previous(e: HalfEdge) -> HalfEdge {
    if e & 3 == 0 { e + 2 } else { e - 1 }
}

/// The triangles of one patch.
pub(super) struct HalfEdges {
    origin: Box<[Vertex; SLOTS]>,
    twin: Box<[HalfEdge; SLOTS]>,
    triangles: u16,
    /// Edges that [`Self::settle`] has yet to test; empty between calls, kept for its memory.
    suspects: Vec<HalfEdge>,
}

impl HalfEdges {
    pub fn new() -> Self {
        let slots = || vec![0; SLOTS].into_boxed_slice().try_into().expect("the length is that of the array");
        Self { origin: slots(), twin: slots(), triangles: 0, suspects: Vec::new() }
    }

    pub fn clear(&mut self) {
        self.triangles = 0;
    }

    /// The corners of all triangles.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [Vertex; 3]> {
        let slots = self.origin[..4 * self.triangles as usize].as_chunks().0;
        slots.iter().map(|[a, b, c, _]| [*a, *b, *c])
    }

    #[inline(always)]
    pub fn twin(&self, e: HalfEdge) -> HalfEdge {
        self.twin[e as usize]
    }

    #[inline(always)]
    pub fn link(&mut self, e: HalfEdge, twin: HalfEdge) {
        self.twin[e as usize] = twin;
        self.twin[twin as usize] = e;
    }

    /// Adds a triangle with the given corners and, for the edge that starts at each, its twin. Returns the first.
    #[inline(always)]
    pub fn push(&mut self, corners: [Vertex; 3], twins: [HalfEdge; 3]) -> HalfEdge {
        let e = 4 * self.triangles;
        self.triangles += 1;
        self.set(e, corners);
        self.link(e, twins[0]);
        self.link(e | 1, twins[1]);
        self.link(e | 2, twins[2]);
        e
    }

    #[inline(always)]
    fn set(&mut self, first: HalfEdge, corners: [Vertex; 3]) {
        self.origin[first as usize] = corners[0];
        self.origin[(first | 1) as usize] = corners[1];
        self.origin[(first | 2) as usize] = corners[2];
    }

    /// The triangle of a half-edge, from the corner opposite to it on.
    fn corners(&self, e: HalfEdge) -> [Vertex; 3] {
        [previous(e), e, next(e)].map(|e| self.origin[e as usize])
    }

    /// If the edge `e` = `a b` of the triangle `apex a b` is wrong: the corner beyond it.
    #[inline(always)]
    fn wrong(&self, e: HalfEdge, [apex, a, b]: [Vertex; 3]) -> Option<Vertex> {
        let twin = self.twin(e);
        if is_open(twin) {
            return None;
        }
        let far = self.origin[previous(twin) as usize];
        must_flip(apex, a, b, far).then_some(far)
    }

    /// Turns the edge `a b` into `far apex`.
    ///
    /// ```text
    ///    b ---- far        b ---- far
    ///    |  \  f |         |  u / |        e = a b in triangle t, f = b a in u
    ///    | e  \  |   ->    |  /   |
    ///    |  t   \|         | /  t |        after: t = apex a far, u = apex far b, the apex first in both
    ///  apex ---- a       apex --- a
    /// ```
    #[inline(always)]
    fn flip(&mut self, e: HalfEdge, [apex, a, b]: [Vertex; 3], far: Vertex) {
        let f = self.twin(e);
        let (t, u) = (e & !3, f & !3);
        let (b_apex, apex_a) = (self.twin(next(e)), self.twin(previous(e)));
        let (a_far, far_b) = (self.twin(next(f)), self.twin(previous(f)));
        self.set(t, [apex, a, far]);
        self.set(u, [apex, far, b]);
        self.link(t, apex_a);
        self.link(t | 1, a_far);
        self.link(t | 2, u);
        self.link(u | 1, far_b);
        self.link(u | 2, b_apex);
    }

    /// Makes the edge opposite to a new triangle's first corner Delaunay. Flips turn the triangle into a fan around
    /// that corner, which is walked from edge 0 of the new triangle; that edge keeps its slot.
    ///
    /// Edges between two triangles of the fan need no test. Such an edge joins the apex to a corner `c` that the
    /// flips have uncovered. Lifted to the paraboloid, the triangles around `c` were convex before, and the apex lies
    /// below each of those that have gone, so below the plane through `c` and the two corners beside it.
    #[inline(always)]
    pub fn settle_fan(&mut self, first: HalfEdge, [apex, mut a, mut b]: [Vertex; 3]) {
        let mut t = first;
        let mut fan_ahead = 0;
        loop {
            // The last two bits are known from here on: `next` and `previous` cost nothing.
            t &= !3;
            while let Some(far) = self.wrong(t | 1, [apex, a, b]) {
                self.flip(t | 1, [apex, a, b], far);
                b = far;
                fan_ahead += 1;
            }
            if fan_ahead == 0 {
                return;
            }
            fan_ahead -= 1;
            t = self.twin(t | 2);
            (a, b) = (b, self.origin[(t | 2) as usize]);
        }
    }

    /// Flips an edge if it is wrong, and then whatever becomes wrong around it (Lawson).
    #[inline(always)]
    pub fn settle(&mut self, e: HalfEdge) {
        if self.wrong(e, self.corners(e)).is_some() {
            self.suspects.push(e);
            self.settle_suspects();
        }
    }

    #[cold]
    fn settle_suspects(&mut self) {
        while let Some(e) = self.suspects.pop() {
            let corners = self.corners(e);
            if let Some(far) = self.wrong(e, corners) {
                let (t, u) = (e & !3, self.twin(e) & !3);
                self.flip(e, corners, far);
                // A flip gives slots to other edges, but all these edges are suspects again: none is forgotten.
                self.suspects.extend([t, t | 1, u | 1, u | 2]);
            }
        }
    }

    /// Adds a point to triangles that are convex, Delaunay, and hold it inside their outline. `near` is the number of
    /// any triangle, best of one close to the point.
    ///
    /// ```text
    ///     c                c          Where the point is on an edge, one of the three has no area. It goes first:
    ///    / \              /|\         its edge is wrong, and the flip leaves two triangles of its width.
    ///   / . \     ->     / . \
    ///  a-----b          a-----b
    /// ```
    pub fn insert(&mut self, point: Vertex, near: usize) {
        let t = self.locate(point, 4 * near as HalfEdge);
        let ([c, a, b], twins) = (self.corners(t), [t, t | 1, t | 2].map(|e| self.twin(e)));
        self.set(t, [point, a, b]);
        self.link(t | 1, twins[0]);
        let u = self.push([point, b, c], [t | 2, twins[1], OUTSIDE]);
        let v = self.push([point, c, a], [u | 2, twins[2], t]);
        let mut outer = [t | 1, u | 1, v | 1];
        outer.sort_unstable_by_key(|e| {
            let [apex, from, to] = self.corners(*e);
            doubled_area(apex, from, to) == 0
        });
        self.suspects.extend(outer);
        self.settle_suspects();
    }

    /// Walks to the triangle of a point, always across an edge that has the point beyond it: in a Delaunay
    /// triangulation no such walk runs in a circle.
    fn locate(&self, point: Vertex, mut first: HalfEdge) -> HalfEdge {
        let is_beyond =
            |e: &HalfEdge| doubled_area(self.origin[*e as usize], self.origin[next(*e) as usize], point) < 0;
        while let Some(e) = [first, first | 1, first | 2].into_iter().find(is_beyond) {
            first = self.twin(e) & !3;
        }
        first
    }
}
