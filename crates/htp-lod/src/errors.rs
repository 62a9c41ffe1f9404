//! The error of every patch and of every matching block that it can be drawn with: stored once, looked up in each
//! frame. The paper has no errors; this is what makes a tolerance a bound.
//!
//! The error of a patch is the largest vertical distance between a sample of the DEM and the patch drawn plain, made
//! the maximum with the errors of its children: a patch that is fine has children that are fine, so that splitting it
//! for a neighbour's sake (`closure`) asks for no more. The error with a mask is that of the matching block, made the
//! maximum with the masks that it contains: a block stays fine when a side is no longer collapsed. Even a patch of the
//! finest layer has errors, where a side drops samples.
//!
//! Only what can be drawn is stored, by split patch: its own error and those of its border children (`border`). Every
//! decision needs the first, few the others: in memory they are apart, in a file of cells together, a record a square.
//!
//! ```text
//!  | square: NW half                                 | SE half ...
//!  | plain | child 0: L  R  LR | child 1: R | ...    |               a plain error takes 2 bytes, that of a block 1:
//!                                                                    2 (3k + 5) bytes, 28 for k = 3
//! ```
//!
//! An error counts steps of 1/65,535 of the DEM's height range, rounded up, and that of a block once more, to what has a
//! byte (`steps`): one split patch in 500 comes from blocks. No error is larger than the range, since every triangle lies
//! between its corners.

mod steps;

use crate::blocks::{ALL_COLLAPSED, index_list, local_vertices};
use crate::border::{Border, BorderChild};
use crate::cells::CellsHeader;
use crate::deviation::deviation_m;
use crate::grid::{Grid, Half, Patch, Run, Spot, Square};
use crate::window::Sheet;
use rayon::prelude::*;
use terrain_core::{Heightmap, LocalVertex};

/// The errors of all patches that can be split, and of their border children.
pub(crate) struct ErrorTable {
    pub border: Border,
    /// Metres of one step.
    step_m: f64,
    /// By level, from 1.
    layers: Vec<Layer>,
}

/// The errors of one level, by the position of a square, see [`Grid::index`].
struct Layer {
    /// Of both halves, drawn plain.
    plain: Vec<[u16; 2]>,
    /// The largest plain error of their children; empty where there are none, or these come and go.
    worst_child: Vec<u16>,
    /// Of their border children, half by half.
    blocks: Vec<u8>,
}

impl Layer {
    /// For so many squares, with so many bytes of blocks each.
    fn new(squares: usize, blocks: usize) -> Self {
        Self { plain: vec![[0; 2]; squares], worst_child: Vec::new(), blocks: vec![0; squares * blocks] }
    }

    /// Takes the records of squares that are stored side by side, from one on.
    fn put(&mut self, first: usize, records: &[u8], k: u32) {
        let (record, blocks) = (record_length(k), 2 * blocks_length(k));
        for (index, record) in (first..).zip(records.chunks_exact(record)) {
            for (half, record) in record.chunks_exact(record.len() / 2).enumerate() {
                let (plain, of_blocks) = record.split_at(PLAIN);
                self.plain[index][half] = u16::from_le_bytes([plain[0], plain[1]]);
                self.blocks[index * blocks..][half * of_blocks.len()..][..of_blocks.len()].copy_from_slice(of_blocks);
            }
        }
    }

    /// Appends the record of a square.
    fn push_record(&self, index: usize, k: u32, records: &mut Vec<u8>) {
        let blocks = self.blocks[2 * index * blocks_length(k)..].chunks_exact(blocks_length(k));
        for (plain, blocks) in self.plain[index].iter().zip(blocks) {
            records.extend(plain.to_le_bytes());
            records.extend(blocks);
        }
    }
}

