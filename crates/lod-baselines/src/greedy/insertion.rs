//! Plain greedy insertion over a whole DEM.
//!
//! Algorithm III of Garland and Heckbert, "Fast polygonal approximation of terrains and height fields"
//! (CMU-CS-95-181, 1995): of all samples the one with the largest vertical deviation enters a Delaunay triangulation,
//! until none is farther off than the tolerance. A heap has the worst sample of each triangle. No patches, no edges,
//! no ladder.

use std::collections::BinaryHeap;

use terrain_core::{Heightmap, Sample, Triangle};

use super::delaunay::{Delaunay, MAX_COORDINATE, Point, TriangleId, doubled_area};

/// A mesh over a whole DEM that is refined step by step.
pub struct GreedyInsertion<'a> {
    heightmap: &'a Heightmap,
    mesh: Delaunay,
    /// The worst sample of each triangle; none where it fits all of its samples.
    worst: Vec<Option<Worst>>,
    /// The worst first. Holds also what waited for triangles that are no more: `worst` tells.
    waiting: BinaryHeap<(Worst, TriangleId)>,
}

/// The sample that a triangle is farthest from. Compares by the deviation first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Worst {
    /// The bits of a positive number of metres, which compare as the number does.
    deviation_m_bits: u64,
    point: Point,
}

impl Worst {
    fn deviation_m(&self) -> f64 {
        f64::from_bits(self.deviation_m_bits)
    }
}

impl<'a> GreedyInsertion<'a> {
    /// The longest side of a DEM in samples: with a longer one the in-circle test would overflow.
    pub const MAX_SIDE: u32 = MAX_COORDINATE as u32 + 1;

    /// The two triangles of the DEM's corners. Panics above [`Self::MAX_SIDE`] samples along a side.
    pub fn new(heightmap: &'a Heightmap) -> Self {
        let mesh = Delaunay::new(heightmap.columns() as i64 - 1, heightmap.rows() as i64 - 1);
        let mut greedy = Self { heightmap, mesh, worst: Vec::new(), waiting: BinaryHeap::new() };
        greedy.measure(&[0, 1]);
        greedy
    }

    /// Inserts samples until no sample is farther off than a tolerance in metres, above 0. The mesh is the same as
    /// that of a start from nothing: coarser tolerances come first anyway.
    pub fn refine(&mut self, tolerance_m: f64) {
        while self.worst().is_some_and(|worst| worst.deviation_m() > tolerance_m) {
            self.insert_worst();
        }
    }

    /// The sample that is farthest off, and by how many metres; none where every sample is met.
    pub fn worst_sample(&mut self) -> Option<(Sample, f64)> {
        self.worst().map(|worst| (sample(worst.point), worst.deviation_m()))
    }

    fn worst(&mut self) -> Option<Worst> {
        while let Some((worst, triangle)) = self.waiting.peek() {
            if self.worst[*triangle] == Some(*worst) {
                return Some(*worst);
            }
            self.waiting.pop();
        }
        None
    }

    /// Inserts the sample that is farthest off.
    pub fn insert_worst(&mut self) {
        let worst = self.worst();
        if let (Some(worst), Some((_, triangle))) = (worst, self.waiting.pop()) {
            let made = self.mesh.insert(worst.point, triangle);
            self.measure(&made);
        }
    }

    /// Triangles of the mesh.
    pub fn triangle_count(&self) -> usize {
        self.mesh.triangles().len()
    }

    /// The mesh, counter-clockwise seen from above.
    pub fn triangles(&self) -> Vec<Triangle> {
        let triangle = |corners: &[Point; 3]| {
            let samples = corners.map(sample);
            Triangle { samples, heights_m: samples.map(|s| self.heightmap.height_m(s)) }
        };
        self.mesh.triangles().iter().map(triangle).collect()
    }

    /// Lets new triangles wait for their worst samples.
    fn measure(&mut self, triangles: &[TriangleId]) {
        self.worst.resize(self.mesh.triangles().len(), None);
        for triangle in triangles {
            let worst = worst_of(self.heightmap, self.mesh.triangles()[*triangle]);
            self.worst[*triangle] = worst;
            self.waiting.extend(worst.map(|worst| (worst, *triangle)));
        }
    }
}

fn sample([column, row]: Point) -> Sample {
    Sample { column: column as u32, row: row as u32 }
}

/// The sample in a triangle, or on its sides, that it is farthest from.
fn worst_of(heightmap: &Heightmap, corners: [Point; 3]) -> Option<Worst> {
    let [a, b, c] = corners;
    let height_m = |[column, row]: Point| {
        heightmap.heights_m()[row as usize * heightmap.columns() as usize + column as usize] as f64
    };
    // Twice the area times the height above corner a is `by_column` a column and `by_row` a row.
    let area = doubled_area(corners) as f64;
    let (origin_m, rise_b, rise_c) = (height_m(a), height_m(b) - height_m(a), height_m(c) - height_m(a));
    let (by_b, by_c) = ([b[0] - a[0], b[1] - a[1]].map(|i| i as f64), [c[0] - a[0], c[1] - a[1]].map(|i| i as f64));
    let by_column = rise_c * by_b[1] - rise_b * by_c[1];
    let by_row = rise_b * by_c[0] - rise_c * by_b[0];

    let mut worst = (0.0, a);
    for row in a[1].min(b[1]).min(c[1])..=a[1].max(b[1]).max(c[1]) {
        let (first, last) = columns_of(corners, row);
        for column in first..=last {
            let plane = by_column * (column - a[0]) as f64 + by_row * (row - a[1]) as f64;
            let numerator = (plane - area * (height_m([column, row]) - origin_m)).abs();
            if numerator > worst.0 {
                worst = (numerator, [column, row]);
            }
        }
    }
    let (numerator, point) = worst;
    // Where a corner is the worst, all is rounding.
    let found = !corners.contains(&point);
    found.then(|| Worst { deviation_m_bits: (numerator / area).to_bits(), point })
}

/// First and last column of a row's samples in a counter-clockwise triangle; the range may be empty.
fn columns_of([a, b, c]: [Point; 3], row: i64) -> (i64, i64) {
    let (mut first, mut last) = (i64::MIN, i64::MAX);
    for (from, to) in [(a, b), (b, c), (c, a)] {
        // A sample is on the inner side where `side + rise * column` is not negative.
        let rise = to[1] - from[1];
        let side = doubled_area([from, to, [0, row]]);
        if rise > 0 {
            first = first.max(-side.div_euclid(rise));
        } else if rise < 0 {
            last = last.min(side.div_euclid(-rise));
        }
    }
    (first, last)
}
