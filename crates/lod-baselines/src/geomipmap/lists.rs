//! The index lists that all blocks share: by shape, level, and the sides that meet a coarser neighbour.
//!
//! A block's mesh is an inner part of plain quads and a strip along each side. The strips end at the block's diagonals,
//! so that each can be exchanged for its joined form without touching the others:
//!
//! ```text
//!   o-------o-------o        a block of 4 intervals,       a strip, plain:      and joined, without every
//!   | \   / | \   / |        the northern side joined,                          other vertex of the border:
//!   o---o---o---o---o        the others plain
//!   | / | / | / | / |                                      o---o---o---o---o    o-------o-------o
//!   o---o---o---o---o                                       \  |\  |\  |  /      \     /|\     /
//!   | / | / | / | / |                                         \| \| \| /          \ /  |  \ /
//!   o---o---o---o---o                                          o---o---o            o---o---o
//!   | / | \ | \ | \ |
//!   o---o---o---o---o
//! ```
//!
//! Blocks at the rim may be narrower. Their lists are the same with the vertices beyond the rim clamped to it. That
//! cannot fold a triangle: each has an edge along an axis, and clamping keeps the order of columns and of rows. A
//! triangle that loses its area lies on the outline, or two of its corners become one; it is left out.

use std::ops::Range;

use terrain_core::{Sample, Triangle};

/// Grid intervals along the side of a block.
pub(crate) const BLOCK: u32 = 32;
/// Levels of a block: steps of 1, 2, 4, ... to the whole block.
pub(crate) const LEVELS: usize = BLOCK.ilog2() as usize + 1;

/// A side of a block. Its number is how often the northern side is turned clockwise, seen from above, to become it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    North = 0,
    East = 1,
    South = 2,
    West = 3,
}

impl Side {
    pub const ALL: [Side; 4] = [Side::North, Side::East, Side::South, Side::West];

    /// Its bit in a set of sides.
    pub fn bit(self) -> usize {
        1 << self as usize
    }
}

/// Sets of sides.
const MASKS: usize = 1 << Side::ALL.len();

/// Grid intervals of a block along x and z; less than [`BLOCK`] at the DEM's rim.
pub(crate) type Shape = [u32; 2];

/// A vertex of a block's lattice, in steps of its level from the north-western corner.
type Place = [u32; 2];

/// A triangle of a block, counter-clockwise seen from above, relative to the block's north-western sample.
pub(crate) type Corners = [Sample; 3];

/// All triangles of a block on a level, with the strips of some sides joined to a neighbour one level coarser.
pub(crate) fn triangles(shape: Shape, level: usize, joined: usize) -> Vec<Corners> {
    let intervals = BLOCK >> level;
    let mut places = inner(intervals);
    for side in Side::ALL {
        strip(intervals, side, joined & side.bit() != 0, &mut places);
    }
    clamped(shape, level, &places)
}

/// Whether a side can meet a coarser neighbour: not on the last level, and not where the block is cut off by the rim.
pub(crate) fn can_join(shape: Shape, level: usize, side: Side) -> bool {
    let is_cut_off = match side {
        Side::North | Side::West => false,
        Side::East => shape[0] < BLOCK,
        Side::South => shape[1] < BLOCK,
    };
    level + 1 < LEVELS && !is_cut_off
}

/// The triangles along one side where it is joined.
pub(crate) fn joined_strip(shape: Shape, level: usize, side: Side) -> Vec<Corners> {
    let mut places = Vec::new();
    strip(BLOCK >> level, side, true, &mut places);
    clamped(shape, level, &places)
}

fn is_possible(shape: Shape, level: usize, joined: usize) -> bool {
    Side::ALL.iter().all(|side| joined & side.bit() == 0 || can_join(shape, level, *side))
}

/// What the strips leave: two triangles a quad, or on the last level, which has no strips, the two of the block.
fn inner(intervals: u32) -> Vec<[Place; 3]> {
    let quads = if intervals == 1 { 0..1 } else { 1..intervals - 1 };
    let mut places = Vec::new();
    for z in quads.clone() {
        for x in quads.clone() {
            places.push([[x, z], [x, z + 1], [x + 1, z]]);
            places.push([[x + 1, z], [x, z + 1], [x + 1, z + 1]]);
        }
    }
    places
}

/// The strip between the border and the first inner row: a triangle on each edge of the border, and one on each edge
/// of the inner row between two of those.
fn strip(intervals: u32, side: Side, joined: bool, places: &mut Vec<[Place; 3]>) {
    if intervals == 1 {
        return;
    }
    let step = if joined { 2 } else { 1 };
    let inner = 1..intervals - 1;
    let third_corner = |start: u32| (start + 1).min(inner.end);
    let mut push = |corners: [Place; 3]| places.push(corners.map(|place| turned(place, intervals, side)));
    for start in (0..intervals).step_by(step as usize) {
        push([[start + step, 0], [start, 0], [third_corner(start), 1]]);
        let end = start + step;
        if end < intervals {
            (third_corner(start)..third_corner(end)).for_each(|x| push([[x, 1], [x + 1, 1], [end, 0]]));
        }
    }
}

