use std::collections::HashSet;
use std::sync::Arc;

use terrain_core::{SplitMix64, VoidMask};

use super::*;

const SIDE: u32 = 17;

fn sample(column: u32, row: u32) -> Sample {
    Sample { column, row }
}

/// Rough ground with one sample in a few void, and one of them at least.
fn ground(seed: u64, one_in: u64) -> Heightmap {
    let mut random = SplitMix64::new(seed);
    let heights_m = (0..SIDE * SIDE).map(|_| random.range(0.0, 50.0) as f32).collect();
    let mut flags: Vec<bool> = (0..SIDE * SIDE).map(|_| random.below(one_in) == 0).collect();
    flags[seed as usize] = true;
    let map = Heightmap::new(SIDE, SIDE, [10.0, 20.0], heights_m).unwrap();
    map.with_voids(Arc::new(VoidMask::of_flags(SIDE, &flags))).unwrap()
}

/// A mesh of random shape over the whole grid: fans around inner samples of squares, each square cut at one of its samples.
fn mesh(map: &Heightmap, seed: u64) -> Vec<Triangle> {
    let mut random = SplitMix64::new(seed);
    let mut triangles = vec![
        [sample(0, 0), sample(0, SIDE - 1), sample(SIDE - 1, SIDE - 1)],
        [sample(0, 0), sample(SIDE - 1, SIDE - 1), sample(SIDE - 1, 0)],
    ];
    for _ in 0..12 {
        let middle = sample(random.below(SIDE.into()) as u32, random.below(SIDE.into()) as u32);
        triangles = triangles.into_iter().flat_map(|corners| split(corners, middle)).collect();
    }
    let heights_m = |corners: [Sample; 3]| corners.map(|corner| map.height_m(corner));
    triangles.into_iter().map(|samples| Triangle { samples, heights_m: heights_m(samples) }).collect()
}

/// A triangle, or its parts around a sample in it or on its sides.
fn split(corners: [Sample; 3], middle: Sample) -> Vec<[Sample; 3]> {
    let parts = [0, 1, 2].map(|at| {
        let mut part = corners;
        part[at] = middle;
        part
    });
    let areas = parts.map(|part| turn(part.map(Place::from)));
    if areas.iter().any(|area| *area < 0) || corners.contains(&middle) {
        return vec![corners];
    }
    parts.into_iter().zip(areas).filter(|(_, area)| *area > 0).map(|(part, _)| part).collect()
}

fn all_parts(cut: &Cut) -> Vec<[Place; 3]> {
    let whole = cut.whole.iter().map(|triangle| triangle.samples.map(Place::from));
    whole.chain(cut.parts.iter().map(|part| part.corners)).collect()
}

fn area([a, b, c]: [Place; 3]) -> f64 {
    let [a, b, c] = [a, b, c].map(Place::at);
    0.5 * ((c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1]))
}

/// Whether a side lies on the outline of the DEM or of a void quad.
fn is_at_an_end(quads: &VoidQuads, [from, to]: [Place; 2]) -> bool {
    let [[x0, z0], [x1, z1]] = [from.at(), to.at()];
    let last = (SIDE - 1) as f64;
    let is_void =
        |x: f64, z: f64| !(0.0..last).contains(&x) || !(0.0..last).contains(&z) || quads.is_void(x as u32, z as u32);
    let (x, z) = ((x0 + x1) / 2.0, (z0 + z1) / 2.0);
    (x0 == x1 && x0.fract() == 0.0 && (is_void(x - 0.5, z) || is_void(x, z)))
        || (z0 == z1 && z0.fract() == 0.0 && (is_void(x, z - 0.5) || is_void(x, z)))
}

#[test]
fn the_ground_is_covered_once_and_stays_watertight() {
    let mut cuts = 0;
    for seed in 0..150 {
        let map = ground(seed, 4 + 12 * (seed % 8));
        let quads = VoidQuads::of(map.voids().unwrap());
        let triangles = mesh(&map, seed);
        let all = triangles.len();
        let cut = along_voids(&map, triangles);
        assert!(cut.whole.len() + cut.cut + cut.left_out <= all, "neighbours are counted nowhere");
        cuts += cut.cut;

        let parts = all_parts(&cut);
        assert!(parts.iter().all(|part| turn(*part) > 0), "seed {seed}");
        let ground = (0..SIDE - 1).flat_map(|row| (0..SIDE - 1).map(move |column| (column, row)));
        let ground = ground.filter(|(column, row)| !quads.is_void(*column, *row)).count() as f64;
        let covered: f64 = parts.iter().map(|part| area(*part)).sum();
        assert!((covered - ground).abs() < 1e-6, "seed {seed}: {covered} of {ground}");

        let directed = |part: &[Place; 3]| [[part[0], part[1]], [part[1], part[2]], [part[2], part[0]]];
        let sides: HashSet<[Place; 2]> = parts.iter().flat_map(directed).collect();
        assert_eq!(sides.len(), parts.len() * 3, "seed {seed}: no side twice");
        for [from, to] in &sides {
            let is_matched = sides.contains(&[*to, *from]);
            assert!(is_matched || is_at_an_end(&quads, [*from, *to]), "seed {seed}: {from:?} to {to:?}");
        }
    }
    assert!(cuts > 500, "{cuts}");
}

#[test]
fn the_surface_stays_where_it_was_and_each_place_has_one_height() {
    for seed in 0..50 {
        let map = ground(seed, 20);
        let triangles = mesh(&map, seed);
        let cut = along_voids(&map, triangles.clone());
        let mut heights = HashMap::new();
        for (corner, height_m) in cut.parts.iter().flat_map(|part| part.corners.into_iter().zip(part.heights_m)) {
            assert_eq!(*heights.entry(corner).or_insert(height_m), height_m, "seed {seed}: {corner:?}");
        }
        for (place, found_m) in heights {
            let covers = |triangle: &&Triangle| {
                let [a, b, c] = triangle.samples.map(Place::from);
                [[a, b, place], [b, c, place], [c, a, place]].iter().all(|corners| turn(*corners) >= 0)
            };
            let under = triangles.iter().find(covers).expect("a triangle under each place");
            assert!((height_m(under, place) - found_m).abs() < 1e-4, "seed {seed}: {place:?}");
        }
    }
}

#[test]
fn without_voids_nothing_is_cut() {
    let map = Heightmap::new(SIDE, SIDE, [10.0; 2], vec![0.0; (SIDE * SIDE) as usize]).unwrap();
    let triangles = mesh(&map, 1);
    let cut = along_voids(&map, triangles.clone());
    assert_eq!((cut.whole, cut.parts.len(), cut.left_out, cut.cut), (triangles, 0, 0, 0));
}
