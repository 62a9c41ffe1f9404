//! The watertightness oracle: topology of a mesh in exact integers.
//!
//! The signed area alone proves nothing (a mesh that folds over itself has the right one), so the edges are
//! checked as well: every directed edge at most once, and every inner one with its twin.
//!
//! A mesh that was culled has open edges where what is out of view begins. They are no cracks as long as nobody sees
//! them. What is a crack is an open edge that runs along *another* open edge (there is mesh on both sides, and it does
//! not match), and an open edge in view (there is nothing where something should be).
//!
//! ```text
//!   whole        T-junction: three        culled: one open edge,
//!   a---b        open edges overlap       no crack if out of view
//!   | / |        a-------b                a---b
//!   c---d        b---m   m---a            | /
//! ```

use glam::DVec3;

use crate::{Heightmap, Sample, Triangle, View};

/// What the oracle found. All counts are 0 for a sound mesh, but `open_edges` where it was culled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Watertightness {
    /// Open edges that overlap other open edges: T-junctions, gaps, overlapping triangles.
    pub mismatched_edges: u64,
    /// Directed edges that are used more than once.
    pub doubled_edges: u64,
    /// Triangles that run clockwise seen from above.
    pub inverted: u64,
    /// Triangles without area, of three different corners, that do not lie on the DEM's outline.
    pub stray_degenerate: u64,
    /// Edges inside the DEM without a twin, `mismatched_edges` included.
    pub open_edges: u64,
    /// Sum of the doubled signed areas, in grid intervals.
    pub doubled_area: i64,
    /// Ends of the first defect, for messages.
    pub first_defect: Option<[Sample; 2]>,
}

impl Watertightness {
    /// Defects of a mesh that may be culled, but for [open edges in view](WatertightOracle::open_edges_in_view).
    pub fn cracks(&self) -> u64 {
        self.mismatched_edges + self.doubled_edges + self.inverted + self.stray_degenerate
    }

    /// Whether the mesh is sound and covers a DEM of that many samples exactly once.
    pub fn covers(&self, columns: u32, rows: u32) -> bool {
        let whole = 2 * (columns as i64 - 1) * (rows as i64 - 1);
        self.cracks() == 0 && self.open_edges == 0 && self.doubled_area == whole
    }
}

/// An open edge may lie on the very plane of the frustum that its neighbour's box ends at.
const SLACK_M: f64 = 1e-6;

/// Checks meshes over a DEM of one size; keeps its memory from frame to frame.
pub struct WatertightOracle {
    columns: u32,
    rows: u32,
    /// Directed edges from a smaller to a larger sample index as `from << 32 | to`.
    ascending: Vec<u64>,
    /// The others, reversed: a twin has the same key here.
    descending: Vec<u64>,
    open: Vec<OpenEdge>,
}

impl WatertightOracle {
    /// For a DEM of that many samples.
    pub fn new(columns: u32, rows: u32) -> Self {
        Self { columns, rows, ascending: Vec::new(), descending: Vec::new(), open: Vec::new() }
    }

    /// Checks a mesh: its triangles, and those without area.
    pub fn check(&mut self, triangles: &[Triangle], degenerate: &[Triangle]) -> Watertightness {
        let mut found = Watertightness::default();
        self.collect_edges(triangles, &mut found);
        self.pair_edges(&mut found);
        self.match_open_edges(&mut found);
        for triangle in degenerate.iter().filter(|t| has_three_corners(t) && !self.on_outline(&t.samples)) {
            found.stray_degenerate += 1;
            found.first_defect.get_or_insert([triangle.samples[0], triangle.samples[1]]);
        }
        found
    }

    /// Open edges of the mesh checked last that a view shows, those left out that are mismatched already: holes.
    /// Culling may only leave out what is out of view.
    pub fn open_edges_in_view(&self, heightmap: &Heightmap, view: &View) -> u64 {
        let is_seen = |edge: &&OpenEdge| {
            let [a, b] = edge.ends.map(|sample| DVec3::from(heightmap.world(sample)));
            !edge.mismatched && view.sees_segment(a, b, SLACK_M)
        };
        self.open.iter().filter(is_seen).count() as u64
    }