impl ErrorTable {
    /// Measures all patches and blocks, on the threads of the current pool.
    pub fn new(heightmap: &Heightmap, grid: &Grid) -> Self {
        let heights_m = heightmap.heights_m().iter();
        let [low, high] =
            heights_m.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], h| [low.min(*h), high.max(*h)]);
        Self::with_step(heightmap, grid, (high as f64 - low as f64) / u16::MAX as f64)
    }

    /// As [`Self::new`], in steps of so many metres: those of a DEM of which this one is a part.
    pub fn with_step(heightmap: &Heightmap, grid: &Grid, step_m: f64) -> Self {
        let mut table = Self { border: Border::new(grid), step_m, layers: Vec::new() };
        let survey = Survey::new(heightmap, grid);
        for level in 1..=grid.top() {
            let blocks = 2 * blocks_length(grid.k);
            let mut layer = Layer::new(grid.layers[level as usize].squares_stored(), blocks);
            let squares = layer.plain.par_iter_mut().zip(layer.blocks.par_chunks_mut(blocks)).enumerate();
            squares.with_min_len(SQUARES_A_JOB).for_each(|(index, (plain, blocks))| {
                let Spot { square, .. } = grid.spot_at(level, index);
                if grid.exists(square) {
                    *plain = table.measure(&survey, square, blocks);
                }
            });
            table.layers.push(layer);
        }
        (2..=grid.top()).for_each(|level| table.find_worst_children(grid, level));
        table
    }

    /// Of a DEM whose coarser levels are resident; nothing else is loaded.
    pub fn streamed(header: &CellsHeader, resident: Vec<Vec<u8>>, grid: &Grid) -> Self {
        let room = |level: u32| Layer::new(grid.layers[level as usize].squares_stored(), 2 * blocks_length(grid.k));
        let mut layers: Vec<Layer> = (1..=grid.top()).map(room).collect();
        for (level, records) in (header.streamed..).zip(resident) {
            for (square, record) in grid.squares(level).zip(records.chunks(record_length(grid.k))) {
                layers[level as usize - 1].put(grid.index(square), record, grid.k);
            }
        }
        let mut table = Self { border: Border::new(grid), step_m: header.step_m(), layers };
        (header.streamed + 1..=grid.top()).for_each(|level| table.find_worst_children(grid, level));
        table
    }

    /// Of all squares of a level.
    fn find_worst_children(&mut self, grid: &Grid, level: u32) {
        let [finer, layer] = &mut self.layers[level as usize - 2..level as usize] else { unreachable!("two layers") };
        layer.worst_child = vec![0; layer.plain.len()];
        for square in grid.squares(level) {
            let brood = &finer.plain[grid.brood_start(square)..][..(grid.k * grid.k) as usize];
            layer.worst_child[grid.index(square)] = brood.iter().flatten().fold(0, |worst, plain| worst.max(*plain));
        }
    }

    /// Takes the records of a sheet's squares; there are none on level 0.
    pub fn put(&mut self, grid: &Grid, sheet: Sheet, records: &[u8]) {
        if sheet.level == 0 {
            return;
        }
        let length = record_length(grid.k);
        for Run { first, stored } in grid.runs(sheet) {
            let records = &records[first * length..][..stored.len() * length];
            self.layers[sheet.level as usize - 1].put(stored.start, records, grid.k);
        }
    }

    /// Metres of one step of the stored errors.
    pub fn step_m(&self) -> f64 {
        self.step_m
    }

    /// Bytes of all errors.
    pub fn bytes(&self) -> u64 {
        self.layers
            .iter()
            .map(|layer| {
                (size_of_val(&layer.plain[..]) + size_of_val(&layer.worst_child[..]) + layer.blocks.len()) as u64
            })
            .sum()
    }

    /// The error of a patch above the finest layer, drawn plain, in steps.
    #[inline]
    pub fn plain(&self, grid: &Grid, patch: Patch) -> u16 {
        self.plain_both(patch.square.level, grid.index(patch.square))[patch.half as usize]
    }

    /// The error of a border child with a mask other than 0, in steps; for a parent above the finest layer.
    #[inline]
    pub fn block(&self, grid: &Grid, parent: Patch, child: &BorderChild, mask: u8) -> u16 {
        steps::from_byte(self.blocks(grid.spot(parent.square), parent.half)[child.mask_index(mask)])
    }

    /// Those of both halves of a square, by its position.
    #[inline]
    pub fn plain_both(&self, level: u32, index: usize) -> [u16; 2] {
        self.layers[level as usize - 1].plain[index]
    }

    /// The largest plain error of a square's children, or more; for a square above level 1.
    #[inline]
    pub fn worst_child(&self, level: u32, index: usize) -> u16 {
        *self.layers[level as usize - 1].worst_child.get(index).unwrap_or(&u16::MAX)
    }

    /// The largest error of a patch's border children that touch sides of a mask, with these sides collapsed.
    #[inline]
    pub fn worst_block(&self, parent: Spot, half: Half, sides: u8) -> u16 {
        let blocks = self.blocks(parent, half);
        steps::from_byte(self.border.masks_along(sides).iter().fold(0, |worst, mask| worst.max(blocks[*mask])))
    }

    /// The errors of a patch's border children, by the position of the mask.
    #[inline]
    fn blocks(&self, Spot { square, index, .. }: Spot, half: Half) -> &[u8] {
        let length = self.border.masks;
        let start = (2 * index + half as usize) * length;
        &self.layers[square.level as usize - 1].blocks[start..start + length]
    }

    /// The records of a level above the finest, row by row.
    pub fn records(&self, grid: &Grid, level: u32) -> Vec<u8> {
        let (layer, mut records) = (&self.layers[level as usize - 1], Vec::new());
        grid.squares(level).for_each(|square| layer.push_record(grid.index(square), grid.k, &mut records));
        records
    }

    /// Measures a square's patches and, into `blocks`, their border children; the errors of the finer layers are there.
    fn measure(&self, survey: &Survey, square: Square, blocks: &mut [u8]) -> [u16; 2] {
        let mut plain = Half::BOTH.map(|half| self.measure_plain(survey, square.half(half)));
        // The halves of a square that crosses the rim are split together.
        if survey.grid.crosses_rim(square) {
            plain = [plain[0].max(plain[1]); 2];
        }
        for (half, blocks) in Half::BOTH.into_iter().zip(blocks.chunks_mut(self.border.masks)) {
            self.measure_blocks(survey, square.half(half), blocks);
        }
        plain
    }

    fn measure_plain(&self, survey: &Survey, patch: Patch) -> u16 {
        let own = self.steps(survey.deviation_m(patch, &survey.plain));
        if patch.square.level == 1 {
            return own;
        }
        let children = survey.grid.children(patch.square).flat_map(|square| Half::BOTH.map(|half| square.half(half)));
        let children = children.filter(|child| survey.grid.parent(*child) == Some(patch));
        children.map(|child| self.plain(survey.grid, child)).fold(own, u16::max)
    }

    fn measure_blocks(&self, survey: &Survey, parent: Patch, blocks: &mut [u8]) {
        for (child, patch) in self.border.touching(survey.grid, parent, ALL_COLLAPSED) {
            let plain = if patch.square.level == 0 { 0 } else { self.plain(survey.grid, patch) };
            for mask in child.masks() {
                let own = self.steps(survey.deviation_m(patch, &survey.strips[mask as usize]));
                let contained = child.masks().filter(|other| *other != mask && other & mask == *other);
                let contained = contained.map(|other| blocks[child.mask_index(other)]);
                blocks[child.mask_index(mask)] = contained.fold(steps::to_byte(own.max(plain)), u8::max);
            }
        }
    }

    /// Steps of an error, rounded up; what f64 sums may have lost is added first.
    fn steps(&self, error_m: f64) -> u16 {
        if error_m == 0.0 { 0 } else { (error_m / self.step_m * (1.0 + 1e-9)).ceil() as u16 }
    }
}

