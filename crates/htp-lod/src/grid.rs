//! The hierarchy of squares and patches (section 2.1, Figure 1), in sample coordinates.
//!
//! Level 0 is the finest. A square of level n is `k^(n + 1)` sample intervals wide and holds two patches, whose small
//! triangles have legs of `k^n` intervals. All diagonals run the same way:
//!
//! ```text
//!   apex         right end                      k = 3: the children of a square. Upper case stands for the
//!      +--------+                               parent's north-west half, lower case for its south-east half:
//!      |       /|  left end
//!      | NW   / |                                  +---+---+---+
//!      |     /  |  SE is NW turned                 |A /|A /|A /|
//!      |    /   |  by 180 degrees                  |/ B|/ B|/ b|    column i, row j:
//!      |   /    |                                  +---+---+---+    A: a north-west child, in the parent's NW half
//!      |  /     |                                  |A /|A /|a /|       where i + j <= k - 1
//!      | /   SE |                                  |/ B|/ b|/ b|    B: a south-east child, in the parent's NW half
//!      |/       |                                  +---+---+---+       where i + j <= k - 2
//!      +--------+                                  |A /|a /|a /|
//!   left end     apex                              |/ b|/ b|/ b|
//!                                                  +---+---+---+
//! ```
//!
//! Only a child of its parent's own half touches the parent's sides; the other children lie inside. Squares are
//! numbered over the whole DEM, so a neighbour in another cell is found like any other: that is the paper's cell
//! binding (section 3, phase 3).
//!
//! Deviation: the paper's DEM is a whole number of cells. Here the squares of the top layer (the cells) cover any DEM
//! by rounding up; vertices beyond the last column or row are clamped to it, and squares wholly beyond do not exist.
//! A triangle may lose its area by that. Then it lies on the outline, or two of its corners become one sample (in the
//! strip along a collapsed side that runs over the rim), so that it vanishes without an edge of its own.

mod family;
mod layer;
mod region;
mod storage;

use crate::cells::CellsHeader;
use crate::options::Options;
use crate::window::Window;
use terrain_core::{Aabb, Heightmap, PatchInstance, PatchTag, Sample};

pub(crate) use family::{Child, Kin};
pub(crate) use layer::Layer;
use layer::Position;
pub(crate) use region::Region;
pub(crate) use storage::{Run, Spot};

/// One of the two patches of a square, named after the corner where its right angle is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Half {
    NorthWest = 0,
    SouthEast = 1,
}

impl Half {
    pub const BOTH: [Half; 2] = [Half::NorthWest, Half::SouthEast];

    /// Its bit in a set of halves.
    pub fn bit(self) -> u8 {
        1 << self as u8
    }

    /// The half on the other side of the hypotenuse; all three neighbours of a patch are such halves.
    pub fn other(self) -> Self {
        Self::BOTH[1 - self as usize]
    }
}

/// Numbers that a [`PatchTag`] has room for.
pub(crate) const TAG_NUMBERS: u32 = 1 << 27;

/// The set of both halves.
pub(crate) const BOTH_HALVES: u8 = 0b11;

/// A square of one level, by its column and row among the squares of that level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Square {
    pub level: u32,
    pub column: u32,
    pub row: u32,
}

impl Square {
    pub fn half(self, half: Half) -> Patch {
        Patch { square: self, half }
    }
}

/// A patch: one half of a square.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Patch {
    pub square: Square,
    pub half: Half,
}

/// The hierarchy over one DEM.
pub(crate) struct Grid {
    /// Small triangles along each side of a patch, and squares along each side of the next coarser square.
    pub k: u32,
    /// The DEM's last column and last row.
    last: [u32; 2],
    spacing_m: [f64; 2],
    /// By level, the finest first.
    pub layers: Vec<Layer>,
    /// The cells that are loaded, where not all is in memory.
    pub window: Window,
    /// By row and column among a square's children.
    kin: Vec<Kin>,
    /// By half: its children.
    in_half: [Vec<Child>; 2],
    /// Lowest and highest sample, once the top layer has its own.
    range_m: [f64; 2],
}

