//! Cuts a mesh along the sides of void quads, where the renderer ends it too.
//!
//! ```text
//!  o───────────o───────────o        o───o───────o───────────o
//!  │ ╲         ╱    x │ x  │        │ ╲ │ ╲   ╱ │           │     x  a void quad
//!  │    ╲     ╱       │    │        │   │  ╲ ╱──o           o
//!  │  A    ╲ ╱  B     │    │   to   │   │   ╳   │           │
//!  o────────o─────────o────o        o───o───o───o───────────o
//! ```
//!
//! A triangle that covers ground and voids becomes its parts in each quad of ground: the surface is the same, seen quad by
//! quad. Its sides get corners where they cross the lines between quads, and so do its neighbours, which are else as they
//! were: what was watertight stays so up to the voids. Places are exact, and each has one height.

mod place;

use std::collections::HashMap;

use terrain_core::{Heightmap, Sample, Triangle, VoidQuads};

pub use place::Place;
use place::{Axis, turn};

/// A part of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Turned as the triangle was.
    pub corners: [Place; 3],
    pub heights_m: [f32; 3],
}

/// A mesh without its voids.
#[derive(Debug, Default)]
pub struct Cut {
    /// As they were.
    pub whole: Vec<Triangle>,
    /// Of those that were cut, and of their neighbours.
    pub parts: Vec<Part>,
    /// How many triangles covered nothing but voids.
    pub left_out: usize,
    /// How many covered ground and voids.
    pub cut: usize,
}

/// A mesh that covers each place once at most; with no voids it stays as it is.
pub fn along_voids(heightmap: &Heightmap, triangles: Vec<Triangle>) -> Cut {
    let Some(quads) = heightmap.voids().map(VoidQuads::of) else {
        return Cut { whole: triangles, ..Cut::default() };
    };
    let (at_voids, beside): (Vec<_>, Vec<_>) = triangles.into_iter().partition(|triangle| quads.reach_into(triangle));
    let (mut cut, mut crossings) = (Cut::default(), HashMap::new());
    for triangle in at_voids {
        if quads.contain(&triangle) {
            cut.left_out += 1;
            continue;
        }
        cut.cut += 1;
        crossings.extend(sides(&triangle).map(|side| (side, crossings_of(side))));
        for quad in VoidQuads::covered_by(&triangle).filter(|[column, row]| !quads.is_void(*column, *row)) {
            cut.push(&triangle, part_in(&triangle, quad));
        }
    }
    for triangle in beside {
        let has_crossings = |side: &[Sample; 2]| crossings.get(side).is_some_and(|places| !places.is_empty());
        match sides(&triangle).iter().any(has_crossings) {
            true => cut.push(&triangle, with_crossings(&triangle, &crossings)),
            false => cut.whole.push(triangle),
        }
    }
    cut
}

impl Cut {
    /// Adds a convex part of a triangle.
    fn push(&mut self, triangle: &Triangle, polygon: Vec<Place>) {
        let parts = triangulate(polygon);
        self.parts.extend(
            parts
                .into_iter()
                .map(|corners| Part { corners, heights_m: corners.map(|corner| height_m(triangle, corner)) }),
        );
    }
}

/// The three sides, the ends of each in one order for both triangles that have it.
fn sides(triangle: &Triangle) -> [[Sample; 2]; 3] {
    let [a, b, c] = triangle.samples;
    [[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)])
}

/// Where a side crosses the lines between quads, from its first end on; without its ends.
fn crossings_of([from, to]: [Sample; 2]) -> Vec<Place> {
    let [first, last] = [from, to].map(Place::from);
    let between = |a: u32, b: u32| a.min(b) + 1..a.max(b);
    let columns = between(from.column, to.column).map(|line| first.crossing(last, Axis::Column, line));
    let rows = between(from.row, to.row).map(|line| first.crossing(last, Axis::Row, line));
    let mut all: Vec<Place> = columns.chain(rows).collect();
    // Crossings of one line are at least 1 / 65535 apart, which floats can tell.
    let how_far = |place: &Place| {
        let [x, z] = place.at();
        (x - from.column as f64).abs() + (z - from.row as f64).abs()
    };
    all.sort_by(|a, b| how_far(a).total_cmp(&how_far(b)));
    all.dedup();
    all
}

