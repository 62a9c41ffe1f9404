//! The hierarchy of right triangles over a DEM of any size, and what each of its vertices must know.
//!
//! A right triangle is split at the middle of its longest edge (Evans, Kirkpatrick and Townsend 2001). The triangle on
//! the other side of that edge is split at the same vertex: together they are the vertex's *diamond*.
//!
//! ```text
//!   l             l            square vertex s: in the middle      edge vertex e: in the middle
//!   |\            |\           of a square's diagonal              of a square's side
//!   | \           | \
//!   |  m    ->    |  m            +-------+  +-------+                   +---e---+
//!   |   \         | / \           | \     |  |     / |                   | \   / |
//!   |    \        |/   \          |   s   |  |   s   |                   e   s   e
//!   a-----r       a-----r         |     \ |  | /     |                   | /   \ |
//!                                 +-------+  +-------+                   +---e---+
//!   a = apex
//! ```
//!
//! Vertices have a `half`, half the extent of the edge that they split: a square vertex lies at odd multiples of it in
//! both axes, an edge vertex in one of them.
//!
//! A square whose column and row (counted in squares) add up to an even number has the falling diagonal, else the
//! rising one; that is what the bisection makes of a falling diagonal in the root.
//!
//! **Any size.** The root is a square of 2^n intervals, the smallest that holds the DEM with its north-west corner on
//! the DEM's. Vertices beyond the last column or row are clamped to it. That cannot fold a triangle: each triangle of
//! the hierarchy has an edge along an axis, clamping keeps the order of columns and of rows, and so the sign of (length
//! of that edge) x (distance of the third corner from its line) cannot turn. It may become 0, exactly where all corners
//! lie on or beyond the last column, or all on or beyond the last row: such triangles lie on the outline, and are left
//! out with all their descendants. A mesh without folds whose outline is the DEM's covers the DEM once. No triangle is
//! split for the rim's sake.
//!
//! Errors and bounds are those of the clamped triangles.

use terrain_core::{Aabb, Heightmap, Sample};

use crate::deviation::{SampleRect, max_deviation_m};

/// A place on the root square's grid, as column and row; some lie beyond the DEM.
pub(crate) type Point = [i32; 2];

/// A triangle of the hierarchy; its right angle is at the apex, and its corners run counter-clockwise seen from above.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RightTriangle {
    pub apex: Point,
    pub left: Point,
    pub right: Point,
}

impl RightTriangle {
    /// One of the two triangles of a diamond, by the middle of its longest edge and the way from there to its apex.
    fn around(middle: Point, to_apex: Point) -> Self {
        let along = [to_apex[1], -to_apex[0]];
        Self { apex: add(middle, to_apex), left: add(middle, along), right: add(middle, [-along[0], -along[1]]) }
    }

    pub fn corners(&self) -> [Point; 3] {
        [self.apex, self.left, self.right]
    }

    /// The middle of the longest edge. Only for triangles with a `half`.
    pub fn split_vertex(&self) -> Point {
        [0, 1].map(|axis| (self.left[axis] + self.right[axis]) / 2)
    }

    /// Half the extent of the longest edge along an axis; 0 where its middle is no sample.
    pub fn half(&self) -> i32 {
        let extent = |axis: usize| (self.left[axis] - self.right[axis]).abs();
        extent(0).max(extent(1)) / 2
    }

    pub fn children(&self) -> [Self; 2] {
        let middle = self.split_vertex();
        let Self { apex, left, right } = *self;
        [Self { apex: middle, left: apex, right: left }, Self { apex: middle, left: right, right: apex }]
    }
}

fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1]]
}

/// What is stored of a vertex. A triangle that is split at a vertex is reached through that vertex's parents alone, so
/// each value includes those of the vertices below: errors and bounds are *nested* (Lindstrom and Pascucci 2002).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    /// The largest distance in metres between the triangles of the diamond, or of any below it, and the DEM's samples.
    pub error_m: f32,
    /// Lowest and highest sample inside of the nested bounds, in metres.
    pub heights_m: [f32; 2],
}

impl Node {
    /// Nothing: what is beyond the DEM, and what belongs to a coarser layer.
    const NONE: Self = Self { error_m: 0.0, heights_m: [f32::INFINITY, f32::NEG_INFINITY] };

