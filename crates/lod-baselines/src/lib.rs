//! Terrain methods to compare against.
//!
//! | method | source | triangles follow | tolerance |
//! |---|---|---|---|
//! | [`FullGrid`] | - | nothing: every sample, one draw, no error | - |
//! | [`Decimated`] | - | nothing: every n-th row and column, one draw | - |
//! | [`Rqt`] | Lindstrom and Pascucci 2002; Evans, Kirkpatrick and Townsend 2001 | the view, by longest-edge bisection, one draw | a bound |

mod decimated;
mod deviation;
mod error;
mod full_grid;
mod rqt;
mod static_grid;

pub use decimated::Decimated;
pub use error::BaselineError;
pub use full_grid::FullGrid;
pub use rqt::Rqt;
