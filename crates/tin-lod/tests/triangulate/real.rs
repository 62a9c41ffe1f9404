//! Patches as the two selectors make them from real terrain.

use terrain_core::{Heightmap, SplitMix64};
use tin_lod::algorithm1::{select_edge, select_interior};
use tin_lod::ladder;
use tin_lod::levels::NodeLevels;
use tin_lod::{Border, Cut, NodeMaps, Owners, PatchGrid, Selection};

use super::patches::Patch;

/// Visits the patches of a DEM as Algorithm 1 selects them at a tolerance in metres. Returns how many there are.
pub fn algorithm1(dem: &Heightmap, grid: &PatchGrid, tolerance_m: f64, mut visit: impl FnMut(&Patch)) -> u32 {
    let max_spacing = grid.side() / 2;
    for number in 0..grid.patches() {
        let area = grid.area(number);
        let edges = grid.edges_of(number).all();
        let [north, south, west, east] = edges.map(|edge| select_edge(dem, grid.run(edge), tolerance_m, max_spacing));
        let border = Border { north, south, west, east };
        let mut interior = Vec::new();
        select_interior(dem, area, border, tolerance_m, max_spacing, &mut interior);
        visit(&Patch { width: area.width, depth: area.depth, border, interior });
    }
    grid.patches()
}

/// Visits the nodes of a DEM as the bounded selector makes them, each at a level between 0.05 m and 1 km of its own, groups
/// and patches by lot, before any repair. Returns how many there are.
pub fn bounded(dem: &Heightmap, maps: &NodeMaps, seed: u64, mut visit: impl FnMut(&Patch)) -> u32 {
    let (mut random, nodes) = (SplitMix64::new(seed), maps.nodes());
    let level = |_| NodeLevels::Uniform(ladder::level_of(random.range(-4.4, 10.0).exp2()));
    let levels: Vec<NodeLevels> = (0..nodes.len()).map(level).collect();
    let mut owners = Owners::roots(nodes);
    for root in nodes.roots().filter(|_| random.below(2) == 0) {
        nodes.members(root).for_each(|member| owners.give(nodes, member));
    }
    let (mut all, mut selection) = (Vec::new(), Selection::default());
    owners.of_all(0..nodes.patches().patches(), &mut all);
    for node in &all {
        let area = nodes.area(*node);
        selection.select(&Cut { heightmap: dem, maps, owners: &owners, levels: &levels }, *node);
        let (border, interior) = (selection.border(), selection.interior().to_vec());
        visit(&Patch { width: area.width, depth: area.depth, border, interior });
    }
    all.len() as u32
}
