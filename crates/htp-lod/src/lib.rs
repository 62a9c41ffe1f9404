//! Hierarchical triangular patches with their matching blocks, after Lim and Choi 2008 (DOI 10.1145/1413634.1413694)
//! and the later paper on its implementation, whose sections and phases are cited here.
//!
//! A patch is a right triangle of `k * k` small triangles, and one triangle of a patch of the next coarser layer.
//! Nothing is triangulated at run time: a patch is replaced by patches of another layer, and where it meets a coarser
//! neighbour by a *matching block*, one of a handful of index lists that drop the vertices which that neighbour lacks.
//!
//! | element of the paper | where |
//! |---|---|
//! | patches and layers (2.1, Figure 1) | `grid` |
//! | matching blocks (2.2, Figure 2), index lists and their re-use (4.1, Figure 3) | `blocks` |
//! | levels differ by one at most (2.2) | `closure` |
//! | phase 1, initialisation | `method` |
//! | phase 2, cell loading; dynamic loading (4.2) | `cells` (files), `window` (which cells, and where), `budget`, `loader`, `failures`, `stream` |
//! | phase 3, cell binding | `grid`: squares are numbered across cells |
//! | phase 4, LOD computation | `rule` (metrics), `wishes`, `levels`; the patches in sight: `leaves`, `in_sight` |
//! | phase 5, vertex-buffer merger | `cell_vertices`; of streamed cells the heights alone, one transfer a cell: `stream` |
//! | phase 6, rendering | `per_patch` as published, `merged_cell` in one draw a cell, `instanced` in at most 7 draws |
//!
//! Deviations, each marked where it stands:
//! - any `k` and any number of layers, where the paper has 3 and 3 (`options`);
//! - DEMs of any size: vertices beyond the rim are clamped to it, and squares that cross the rim split both halves
//!   together (`grid`, `closure`);
//! - "levels in proportion to the distance" is made precise as a longest screen length of a triangle's leg, and "the
//!   sizes of the edges of the bounding box" likewise (`rule`);
//! - levels by error, so that a tolerance is a bound: no sample of the DEM is farther off on the screen (`errors`,
//!   `closure`);
//! - 8 index lists: the plain patch and all 7 matching blocks of Figure 2. The paper counts 7 in all; the block with
//!   three collapsed sides can never be drawn, so that 7 are in use (`blocks`, `border`);
//! - the whole DEM may be in memory; where it is not, cells are loaded around the eye and not in the frustum (`window`), and
//!   their finest levels alone: the coarse ones are always there (`cells`);
//! - no threads: levels are computed within the plan, and only those that the view may have changed (`terrain_core::odometer`);
//! - levels that glide into one another, where the paper's pop (`geomorph`);
//! - besides one draw a patch, one draw a cell (`merged_cell`) and instances (`instanced`).

mod blocks;
mod border;
mod budget;
mod cell_layout;
mod cell_patches;
mod cell_vertices;
mod cells;
mod closure;
mod deadlines;
mod deviation;
mod errors;
mod failures;
mod geomorph;
mod grid;
mod in_sight;
mod instanced;
mod leaves;
mod levels;
mod loader;
mod merged_cell;
mod method;
mod options;
mod per_patch;
mod repair;
mod rooms;
mod rule;
mod sight;
mod slots;
mod split;
mod stream;
mod window;
mod wishes;

pub use blocks::{index_list, local_vertices};
pub use cell_patches::cell_patches;
pub use cells::{
    Cell, CellFile, CellSource, CellsError, CellsHeader, CutError, Cutter, Provenance, Resident, Scan, Voids, cut,
    cut_steps,
};
pub use failures::FailedReads;
pub use method::Htp;
pub use options::{Batching, HtpError, LevelMetric, Loading, Options};
