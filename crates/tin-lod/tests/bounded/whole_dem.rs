//! Bounded meshes of whole DEMs, and how far they are from every sample.

use terrain_core::error::ErrorOracle;
use terrain_core::{Heightmap, Sample, Triangle, View};
use tin_lod::ladder::{self, Level};
use tin_lod::{BoundedMesher, PatchGrid, Repair, Selection, ThresholdMap, edge_levels};

/// A DEM, its patches, and its threshold map.
pub struct WholeDem {
    pub dem: Heightmap,
    pub grid: PatchGrid,
    pub map: ThresholdMap,
}

/// Triangles of all patches.
#[derive(Default)]
pub struct Mesh {
    pub indices: Vec<u32>,
    pub repair: Repair,
    pub patches_repaired: u32,
}

/// Deviations of all samples, against the tolerances of their patches.
pub struct Bound {
    /// Samples above the tolerance of one of their patches, without slack.
    pub above: u64,
    /// The largest quotient of a deviation and a tolerance.
    pub worst: f64,
    /// The largest deviation in pixels, if there is a view.
    pub worst_px: f64,
}

impl WholeDem {
    pub fn new(dem: Heightmap, patch: u32) -> Self {
        let grid = PatchGrid::new(&dem, patch);
        let map = ThresholdMap::build(&dem, &grid, &|_, _| {});
        Self { dem, grid, map }
    }

    pub fn uniform(&self, level: Level) -> Vec<Level> {
        vec![level; self.grid.patches() as usize]
    }

    /// The level of each patch for a view: its tolerance at the point of its box that is nearest to the eye.
    pub fn levels_of(&self, view: &View, tolerance_px: f64) -> Vec<Level> {
        let level = |patch| {
            let area = self.grid.area(patch);
            let distance_m = view.distance_m(&self.dem.bounds_world(area.first, area.last()));
            ladder::level_of(view.metres(tolerance_px, distance_m))
        };
        (0..self.grid.patches()).map(level).collect()
    }

    pub fn triangulate(&self, levels: &[Level], mesh: &mut Mesh) {
        let (mut selection, mut mesher) = (Selection::default(), BoundedMesher::default());
        (mesh.repair, mesh.patches_repaired) = (Repair::default(), 0);
        mesh.indices.clear();
        for patch in 0..self.grid.patches() {
            let edges = edge_levels(&self.grid, patch, levels);
            selection.select(&self.map, &self.grid, patch, levels[patch as usize], edges);
            let repair = mesher.triangulate(&self.dem, self.grid.area(patch), &selection, &mut mesh.indices);
            mesh.patches_repaired += (repair.rounds > 0) as u32;
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
    pub fn bound(&self, levels: &[Level], triangles: &[Triangle], view: Option<&View>) -> Bound {
        let mut oracle = ErrorOracle::new(&self.dem);
        oracle.set_mesh(triangles);
        let mut bound = Bound { above: 0, worst: 0.0, worst_px: 0.0 };
        for patch in 0..self.grid.patches() {
            let (area, tolerance_m) = (self.grid.area(patch), ladder::tolerance_m(levels[patch as usize]));
            for row in area.first.row..=area.last().row {
                for column in area.first.column..=area.last().column {
                    let at = Sample { column, row };
                    let deviation_m = oracle.deviations_m()[self.dem.index(at) as usize] as f64;
                    assert!(!deviation_m.is_nan(), "{at:?} is not covered");
                    if deviation_m > 0.0 {
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
