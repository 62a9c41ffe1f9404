//! Bounded selection: no sample is farther from its patch's mesh than the patch's tolerance, whatever its edges keep.
//!
//! The threshold map is sound where a patch and its four edges have one level. An edge takes the finer level of its two
//! patches, so a patch may get *extra* border samples. They can spoil triangles, but only those that touch one:
//!
//! ```text
//!   +-------+-------+     S: what the patch keeps at its own level, E: the extra samples (*). A Delaunay triangle of
//!   |     . |     * |     S + E without a corner in E has no point of S in its circle, so it is a triangle of S
//!   |  .    * .     |     alone, and those are sound. The tie-break is a consistent lifting: with it this holds for
//!   |    .  *    .  |     points on one circle too.
//!   +-------+-------+     Repair: the worst sample of each bad triangle joins E and the triangulation, until none is
//!    coarse   fine        bad.
//! ```
//!
//! The result is a function of the map, the level and the levels of the edges alone.

use terrain_core::Heightmap;

use crate::deviation::PatchHeights;
use crate::ladder::{Level, tolerance_m};
use crate::lattice::{Vertex, vertex};
use crate::patches::{PatchArea, PatchGrid, PatchId};
use crate::select::{Border, Mask};
use crate::threshold_map::ThresholdMap;
use crate::triangulate::{GridKernel, KeptSamples, bits};

/// What a patch keeps at a level, with its edges at levels of their own.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    level: Level,
    border: Border,
    interior: Vec<Mask>,
    /// Samples of the border that the patch's own level would not keep.
    extra: Border,
}

impl Selection {
    /// Selects anew, in the memory of the last selection.
    ///
    /// `edge_levels`: north, south, west, east; none above `level`, or the bound does not hold.
    pub fn select(
        &mut self,
        map: &ThresholdMap,
        grid: &PatchGrid,
        patch: PatchId,
        level: Level,
        edge_levels: [Level; 4],
    ) {
        debug_assert!(edge_levels.iter().all(|edge| *edge <= level), "an edge coarser than its patch");
        let edges = grid.edges_of(patch).all();
        let kept = |i: usize| map.edge_mask(edges[i], edge_levels[i]);
        let extra = |i: usize| if edge_levels[i] < level { kept(i) & !map.edge_mask(edges[i], level) } else { 0 };
        let border = |[north, south, west, east]: [Mask; 4]| Border { north, south, west, east };
        self.level = level;
        self.border = border([0, 1, 2, 3].map(kept));
        self.extra = border([0, 1, 2, 3].map(extra));
        let inner_rows = grid.area(patch).depth as usize - 1;
        map.interior_masks(patch, inner_rows, level, &mut self.interior);
    }

    /// The samples that the four edges keep.
    pub fn border(&self) -> Border {
        self.border
    }

    /// The samples that the inner rows keep, before any repair.
    pub fn interior(&self) -> &[Mask] {
        &self.interior
    }

    /// Samples of the border that the patch's own level would not keep. Without such nothing is checked.
    pub fn extra(&self) -> Border {
        self.extra
    }

    fn kept_samples(&self, area: PatchArea, place: VertexPlace) -> KeptSamples<'_> {
        KeptSamples {
            width: area.width,
            depth: area.depth,
            border: self.border,
            interior: &self.interior,
            first_index: place.first_index,
            row_stride: place.row_stride,
        }
    }

    /// Whether the triangles of both are the same: the same samples, checked against the same limit or not at all.
    pub fn gives_the_mesh_of(&self, other: &Self) -> bool {
        let unchecked = self.extra == Border::default() && other.extra == Border::default();
        (unchecked || self.level == other.level) && self.border == other.border && self.interior == other.interior
    }
}

/// The levels of a patch's edges, north, south, west, east: each the finer one of the patches on its two sides.
///
/// `levels`: of all patches.
pub fn edge_levels(grid: &PatchGrid, patch: PatchId, levels: &[Level]) -> [Level; 4] {
    grid.edges_of(patch).all().map(|edge| {
        let beside = grid.patches_of(edge).into_iter().flatten();
        beside.map(|patch| levels[patch as usize]).min().expect("an edge has a patch")
    })
}

/// Where a patch's samples are in a vertex buffer: at `first_index + row * row_stride + column`.
#[derive(Clone, Copy)]
pub(crate) struct VertexPlace {
    pub first_index: u32,
    pub row_stride: u32,
}

impl VertexPlace {
    fn in_whole_dem(heightmap: &Heightmap, area: PatchArea) -> Self {
        Self { first_index: heightmap.index(area.first), row_stride: heightmap.columns() }
    }
}

