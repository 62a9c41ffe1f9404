//! The hierarchy against a plain recursion, its errors against brute force, and its meshes for every set of vertices.

use std::collections::{BTreeMap, BTreeSet};

use super::*;
use crate::rqt::refine::Refinement;
use terrain_core::walk::RandomWalk;
use terrain_core::watertight::WatertightOracle;
use terrain_core::{SplitMix64, Triangle};

fn rough_dem(columns: u32, rows: u32, seed: u64) -> Heightmap {
    let mut random = SplitMix64::new(seed);
    let heights = (0..columns * rows).map(|_| random.range(0.0, 50.0) as f32).collect();
    Heightmap::new(columns, rows, [10.0, 12.0], heights).unwrap()
}

/// Every triangle of the hierarchy by plain recursion: corners, the middle of the first two, and its parent's middle.
fn every_triangle(side: i32, visit: &mut impl FnMut([Point; 3], Point, Option<Point>)) {
    fn split([a, b, apex]: [Point; 3], above: Option<Point>, visit: &mut impl FnMut([Point; 3], Point, Option<Point>)) {
        if (a[0] + b[0]) % 2 != 0 || (a[1] + b[1]) % 2 != 0 {
            return;
        }
        let middle = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
        visit([a, b, apex], middle, above);
        split([a, apex, middle], Some(middle), visit);
        split([apex, b, middle], Some(middle), visit);
    }
    split([[0, 0], [side, side], [side, 0]], None, visit);
    split([[0, 0], [side, side], [0, side]], None, visit);
}

/// Barycentric weights at every sample of the DEM, either way round: nothing shared with the walk over rows.
fn brute_force_m(dem: &Heightmap, corners: [Point; 3]) -> f64 {
    let last = [dem.columns() as i32 - 1, dem.rows() as i32 - 1];
    let samples = corners.map(|[x, z]| Sample { column: x.min(last[0]) as u32, row: z.min(last[1]) as u32 });
    let doubled_area = |samples| Triangle { samples, heights_m: [0.0; 3] }.doubled_area();
    let [a, b, c] = samples;
    let area = doubled_area(samples);
    let all = (0..dem.rows()).flat_map(|row| (0..dem.columns()).map(move |column| Sample { column, row }));
    let deviation_m = |p: Sample| {
        let weights = [[p, b, c], [a, p, c], [a, b, p]].map(|of| doubled_area(of) * area.signum());
        let sum: f64 = weights.iter().zip(samples).map(|(w, v)| *w as f64 * dem.height_m(v) as f64).sum();
        let covered = weights.iter().all(|weight| *weight >= 0);
        covered.then(|| (sum / area.abs() as f64 - dem.height_m(p) as f64).abs())
    };
    if area == 0 { 0.0 } else { all.filter_map(deviation_m).fold(0.0, f64::max) }
}

#[test]
fn errors_are_the_largest_of_all_triangles_below_by_brute_force() {
    for (seed, [columns, rows]) in
        [[9, 9], [17, 17], [2, 9], [12, 7], [10, 17], [18, 5], [3, 3]].into_iter().enumerate()
    {
        let dem = rough_dem(columns, rows, seed as u64);
        let hierarchy = Hierarchy::new(&dem);
        let mut own: BTreeMap<Point, f64> = BTreeMap::new();
        let mut vertices_below: BTreeMap<Point, BTreeSet<Point>> = BTreeMap::new();
        let mut halves: BTreeMap<Point, i32> = BTreeMap::new();
        every_triangle(hierarchy.side, &mut |corners, middle, above| {
            let [left, right, apex] = corners;
            if hierarchy.is_beyond_the_rim(&RightTriangle { apex, left, right }) {
                return;
            }
            let error = own.entry(middle).or_default();
            *error = error.max(brute_force_m(&dem, corners));
            let extent = |axis: usize| (corners[0][axis] - corners[1][axis]).abs();
            halves.insert(middle, extent(0).max(extent(1)) / 2);
            if let Some(above) = above {
                vertices_below.entry(above).or_default().insert(middle);
            }
        });
        // By falling `half`, edge vertices after square ones: what is below comes first when this is reversed.
        let mut order: Vec<Point> = own.keys().copied().collect();
        order.sort_by_key(|v| (halves[v], v[0] & halves[v] != 0 && v[1] & halves[v] != 0));
        let mut nested: BTreeMap<Point, f64> = BTreeMap::new();
        for vertex in order {
            let below = vertices_below.get(&vertex).into_iter().flatten().map(|v| nested[v]);
            let expected = below.fold(own[&vertex], f64::max);
            nested.insert(vertex, expected);
            let found = hierarchy.node(vertex, halves[&vertex]).error_m as f64;
            assert!((found - expected).abs() < 1e-4, "{columns} x {rows}, {vertex:?}: {found} for {expected}");
        }
    }
}

