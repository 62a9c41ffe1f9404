//! The blocks of a DEM, and how far each level of each is from the DEM.

use terrain_core::{Aabb, Heightmap, Sample};

use super::lists::{self, BLOCK, LEVELS, Shape, Side};
use crate::deviation::{SampleRect, max_deviation_m};

/// A square of [`BLOCK`] intervals, less at the rim: the part of the DEM that is drawn at one level.
pub(crate) struct Block {
    pub area: SampleRect,
    /// Position of its shape in [`Blocks::shapes`].
    pub shape: usize,
    pub bounds_world: Aabb,
    /// Of each level the largest distance of its mesh, or of any finer one, from the samples of the block, in metres.
    pub errors_m: [f32; LEVELS],
    /// Of each level and side the distance of the side's strip where it is joined to a neighbour one level coarser. The
    /// samples of the side itself are left out: they lie on the neighbour's mesh, too, and are within its error.
    pub joined_m: [[f32; 4]; LEVELS],
}

/// All blocks, row by row.
pub(crate) struct Blocks {
    across: usize,
    pub blocks: Vec<Block>,
    /// The whole block, and those narrower ones that the rim needs.
    pub shapes: Vec<Shape>,
}

impl Blocks {
    pub fn new(heightmap: &Heightmap) -> Self {
        let last = [heightmap.columns() - 1, heightmap.rows() - 1];
        let [across, down] = last.map(|last| last.div_ceil(BLOCK));
        let mut blocks = Self { across: across as usize, blocks: Vec::new(), shapes: Vec::new() };
        for row in 0..down {
            for column in 0..across {
                let first = Sample { column: column * BLOCK, row: row * BLOCK };
                let end = Sample { column: last[0].min(first.column + BLOCK), row: last[1].min(first.row + BLOCK) };
                blocks.push(heightmap, SampleRect { first, last: end });
            }
        }
        blocks
    }

    fn push(&mut self, heightmap: &Heightmap, area: SampleRect) {
        let shape = [area.last.column - area.first.column, area.last.row - area.first.row];
        let known = self.shapes.iter().position(|known| *known == shape);
        self.blocks.push(Block {
            area,
            shape: known.unwrap_or(self.shapes.len()),
            bounds_world: heightmap.bounds_world(area.first, area.last),
            errors_m: errors_m(heightmap, area, shape),
            joined_m: joined_m(heightmap, area, shape),
        });
        if known.is_none() {
            self.shapes.push(shape);
        }
    }

    /// The block on the other side of a side.
    pub fn neighbour(&self, block: usize, side: Side) -> Option<usize> {
        let column = block % self.across;
        let neighbour = match side {
            Side::North => block.checked_sub(self.across)?,
            Side::South => block + self.across,
            Side::West if column > 0 => block - 1,
            Side::East if column + 1 < self.across => block + 1,
            Side::West | Side::East => return None,
        };
        (neighbour < self.blocks.len()).then_some(neighbour)
    }
}

fn errors_m(heightmap: &Heightmap, area: SampleRect, shape: Shape) -> [f32; LEVELS] {
    let mut errors_m = [0.0; LEVELS];
    for level in 1..LEVELS {
        let own_m = largest_m(heightmap, area, &lists::triangles(shape, level, 0), area);
        errors_m[level] = own_m.max(errors_m[level - 1]);
    }
    errors_m
}

fn joined_m(heightmap: &Heightmap, area: SampleRect, shape: Shape) -> [[f32; 4]; LEVELS] {
    let mut joined_m = [[0.0; 4]; LEVELS];
    for (level, of_sides_m) in joined_m.iter_mut().enumerate() {
        for side in Side::ALL.into_iter().filter(|side| lists::can_join(shape, level, *side)) {
            let strip = lists::joined_strip(shape, level, side);
            of_sides_m[side as usize] = largest_m(heightmap, area, &strip, without(area, side));
        }
    }
    joined_m
}

/// An area without the samples on one of its sides.
fn without(mut area: SampleRect, side: Side) -> SampleRect {
    match side {
        Side::North => area.first.row += 1,
        Side::East => area.last.column -= 1,
        Side::South => area.last.row -= 1,
        Side::West => area.first.column += 1,
    }
    area
}

/// The largest distance of some triangles of a block from the samples of `within`.
fn largest_m(heightmap: &Heightmap, block: SampleRect, triangles: &[lists::Corners], within: SampleRect) -> f32 {
    let SampleRect { first, .. } = block;
    let on_dem = |at: Sample| Sample { column: first.column + at.column, row: first.row + at.row };
    let deviation_m = |corners: &lists::Corners| max_deviation_m(heightmap, corners.map(on_dem), within);
    triangles.iter().map(deviation_m).fold(0.0, f32::max)
}
