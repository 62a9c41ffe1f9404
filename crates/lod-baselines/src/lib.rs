//! Terrain methods to compare against.
//!
//! | method | source | triangles follow | tolerance |
//! |---|---|---|---|
//! | [`FullGrid`] | - | nothing: every sample, one draw, no error | - |
//! | [`Decimated`] | - | nothing: every n-th row and column, one draw | - |

mod decimated;
mod error;
mod full_grid;
mod static_grid;

pub use decimated::Decimated;
pub use error::BaselineError;
pub use full_grid::FullGrid;