/// What had to be added to keep the bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repair {
    /// Checks that found bad triangles.
    pub rounds: u32,
    /// Samples added.
    pub samples: u32,
}

/// Workspace that turns selections into triangles, one after the other.
pub struct BoundedMesher {
    kernel: GridKernel,
    /// The samples whose triangles have to be checked: E of the figure above, then the newest ones of it.
    suspects: VertexSet,
    /// The worst samples of the last round's bad triangles, with the numbers of those.
    worst: Vec<(usize, Vertex)>,
}

impl Default for BoundedMesher {
    fn default() -> Self {
        Self { kernel: GridKernel::new(), suspects: VertexSet::default(), worst: Vec::new() }
    }
}

impl BoundedMesher {
    /// Appends the triangles of a patch: indices into a vertex buffer that holds the whole DEM, counter-clockwise seen
    /// from above. No sample of the patch is farther from them than the tolerance of the selection's level.
    pub fn triangulate(
        &mut self,
        heightmap: &Heightmap,
        area: PatchArea,
        selection: &Selection,
        indices: &mut Vec<u32>,
    ) -> Repair {
        self.triangulate_at(heightmap, area, selection, VertexPlace::in_whole_dem(heightmap, area), indices)
    }

    /// The same with indices into another vertex buffer.
    pub(crate) fn triangulate_at(
        &mut self,
        heightmap: &Heightmap,
        area: PatchArea,
        selection: &Selection,
        place: VertexPlace,
        indices: &mut Vec<u32>,
    ) -> Repair {
        let kept = selection.kept_samples(area, place);
        self.kernel.connect(&kept);
        self.suspects.fill(area, selection.extra);
        let repair = if self.suspects.is_empty() {
            Repair::default()
        } else {
            let touches = |suspects: &VertexSet, corners: [Vertex; 3]| corners.iter().any(|v| suspects.contains(*v));
            self.repair(&PatchHeights::new(heightmap, area), tolerance_m(selection.level), touches)
        };
        self.kernel.append_indices(&kept, indices);
        repair
    }

    /// Adds samples until no triangle is bad of those that `is_suspect` says may be.
    fn repair(
        &mut self,
        heights: &PatchHeights,
        limit_m: f64,
        is_suspect: impl Fn(&VertexSet, [Vertex; 3]) -> bool,
    ) -> Repair {
        let mut repair = Repair::default();
        while self.find_worst(heights, limit_m, &is_suspect) {
            repair.rounds += 1;
            // A triangle without a new corner was there before, and good: a bad one's circle holds its worst sample.
            self.suspects.clear();
            for (triangle, sample) in self.worst.drain(..) {
                // Two triangles may have the same worst sample, on the side between them.
                if self.suspects.insert(sample) {
                    self.kernel.add(sample, triangle);
                    repair.samples += 1;
                }
            }
        }
        repair
    }

    /// Lists the worst samples of the suspect triangles that are farther away than the limit. Whether there are any.
    fn find_worst(
        &mut self,
        heights: &PatchHeights,
        limit_m: f64,
        is_suspect: impl Fn(&VertexSet, [Vertex; 3]) -> bool,
    ) -> bool {
        for (triangle, corners) in self.kernel.triangles().enumerate() {
            if is_suspect(&self.suspects, corners)
                && let Some(worst) = heights.worst_beyond(limit_m, corners)
            {
                self.worst.push((triangle, worst.sample));
            }
        }
        !self.worst.is_empty()
    }
}

/// Vertices of a patch, a bit each.
struct VertexSet {
    /// Four words a row: 256 columns, as keys have it.
    words: [u64; 4 * 65],
    members: u32,
}

impl Default for VertexSet {
    fn default() -> Self {
        Self { words: [0; 4 * 65], members: 0 }
    }
}

impl VertexSet {
    fn clear(&mut self) {
        if !self.is_empty() {
            *self = Self::default();
        }
    }

    /// Replaces all members by samples of a patch's border.
    fn fill(&mut self, area: PatchArea, Border { north, south, west, east }: Border) {
        self.clear();
        for i in bits(north) {
            self.insert(vertex(i, 0));
        }
        for i in bits(south) {
            self.insert(vertex(i, area.depth));
        }
        for i in bits(west) {
            self.insert(vertex(0, i));
        }
        for i in bits(east) {
            self.insert(vertex(area.width, i));
        }
    }

    /// Adds a vertex; false if it was there before.
    fn insert(&mut self, vertex: Vertex) -> bool {
        let is_new = !self.contains(vertex);
        self.words[vertex as usize >> 6] |= 1 << (vertex & 63);
        self.members += is_new as u32;
        is_new
    }

    fn contains(&self, vertex: Vertex) -> bool {
        self.words[vertex as usize >> 6] >> (vertex & 63) & 1 == 1
    }

