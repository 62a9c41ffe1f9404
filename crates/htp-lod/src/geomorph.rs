//! Geomorphing between levels by distance. Not in the paper, whose levels pop.
//!
//! A patch is one triangle of a patch of the next coarser level, its parent. Where the parent is drawn, each vertex of the
//! patch that is not a corner lies on that triangle: its target. A vertex is moved there by its distance from the eye,
//! relative to the parent's reach (`rule`): the parent is split while its box is nearer than that, so a patch that is
//! about to merge has all its vertices beyond the reach, and has arrived. [`Morph`] has the formula and why no crack can
//! open.
//!
//! - *Corners* are vertices of a coarser level, and glide with it. A corner belongs to a parent that is split, and so is
//!   nearer than its reach and a diagonal of its box; the next level begins to glide at [`Morph::START`] times `k` reaches,
//!   1.4 or more. So corners stand still unless that diagonal is longer than 0.4 reaches: with the default of 8 px for a
//!   leg and a picture of 360 lines it is about 0.1, with legs of 100 px 1.4.
//! - *Collapsed sides* drop vertices that have arrived, on a line with their ends. The strip beside them is triangulated
//!   otherwise, which would show if the row behind it had not arrived: it is a leg of the finer level away, which
//!   [`Morph::END`] leaves room for where legs are as short as that.
//! - *Patches that are split for the restriction alone* may be beyond the reach. They have arrived and look like their
//!   parents.
//! - *The coarsest level* has no targets.
//!
//! Other metrics are refused:
//!
//! - By *box*, reaches differ from square to square. Those of steep squares are longer than their level's, and they would
//!   be drawn as their parents long before they merge; those of squares that the rim cuts off are shorter, and would pop.
//! - By *error*, reaches differ from patch to patch as well, and a vertex on a side has two. Its own displacement gives a
//!   reach that is never longer than theirs, so that it does arrive in time. But then every vertex whose displacement is
//!   below the tolerance has arrived wherever its patch is still drawn for the sake of another one: samples that the
//!   levels keep within the tolerance are off by up to twice as much. Levels at half the tolerance restore the bound and
//!   need 1.9 times the triangles on the built-in DEM and 2.6 times on Puget Sound (0.5 px against 1 px). And reaches of
//!   consecutive levels are not `k` apart, so that corners move, too.

use crate::grid::Grid;
use crate::options::Options;
use crate::rule::reach_m;
use terrain_core::{Morph, View};

/// Where the vertices of one view are drawn.
pub(crate) fn morph(options: &Options, grid: &Grid, view: &View) -> Morph {
    // Patches of level 1 are split up to here, so that none of level 0 begins beyond.
    let reach_m = options.k as f64 * reach_m(view, grid.leg_m(0), options.leg_px);
    Morph { eye_world: view.eye_world.into(), k: options.k, levels: grid.top(), reach_m }
}