    fn collect_edges(&mut self, triangles: &[Triangle], found: &mut Watertightness) {
        self.ascending.clear();
        self.descending.clear();
        for triangle in triangles {
            let area = triangle.doubled_area();
            found.doubled_area += area;
            if area < 0 {
                found.inverted += 1;
                found.first_defect.get_or_insert([triangle.samples[0], triangle.samples[1]]);
            }
            let corners = triangle.samples.map(|s| s.row as u64 * self.columns as u64 + s.column as u64);
            for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (corners[a], corners[b])) {
                if from < to {
                    self.ascending.push(from << 32 | to);
                } else {
                    self.descending.push(to << 32 | from);
                }
            }
        }
        self.ascending.sort_unstable();
        self.descending.sort_unstable();
    }

    /// Walks both sorted lists side by side: a key in one list alone is an open edge.
    fn pair_edges(&mut self, found: &mut Watertightness) {
        let (mut up, mut down) = (0, 0);
        self.open.clear();
        while up < self.ascending.len() || down < self.descending.len() {
            let next_up = self.ascending.get(up).copied().unwrap_or(u64::MAX);
            let next_down = self.descending.get(down).copied().unwrap_or(u64::MAX);
            let key = next_up.min(next_down);
            let ups = count_equal(&self.ascending[up..], key);
            let downs = count_equal(&self.descending[down..], key);
            (up, down) = (up + ups, down + downs);
            let ends = [self.sample(key >> 32), self.sample(key & 0xffff_ffff)];
            if ups > 1 || downs > 1 {
                found.doubled_edges += (ups.max(1) - 1 + downs.max(1) - 1) as u64;
                found.first_defect.get_or_insert(ends);
            }
            if (ups == 0 || downs == 0) && !self.on_outline(&ends) {
                found.open_edges += 1;
                self.open.push(OpenEdge::between(ends));
            }
        }
    }

    /// Two open edges on one line that share more than a point do not match.
    fn match_open_edges(&mut self, found: &mut Watertightness) {
        self.open.sort_unstable_by_key(|edge| (edge.line, edge.span));
        let mut start = 0;
        while start < self.open.len() {
            // A group of edges on one line whose spans overlap in a chain.
            let (line, mut reach) = (self.open[start].line, self.open[start].span.1);
            let mut end = start + 1;
            while end < self.open.len() && self.open[end].line == line && self.open[end].span.0 < reach {
                reach = reach.max(self.open[end].span.1);
                end += 1;
            }
            if end - start > 1 {
                found.mismatched_edges += (end - start) as u64;
                found.first_defect.get_or_insert(self.open[start].ends);
                self.open[start..end].iter_mut().for_each(|edge| edge.mismatched = true);
            }
            start = end;
        }
    }

    fn sample(&self, index: u64) -> Sample {
        Sample { column: (index % self.columns as u64) as u32, row: (index / self.columns as u64) as u32 }
    }

    /// Whether all of these samples lie on one and the same side of the DEM's outline.
    fn on_outline(&self, samples: &[Sample]) -> bool {
        samples.iter().all(|s| s.column == 0)
            || samples.iter().all(|s| s.column == self.columns - 1)
            || samples.iter().all(|s| s.row == 0)
            || samples.iter().all(|s| s.row == self.rows - 1)
    }
}

/// A triangle with two equal corners covers nothing, and its two edges are each other's twins. Index lists that are
/// shared by all patches make such triangles where a strip of a matching block is clamped to the rim.
fn has_three_corners(triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.samples;
    a != b && b != c && c != a
}

/// How often `key` stands at the front of a sorted slice.
fn count_equal(sorted: &[u64], key: u64) -> usize {
    sorted.iter().take_while(|k| **k == key).count()
}

/// An edge without twin, as a span on its line.
struct OpenEdge {
    /// Reduced direction (dx, dz) with dx > 0, or dx = 0 and dz > 0; and the line's offset, dx * row - dz * column.
    line: (i64, i64, i64),
    /// The ends along the direction: dx * column + dz * row, smaller first.
    span: (i64, i64),
    ends: [Sample; 2],
    mismatched: bool,
}

impl OpenEdge {
    fn between(ends: [Sample; 2]) -> Self {
        let [a, b] = ends.map(|s| (s.column as i64, s.row as i64));
        let (dx, dz) = (b.0 - a.0, b.1 - a.1);
        let scale = gcd(dx.abs(), dz.abs()) * if (dx, dz) > (0, 0) { 1 } else { -1 };
        let (dx, dz) = (dx / scale, dz / scale);
        let along = |p: (i64, i64)| dx * p.0 + dz * p.1;
        let (s, t) = (along(a), along(b));
        Self { line: (dx, dz, dx * a.1 - dz * a.0), span: (s.min(t), s.max(t)), ends, mismatched: false }
    }
}

