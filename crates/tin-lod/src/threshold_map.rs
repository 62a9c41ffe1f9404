//! The threshold map: one byte a sample that says at which levels the sample is needed.
//!
//! A sample is kept at a level exactly if its code is larger than the level; the four corners of a patch always are.
//! The samples that a patch keeps at a level, its border at the same level, make a mesh that is nowhere inside farther
//! from the DEM than the level's tolerance. Kept sets of finer levels contain those of coarser ones.
//!
//! ```text
//!   edge codes, shared          interior codes, a row of `side` bytes for each inner row of the patch
//!   0 7 3 9 1 (corner)          0 4 2 8        byte i is column i; byte 0 is the border's and never kept, so that a
//!   ^ byte 0: the corner        0 3 9 1        comparison of whole rows gives the bits of a `Mask`
//! ```
//!
//! Edges come first, each from its own samples alone, so that both neighbours have the same: recursive splitting at
//! the sample farthest from the chord (Douglas and Peucker, "Algorithms for the reduction of the number of points",
//! Cartographica 10(2), 1973). Then the interiors (`greedy.rs`).

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use terrain_core::{Heightmap, Sample};

use crate::greedy::{Greedy, LEAST_CODE};
use crate::ladder::{Level, code_of};
use crate::lattice::{Vertex, position, vertex};
use crate::levels::NodeLevels;
use crate::patches::{EdgeId, EdgeRun, PatchArea, PatchGrid, PatchId};
use crate::select::Mask;

/// Codes of all samples of a DEM.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ThresholdMap {
    /// Bytes a row, and rows an edge: the side of a whole patch.
    side: usize,
    /// `side` bytes an edge.
    edges: Vec<u8>,
    /// `side * (side - 1)` bytes a patch.
    interiors: Vec<u8>,
}

impl ThresholdMap {
    /// Computes the map on the threads of the current rayon pool; the result does not depend on them.
    ///
    /// `progress` is told how many of how many patches are done, by any thread, not always in order.
    pub fn build(heightmap: &Heightmap, grid: &PatchGrid, progress: &(dyn Fn(usize, usize) + Sync)) -> Self {
        let (side, patches) = (grid.side() as usize, grid.patches() as usize);
        let mut map = Self {
            side,
            edges: vec![0; grid.edges() as usize * side],
            interiors: vec![0; patches * side * (side - 1)],
        };
        map.edges.par_chunks_mut(side).enumerate().for_each_init(Vec::new, |pending, (edge, codes)| {
            edge_codes(heightmap, grid.run(edge as EdgeId), pending, codes);
        });
        let (edges, done) = (&map.edges, AtomicUsize::new(0));
        let interiors = map.interiors.par_chunks_mut(side * (side - 1)).enumerate();
        interiors.for_each_init(Workspace::new, |workspace, (patch, codes)| {
            workspace.list_border(grid, patch as PatchId, edges);
            workspace.inner_codes(heightmap, grid.area(patch as PatchId), side, codes);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, patches);
        });
        map
    }

    /// A map that [`Self::codes`] gave, from the beginning of `bytes`, which then begin behind it.
    pub(crate) fn take_from(bytes: &mut &[u8], grid: &PatchGrid) -> Option<Self> {
        let side = grid.side() as usize;
        let mut take = |count| Some(bytes.split_off(..count)?.to_vec());
        let edges = take(grid.edges() as usize * side)?;
        Some(Self { side, edges, interiors: take(grid.patches() as usize * side * (side - 1))? })
    }

    /// The codes of all edges, then those of all interiors.
    pub(crate) fn codes(&self) -> [&[u8]; 2] {
        [&self.edges, &self.interiors]
    }

    /// The inner samples of an edge that are kept at levels of its runs of 8 samples.
    pub(crate) fn edge_mask(&self, edge: EdgeId, levels: &[Level; 8]) -> Mask {
        kept(&self.edges[edge as usize * self.side..][..self.side], levels)
    }

    /// The inner samples of a patch that are kept at levels of its blocks, a mask for each of its inner rows.
    pub(crate) fn interior_masks(
        &self,
        patch: PatchId,
        inner_rows: u32,
        levels: &NodeLevels,
    ) -> impl Iterator<Item = Mask> {
        let codes = &self.interiors[patch as usize * self.side * (self.side - 1)..];
        let rows = codes.chunks_exact(self.side).zip(1..=inner_rows);
        rows.map(|(codes, row)| kept(codes, &levels.row(row)))
    }
}

/// Bit `i` for each byte `i` that is larger than the level of its run of eight bytes.
fn kept(codes: &[u8], levels: &[Level; 8]) -> Mask {
    let (chunks, rest) = codes.as_chunks::<8>();
    debug_assert!(rest.is_empty(), "sides of patches are multiples of 8");
    let runs = chunks.iter().zip(levels).enumerate();
    runs.fold(0, |mask, (i, (run, level))| mask | larger_bytes(u64::from_le_bytes(*run), *level) << (8 * i))
}