impl Grid {
    pub fn new(heightmap: &Heightmap, options: &Options) -> Self {
        let samples = [heightmap.columns(), heightmap.rows()];
        let mut grid = Self::sized(samples, heightmap.spacing_m(), options, Window::everything());
        for level in 0..options.layers {
            let ranges_m: Vec<_> = grid.squares(level).map(|square| grid.height_range_m(heightmap, square)).collect();
            grid.put_level(level, ranges_m);
        }
        grid
    }

    /// Of a DEM whose coarser levels are resident; nothing else is loaded. `sides` are cells along the window of each
    /// streamed level.
    pub fn streamed(header: &CellsHeader, ranges_m: Vec<Vec<[f32; 2]>>, options: &Options, sides: &[u32]) -> Self {
        let window = Window::new(sides, header.cells());
        let mut grid = Self::sized(header.samples, header.spacing_m, options, window);
        for layer in &mut grid.layers[..header.streamed as usize] {
            layer.heights_m = vec![[0.0; 2]; layer.squares_stored()];
        }
        (header.streamed..).zip(ranges_m).for_each(|(level, ranges_m)| grid.put_level(level, ranges_m));
        grid
    }

    /// Without height ranges.
    pub fn sized(samples: [u32; 2], spacing_m: [f64; 2], options: &Options, window: Window) -> Self {
        let last = samples.map(|samples| samples - 1);
        let mut grid = Self {
            k: options.k,
            last,
            spacing_m,
            layers: Vec::new(),
            window,
            kin: Kin::all(options.k),
            in_half: Half::BOTH.map(|half| Child::all(options.k, half)),
            range_m: [f64::INFINITY, f64::NEG_INFINITY],
        };
        for level in 0..options.layers {
            let (step, side) = (grid.k.pow(level), grid.k.pow(level + 1));
            let [size, inside] = [last.map(|end| end.div_ceil(side)), last.map(|end| end / side)];
            let per_cell = grid.k.pow(options.layers - 1 - level);
            let brood = if per_cell > 1 { grid.k } else { 1 };
            let room = if level < grid.window.streamed { grid.window.side(level) * per_cell / brood } else { u32::MAX };
            let all = size.map(|squares| squares.div_ceil(brood));
            let broods = all.map(|broods| broods.min(room));
            let [first_patch, first_place] = [grid.patches(), grid.places()];
            let layer = Layer {
                step,
                side,
                size,
                inside,
                brood,
                broods,
                wraps: broods != all,
                positions: Position::all(brood, broods[0]),
                per_cell,
                first_patch,
                first_place,
                heights_m: Vec::new(),
            };
            grid.layers.push(layer);
        }
        grid
    }