    fn with(self, other: Self) -> Self {
        let ([low, high], [l, h]) = (self.heights_m, other.heights_m);
        Self { error_m: self.error_m.max(other.error_m), heights_m: [low.min(l), high.max(h)] }
    }
}

/// The vertices with one `half`: places whose column or row is an odd multiple of it and whose other is any multiple.
/// Row by row; a quarter of the places (both even) belongs to coarser layers and is not used.
struct Layer {
    size: [i32; 2],
    nodes: Vec<Node>,
}

/// All vertices over one DEM: 16 bytes a sample.
pub(crate) struct Hierarchy {
    /// The DEM's last column and row.
    last: [i32; 2],
    spacing_m: [f64; 2],
    /// Side of the root square in grid intervals, a power of 2.
    side: i32,
    /// Layer i has the vertices with `half` = 2^i.
    layers: Vec<Layer>,
    /// Lowest and highest sample of all.
    heights_m: [f32; 2],
}

impl Hierarchy {
    /// Measures the error of every triangle, from the finest to the two of the root.
    pub fn new(heightmap: &Heightmap) -> Self {
        let whole = SampleRect::whole(heightmap);
        let last = [whole.last.column as i32, whole.last.row as i32];
        let side = (last[0].max(last[1]) as u32).next_power_of_two() as i32;
        let heights_m = heightmap.height_range_m(whole.first, whole.last);
        let mut hierarchy = Self { last, spacing_m: heightmap.spacing_m(), side, layers: Vec::new(), heights_m };
        for layer in 0..side.ilog2() {
            hierarchy.add_layer(heightmap, 1 << layer);
        }
        hierarchy
    }

    /// The two triangles that hold all others.
    pub fn roots(&self) -> [RightTriangle; 2] {
        let (near, far) = (0, self.side);
        let [north_west, south_east] = [[near, near], [far, far]];
        [
            RightTriangle { apex: [near, far], left: south_east, right: north_west },
            RightTriangle { apex: [far, near], left: north_west, right: south_east },
        ]
    }

    /// Lowest and highest sample of all, in metres.
    pub fn heights_m(&self) -> [f32; 2] {
        self.heights_m
    }

    /// Whether a triangle, clamped, has no area left.
    pub fn is_beyond_the_rim(&self, triangle: &RightTriangle) -> bool {
        let beyond = |axis: usize| triangle.corners().iter().all(|corner| corner[axis] >= self.last[axis]);
        beyond(0) || beyond(1)
    }

    /// The sample of a vertex.
    pub fn sample(&self, point: Point) -> Sample {
        let [column, row] = [0, 1].map(|axis| point[axis].min(self.last[axis]) as u32);
        Sample { column, row }
    }

    /// What is stored of a vertex.
    pub fn node(&self, vertex: Point, half: i32) -> &Node {
        let layer = &self.layers[half.ilog2() as usize];
        &layer.nodes[layer.index(vertex, half).expect("a triangle on the DEM has its vertex in the lattice")]
    }

    /// A box around the samples of a vertex's diamond and of all diamonds below it. Those reach over its border: a
    /// square's by the diamonds of its sides, and so on, down to one interval.
    ///
    /// Deviation: boxes where Lindstrom and Pascucci have spheres. Sides are nested by comparisons alone, so that
    /// nothing is rounded: a vertex is never wanted without its parents, whatever the eye. And they are narrower.
    pub fn bounds_world(&self, vertex: Point, half: i32) -> Aabb {
        let reach = if is_square(vertex, half) { 3 * half - 1 } else { 2 * half - 1 };
        self.box_world(add(vertex, [-reach; 2]), add(vertex, [reach; 2]), self.node(vertex, half).heights_m)
    }

    /// A box around a triangle, and with it around all its descendants, whose samples are within the given heights.
    pub fn triangle_bounds_world(&self, triangle: &RightTriangle, heights_m: [f32; 2]) -> Aabb {
        let RightTriangle { apex, left, right } = triangle;
        let each = |pick: fn(i32, i32) -> i32| [0, 1].map(|i| pick(pick(apex[i], left[i]), right[i]));
        self.box_world(each(i32::min), each(i32::max), heights_m)
    }

    fn box_world(&self, first: Point, last: Point, heights_m: [f32; 2]) -> Aabb {
        let metres = |at: Point, axis: usize| at[axis].clamp(0, self.last[axis]) as f64 * self.spacing_m[axis];
        let [low_m, high_m] = heights_m.map(f64::from);
        Aabb { min: [metres(first, 0), low_m, metres(first, 1)], max: [metres(last, 0), high_m, metres(last, 1)] }
    }

