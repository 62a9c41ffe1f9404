//! Delaunay triangulation of grid points that arrive row by row: a sweep with an advancing front, in integers.
//!
//! ```text
//!   row 0   o-----o-----------o     #     the front: the lower rim of the triangles so far
//!           |\   / \       /##      p     the new vertex
//!   row 1   o##a    \   /##         a b   the edge of the front above it
//!               ###  \/#
//!   row 2          ###b             1. The triangle p b a, then flips of the edges opposite to p.
//!                                   2. If p is straight below a: the triangle on the other side of a p, too.
//!   row 3          p                3. Valleys beside p are filled while they are sharp.
//! ```
//!
//! The front has at most one vertex in a column. So a column number finds a vertex, and a bit mask of the columns its
//! neighbours: no search, no sort. The corners are always kept and their rows are the first and the last, so after
//! the last row the front is brought to a straight line, and the triangles cover the rectangle. Points in line and
//! points on a circle need no care, as nothing is rounded (`half_edges.rs`). Nothing is allocated for a patch.
//!
//! Steps 2 and 3 and the end fill valleys: a triangle `b v a` below a front vertex `v`, with triangles beyond two of
//! its edges. The fan around `b` puts `v a` right. The edge `b v` is tested after that, because around `v` the
//! triangles had a gap and what holds for fans (`HalfEdges::settle_fan`) does not hold there. For step 2 that edge is
//! the one straight up from `p`.
//!
//! Measured on 33 x 33 samples, random sets of 50 to 400: 3.6 to 3.8 in-circle tests and 0.4 to 0.5 flips a sample.
//! The angle up to which valleys are filled at once, at 200 samples:
//!
//! | below | never | 45 | 63 | 90 | 117 | 135 | 180 degrees |
//! |---|---|---|---|---|---|---|---|
//! | tests a sample | 8.1 | 5.6 | 4.8 | 4.3 | 3.8 | 4.1 | 8.7 |
//! | flips a sample | 1.68 | 1.00 | 0.77 | 0.60 | 0.50 | 0.67 | 2.97 |
//!
//! With all samples kept there is not one flip, since the sweep makes the very diagonals that the lifts leave: a
//! shortcut for full blocks was not needed. `fill` inlined into its callers was 3 to 7 % slower.

mod half_edges;

use half_edges::{HalfEdge, HalfEdges, OUTSIDE, PLUMB, open_slot};

use crate::lattice::{Vertex, dot, doubled_area, position, vertex};

use super::KeptSamples;

/// The memory that the triangulation of a patch needs, for one patch after the other.
pub(crate) struct GridKernel {
    triangles: HalfEdges,
    front: Front,
}

impl GridKernel {
    pub fn new() -> Self {
        Self { triangles: HalfEdges::new(), front: Front { width: 0, inner: 0, vertices: [0; 65] } }
    }

    pub fn triangulate(&mut self, kept: &KeptSamples, indices: &mut Vec<u32>) {
        self.connect(kept);
        self.append_indices(kept, indices);
    }