fn gcd(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, Lens};

    /// Triangles from corners given as (column, row).
    fn mesh(corners: &[[(u32, u32); 3]]) -> Vec<Triangle> {
        let triangle = |t: &[(u32, u32); 3]| Triangle {
            samples: t.map(|(column, row)| Sample { column, row }),
            heights_m: [0.0; 3],
        };
        corners.iter().map(triangle).collect()
    }

    fn check(side: u32, corners: &[[(u32, u32); 3]]) -> Watertightness {
        let (degenerate, triangles): (Vec<_>, Vec<_>) = mesh(corners).into_iter().partition(|t| t.doubled_area() == 0);
        WatertightOracle::new(side, side).check(&triangles, &degenerate)
    }

    /// A 4 x 4 square, split along its falling diagonal.
    const LOWER: [(u32, u32); 3] = [(0, 0), (0, 4), (4, 4)];
    const UPPER: [(u32, u32); 3] = [(0, 0), (4, 4), (4, 0)];

    #[test]
    fn a_square_of_two_triangles_is_sound() {
        let found = check(5, &[LOWER, UPPER]);
        assert!(found.covers(5, 5), "{found:?}");
    }

    #[test]
    fn a_t_junction_is_found_also_when_culled() {
        let halves = [[(0, 0), (2, 2), (4, 0)], [(2, 2), (4, 4), (4, 0)]];
        let found = check(5, &[LOWER, halves[0], halves[1]]);
        assert_eq!((found.mismatched_edges, found.open_edges, found.doubled_area), (3, 3, 32));
        // With one half culled away, the other still does not match.
        assert_eq!(check(5, &[LOWER, halves[0]]).mismatched_edges, 2);
    }

    #[test]
    fn the_rim_of_a_culled_mesh_is_no_crack() {
        let found = check(5, &[LOWER]);
        assert_eq!((found.cracks(), found.open_edges), (0, 1));
        assert!(!found.covers(5, 5));
    }

    /// Found by a review: no sample is uncovered and no open edge overlaps another, and yet there is a hole.
    #[test]
    fn a_missing_triangle_is_seen_where_the_camera_looks() {
        let heightmap = Heightmap::new(9, 9, [1.0; 2], vec![0.0; 81]).unwrap();
        let quad = |c: u32, r: u32| [[(c, r), (c, r + 1), (c + 1, r)], [(c + 1, r), (c, r + 1), (c + 1, r + 1)]];
        let mut corners: Vec<_> = (0..64).flat_map(|i| quad(i % 8, i / 8)).collect();
        corners.remove(2 * (8 * 4 + 4));
        let mut oracle = WatertightOracle::new(9, 9);
        let found = oracle.check(&mesh(&corners), &[]);
        assert_eq!((found.cracks(), found.open_edges), (0, 3));
        let lens = Lens { fov_y: 0.2, size_px: [9, 9], near_m: 0.1 };
        let above = |x: f64, z: f64| {
            let camera = Camera { eye_world: DVec3::new(x, 9.0, z), heading: 0.0, pitch: -std::f64::consts::FRAC_PI_2 };
            View::new(&camera, &lens).unwrap()
        };
        assert_eq!(oracle.open_edges_in_view(&heightmap, &above(4.3, 4.3)), 3);
        assert_eq!(oracle.open_edges_in_view(&heightmap, &above(1.0, 1.0)), 0, "out of view it may have been culled");
    }

    #[test]
    fn a_fold_with_the_right_area_is_found() {
        // The inner vertex (2, 2) is used as if it stood at (3, 1): the sum of areas is still right.
        let folded =
            [[(0, 0), (0, 4), (4, 4)], [(0, 0), (4, 4), (3, 1)], [(3, 1), (4, 4), (4, 0)], [(0, 0), (3, 1), (4, 0)]];
        assert!(check(5, &folded).covers(5, 5), "a sound mesh with an inner vertex");
        let mut broken = folded;
        broken[1][2] = (0, 3);
        broken[3][1] = (0, 3);
        broken[2][0] = (0, 3);
        let found = check(5, &broken);
        assert_eq!(found.doubled_area, 32, "the area proves nothing");
        assert!(found.inverted > 0 && found.cracks() > 0, "{found:?}");
    }

    #[test]
    fn doubled_and_inverted_triangles_are_found() {
        assert_eq!(check(5, &[LOWER, UPPER, UPPER]).doubled_edges, 3);
        let found = check(5, &[LOWER, [(0, 0), (4, 0), (4, 4)]]);
        assert_eq!(found.inverted, 1);
    }

    #[test]
    fn degenerate_triangles_are_allowed_on_the_outline_alone() {
        assert!(check(5, &[LOWER, UPPER, [(0, 0), (2, 0), (4, 0)]]).covers(5, 5));
        assert_eq!(check(5, &[LOWER, UPPER, [(0, 1), (2, 1), (4, 1)]]).stray_degenerate, 1);
        assert!(check(5, &[LOWER, UPPER, [(0, 0), (0, 0), (4, 4)]]).covers(5, 5), "two equal corners are nothing");
    }

    #[test]
    fn edges_that_only_touch_or_run_parallel_match() {
        // Two triangles of a culled mesh meet at a point, end to end on one line; a third has a parallel edge.
        let found = check(9, &[[(1, 1), (1, 3), (3, 3)], [(3, 3), (3, 5), (5, 5)], [(2, 1), (4, 3), (4, 1)]]);
        assert_eq!(found.mismatched_edges, 0, "{found:?}");
    }
}
