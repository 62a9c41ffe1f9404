//! One irregular mesh for all views, made offline: greedy Delaunay insertion over the whole DEM, for a camera at a fixed
//! distance (Garland and Heckbert, "Fast polygonal approximation of terrains and height fields", CMU-CS-95-181, 1995).
//!
//! It stands for the fewest triangles that a mesh of one vertical tolerance gets along with: no patches, no borders, no
//! levels. It is close to what is known to be achievable, and no proof of a minimum. A method that follows the view has
//! to need fewer, since far terrain may be coarser; where it needs more, its structure costs more than the view saves.
//!
//! The tolerance in pixels counts at the given distance: nearer terrain is off by more pixels, and so it is no bound.

mod delaunay;
mod insertion;

use std::sync::Arc;

use terrain_core::{
    BakedVertex, Buffer, BufferSizes, Draw, FramePlan, Growth, Heightmap, IndexFormat, LodMethod, PatchTag, VertexKind,
    View,
};

use crate::error::{BaselineError, check_tolerance};
pub use insertion::GreedyInsertion;

/// A static mesh, made for the lens of the first view.
pub struct Greedy {
    heightmap: Arc<Heightmap>,
    tolerance_px: f64,
    distance_m: f64,
    /// The tolerance in metres of the mesh in the buffers.
    made_for_m: Option<f64>,
    sizes: BufferSizes,
    index_count: u32,
}

impl Greedy {
    /// The mesh that a camera at `distance_m` metres from all of it sees within `tolerance_px` pixels. The first plan makes
    /// it, in seconds for a million samples, and so does one with another lens. At most
    /// [`GreedyInsertion::MAX_SIDE`] samples along a side.
    pub fn new(heightmap: Arc<Heightmap>, tolerance_px: f64, distance_m: f64) -> Result<Self, BaselineError> {
        check_tolerance(tolerance_px)?;
        if !(distance_m > 0.0 && distance_m.is_finite()) {
            return Err(BaselineError::Distance(distance_m));
        }
        let side = heightmap.columns().max(heightmap.rows());
        if side > GreedyInsertion::MAX_SIDE {
            return Err(BaselineError::Side(side));
        }
        let sizes = BufferSizes {
            vertex_kind: VertexKind::Baked,
            index_format: IndexFormat::U32,
            vertices: size_of::<BakedVertex>() as u64,
            indices: size_of::<u32>() as u64,
            instances: 0,
            heights: None,
            cell_side: None,
        };
        Ok(Self { heightmap, tolerance_px, distance_m, made_for_m: None, sizes, index_count: 0 })
    }

    /// Half of the DEM's longer extent: a distance that is neither near nor far, whatever the DEM.
    pub fn usual_distance_m(heightmap: &Heightmap) -> f64 {
        let [x_m, z_m] = heightmap.extent_m();
        x_m.max(z_m) / 2.0
    }

    fn make(&mut self, tolerance_m: f64, plan: &mut FramePlan) {
        let mut greedy = GreedyInsertion::new(&self.heightmap);
        greedy.refine(tolerance_m);
        let mut vertex_of = vec![u32::MAX; self.heightmap.heights_m().len()];
        let mut vertices = Vec::new();
        let mut indices = Vec::with_capacity(3 * greedy.triangle_count());
        for sample in greedy.triangles().into_iter().flat_map(|triangle| triangle.samples) {
            let vertex = &mut vertex_of[self.heightmap.index(sample) as usize];
            if *vertex == u32::MAX {
                *vertex = vertices.len() as u32;
                vertices.push(BakedVertex::of(&self.heightmap, sample));
            }
            indices.push(*vertex);
        }
        self.send(Buffer::Vertices, &vertices, plan);
        self.send(Buffer::Indices, &indices, plan);
        self.index_count = indices.len() as u32;
    }

    fn send<T: bytemuck::NoUninit>(&mut self, buffer: Buffer, values: &[T], plan: &mut FramePlan) {
        let bytes = size_of_val(values) as u64;
        let held = if buffer == Buffer::Vertices { self.sizes.vertices } else { self.sizes.indices };
        if bytes > held {
            let growth = Growth { buffer, bytes };
            self.sizes.grow(&growth);
            plan.growths.push(growth);
        }
        plan.upload(buffer, 0, values);
    }
}

impl LodMethod for Greedy {
    fn name(&self) -> &'static str {
        "greedy"
    }

    fn buffers(&self) -> BufferSizes {
        self.sizes
    }

    fn set_culling(&mut self, _culling: bool) {
        // One draw: all or nothing.
    }

    fn plan(&mut self, view: &View, plan: &mut FramePlan) {
        plan.clear();
        let tolerance_m = self.tolerance_px / view.pixels(1.0, self.distance_m);
        if self.made_for_m.replace(tolerance_m) != Some(tolerance_m) {
            self.make(tolerance_m, plan);
        }
        plan.draws.push(Draw::baked(0..self.index_count, 0, PatchTag { patch: 0, level: 0 }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unusable_settings_are_refused_in_one_line() {
        let dem = Arc::new(Heightmap::new(2, 20_000, [1.0; 2], vec![0.0; 40_000]).unwrap());
        let refuse = |px, m| Greedy::new(dem.clone(), px, m).err().unwrap().to_string();
        assert_eq!(refuse(1.0, 0.0), "distance of 0 m: expected a finite number above 0");
        assert_eq!(refuse(f64::NAN, 1.0), "tolerance of NaN px: expected a finite number above 0");
        assert_eq!(refuse(1.0, 1.0), "20000 samples along a side: greedy insertion takes at most 16384");
    }
}