    /// The corners of the present triangles.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [Vertex; 3]> {
        self.triangles.triangles()
    }

    /// Adds a sample inside the patch to the present triangles. `near` is the number of any of them.
    pub fn add(&mut self, sample: Vertex, near: usize) {
        self.triangles.insert(sample, near);
    }

    /// Triangulates.
    pub fn connect(&mut self, kept: &KeptSamples) {
        self.start(kept);
        for row in 1..=kept.depth {
            let mut columns = kept.inner_row(row) | kept.has_west(row) as u64;
            while columns != 0 {
                let column = columns.trailing_zeros();
                columns &= columns - 1;
                self.insert(column, row, columns.trailing_zeros());
            }
            if kept.has_east(row) {
                self.insert_east(row);
            }
        }
        self.flatten();
    }

    /// The first row is the first front. There is no triangle beyond it.
    fn start(&mut self, kept: &KeptSamples) {
        self.triangles.clear();
        self.front = Front { width: kept.width, inner: kept.inner_row(0) | 1, vertices: [0; 65] };
        for column in 0..=kept.width {
            self.front.vertices[column as usize] = vertex(column, 0);
            self.triangles.link(open_slot(column), OUTSIDE);
        }
    }

    /// Inserts a vertex below the front, anywhere but on the eastern side. `next_column` is that of the next vertex
    /// of the row, 64 or more if there is none.
    #[inline(always)]
    fn insert(&mut self, column: u32, row: u32, next_column: u32) {
        let (west, east) = (self.front.at_or_before(column), self.front.after(column));
        let new = vertex(column, row);
        let is_below_vertex = west == column;
        let west_side = match column {
            0 => OUTSIDE,
            _ if is_below_vertex => PLUMB,
            _ => open_slot(west),
        };
        self.attach(new, west, east, west_side, open_slot(column));
        self.fill_west(new, west, west_side, is_below_vertex);
        self.front.insert(column, new);
        // A vertex that comes next under the new edge sees that valley from nearer by.
        if next_column > east {
            self.fill_east(column, new);
        }
    }

    /// Inserts a vertex on the eastern side, straight below the front's last one.
    fn insert_east(&mut self, row: u32) {
        let column = self.front.width;
        let (new, west) = (vertex(column, row), self.front.before(column));
        self.attach(new, west, column, open_slot(west), OUTSIDE);
        self.fill_west(new, west, open_slot(west), false);
        self.front.vertices[column as usize] = new;
    }

    /// The triangle between the front's edge from `west` to `east` and a new vertex, and its flips.
    #[inline(always)]
    fn attach(&mut self, new: Vertex, west: u32, east: u32, west_side: HalfEdge, east_side: HalfEdge) {
        let corners = [new, self.front.vertex(east), self.front.vertex(west)];
        let above = self.triangles.twin(open_slot(west));
        let first = self.triangles.push(corners, [east_side, above, west_side]);
        self.triangles.settle_fan(first, corners);
    }

    /// Fills the valleys to the west of a new vertex, from the one in a given column on; `side` is the open slot
    /// of the edge from that valley's vertex to the new one, `must` whether it is to be filled in any case.
    #[inline(always)]
    fn fill_west(&mut self, new: Vertex, mut valley: u32, mut side: HalfEdge, mut must: bool) {
        while valley > 0 {
            let west = self.front.before(valley);
            let (a, v) = (self.front.vertex(west), self.front.vertex(valley));
            // Not `||`: a branch that cannot be foreseen costs more than the test of the angle.
            if !(must | is_sharp(a, v, new)) {
                return;
            }
            self.fill(west, v, side, new);
            self.front.remove(valley);
            (valley, side, must) = (west, open_slot(west), false);
        }
    }

    #[inline(always)]
    fn fill_east(&mut self, column: u32, new: Vertex) {
        let mut valley = self.front.after(column);
        while valley < self.front.width {
            let east = self.front.after(valley);
            let (v, b) = (self.front.vertex(valley), self.front.vertex(east));
            if !is_sharp(new, v, b) {
                return;
            }
            self.fill(column, v, open_slot(valley), b);
            self.front.remove(valley);
            valley = east;
        }
    }

    /// The triangle below a valley: from the front's vertex in a column over the valley's vertex `v` to `b`. Its new
    /// lower edge takes the place of the western one; `east_side` is the open slot of the edge from `v` to `b`.
    #[inline(never)] // Measured: see the module.
    fn fill(&mut self, west: u32, v: Vertex, east_side: HalfEdge, b: Vertex) {
        let west_side = open_slot(west);
        let twins = [self.triangles.twin(east_side), self.triangles.twin(west_side), west_side];
        let corners = [b, v, self.front.vertex(west)];
        let first = self.triangles.push(corners, twins);
        self.triangles.settle_fan(first, corners);
        self.triangles.settle(first);
    }

    /// Fills what is left above the last row: each valley, and each hill once its slopes have been filled.
    fn flatten(&mut self) {
        let mut west = 0;
        loop {
            let valley = self.front.after(west);
            if valley == self.front.width {
                return;
            }
            let east = self.front.after(valley);
            let (a, v, b) = (self.front.vertex(west), self.front.vertex(valley), self.front.vertex(east));
            if doubled_area(b, v, a) > 0 {
                self.fill(west, v, open_slot(valley), b);
                self.front.remove(valley);
                west = if west == 0 { 0 } else { self.front.before(west) };
            } else {
                west = valley;
            }
        }
    }

    pub fn append_indices(&self, kept: &KeptSamples, indices: &mut Vec<u32>) {
        let index = |v: Vertex| {
            let (column, row) = position(v);
            kept.index(column as u32, row as u32)
        };
        let triangles = self.triangles.triangles();
        let start = indices.len();
        indices.resize(start + 3 * triangles.len(), 0);
        for (to, corners) in indices[start..].as_chunks_mut().0.iter_mut().zip(triangles) {
            *to = corners.map(index);
        }
    }
}

/// Whether a valley from `a` over `v` to `b` is worth a triangle at once: an angle below 117 degrees (cotangent above
/// -1/2). The triangulation does not depend on that, only the number of flips does.
#[inline(always)]
fn is_sharp(a: Vertex, v: Vertex, b: Vertex) -> bool {
    let area = doubled_area(v, a, b);
    area > 0 && 2 * dot(v, a, b) > -area
}

/// The lower rim of the triangles: a vertex in some columns, always in the first (0) and last (`width`).
///
/// The edge that starts at a column's vertex has the open slot with the column's number.
struct Front {
    width: u32,
    /// Bit `i`: a vertex in column `i`, which is not the last. The last column, up to 64, has no bit.
    inner: u64,
    /// The vertex of each column that has one.
    vertices: [Vertex; 65],
}

impl Front {
    fn vertex(&self, column: u32) -> Vertex {
        self.vertices[column as usize]
    }

    /// The next column with a vertex, east of any but the last.
    fn after(&self, column: u32) -> u32 {
        (column + 1 + (self.inner >> column >> 1 | 1 << 63).trailing_zeros()).min(self.width)
    }

    /// The next column with a vertex, west of any but the first.
    fn before(&self, column: u32) -> u32 {
        (self.inner & u64::MAX >> (64 - column) | 1).ilog2()
    }

    /// The column itself, not the last, if it has a vertex; else the next one to the west.
    fn at_or_before(&self, column: u32) -> u32 {
        (self.inner & u64::MAX >> (63 - column) | 1).ilog2()
    }

    fn insert(&mut self, column: u32, vertex: Vertex) {
        self.inner |= 1 << column;
        self.vertices[column as usize] = vertex;
    }

    fn remove(&mut self, column: u32) {
        self.inner &= !(1 << column);
    }
}
