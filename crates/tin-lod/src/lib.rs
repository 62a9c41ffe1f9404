//! View-dependent triangulated irregular networks, made at run time.
//!
//! E. Bertilsson, P. Goswami: *Dynamic Creation of Multi-resolution Triangulated Irregular Network*, SIGRAD 2016.
//!
//! The DEM is divided into square patches. For each patch in view whose projected error has changed, the samples to
//! keep are selected (Algorithm 1), connected by a Delaunay triangulation in the plane, and written to the patch's
//! room in the index buffer; the vertex buffer holds the DEM's samples and never changes (but for
//! [`Options::smoothing`]).
//!
//! | in the paper | here |
//! |---|---|
//! | point selection, Algorithm 1 (3.1) | `select.rs`, [`Options::tolerance_px`], [`max_spacing`](field@Options::max_spacing) |
//! | border points (3.2) | `patches.rs` (edges are things of their own), `select.rs` |
//! | Delaunay in the plane, lifted (3.3) | `triangulate.rs`, [`Options::triangulator`], [`Options::jitter`] |
//! | multi-resolution system, Algorithm 2 (4) | `mesh.rs`, `algorithm1_mesh.rs`, `method.rs`: outdated patches in view, nearest first |
//! | a region of a fully refined patch in the index buffer (4) | `index_store.rs`, [`IndexStore::Fixed`] |
//! | normals in a texture (4) | the renderer |
//! | asynchronous update (4) | `worker.rs`, [`Schedule::Live`]; with [`Schedule::Blocking`] a plan waits |
//! | "a hierarchical data structure" for visibility (4) | `cull.rs` |
//! | smoothing of selected heights (3.3, last paragraph) | `smoothing.rs`, [`Options::smoothing`] |
//!
//! Beyond the paper: a selection whose tolerance is a bound ([`Selector::Bounded`]). A [`ThresholdMap`] says of every
//! sample at which levels of the tolerance ([`ladder`]) it is needed; a [`Selection`] keeps those of a level; a
//! [`BoundedMesher`] triangulates them and repairs what neighbours at other levels spoil (`bounded.rs`). Far from the
//! eye groups of patches are triangulated as one ([`Nodes`], [`group`](field@Options::group)), close to it the blocks of
//! a patch have levels of their own ([`levels`], [`Options::blocks`]); one rule for borders fits nodes of all sizes and
//! levels together (`border.rs`).

mod algorithm1_mesh;
mod border;
mod bounded;
mod bounded_mesh;
mod cull;
mod deviation;
mod greedy;
mod index_store;
pub mod ladder;
mod lattice;
pub mod levels;
mod map_file;
mod mesh;
mod method;
mod node_maps;
mod nodes;
mod options;
mod patches;
mod select;
mod selection;
mod smoothing;
mod threshold_map;
mod triangulate;
mod uniform;
mod vertices;
mod worker;

#[cfg(test)]
mod live_tests;

/// The paper's selection alone (section 3.1 and 3.2): from a tolerance in metres to kept samples.
///
/// For a whole DEM: [`select_edge`](algorithm1::select_edge) for every edge of a [`PatchGrid`], then
/// [`select_interior`](algorithm1::select_interior) for every patch with the [`Border`] of its four edges, then a
/// [`Triangulator`]. Patches that share an edge need no word between them.
pub mod algorithm1 {
    pub use crate::select::{select_edge, select_interior};
}

pub use border::Cut;
pub use bounded::{BoundedMesher, Repair};
pub use map_file::MapFileError;
pub use method::Tin;
pub use node_maps::NodeMaps;
pub use nodes::{NodeId, Nodes, Owners};
pub use options::{EdgePolicy, IndexStore, Options, Schedule, Selector, TinError};
pub use patches::{EdgeId, EdgeRun, PatchArea, PatchEdges, PatchGrid, PatchId};
pub use select::{Border, Mask};
pub use selection::Selection;
pub use threshold_map::ThresholdMap;
pub use triangulate::{Jitter, KeptSamples, Triangulator};
pub use uniform::mesh_at_tolerance;
