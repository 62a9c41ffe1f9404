//! Bounded triangulation: no sample is farther from its node's mesh than the node's tolerance, whatever its border keeps.
//!
//! The threshold map of a node (a patch, or a group of patches) is sound where the border keeps what the map needs and
//! no more. A border keeps what the nodes on both of its sides need (`border.rs`), so a node may get *extra* border
//! samples. They can spoil triangles, but only those that touch one:
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
//! A patch whose blocks have levels of their own (`levels.rs`) keeps what no single set of the map holds: all of its
//! triangles are checked, each sample against the tolerance of its block.
//!
//! The result is a function of the maps, and of the levels of the node and of those around it.

use terrain_core::Heightmap;

use crate::deviation::{PatchHeights, Worst};
use crate::ladder::tolerance_m;
use crate::lattice::{Vertex, vertex};
use crate::levels::NodeLevels;
use crate::patches::PatchArea;
use crate::select::Border;
use crate::selection::Selection;
use crate::triangulate::{GridKernel, bits};
use crate::vertices::VertexPlace;

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
    /// Appends the triangles of a node: indices into a vertex buffer that holds the whole DEM, counter-clockwise seen
    /// from above. No sample of the node is farther from them than the tolerance of the selection's level.
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
        let heights = PatchHeights::new(heightmap, area);
        let touches = |suspects: &VertexSet, corners: [Vertex; 3]| corners.iter().any(|v| suspects.contains(*v));
        self.suspects.fill(area, selection.extra());
        let repair = match selection.levels() {
            NodeLevels::Uniform(_) if self.suspects.is_empty() => Repair::default(),
            NodeLevels::Uniform(level) => {
                let limit_m = tolerance_m(*level);
                self.repair(|corners| heights.worst_beyond(limit_m, corners), touches)
            }
            NodeLevels::Blocks(blocks) => {
                let limits_m = blocks.map(|row| row.map(tolerance_m));
                // Of the triangles before the first repair any may be bad.
                self.suspects.clear();
                let may_be_bad = |suspects: &VertexSet, corners| suspects.is_empty() || touches(suspects, corners);
                self.repair(|corners| heights.worst_beyond_blocks(&limits_m, corners), may_be_bad)
            }
        };
        self.kernel.append_indices(&kept, indices);
        repair
    }

    /// Adds samples until no triangle has a worst one of those that `is_suspect` says may be bad.
    fn repair(
        &mut self,
        worst_of: impl Fn([Vertex; 3]) -> Option<Worst>,
        is_suspect: impl Fn(&VertexSet, [Vertex; 3]) -> bool,
    ) -> Repair {
        let mut repair = Repair::default();
        while self.find_worst(&worst_of, &is_suspect) {
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

    /// Lists the worst samples of those suspect triangles that are bad. Whether there are any.
    fn find_worst(
        &mut self,
        worst_of: impl Fn([Vertex; 3]) -> Option<Worst>,
        is_suspect: impl Fn(&VertexSet, [Vertex; 3]) -> bool,
    ) -> bool {
        for (triangle, corners) in self.kernel.triangles().enumerate() {
            if is_suspect(&self.suspects, corners)
                && let Some(worst) = worst_of(corners)
            {
                self.worst.push((triangle, worst.sample));
            }
        }
        !self.worst.is_empty()
    }
}

/// Vertices of a node, a bit each.
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

    /// Replaces all members by samples of a border.
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
    use crate::border::Cut;
    use crate::ladder::level_of;
    use crate::lattice::position;
    use crate::node_maps::NodeMaps;
    use crate::nodes::{NodeId, Nodes, Owners};
    use crate::triangulate::KeptSamples;
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

    /// Some roots split, and some of their members.
    fn any_cut(nodes: &Nodes, random: &mut SplitMix64) -> Owners {
        let mut owners = Owners::roots(nodes);
        for node in (0..nodes.len() as NodeId).rev() {
            // A group has a larger number than its members.
            if owners.of(nodes.patches_of(node).next().unwrap()) == node && random.below(2) == 0 {
                nodes.members(node).for_each(|member| owners.give(nodes, member));
            }
        }
        owners
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
        for seed in 0..100 {
            let dem = rough_dem(seed);
            let mut random = SplitMix64::new(seed);
            let (patch, group) = [(8, 4), (16, 4), (32, 2), (64, 1)][seed as usize % 4];
            let nodes = Nodes::new(&dem, patch, group);
            let owners = any_cut(&nodes, &mut random);
            let maps = NodeMaps::build(&dem, nodes);
            let mut level = |_| NodeLevels::Uniform(level_of(random.range(-5.0, 9.0).exp2()));
            let levels: Vec<NodeLevels> = (0..maps.nodes().len()).map(&mut level).collect();
            let cut = Cut { heightmap: &dem, maps: &maps, owners: &owners, levels: &levels };
            let mut all_nodes = Vec::new();
            owners.of_all(0..maps.nodes().patches().patches(), &mut all_nodes);
            for node in all_nodes {
                let area = maps.nodes().area(node);
                selection.select(&cut, node);
                let mut indices = Vec::new();
                let repair = local.triangulate(&dem, area, &selection, &mut indices);
                let kept = selection.kept_samples(area, VertexPlace::in_whole_dem(&dem, area));
                full.kernel.connect(&kept);
                let heights = PatchHeights::new(&dem, area);
                let NodeLevels::Uniform(level) = *selection.levels() else { unreachable!() };
                let limit_m = tolerance_m(level);
                let of_all = full.repair(|corners| heights.worst_beyond(limit_m, corners), |_, _| true);
                let mut all = Vec::new();
                full.kernel.append_indices(&kept, &mut all);
                assert_eq!((of_all, all), (repair, indices), "seed {seed}, node {node}");
                assert_eq!(sorted(&full.kernel), sorted(&anew(&full.kernel, kept)), "seed {seed}, node {node}");
                samples += repair.samples;
            }
        }
        assert!(samples > 500, "{samples} samples added: too few to compare anything");
    }

    #[test]
    fn equal_samples_give_the_mesh_of_each_other_unless_the_limit_differs() {
        let dem = rough_dem(1);
        let nodes = Nodes::new(&dem, 32, 1);
        let owners = Owners::roots(&nodes);
        let maps = NodeMaps::build(&dem, nodes);
        // The first patch at one level, all others at another.
        let select = |level, around| {
            let mut selection = Selection::default();
            let mut levels = vec![NodeLevels::Uniform(around); maps.nodes().len()];
            levels[0] = NodeLevels::Uniform(level);
            selection.select(&Cut { heightmap: &dem, maps: &maps, owners: &owners, levels: &levels }, 0);
            selection
        };
        // Above 9,000 m this DEM needs its corners alone.
        let (coarse, coarser) = (level_of(9_000.0), level_of(90_000.0));
        assert!(select(coarse, coarse).gives_the_mesh_of(&select(coarser, coarser)));
        let fine = level_of(1.0);
        assert!(select(coarse, fine).gives_the_mesh_of(&select(coarse, fine)));
        assert!(!select(coarse, fine).gives_the_mesh_of(&select(coarser, fine)));
        assert!(!select(coarse, fine).gives_the_mesh_of(&select(coarse, coarse)));
    }
}