/// What a triangle covers of a quad: clipped at the quad's four sides.
fn part_in(triangle: &Triangle, [column, row]: [u32; 2]) -> Vec<Place> {
    let sides =
        [(Axis::Column, column, 1), (Axis::Column, column + 1, -1), (Axis::Row, row, 1), (Axis::Row, row + 1, -1)];
    sides.into_iter().fold(triangle.samples.map(Place::from).to_vec(), |polygon, (axis, line, inwards)| {
        let mut clipped = Vec::with_capacity(polygon.len() + 1);
        for (i, &from) in polygon.iter().enumerate() {
            let to = polygon[(i + 1) % polygon.len()];
            let [here, there] = [from, to].map(|place| place.beyond(axis, line) * inwards);
            if here >= 0 {
                clipped.push(from);
            }
            if here.signum() * there.signum() < 0 {
                clipped.push(from.crossing(to, axis, line));
            }
        }
        clipped
    })
}

/// A triangle with the corners that its sides have got.
fn with_crossings(triangle: &Triangle, crossings: &HashMap<[Sample; 2], Vec<Place>>) -> Vec<Place> {
    let mut polygon = Vec::new();
    for (from, side) in triangle.samples.into_iter().zip(sides(triangle)) {
        polygon.push(Place::from(from));
        let places = crossings.get(&side).map_or(&[][..], Vec::as_slice);
        match side[0] == from {
            true => polygon.extend(places),
            false => polygon.extend(places.iter().rev()),
        }
    }
    polygon
}

/// Cuts ears off a convex polygon, whose corners may lie on the line between their neighbours. An ear is cut only where
/// some area is left behind it.
fn triangulate(mut polygon: Vec<Place>) -> Vec<[Place; 3]> {
    let mut triangles = Vec::new();
    while polygon.len() > 3 {
        let ear = (0..polygon.len()).find(|at| {
            let is_ear = turn(around(&polygon, *at)) > 0;
            is_ear && {
                let rest: Vec<Place> = [&polygon[..*at], &polygon[at + 1..]].concat();
                (0..rest.len()).any(|at| turn(around(&rest, at)) > 0)
            }
        });
        let ear = ear.expect("a convex polygon of four corners has an ear");
        triangles.push(around(&polygon, ear));
        polygon.remove(ear);
    }
    if let Ok(last) = <[Place; 3]>::try_from(polygon) {
        triangles.push(last);
    }
    triangles
}

/// A corner between its neighbours.
fn around(polygon: &[Place], at: usize) -> [Place; 3] {
    let count = polygon.len();
    [polygon[(at + count - 1) % count], polygon[at], polygon[(at + 1) % count]]
}

/// The height of a triangle at a place. On its sides it depends on their ends alone, so that neighbours agree.
fn height_m(triangle: &Triangle, place: Place) -> f32 {
    let height_of = |sample: Sample| {
        let corner = triangle.samples.iter().position(|corner| *corner == sample);
        triangle.heights_m[corner.expect("a corner of the triangle")]
    };
    if let Some(sample) = place.sample().filter(|sample| triangle.samples.contains(sample)) {
        return height_of(sample);
    }
    let [a, b, c] = triangle.samples.map(Place::from);
    if let Some([from, to]) =
        sides(triangle).into_iter().find(|[from, to]| turn([(*from).into(), (*to).into(), place]) == 0)
    {
        let share = share(from, to, place);
        return (height_of(from) as f64 * (1.0 - share) + height_of(to) as f64 * share) as f32;
    }
    let weights = [turn([place, b, c]), turn([a, place, c]), turn([a, b, place])].map(|turn| turn as f64);
    let sum: f64 = weights.iter().sum();
    let weighted = weights.iter().zip(triangle.heights_m).map(|(weight, height_m)| weight / sum * height_m as f64);
    weighted.sum::<f64>() as f32
}

/// How much of the way from one sample to another a place on it has behind it.
fn share(from: Sample, to: Sample, place: Place) -> f64 {
    let [x, z] = place.at();
    let [from, to] = [from, to].map(|sample| [sample.column as f64, sample.row as f64]);
    match from[0] == to[0] {
        true => (z - from[1]) / (to[1] - from[1]),
        false => (x - from[0]) / (to[0] - from[0]),
    }
}

#[cfg(test)]
mod tests;
