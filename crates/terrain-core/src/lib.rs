//! What every part of the workspace shares: the heightmap, the view, the frame plan, and the oracles that judge a mesh.
//!
//! *A method plans, the renderer replays, the bench records.* A [`LodMethod`] turns a [`View`] into a [`FramePlan`];
//! the renderer replays it on the GPU, the [`MeshMirror`] on the CPU; statistics are counted from the plan
//! ([`FrameStats`]), cracks and errors from the mirror's triangles ([`watertight`], [`error`]).

pub mod contract;
pub mod damage;
pub mod error;
pub mod flight;
mod height_tiles;
mod heightmap;
pub mod histogram;
mod method;
mod mirror;
mod morph;
pub mod odometer;
pub mod picture;
mod plan;
pub mod popping;
mod random;
pub mod source;
mod stats;
mod vertex;
mod view;
mod voids;
pub mod walk;
pub mod watertight;

pub use flight::{Flight, FlightError, FlightPath};
pub use height_tiles::{HeightFormat, HeightTiles};
pub use heightmap::{Heightmap, HeightmapError};
pub use method::LodMethod;
pub use mirror::{MeshMirror, MirrorError, Triangle};
pub use morph::Morph;
pub use plan::{
    Buffer, BufferSizes, Draw, FramePlan, Growth, IndexFormat, PatchTag, StageTime, Streaming, Upload, VertexKind,
    WorkReport,
};
pub use random::SplitMix64;
pub use stats::{FrameStats, triangles_by_level};
pub use vertex::{BakedVertex, LocalVertex, PatchInstance, Sample};
pub use view::{Aabb, Camera, Lens, Planes, Unprojection, View, ViewError};
pub use voids::{VoidMask, VoidQuads};