    /// Edge vertices first: they are what is below the square vertices of their layer.
    fn add_layer(&mut self, heightmap: &Heightmap, half: i32) {
        let size = self.last.map(|last| 2 * (last as u32).div_ceil(2 * half as u32) as i32 + 1);
        self.layers.push(Layer { size, nodes: vec![Node::NONE; size[0] as usize * size[1] as usize] });
        for odd in [[1, 0], [0, 1], [1, 1]] {
            for row in (odd[1]..size[1]).step_by(2) {
                for column in (odd[0]..size[0]).step_by(2) {
                    let node = self.measure(heightmap, [column * half, row * half], half);
                    let layer = self.layers.last_mut().expect("just added");
                    layer.nodes[row as usize * size[0] as usize + column as usize] = node;
                }
            }
        }
    }

    /// The deviations of a vertex's own triangles, and all that is below.
    fn measure(&self, heightmap: &Heightmap, vertex: Point, half: i32) -> Node {
        let deviation_m = |triangle: RightTriangle| {
            let corners = triangle.corners().map(|corner| self.sample(corner));
            max_deviation_m(heightmap, corners, SampleRect::whole(heightmap))
        };
        let error_m = diamond(vertex, half).map(deviation_m).fold(0.0, f32::max);
        let heights_m = if half == 1 { self.heights_around(heightmap, vertex) } else { Node::NONE.heights_m };
        below(vertex, half)
            .filter_map(|(vertex, half)| self.get(vertex, half))
            .fold(Node { error_m, heights_m }, Node::with)
    }

    /// Of the samples next to a vertex of the finest layer.
    fn heights_around(&self, heightmap: &Heightmap, vertex: Point) -> [f32; 2] {
        let [first, last] = [-1, 1].map(|by| self.sample(add(vertex, [by; 2]).map(|coordinate| coordinate.max(0))));
        heightmap.height_range_m(first, last)
    }

    fn get(&self, vertex: Point, half: i32) -> Option<Node> {
        let layer = &self.layers[half.ilog2() as usize];
        layer.index(vertex, half).map(|index| layer.nodes[index])
    }
}

impl Layer {
    fn index(&self, vertex: Point, half: i32) -> Option<usize> {
        let [column, row] = vertex.map(|coordinate| coordinate >> half.ilog2());
        let inside = (0..self.size[0]).contains(&column) && (0..self.size[1]).contains(&row);
        inside.then(|| row as usize * self.size[0] as usize + column as usize)
    }
}

fn is_odd(coordinate: i32, half: i32) -> bool {
    coordinate & half != 0
}

/// Whether a vertex splits a square's diagonal, and not the side of a square.
fn is_square(vertex: Point, half: i32) -> bool {
    is_odd(vertex[0], half) && is_odd(vertex[1], half)
}

/// The triangles that are split at a vertex: two, or one on the root's northern and western sides.
fn diamond(vertex: Point, half: i32) -> impl Iterator<Item = RightTriangle> {
    let is_rising = is_odd(vertex[0], 2 * half) != is_odd(vertex[1], 2 * half);
    let [x, z] = match vertex.map(|coordinate| is_odd(coordinate, half)) {
        [true, true] if is_rising => [half, half],
        [true, true] => [half, -half],
        [true, false] => [0, half],
        _ => [half, 0],
    };
    let triangles = [[x, z], [-x, -z]].map(|to_apex| RightTriangle::around(vertex, to_apex));
    triangles.into_iter().filter(|triangle| triangle.apex.iter().all(|coordinate| *coordinate >= 0))
}

/// The vertices, with their `half`, that split the children of a vertex's diamond. Some may not exist.
fn below(vertex: Point, half: i32) -> impl Iterator<Item = (Point, i32)> {
    let quarter = half / 2;
    let (half_below, offsets) = match is_square(vertex, half) {
        true => (half, [[-half, 0], [half, 0], [0, -half], [0, half]]),
        false => (quarter, [[-quarter, -quarter], [quarter, -quarter], [-quarter, quarter], [quarter, quarter]]),
    };
    offsets.into_iter().filter(move |_| half_below > 0).map(move |offset| (add(vertex, offset), half_below))
}

#[cfg(test)]
pub(super) mod tests;
