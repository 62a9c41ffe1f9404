//! Terrain methods to compare against.
//!
//! | method | source | what its triangles follow | tolerance |
//! |---|---|---|---|
//! | [`FullGrid`] | - | nothing: every sample, one draw, no error | - |
//! | [`Decimated`] | - | nothing: every n-th row and column, one draw | - |
//! | [`Rqt`] | Lindstrom, Pascucci 2002; Evans et al. 2001 | the view: bisected triangles, one draw | a bound |
//! | [`Greedy`] | Garland, Heckbert 1995 | one tolerance in metres: Delaunay, one draw | at one distance |
//! | [`Geomipmap`] | de Boer 2000 | the view: levels of blocks, one draw each | a bound |
//!
//! *A bound*: no sample of the DEM, in view or not, is farther from the mesh than the tolerance in pixels.

mod decimated;
mod deviation;
mod error;
mod full_grid;
mod geomipmap;
mod greedy;
mod rqt;
mod static_grid;

pub use decimated::Decimated;
pub use error::BaselineError;
pub use full_grid::FullGrid;
pub use geomipmap::Geomipmap;
pub use greedy::{Greedy, GreedyInsertion};
pub use rqt::Rqt;