#[test]
fn nested_bounds_hold_the_diamond_and_all_bounds_below() {
    let holds =
        |outer: &Aabb, inner: &Aabb| (0..3).all(|i| outer.min[i] <= inner.min[i] && outer.max[i] >= inner.max[i]);
    let mut checked = 0;
    for (seed, [columns, rows]) in [[17, 17], [12, 7], [2, 9], [23, 33]].into_iter().enumerate() {
        let dem = rough_dem(columns, rows, seed as u64);
        let hierarchy = Hierarchy::new(&dem);
        every_triangle(hierarchy.side, &mut |corners, middle, _| {
            let triangle = RightTriangle { left: corners[0], right: corners[1], apex: corners[2] };
            if hierarchy.is_beyond_the_rim(&triangle) {
                return;
            }
            let bounds = hierarchy.bounds_world(middle, triangle.half());
            let samples = corners.map(|corner| hierarchy.sample(corner));
            let end = |pick: fn(u32, u32) -> u32| Sample {
                column: samples.iter().map(|s| s.column).reduce(pick).unwrap(),
                row: samples.iter().map(|s| s.row).reduce(pick).unwrap(),
            };
            let rectangle = dem.bounds_world(end(u32::min), end(u32::max));
            assert!(holds(&bounds, &rectangle), "{columns} x {rows}, {corners:?}");
            for (vertex, half) in below(middle, triangle.half()).filter(|(v, h)| hierarchy.get(*v, *h).is_some()) {
                let node = hierarchy.node(vertex, half);
                if node.heights_m[0] <= node.heights_m[1] {
                    assert!(holds(&bounds, &hierarchy.bounds_world(vertex, half)), "{middle:?} and {vertex:?}");
                    checked += 1;
                }
            }
        });
    }
    assert!(checked > 1_000, "{checked}");
}

/// A hierarchy in which exactly the given vertices are wanted, whatever the view.
fn wanting(dem: &Heightmap, vertices: &BTreeSet<Point>) -> Hierarchy {
    let mut hierarchy = Hierarchy::new(dem);
    for (i, layer) in hierarchy.layers.iter_mut().enumerate() {
        for (at, node) in layer.nodes.iter_mut().enumerate() {
            let [column, row] = [at as i32 % layer.size[0], at as i32 / layer.size[0]];
            let wanted = vertices.contains(&[column << i, row << i]);
            node.error_m = if wanted { f32::INFINITY } else { 0.0 };
        }
    }
    hierarchy
}

fn assert_covers(dem: &Heightmap, vertices: &BTreeSet<Point>) {
    let hierarchy = wanting(dem, vertices);
    let view = RandomWalk::new(1, dem).next().unwrap();
    let mut indices = Vec::new();
    let mut refinement = Refinement {
        hierarchy: &hierarchy,
        view: &view,
        tolerance_px: 1.0,
        columns: dem.columns(),
        indices: &mut indices,
    };
    refinement.run(false);
    let sample = |index: u32| Sample { column: index % dem.columns(), row: index / dem.columns() };
    let triangle = |corners: &[u32]| Triangle { samples: [0, 1, 2].map(|i| sample(corners[i])), heights_m: [0.0; 3] };
    let triangles: Vec<Triangle> = indices.chunks(3).map(triangle).collect();
    assert!(triangles.iter().all(|triangle| triangle.doubled_area() > 0), "{vertices:?}");
    let found = WatertightOracle::new(dem.columns(), dem.rows()).check(&triangles, &[]);
    assert!(found.covers(dem.columns(), dem.rows()), "{} x {}, {vertices:?}: {found:?}", dem.columns(), dem.rows());
}

/// The vertices of a root square, those above before those below, each with the vertices that it needs.
fn vertices_with_parents(side: i32) -> Vec<(Point, BTreeSet<Point>)> {
    let mut parents: BTreeMap<Point, BTreeSet<Point>> = BTreeMap::new();
    every_triangle(side, &mut |_, middle, above| parents.entry(middle).or_default().extend(above));
    let depth = |vertex: &Point| {
        let mut depth = 0;
        let mut at = *vertex;
        while let Some(parent) = parents[&at].first() {
            (at, depth) = (*parent, depth + 1);
        }
        depth
    };
    let mut all: Vec<_> = parents.iter().map(|(vertex, above)| (*vertex, above.clone())).collect();
    all.sort_by_key(|(vertex, _)| depth(vertex));
    all
}

/// Calls `check` with each set of vertices that holds the parents of all its members.
fn every_closed_set(
    rest: &[(Point, BTreeSet<Point>)],
    set: &mut BTreeSet<Point>,
    check: &mut impl FnMut(&BTreeSet<Point>),
) {
    let Some(((vertex, parents), rest)) = rest.split_first() else {
        return check(set);
    };
    every_closed_set(rest, set, check);
    if parents.is_subset(set) {
        set.insert(*vertex);
        every_closed_set(rest, set, check);
        set.remove(vertex);
    }
}

#[test]
fn every_set_of_vertices_over_every_dem_of_up_to_five_samples_a_side_is_watertight() {
    let mut meshes = 0;
    for (columns, rows) in (2..=5).flat_map(|columns| (2..=5).map(move |rows| (columns, rows))) {
        let dem = rough_dem(columns, rows, 1);
        let side = Hierarchy::new(&dem).side;
        every_closed_set(&vertices_with_parents(side), &mut BTreeSet::new(), &mut |set| {
            assert_covers(&dem, set);
            meshes += 1;
        });
    }
    assert!(meshes > 10_000, "{meshes}");
}

#[test]
fn random_sets_of_vertices_over_every_dem_of_up_to_twenty_samples_a_side_are_watertight() {
    for (columns, rows) in (2..=20).flat_map(|columns| (2..=20).map(move |rows| (columns, rows))) {
        let dem = rough_dem(columns, rows, 1);
        let vertices = vertices_with_parents(Hierarchy::new(&dem).side);
        let seed = (columns * 100 + rows) as u64;
        let mut random = SplitMix64::new(seed);
        for _ in 0..8 {
            let share = 50 + random.below(50);
            let mut set = BTreeSet::new();
            for (vertex, parents) in &vertices {
                if parents.is_subset(&set) && random.below(100) < share {
                    set.insert(*vertex);
                }
            }
            assert_covers(&dem, &set);
        }
    }
}
