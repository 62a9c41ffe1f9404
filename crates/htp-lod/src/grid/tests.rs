//! The hierarchy on DEMs with and without squares that cross the rim.

use super::*;
use crate::blocks::Side;
use std::collections::BTreeSet;
use terrain_core::{LocalVertex, SplitMix64};

/// Small grids with and without squares that cross the rim.
fn grids() -> Vec<(Heightmap, Grid)> {
    let mut grids = Vec::new();
    for (columns, rows) in [(2, 2), (28, 28), (30, 31), (17, 65), (51, 26)] {
        let mut random = SplitMix64::new(columns as u64);
        let heights = (0..columns * rows).map(|_| random.range(0.0, 1000.0) as f32).collect();
        let heightmap = Heightmap::new(columns, rows, [30.0, 20.0], heights).unwrap();
        for k in [2, 3, 4, 5, 7] {
            let grid = Grid::new(&heightmap, &Options { k, ..Options::default() });
            grids.push((heightmap.clone(), grid));
        }
    }
    grids
}

fn patches(grid: &Grid, level: u32) -> impl Iterator<Item = Patch> {
    grid.squares(level).flat_map(|square| Half::BOTH.map(|half| square.half(half)))
}

/// Column and row of a local vertex, not clamped to the DEM.
fn at(grid: &Grid, patch: Patch, u: u32, v: u32) -> [i32; 2] {
    let map = grid.instance(patch);
    [0, 1].map(|i| map.origin[i] + u as i32 * map.leg_u[i] as i32 + v as i32 * map.leg_v[i] as i32)
}

/// Apex, left end, right end.
fn corners(grid: &Grid, patch: Patch) -> [[i32; 2]; 3] {
    [[0, 0], [grid.k, 0], [0, grid.k]].map(|[u, v]| at(grid, patch, u, v))
}

#[test]
fn children_are_the_parents_small_triangles() {
    for (_, grid) in grids() {
        for level in 1..=grid.top() {
            for parent in patches(&grid, level).filter(|patch| !grid.crosses_rim(patch.square)) {
                let vertices = crate::blocks::local_vertices(grid.k);
                let corner = |i: u32| {
                    let LocalVertex { uv: [u, v] } = vertices[i as usize];
                    at(&grid, parent, u as u32, v as u32)
                };
                let plain = crate::blocks::index_list(grid.k, 0);
                let expected: BTreeSet<_> = plain.iter().map(|triangle| sorted(triangle.map(corner))).collect();
                let children = grid.children(parent.square).flat_map(|s| Half::BOTH.map(|half| s.half(half)));
                let children = children.filter(|child| grid.parent(*child) == Some(parent));
                let found: Vec<_> = children.map(|child| sorted(corners(&grid, child))).collect();
                assert_eq!(found.len() as u32, grid.k * grid.k);
                assert_eq!(found.into_iter().collect::<BTreeSet<_>>(), expected, "{parent:?}");
            }
        }
    }
}

fn sorted(mut corners: [[i32; 2]; 3]) -> [[i32; 2]; 3] {
    corners.sort();
    corners
}

#[test]
fn parents_and_children_agree() {
    for (_, grid) in grids() {
        assert!(patches(&grid, grid.top()).all(|patch| grid.parent(patch).is_none()));
        for child in (0..grid.top()).flat_map(|level| patches(&grid, level)) {
            let parent = grid.parent(child).unwrap();
            assert!(grid.exists(parent.square));
            assert!(grid.children(parent.square).any(|square| square == child.square), "{child:?}");
        }
    }
}

#[test]
fn neighbours_share_an_edge_and_agree() {
    for (heightmap, grid) in grids() {
        for patch in (0..=grid.top()).flat_map(|level| patches(&grid, level)) {
            let [apex, left, right] = corners(&grid, patch);
            let edges = [[left, right], [apex, left], [right, apex]];
            for side in Side::ALL {
                let edge = edges[side as usize];
                let Some(other) = grid.neighbour(patch, side) else {
                    let last = [heightmap.columns() as i32 - 1, heightmap.rows() as i32 - 1];
                    let out = |axis: usize| edge.iter().all(|at| at[axis] <= 0 || at[axis] >= last[axis]);
                    assert!(out(0) || out(1), "{patch:?} {side:?}");
                    continue;
                };
                assert_eq!(grid.neighbour(other, side), Some(patch));
                let [apex, left, right] = corners(&grid, other);
                let [from, to] = [[left, right], [apex, left], [right, apex]][side as usize];
                assert_eq!([to, from], edge, "{patch:?} {side:?}");
            }
        }
    }
}

#[test]
fn positions_are_those_of_squares_and_of_their_neighbours() {
    for (_, grid) in grids() {
        for level in 0..=grid.top() {
            let stored: BTreeSet<usize> = grid.squares(level).map(|square| grid.index(square)).collect();
            assert_eq!(stored.len(), grid.squares(level).count());
            assert!(stored.last().unwrap() < &grid.layers[level as usize].squares_stored());
            for square in grid.squares(level) {
                let index = grid.index(square);
                let spot = grid.spot_at(level, index);
                assert_eq!((spot.square, spot.at), (square, grid.spot(square).at));
                let [north_west, south_east] = Half::BOTH.map(|half| {
                    let beyond = |side| grid.neighbour(square.half(half), side).map(|other| grid.index(other.square));
                    [Side::Left, Side::Right].map(beyond)
                });
                assert_eq!(grid.around(grid.spot(square), Some, None)[..], [north_west, south_east].concat());
            }
        }
    }
}

#[test]
fn only_children_of_the_parents_own_half_touch_its_sides() {
    for (_, grid) in grids() {
        for child in (0..grid.top()).flat_map(|level| patches(&grid, level)) {
            let parent = grid.parent(child).unwrap();
            let touched = grid.kin(child.square).touched[child.half as usize];
            assert!(parent.half != child.half || touched != crate::blocks::ALL_COLLAPSED);
            for side in Side::ALL {
                let Some(other) = grid.neighbour(child, side) else { continue };
                let leaves_parent = grid.parent(other) != Some(parent);
                let expected = parent.half == child.half && touched & side.bit() != 0;
                assert_eq!(leaves_parent, expected, "{child:?} {side:?}");
                assert!(!leaves_parent || grid.neighbour(parent, side) == grid.parent(other));
            }
        }
    }
}

#[test]
fn boxes_hold_their_samples_and_their_children() {
    for (heightmap, grid) in grids() {
        for square in (0..=grid.top()).flat_map(|level| grid.squares(level)) {
            let side = grid.layer(square).side;
            let first = Sample { column: square.column * side, row: square.row * side };
            let last = Sample { column: first.column + side, row: first.row + side };
            assert_eq!(grid.bounds_world(square), heightmap.bounds_world(first, last), "{square:?}");
        }
    }
}