/// Bit `i` where byte `i` of a word is larger than a number.
fn larger_bytes(bytes: u64, number: u8) -> u64 {
    const LOW: u64 = 0x0101_0101_0101_0101;
    const HIGH: u64 = 0x8080_8080_8080_8080;
    let numbers = LOW * number as u64;
    // Bit 7 of each byte: number - byte borrows (Warren, "Hacker's Delight", 2-13), without crossing bytes.
    let difference = (numbers | HIGH) - (bytes & !HIGH);
    let larger = (!numbers & bytes | !(numbers ^ bytes) & !difference) & HIGH;
    // Gathers the bits 7, 15, 23, ... in the top byte.
    (larger >> 7).wrapping_mul(0x0102_0408_1020_4080) >> 56
}

/// Codes of the inner samples of an edge. A sample never has a larger code than the split that it depends on.
fn edge_codes(heightmap: &Heightmap, run: EdgeRun, pending: &mut Vec<(u32, u32, u8)>, codes: &mut [u8]) {
    pending.push((0, run.length, u8::MAX));
    while let Some((from, to, limit)) = pending.pop() {
        let Some((worst, deviation_m)) = farthest(deviations_m(heightmap, run, from, to)) else { continue };
        let code = code_of(deviation_m).clamp(LEAST_CODE, limit);
        codes[worst as usize] = code;
        pending.extend([(from, worst, code), (worst, to, code)]);
    }
}

/// How far the samples between two others of an edge are from the straight line between those, vertically.
pub(crate) fn deviations_m(
    heightmap: &Heightmap,
    run: EdgeRun,
    from: u32,
    to: u32,
) -> impl Iterator<Item = (u32, f64)> {
    let height_m = move |i: u32| heightmap.height_m(run.sample(i)) as f64;
    let (start_m, rise_m, length) = (height_m(from), height_m(to) - height_m(from), (to - from) as f64);
    let numerator = move |i: u32| ((i - from) as f64 * rise_m - length * (height_m(i) - start_m)).abs();
    (from + 1..to).map(move |i| (i, numerator(i) / length))
}

/// The first of the samples that are farthest away.
pub(crate) fn farthest(deviations_m: impl Iterator<Item = (u32, f64)>) -> Option<(u32, f64)> {
    deviations_m.reduce(|a, b| if b.1 > a.1 { b } else { a })
}

/// Memory of one thread.
struct Workspace {
    greedy: Greedy,
    border: Vec<(u8, Vertex)>,
}

impl Workspace {
    fn new() -> Self {
        Self { greedy: Greedy::new(), border: Vec::new() }
    }

    /// Lists the samples of a patch's outline, the largest codes first.
    fn list_border(&mut self, grid: &PatchGrid, patch: PatchId, edges: &[u8]) {
        let first = grid.area(patch).first;
        let local = |Sample { column, row }| vertex(column - first.column, row - first.row);
        self.border.clear();
        for edge in grid.edges_of(patch).all() {
            let (run, codes) = (grid.run(edge), &edges[(edge * grid.side()) as usize..]);
            self.border.extend((1..run.length).map(|i| (codes[i as usize], local(run.sample(i)))));
        }
        self.border.sort_unstable_by(|a, b| b.cmp(a));
    }

    fn inner_codes(&mut self, heightmap: &Heightmap, area: PatchArea, side: usize, codes: &mut [u8]) {
        let (width, depth) = (area.width as usize, area.depth as usize);
        for row in codes.chunks_exact_mut(side).take(depth - 1) {
            row[1..width].fill(LEAST_CODE);
        }
        self.greedy.run(heightmap, area, &self.border, |sample, code| {
            let (column, row) = position(sample);
            codes[(row as usize - 1) * side + column as usize] = code;
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_is_compared_with_every_level_at_every_place() {
        for level in 0..=u8::MAX {
            for byte in 0..=u8::MAX {
                for place in 0..16 {
                    let mut codes = [level; 16];
                    codes[place] = byte;
                    assert_eq!(kept(&codes, &[level; 8]), ((byte > level) as Mask) << place);
                    let others = if level > 0 { 0xffff & !(1 << place) } else { 0 };
                    assert_eq!(kept(&codes, &[level.saturating_sub(1); 8]) & !(1 << place), others);
                }
            }
        }
    }

    fn codes_of(heights_m: &[f32]) -> Vec<u8> {
        let (columns, heights_m) = (heights_m.len() as u32, [heights_m, heights_m].concat());
        let dem = Heightmap::new(columns, 2, [1.0; 2], heights_m).unwrap();
        let mut codes = vec![0; columns as usize - 1];
        let run = EdgeRun { first: Sample { column: 0, row: 0 }, length: columns - 1, along_x: true };
        edge_codes(&dem, run, &mut Vec::new(), &mut codes);
        codes
    }

    #[test]
    fn an_edge_splits_at_the_sample_farthest_from_the_chord() {
        assert_eq!(codes_of(&[1.0, 2.0, 3.0, 4.0, 5.0]), [0, 1, 1, 1]);
        assert_eq!(codes_of(&[0.0, 0.0, 8.0, 0.0, 0.0]), [0, code_of(4.0), code_of(8.0), code_of(4.0)]);
        // The second split is farther from its chord than the first was, but of no use without it.
        assert_eq!(codes_of(&[0.0, -6.0, 7.0, 0.0]), [0, code_of(7.0), code_of(7.0)]);
    }
}