/// Bytes of the worst child of a square.
pub(crate) const BYTES_OF_WORST_CHILD: u64 = size_of::<u16>() as u64;

/// Squares that are measured by one job, at least.
const SQUARES_A_JOB: usize = 64;

/// Bytes of a plain error, at the start of the half of a record.
const PLAIN: usize = size_of::<u16>();

/// Bytes of the blocks of one patch: the masks of its border children.
const fn blocks_length(k: u32) -> usize {
    3 * k as usize + 3
}

/// Bytes of one square, in the table of any DEM.
pub(crate) const fn record_length(k: u32) -> usize {
    2 * (PLAIN + blocks_length(k))
}

/// What is measured: triangles of a patch by their local vertices.
struct Survey<'a> {
    heightmap: &'a Heightmap,
    grid: &'a Grid,
    plain: Vec<[LocalVertex; 3]>,
    /// By mask: the triangles of the strips along the collapsed sides. The rest of a block is as in the plain patch.
    strips: Vec<Vec<[LocalVertex; 3]>>,
}

impl<'a> Survey<'a> {
    fn new(heightmap: &'a Heightmap, grid: &'a Grid) -> Self {
        let local = local_vertices(grid.k);
        let triangles = |mask: u8| -> Vec<[LocalVertex; 3]> {
            index_list(grid.k, mask).iter().map(|corners| corners.map(|i| local[i as usize])).collect()
        };
        let plain = triangles(0);
        let strips = (0..ALL_COLLAPSED).map(|mask| {
            let mut triangles = triangles(mask);
            triangles.retain(|triangle| !plain.contains(triangle));
            triangles
        });
        Self { heightmap, grid, strips: strips.collect(), plain }
    }

    fn deviation_m(&self, patch: Patch, triangles: &[[LocalVertex; 3]]) -> f64 {
        let map = self.grid.instance(patch);
        let sample = |vertex| map.sample(vertex, self.heightmap.columns(), self.heightmap.rows());
        let deviations = triangles.iter().map(|corners| deviation_m(self.heightmap, corners.map(sample)));
        deviations.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests;
