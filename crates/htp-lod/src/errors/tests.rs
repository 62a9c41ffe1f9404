//! Every stored error against brute force: barycentric weights in floats, over all samples of the DEM.

use super::*;
use crate::border::sides_of;
use crate::options::Options;
use terrain_core::{Sample, SplitMix64};

fn rough(columns: u32, rows: u32, seed: u64) -> Heightmap {
    let mut random = SplitMix64::new(seed);
    let heights = (0..columns * rows).map(|_| random.range(-100.0, 3000.0) as f32).collect();
    Heightmap::new(columns, rows, [30.0, 20.0], heights).unwrap()
}

/// The largest deviation of some triangles from all samples that lie in them. Shares nothing with `deviation`.
fn brute_force_m(heightmap: &Heightmap, grid: &Grid, patch: Patch, mask: u8) -> f64 {
    let local = local_vertices(grid.k);
    let map = grid.instance(patch);
    let mut largest = 0.0_f64;
    for triangle in index_list(grid.k, mask) {
        let corners = triangle.map(|i| map.sample(local[i as usize], heightmap.columns(), heightmap.rows()));
        let [a, b, c] = corners.map(|s| [s.column as f64, s.row as f64]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if area == 0.0 {
            continue;
        }
        for i in 0..heightmap.heights_m().len() as u32 {
            let at = Sample { column: i % heightmap.columns(), row: i / heightmap.columns() };
            let p = [at.column as f64, at.row as f64];
            let beta = ((p[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (p[1] - a[1])) / area;
            let gamma = ((b[0] - a[0]) * (p[1] - a[1]) - (p[0] - a[0]) * (b[1] - a[1])) / area;
            let weights = [1.0 - beta - gamma, beta, gamma];
            if weights.iter().all(|weight| *weight > -1e-9) {
                let mesh_m: f64 = (0..3).map(|i| weights[i] * heightmap.height_m(corners[i]) as f64).sum();
                largest = largest.max((mesh_m - heightmap.height_m(at) as f64).abs());
            }
        }
    }
    largest
}

/// The definition of a patch's error, straight down the hierarchy: itself and all below it; both halves of a square
/// that crosses the rim.
fn plain_m(heightmap: &Heightmap, grid: &Grid, patch: Patch) -> f64 {
    if patch.square.level == 0 {
        return 0.0;
    }
    let of = |patch: Patch| {
        let children = grid.children(patch.square).flat_map(|square| Half::BOTH.map(|half| square.half(half)));
        let children = children.filter(|child| grid.parent(*child) == Some(patch));
        let below = children.map(|child| plain_m(heightmap, grid, child));
        below.fold(brute_force_m(heightmap, grid, patch, 0), f64::max)
    };
    let other = patch.square.half(patch.half.other());
    if grid.crosses_rim(patch.square) { of(patch).max(of(other)) } else { of(patch) }
}

/// By less than a step, and a share of that.
fn assert_rounded_up(table: &ErrorTable, steps: u16, error_m: f64, share: f64, what: &str) {
    let stored_m = steps as f64 * table.step_m();
    let slack_m = 1e-6 * table.step_m();
    let largest_m = (error_m + table.step_m()) * (1.0 + share);
    assert!(stored_m >= error_m - slack_m && stored_m <= largest_m + slack_m, "{what}: {steps}, {error_m}");
}

#[test]
fn every_error_is_that_of_brute_force_rounded_up() {
    let mut compared = [0; 8];
    for (columns, rows, k, layers) in
        [(17, 17, 2, 3), (19, 10, 3, 2), (30, 29, 3, 3), (17, 22, 4, 2), (26, 13, 5, 2), (2, 9, 2, 3)]
    {
        let seed = (columns * rows * k) as u64;
        let heightmap = rough(columns, rows, seed);
        let grid = Grid::new(&heightmap, &Options { k, layers, ..Options::default() });
        let table = ErrorTable::new(&heightmap, &grid);
        for parent in
            (1..layers).flat_map(|level| grid.squares(level)).flat_map(|s| Half::BOTH.map(|half| s.half(half)))
        {
            let what = format!("{columns} x {rows}, k {k}, seed {seed}, {parent:?}");
            assert_rounded_up(&table, table.plain(&grid, parent), plain_m(&heightmap, &grid, parent), 0.0, &what);
            compared[0] += 1;
            for (child, patch) in table.border.touching(&grid, parent, ALL_COLLAPSED) {
                let plain_m = plain_m(&heightmap, &grid, patch);
                for mask in child.masks() {
                    let contained = (1..=mask).filter(|other| other & !mask == 0);
                    let own_m =
                        contained.map(|mask| brute_force_m(&heightmap, &grid, patch, mask)).fold(plain_m, f64::max);
                    let steps = table.block(&grid, parent, &child, mask);
                    assert_rounded_up(&table, steps, own_m, 1.0 / 16.0, &format!("{what}, {patch:?}, mask {mask}"));
                    compared[mask as usize] += 1;
                }
            }
        }
    }
    assert!(compared[..7].iter().all(|count| *count > 50), "{compared:?}");
}

/// What the closure rests on: a patch that is fine has children that are fine, a block with fewer collapsed sides is
/// no worse, and the halves of a rim square agree.
#[test]
fn errors_are_nested() {
    for (columns, rows, k, layers) in [(65, 50, 2, 4), (70, 82, 3, 3), (65, 65, 4, 2)] {
        let heightmap = rough(columns, rows, 9);
        let grid = Grid::new(&heightmap, &Options { k, layers, ..Options::default() });
        let table = ErrorTable::new(&heightmap, &grid);
        for square in (1..layers).flat_map(|level| grid.squares(level)) {
            let errors = Half::BOTH.map(|half| table.plain(&grid, square.half(half)));
            assert!(!grid.crosses_rim(square) || errors[0] == errors[1]);
            if square.level > 1 {
                let of_children = grid.children(square).flat_map(|child| Half::BOTH.map(|half| child.half(half)));
                let worst = of_children.map(|child| table.plain(&grid, child)).max();
                assert_eq!(Some(table.worst_child(square.level, grid.index(square))), worst);
            }
            for patch in Half::BOTH.map(|half| square.half(half)) {
                let parent = grid.parent(patch);
                assert!(parent.is_none_or(|parent| table.plain(&grid, parent) >= table.plain(&grid, patch)));
                for (child, _) in table.border.touching(&grid, patch, ALL_COLLAPSED) {
                    for mask in child.masks() {
                        let block = table.block(&grid, patch, &child, mask);
                        let without = sides_of(mask).map(|side| mask & !side.bit()).filter(|mask| *mask != 0);
                        assert!(without.into_iter().all(|mask| table.block(&grid, patch, &child, mask) <= block));
                    }
                }
            }
        }
    }
}

#[test]
fn flat_ground_has_no_error() {
    let heightmap = Heightmap::new(82, 82, [1.0; 2], vec![812.7; 82 * 82]).unwrap();
    let grid = Grid::new(&heightmap, &Options::default());
    let table = ErrorTable::new(&heightmap, &grid);
    assert_eq!(table.step_m(), 0.0);
    // Two layers of squares with two halves of 14 bytes, and the worst children of the coarser one.
    assert_eq!(table.bytes(), 2 * 14 * (81 + 9) + 2 * 9);
}
