//! The vertex and instance layouts that methods write, the renderer binds and the mirror reads.

use bytemuck::{Pod, Zeroable};

/// One grid point of the DEM, by column (x, east) and row (z, south).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Sample {
    /// 0 is the western column.
    pub column: u32,
    /// 0 is the northern row.
    pub row: u32,
}

/// A vertex with its own height: 8 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct BakedVertex {
    /// Column and row of the sample.
    pub sample: [u16; 2],
    /// Its height in metres.
    pub height_m: f32,
}

impl BakedVertex {
    /// The vertex of one sample of the DEM.
    pub fn of(heightmap: &crate::Heightmap, at: Sample) -> Self {
        Self { sample: [at.column as u16, at.row as u16], height_m: heightmap.height_m(at) }
    }

    /// The whole DEM as a static vertex buffer: sample `i` of the heightmap is vertex `i`.
    pub fn whole_dem(heightmap: &crate::Heightmap) -> Vec<Self> {
        let samples =
            (0..heightmap.rows()).flat_map(|row| (0..heightmap.columns()).map(move |column| Sample { column, row }));
        samples.map(|at| Self::of(heightmap, at)).collect()
    }
}

/// A vertex of a patch that is drawn by instances: 4 bytes, in steps along the instance's two legs.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct LocalVertex {
    /// Steps along leg u and leg v.
    pub uv: [u16; 2],
}

/// An integer affine map from local coordinates to samples, and what it draws: 20 bytes.
///
/// `sample = clamp(origin + u * leg_u + v * leg_v)`, clamped to the DEM's last column and row, so that a patch that
/// reaches over the rim ends on it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct PatchInstance {
    /// Column and row of local (0, 0).
    pub origin: [i32; 2],
    /// Columns and rows for one step in u.
    pub leg_u: [i16; 2],
    /// Columns and rows for one step in v.
    pub leg_v: [i16; 2],
    /// A [`PatchTag`](crate::PatchTag), for the pictures that colour by patch or by level.
    pub tag: u32,
}

impl PatchInstance {
    /// The sample of a local vertex on a DEM of `columns` x `rows` samples. `shaders/terrain.wgsl` computes the same.
    pub fn sample(&self, vertex: LocalVertex, columns: u32, rows: u32) -> Sample {
        let [u, v] = vertex.uv.map(i32::from);
        let along = |axis: usize, last: u32| {
            let at = self.origin[axis] + u * self.leg_u[axis] as i32 + v * self.leg_v[axis] as i32;
            at.clamp(0, last as i32) as u32
        };
        Sample { column: along(0, columns - 1), row: along(1, rows - 1) }
    }
}