    /// Of the samples on level 0, above that of the children.
    fn height_range_m(&self, heightmap: &Heightmap, square: Square) -> [f32; 2] {
        if square.level == 0 {
            let side = self.k;
            let first = Sample { column: square.column * side, row: square.row * side };
            let last = Sample { column: first.column + side, row: first.row + side };
            return heightmap.height_range_m(first, last);
        }
        let children = self.children(square).map(|child| self.layer(child).heights_m[self.index(child)]);
        children.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], [l, h]| [low.min(l), high.max(h)])
    }

    /// Columns and rows of the DEM.
    #[cfg(test)]
    pub fn samples(&self) -> [u32; 2] {
        self.last.map(|last| last + 1)
    }

    /// The coarsest level; its squares are the cells.
    pub fn top(&self) -> u32 {
        self.layers.len() as u32 - 1
    }

    #[inline]
    pub fn layer(&self, square: Square) -> &Layer {
        &self.layers[square.level as usize]
    }

    /// All squares of a level, row by row.
    pub fn squares(&self, level: u32) -> impl Iterator<Item = Square> + use<> {
        let [columns, rows] = self.layers[level as usize].size;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| Square { level, column, row }))
    }

    /// Whether a patch of a square may be split: see `window`.
    #[inline]
    pub fn may_split(&self, square: Square) -> bool {
        square.level > self.window.streamed || self.window.may_split(square.level, self.cell_number(square))
    }

    /// Sample intervals along a cell.
    pub fn cell_side(&self) -> u32 {
        self.k.pow(self.layers.len() as u32)
    }

    /// Column and row of the cell that a square lies in.
    pub fn cell_number(&self, square: Square) -> [u32; 2] {
        let per_cell = self.layer(square).per_cell;
        [square.column / per_cell, square.row / per_cell]
    }

    /// Patches of all layers so far. A DEM of the largest size has fewer than 2^32.
    pub fn patches(&self) -> u32 {
        self.layers.last().map_or(0, |layer| layer.first_patch + 2 * layer.size[0] * layer.size[1])
    }

    /// A running number over the DEM: level by level, square by square, half by half.
    #[inline]
    pub fn patch_number(&self, patch: Patch) -> u32 {
        self.layer(patch.square).patch_number(patch)
    }

    /// What all batchings say of a patch, in every view. A tag has 27 bits for a number: on the largest DEMs they begin
    /// again.
    #[inline]
    pub fn tag(&self, patch: Patch) -> PatchTag {
        self.layer(patch.square).tag(patch)
    }

    #[inline]
    pub fn exists(&self, square: Square) -> bool {
        let [columns, rows] = self.layer(square).size;
        square.column < columns && square.row < rows
    }

    /// Whether a square reaches over the DEM's last column or row, so that its vertices are clamped.
    #[inline]
    pub fn crosses_rim(&self, square: Square) -> bool {
        let [columns, rows] = self.layer(square).inside;
        square.column >= columns || square.row >= rows
    }

    /// The world box of a square, clamped to the DEM.
    #[inline]
    pub fn bounds_world(&self, square: Square) -> Aabb {
        self.bounds_world_at(self.spot(square))
    }

    /// The same where its position is known.
    #[inline]
    pub fn bounds_world_at(&self, Spot { square, index, .. }: Spot) -> Aabb {
        let [low, high] = self.heights_m(square.level, index);
        let [x, z] = [self.interval_m(0, square.level, square.column), self.interval_m(1, square.level, square.row)];
        Aabb { min: [x[0], low, z[0]], max: [x[1], high, z[1]] }
    }

    /// Lowest and highest sample of the square at a position.
    #[inline]
    pub fn heights_m(&self, level: u32, index: usize) -> [f64; 2] {
        let [low, high] = self.layers[level as usize].heights_m[index];
        [low as f64, high as f64]
    }

    /// From where to where the squares of a column (axis 0) or row (axis 1) reach, clamped to the DEM.
    #[inline]
    pub fn interval_m(&self, axis: usize, level: u32, at: u32) -> [f64; 2] {
        let side = self.layers[level as usize].side;
        let [first, last] = [at * side, ((at + 1) * side).min(self.last[axis])];
        [first as f64 * self.spacing_m[axis], last as f64 * self.spacing_m[axis]]
    }

    /// Metres of a leg of the small triangles of a level, along the axis with the wider spacing.
    pub fn leg_m(&self, level: u32) -> f64 {
        self.layers[level as usize].step as f64 * self.spacing_m[0].max(self.spacing_m[1])
    }

    /// Metres of the longest edge of a square's box; at most that of the square around it.
    pub fn longest_edge_m(&self, square: Square) -> f64 {
        let Aabb { min, max } = self.bounds_world(square);
        [0, 1, 2].map(|axis| max[axis] - min[axis]).into_iter().fold(0.0, f64::max)
    }

    /// The map from a patch's local vertices to samples: u leads to the left end, v to the right end.
    #[inline]
    pub fn instance(&self, patch: Patch) -> PatchInstance {
        self.layer(patch.square).instance(patch)
    }
}

#[cfg(test)]
mod tests;
