//! The reference that bounded meshes are measured against (`benches/reference.rs`): it must be beyond doubt itself.

#[path = "../bounded/terrain.rs"]
mod terrain;

mod delaunay;
mod greedy;

use delaunay::{Delaunay, Point, doubled_area};
use greedy::Greedy;
use terrain_core::error::ErrorOracle;
use terrain_core::watertight::WatertightOracle;
use terrain_core::{Heightmap, Sample, SplitMix64};
use terrain_dem::synthetic;

/// The oracle's deviations are f32: it may see a deviation at the limit a ten-millionth above it. No other slack.
const ORACLE_ROUNDING: f64 = 1.000_000_1;

/// The deviations of all samples, in metres.
fn deviations_m(dem: &Heightmap, greedy: &Greedy) -> Vec<f32> {
    let mut oracle = ErrorOracle::new(dem);
    oracle.set_mesh(&greedy.triangles());
    let deviations_m = oracle.deviations_m().to_vec();
    assert!(deviations_m.iter().all(|d| !d.is_nan()), "a sample is not covered");
    deviations_m
}

/// Whether a point lies inside the circle through three others: by the circle's centre, exactly.
fn is_inside_circle([a, b, c]: [Point; 3], point: Point) -> bool {
    let from_a = |p: Point| [p[0] - a[0], p[1] - a[1]].map(i128::from);
    let square = |[x, z]: [i128; 2]| x * x + z * z;
    let (b, c, p) = (from_a(b), from_a(c), from_a(point));
    // The centre times `scale`, seen from a.
    let scale = 2 * (b[0] * c[1] - b[1] * c[0]);
    let centre = [c[1] * square(b) - b[1] * square(c), b[0] * square(c) - c[0] * square(b)];
    square([p[0] * scale - centre[0], p[1] * scale - centre[1]]) < square(centre)
}

/// No corner of any triangle lies in the circle of another: all against all.
fn assert_delaunay(triangles: &[[Point; 3]]) {
    let mut points: Vec<Point> = triangles.iter().flatten().copied().collect();
    points.sort_unstable();
    points.dedup();
    for triangle in triangles {
        assert!(doubled_area(*triangle) > 0, "{triangle:?}");
        let inside = points.iter().find(|p| is_inside_circle(*triangle, **p));
        assert_eq!(inside, None, "in the circle of {triangle:?}");
    }
}

fn corners(greedy: &Greedy) -> Vec<[Point; 3]> {
    let point = |s: Sample| [s.column as i64, s.row as i64];
    greedy.triangles().iter().map(|t| t.samples.map(point)).collect()
}

/// Refines to each tolerance in turn, from the coarsest on, and checks bound and topology.
fn check(dem: &Heightmap, tolerances_m: &[f64]) {
    let mut greedy = Greedy::new(dem);
    let mut before = 0;
    for tolerance_m in tolerances_m {
        greedy.refine(*tolerance_m);
        let worst_m = deviations_m(dem, &greedy).into_iter().fold(0.0, f32::max) as f64;
        assert!(worst_m <= tolerance_m * ORACLE_ROUNDING, "{worst_m} m at {tolerance_m} m");
        let found = WatertightOracle::new(dem.columns(), dem.rows()).check(&greedy.triangles(), &[]);
        assert!(found.covers(dem.columns(), dem.rows()), "{found:?}");
        assert!(greedy.triangle_count() >= before);
        before = greedy.triangle_count();
    }
}

#[test]
fn any_points_in_any_order_are_delaunay() {
    for seed in 0..200 {
        let mut random = SplitMix64::new(seed);
        let [width, depth] = [(); 2].map(|_| 1 + random.below(if seed % 4 == 0 { 5 } else { 30 }) as i64);
        let mut mesh = Delaunay::new(width, depth);
        for _ in 0..random.below(120) {
            let point = [random.below(width as u64 + 1) as i64, random.below(depth as u64 + 1) as i64];
            let holds = |[a, b, c]: &[Point; 3]| {
                [(a, b), (b, c), (c, a)].iter().all(|e| doubled_area([*e.0, *e.1, point]) >= 0)
            };
            let triangle = mesh.triangles().iter().position(holds).unwrap();
            if !mesh.triangles()[triangle].contains(&point) {
                let made = mesh.insert(point, triangle);
                assert!(made.iter().all(|t| mesh.triangles()[*t].contains(&point)), "seed {seed}");
            }
        }
        assert_delaunay(mesh.triangles());
        let area: i64 = mesh.triangles().iter().map(|t| doubled_area(*t)).sum();
        assert_eq!(area, 2 * width * depth, "seed {seed}");
    }
}

#[test]
fn the_next_sample_is_the_worst_of_all() {
    for seed in 0..8 {
        let mut random = SplitMix64::new(seed);
        let dem = terrain::dem(19, 23, |x, z| (x * z) as f64 + random.range(0.0, 40.0));
        let mut greedy = Greedy::new(&dem);
        while let Some(next) = greedy.worst() {
            let deviations_m = deviations_m(&dem, &greedy);
            let worst_m = deviations_m.iter().copied().fold(0.0, f32::max) as f64;
            let [column, row] = next.point.map(|i| i as u32);
            let at_next_m = deviations_m[dem.index(Sample { column, row }) as usize] as f64;
            assert!((next.deviation_m() - worst_m).abs() < 1e-5 && (at_next_m - worst_m).abs() < 1e-5, "seed {seed}");
            greedy.insert_worst();
            let corners = corners(&greedy);
            assert!(corners.iter().flatten().any(|p| *p == next.point));
        }
        assert_delaunay(&corners(&greedy));
        assert_eq!(greedy.triangle_count(), 2 * 18 * 22, "all samples are in");
    }
}

#[test]
fn meshes_are_watertight_delaunay_and_within_the_tolerance() {
    let dem = synthetic::generate(193, 150, 7);
    check(&dem, &[256.0, 64.0, 16.0, 4.0, 1.0, 0.01]);
    let mut greedy = Greedy::new(&dem);
    greedy.refine(10.0);
    assert!(greedy.triangle_count() > 500, "{} triangles", greedy.triangle_count());
    assert_delaunay(&corners(&greedy));
}

#[test]
fn real_terrain_is_watertight_and_within_the_tolerance() {
    for dem in ["ps_257_crop_rainier", "sthelens_30m_257"].into_iter().filter_map(terrain::shared) {
        check(&dem, &[128.0, 32.0, 8.0, 2.0, 0.5, 0.06]);
    }
}

#[test]
fn awkward_shapes_and_heights() {
    for (name, dem) in terrain::awkward() {
        println!("{name}");
        check(&dem, &[1000.0, 10.0, 0.5]);
    }
}