    fn is_empty(&self) -> bool {
        self.members == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ladder::level_of;
    use crate::lattice::position;
    use terrain_core::SplitMix64;

    fn rough_dem(seed: u64) -> Heightmap {
        let mut random = SplitMix64::new(seed);
        let roughness = random.range(0.0, 40.0);
        let waves = [0; 3].map(|_| (random.range(0.0, 0.4), random.range(0.0, 0.4), random.range(0.0, 300.0)));
        let height_m = |i: u32| {
            let (x, z) = ((i % 70) as f64, (i / 70) as f64);
            let hills: f64 = waves.iter().map(|(u, v, h)| h * (x * u + z * v).sin()).sum();
            (hills + random.range(0.0, roughness)) as f32
        };
        Heightmap::new(70, 81, [10.0; 2], (0..70 * 81).map(height_m).collect()).unwrap()
    }

    /// The triangulation of the same samples, from nothing.
    fn anew(kernel: &GridKernel, kept: KeptSamples) -> GridKernel {
        let mut interior = kept.interior.to_vec();
        for (column, row) in kernel.triangles().flatten().map(position) {
            if column > 0 && (column as u32) < kept.width && row > 0 && (row as u32) < kept.depth {
                interior[row as usize - 1] |= 1 << column;
            }
        }
        let mut kernel = GridKernel::new();
        kernel.connect(&KeptSamples { interior: &interior, ..kept });
        kernel
    }

    fn sorted(kernel: &GridKernel) -> Vec<[Vertex; 3]> {
        let mut triangles: Vec<_> = kernel.triangles().collect();
        for corners in &mut triangles {
            let least = (0..3).min_by_key(|i| corners[*i]).unwrap();
            corners.rotate_left(least);
        }
        triangles.sort_unstable();
        triangles
    }

    #[test]
    fn the_local_check_finds_what_the_check_of_all_triangles_finds() {
        let (mut local, mut full) = (BoundedMesher::default(), BoundedMesher::default());
        let mut selection = Selection::default();
        let mut samples = 0;
        for seed in 0..60 {
            let dem = rough_dem(seed);
            let mut random = SplitMix64::new(seed);
            let grid = PatchGrid::new(&dem, [8, 16, 32, 64][seed as usize % 4]);
            let map = ThresholdMap::build(&dem, &grid, &|_, _| {});
            let mut level = |_| level_of(random.range(-5.0, 9.0).exp2());
            let levels: Vec<Level> = (0..grid.patches()).map(&mut level).collect();
            for patch in 0..grid.patches() {
                let (area, edges) = (grid.area(patch), edge_levels(&grid, patch, &levels));
                selection.select(&map, &grid, patch, levels[patch as usize], edges);
                let mut indices = Vec::new();
                let repair = local.triangulate(&dem, area, &selection, &mut indices);
                let kept = selection.kept_samples(area, VertexPlace::in_whole_dem(&dem, area));
                full.kernel.connect(&kept);
                let heights = PatchHeights::new(&dem, area);
                let of_all = full.repair(&heights, tolerance_m(selection.level), |_, _| true);
                let mut all = Vec::new();
                full.kernel.append_indices(&kept, &mut all);
                assert_eq!((of_all, all), (repair, indices), "seed {seed}, patch {patch}");
                assert_eq!(sorted(&full.kernel), sorted(&anew(&full.kernel, kept)), "seed {seed}, patch {patch}");
                samples += repair.samples;
            }
        }
        assert!(samples > 500, "{samples} samples added: too few to compare anything");
    }

    #[test]
    fn equal_samples_give_the_mesh_of_each_other_unless_the_limit_differs() {
        let dem = rough_dem(1);
        let grid = PatchGrid::new(&dem, 32);
        let map = ThresholdMap::build(&dem, &grid, &|_, _| {});
        let select = |level, edges| {
            let mut selection = Selection::default();
            selection.select(&map, &grid, 0, level, edges);
            selection
        };
        // Above 9,000 m this DEM needs its corners alone.
        let (coarse, coarser) = (level_of(9_000.0), level_of(90_000.0));
        assert!(select(coarse, [coarse; 4]).gives_the_mesh_of(&select(coarser, [coarser; 4])));
        let fine = level_of(1.0);
        let mixed = [fine, coarse, coarse, coarse];
        assert!(select(coarse, mixed).gives_the_mesh_of(&select(coarse, mixed)));
        assert!(!select(coarse, mixed).gives_the_mesh_of(&select(coarser, mixed)));
        assert!(!select(coarse, mixed).gives_the_mesh_of(&select(coarse, [coarse; 4])));
    }
}
