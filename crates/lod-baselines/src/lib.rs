//! Terrain methods to compare against. The full grid is the reference: no error, one draw, every triangle.

mod full_grid;

pub use full_grid::FullGrid;
