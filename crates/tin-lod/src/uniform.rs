//! A mesh of a whole DEM at one tolerance, without a camera.

use rayon::prelude::*;
use terrain_core::Heightmap;

use crate::border::Cut;
use crate::bounded::BoundedMesher;
use crate::ladder::level_of;
use crate::levels::NodeLevels;
use crate::node_maps::NodeMaps;
use crate::nodes::{NodeId, Nodes, Owners};
use crate::selection::Selection;

/// The largest that there is: without a camera a patch has one level anyway, and fewer patches have fewer corners.
const PATCH: u32 = 64;

/// The triangles of a DEM at one tolerance in metres: no sample is farther from them, measured vertically.
///
/// Triples of indices into the heights (row by row), counter-clockwise seen from above with x to the east and z to the
/// south. They are watertight and cover the grid exactly once. The tolerance is rounded down to a rung of the
/// [`ladder`](crate::ladder), by 9 % at most; below its first rung, 0.05 m, every sample is a corner.
///
/// Greedy insertion in patches of 64 x 64 intervals (Garland and Heckbert 1995), 1.03 to 1.05 times the triangles of
/// greedy insertion over the whole DEM (`cargo bench -p tin-lod --bench reference`). Runs on the threads of the current
/// rayon pool; the result does not depend on them.
///
/// ```
/// let heightmap = terrain_core::Heightmap::new(3, 2, [10.0; 2], vec![0.0, 5.0, 0.0, 0.0, 5.0, 0.0])?;
/// assert_eq!(tin_lod::mesh_at_tolerance(&heightmap, 6.0).len(), 2); // the four corners
/// assert_eq!(tin_lod::mesh_at_tolerance(&heightmap, 4.0).len(), 4); // and the ridge
/// # Ok::<(), terrain_core::HeightmapError>(())
/// ```
pub fn mesh_at_tolerance(heightmap: &Heightmap, tolerance_m: f64) -> Vec<[u32; 3]> {
    let maps = NodeMaps::build(heightmap, Nodes::new(heightmap, PATCH, 1));
    let (nodes, levels) = (maps.nodes(), vec![NodeLevels::Uniform(level_of(tolerance_m)); maps.nodes().len()]);
    let cut = Cut { heightmap, maps: &maps, owners: &Owners::roots(nodes), levels: &levels };
    let triangles = |mesher: &mut BoundedMesher, patch: NodeId| -> Vec<[u32; 3]> {
        let (mut selection, mut indices) = (Selection::default(), Vec::new());
        selection.select(&cut, patch);
        mesher.triangulate(heightmap, nodes.area(patch), &selection, &mut indices);
        indices.as_chunks().0.to_vec()
    };
    nodes.roots().into_par_iter().map_init(BoundedMesher::default, triangles).flatten_iter().collect()
}
