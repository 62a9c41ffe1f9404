//! Bounded meshes of whole DEMs, and how far they are from every sample.

use terrain_core::error::ErrorOracle;
use terrain_core::{Heightmap, Sample, Triangle, View};
use tin_lod::ladder::{self, Level};
use tin_lod::levels::{Boxes, NodeLevels};
use tin_lod::{BoundedMesher, Cut, NodeId, NodeMaps, Nodes, Owners, Repair, Selection};

/// A DEM and its threshold maps.
pub struct WholeDem {
    pub dem: Heightmap,
    pub maps: NodeMaps,
    /// Without those of blocks, and with.
    boxes: [Boxes; 2],
}

/// What a mesh consists of, and at which levels.
#[derive(Clone)]
pub struct Leveled {
    pub owners: Owners,
    pub levels: Vec<NodeLevels>,
}

/// Triangles of all nodes.
#[derive(Default)]
pub struct Mesh {
    pub indices: Vec<u32>,
    pub repair: Repair,
    pub nodes: u32,
    pub nodes_repaired: u32,
}

/// Deviations of all samples, against the tolerances of their nodes and blocks.
pub struct Bound {
    /// Samples above the tolerance of one of their nodes, without slack.
    pub above: u64,
    /// The largest quotient of a deviation and a tolerance.
    pub worst: f64,
    /// The largest deviation in pixels, if there is a view.
    pub worst_px: f64,
}

impl WholeDem {
    /// With groups of up to `group` x `group` patches.
    pub fn new(dem: Heightmap, patch: u32, group: u32) -> Self {
        let maps = NodeMaps::build(&dem, Nodes::new(&dem, patch, group));
        let boxes = [false, true].map(|blocks| Boxes::new(&dem, maps.nodes(), blocks));
        Self { dem, maps, boxes }
    }

    fn nodes(&self) -> &Nodes {
        self.maps.nodes()
    }

    /// The roots, all at one level.
    pub fn uniform(&self, level: Level) -> Leveled {
        Leveled { owners: Owners::roots(self.nodes()), levels: vec![NodeLevels::Uniform(level); self.nodes().len()] }
    }

    /// The levels of all nodes for a view, with blocks near the eye or without, and of each group and its members what
    /// costs less.
    pub fn of_view(&self, view: &View, tolerance_px: f64, blocks: bool) -> Leveled {
        let levels = |node| self.boxes[blocks as usize].levels(node, view, tolerance_px);
        self.best_cut((0..self.nodes().len() as NodeId).map(levels).collect())
    }

    /// Of each group and its members what costs less.
    pub fn best_cut(&self, levels: Vec<NodeLevels>) -> Leveled {
        let (nodes, mut owners, mut chosen) = (self.nodes(), Owners::roots(self.nodes()), Vec::new());
        for root in nodes.roots() {
            self.maps.cut(root, &levels, &mut chosen);
        }
        chosen.iter().for_each(|node| owners.give(nodes, *node));
        Leveled { owners, levels }
    }

    /// The nodes of a mesh.
    pub fn nodes_of(&self, Leveled { owners, .. }: &Leveled) -> Vec<NodeId> {
        let mut all = Vec::new();
        owners.of_all(0..self.nodes().patches().patches(), &mut all);
        all
    }

    pub fn cut<'a>(&'a self, Leveled { owners, levels }: &'a Leveled) -> Cut<'a> {
        Cut { heightmap: &self.dem, maps: &self.maps, owners, levels }
    }

    pub fn triangulate(&self, leveled: &Leveled, mesh: &mut Mesh) {
        let (mut selection, mut mesher) = (Selection::default(), BoundedMesher::default());
        let (cut, all) = (self.cut(leveled), self.nodes_of(leveled));
        (mesh.repair, mesh.nodes_repaired, mesh.nodes) = (Repair::default(), 0, all.len() as u32);
        mesh.indices.clear();
        for node in all {
            selection.select(&cut, node);
            let repair = mesher.triangulate(&self.dem, self.nodes().area(node), &selection, &mut mesh.indices);
            mesh.nodes_repaired += (repair.rounds > 0) as u32;
            mesh.repair.rounds = mesh.repair.rounds.max(repair.rounds);
            mesh.repair.samples += repair.samples;
        }
    }

    pub fn triangles(&self, mesh: &Mesh) -> Vec<Triangle> {
        let columns = self.dem.columns();
        let sample = |index: &u32| Sample { column: index % columns, row: index / columns };
        let triangle = |corners: &[u32; 3]| {
            let samples = corners.each_ref().map(sample);
            Triangle { samples, heights_m: samples.map(|s| self.dem.height_m(s)) }
        };
        mesh.indices.as_chunks().0.iter().map(triangle).collect()
    }

    /// Measures every sample with the error oracle. A sample that no triangle covers is above every tolerance.
    pub fn bound(&self, leveled: &Leveled, triangles: &[Triangle], view: Option<&View>) -> Bound {
        let mut oracle = ErrorOracle::new(&self.dem);
        oracle.set_mesh(triangles);
        let mut bound = Bound { above: 0, worst: 0.0, worst_px: 0.0 };
        for node in self.nodes_of(leveled) {
            let (area, levels) = (self.nodes().area(node), leveled.levels[node as usize]);
            for row in area.first.row..=area.last().row {
                for column in area.first.column..=area.last().column {
                    let at = Sample { column, row };
                    let deviation_m = oracle.deviation_m(at) as f64;
                    assert!(!deviation_m.is_nan(), "{at:?} is not covered");
                    if deviation_m > 0.0 {
                        let level = levels.at(area, column - area.first.column, row - area.first.row);
                        let tolerance_m = ladder::tolerance_m(level);
                        bound.above += (deviation_m > tolerance_m) as u64;
                        bound.worst = bound.worst.max(deviation_m / tolerance_m);
                        let px = |v: &View| v.pixels(deviation_m, v.eye_world.distance(self.dem.world(at).into()));
                        bound.worst_px = bound.worst_px.max(view.map_or(0.0, px));
                    }
                }
            }
        }
        bound
    }
}