/// A place of the northern strip, turned to another side.
fn turned(place: Place, intervals: u32, side: Side) -> Place {
    (0..side as usize).fold(place, |[x, z], _| [intervals - z, x])
}

fn clamped(shape: Shape, level: usize, places: &[[Place; 3]]) -> Vec<Corners> {
    let sample = |[x, z]: Place| Sample { column: (x << level).min(shape[0]), row: (z << level).min(shape[1]) };
    let corners = places.iter().map(|corners| corners.map(sample));
    corners.filter(|corners| Triangle { samples: *corners, heights_m: [0.0; 3] }.doubled_area() > 0).collect()
}

/// The index lists of the shapes of one DEM, relative to a block's north-western vertex.
pub(crate) struct Lists {
    pub indices: Vec<u32>,
    /// By shape, level and set of joined sides.
    ranges: Vec<Range<u32>>,
}

impl Lists {
    /// For a vertex buffer that holds `columns` samples a row.
    pub fn new(shapes: &[Shape], columns: u32) -> Self {
        let mut lists = Self { indices: Vec::new(), ranges: Vec::new() };
        for shape in shapes {
            for level in 0..LEVELS {
                (0..MASKS).for_each(|joined| lists.add(*shape, level, joined, columns));
            }
        }
        lists
    }

    /// A list that no block can have is empty.
    fn add(&mut self, shape: Shape, level: usize, joined: usize, columns: u32) {
        match is_possible(shape, level, joined) {
            true => self.push(&triangles(shape, level, joined), columns),
            false => self.push(&[], columns),
        }
    }

    fn push(&mut self, triangles: &[Corners], columns: u32) {
        let first = self.indices.len() as u32;
        self.indices.extend(triangles.iter().flatten().map(|sample| sample.row * columns + sample.column));
        self.ranges.push(first..self.indices.len() as u32);
    }

    /// Where a list is in the index buffer, by the position of the block's shape in the list of shapes.
    pub fn range(&self, shape: usize, level: usize, joined: usize) -> Range<u32> {
        self.ranges[(shape * LEVELS + level) * MASKS + joined].clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use terrain_core::watertight::WatertightOracle;

    /// Samples along a side of a list, as distances from its northern or western end.
    fn border(list: &[Corners], shape: Shape, side: Side) -> BTreeSet<u32> {
        let along = |sample: &Sample| match side {
            Side::North => (sample.row == 0).then_some(sample.column),
            Side::South => (sample.row == shape[1]).then_some(sample.column),
            Side::West => (sample.column == 0).then_some(sample.row),
            Side::East => (sample.column == shape[0]).then_some(sample.row),
        };
        list.iter().flatten().filter_map(along).collect()
    }

    fn check(shape: Shape, level: usize, joined: usize) {
        let list = triangles(shape, level, joined);
        let mesh: Vec<Triangle> =
            list.iter().map(|samples| Triangle { samples: *samples, heights_m: [0.0; 3] }).collect();
        let found = WatertightOracle::new(shape[0] + 1, shape[1] + 1).check(&mesh, &[]);
        assert!(found.covers(shape[0] + 1, shape[1] + 1), "{shape:?}, level {level}, joined {joined:04b}: {found:?}");
        for side in Side::ALL {
            let length = shape[side as usize % 2];
            let step = 1 << level << (joined & side.bit() != 0) as u32;
            let expected: BTreeSet<u32> = (0..length).step_by(step).chain([length]).collect();
            assert_eq!(border(&list, shape, side), expected, "{shape:?}, level {level}, joined {joined:04b}, {side:?}");
        }
    }

    /// Two neighbours share their whole border where both have the same vertices there, and the level and the set of
    /// joined sides say which those are.
    #[test]
    fn every_list_of_every_shape_covers_its_block_and_ends_where_its_neighbours_begin() {
        let sides = [1, 2, 3, 5, 8, 15, 16, 17, 31, 32];
        for shape in sides.into_iter().flat_map(|width| sides.map(|depth| [width, depth])) {
            for level in 0..LEVELS {
                let possible = (0..MASKS).filter(|joined| is_possible(shape, level, *joined));
                possible.for_each(|joined| check(shape, level, joined));
            }
        }
    }

    #[test]
    fn as_many_triangles_as_the_grid_less_one_for_each_dropped_vertex() {
        for level in 0..LEVELS - 1 {
            let intervals = BLOCK as usize >> level;
            for joined in 0..MASKS {
                let dropped = joined.count_ones() as usize * intervals / 2;
                assert_eq!(triangles([BLOCK; 2], level, joined).len(), 2 * intervals * intervals - dropped);
            }
        }
    }
}
