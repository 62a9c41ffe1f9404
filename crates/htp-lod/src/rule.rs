//! What a metric asks for in one view (section 3, phase 4), as lengths: a patch is split, and a block is too bad, while
//! the eye is nearer to the square's box than the patch's or block's *reach*.
//!
//! The screen length of anything in metres falls with the distance ([`View::pixels`]), so that each has one distance
//! at which it is as long as allowed. A box contains those of its square's children, so no child is nearer; and no
//! metric gives it a longer reach. Hence a patch that wants to be split has a parent that wants it, too.
//!
//! Deviation: the paper's levels go by the bare distance, in a proportion that it does not state. A longest length on
//! the screen means the same for any picture, field of view and spacing. Of the bounding box, "the sizes of the edges"
//! are to be computed; here the longest one decides, as if seen square-on from where the eye is nearest to the box, so
//! that levels do not change when the camera turns.

use crate::border::BorderChild;
use crate::errors::ErrorTable;
use crate::grid::{Grid, Half, Patch, Spot, Square};
use crate::options::{LevelMetric, Options};
use terrain_core::View;

/// A metric and a view.
pub(crate) struct Rule<'a> {
    pub grid: &'a Grid,
    view: &'a View,
    metric: Metric<'a>,
    /// What the metric allows.
    limit_px: f64,
}

enum Metric<'a> {
    /// By level.
    Distance { reach_m: Vec<f64> },
    /// For one metre of a leg.
    Box { reach_per_metre: f64 },
    /// For one step of an error.
    Error { table: &'a ErrorTable, reach_per_step_m: f64 },
}

/// How far the eye is from the columns and from the rows of a square's children, in square metres along the axis.
#[derive(Default)]
pub(crate) struct Ways {
    eye_m: f64,
    columns_m2: [f64; LARGEST_K],
    rows_m2: [f64; LARGEST_K],
}

const LARGEST_K: usize = Options::MAX_K as usize;

impl Ways {
    /// [`Rule::distance_m`] of the child in a column and row, with its heights.
    #[inline]
    pub fn distance_m(&self, [i, j]: [usize; 2], heights_m: [f64; 2]) -> f64 {
        let way_m = way_m(self.eye_m, heights_m);
        (self.columns_m2[i] + way_m * way_m + self.rows_m2[j]).sqrt()
    }
}

/// The way to an interval. All are numbers, which `f64::max` does not count on.
#[inline]
fn way_m(from_m: f64, [low_m, high_m]: [f64; 2]) -> f64 {
    let nearest_m = if from_m < low_m { low_m } else { from_m };
    (if nearest_m > high_m { high_m } else { nearest_m }) - from_m
}

/// An answer, and how far the eye can move before it may be another one.
#[derive(Clone, Copy)]
pub(crate) struct Answer {
    pub near: bool,
    pub slack_m: f64,
}

impl<'a> Rule<'a> {
    /// `errors` must be there for [`LevelMetric::Error`].
    pub fn new(options: &Options, grid: &'a Grid, errors: Option<&'a ErrorTable>, view: &'a View) -> Self {
        let metric = match (options.metric, errors) {
            (LevelMetric::Distance, _) => Metric::Distance {
                reach_m: (0..=grid.top()).map(|level| reach_m(view, grid.leg_m(level), options.leg_px)).collect(),
            },
            (LevelMetric::Box, _) => Metric::Box { reach_per_metre: reach_m(view, 1.0, options.leg_px) },
            (LevelMetric::Error, Some(table)) => {
                Metric::Error { table, reach_per_step_m: reach_m(view, table.step_m(), options.tolerance_px) }
            }
            (LevelMetric::Error, None) => unreachable!("levels by error without errors"),
        };
        let limit_px = if options.metric == LevelMetric::Error { options.tolerance_px } else { options.leg_px };
        Self { grid, view, metric, limit_px }
    }

    /// The errors, where they matter.
    pub fn errors(&self) -> Option<&'a ErrorTable> {
        match self.metric {
            Metric::Error { table, .. } => Some(table),
            _ => None,
        }
    }

    /// The halves of a square that want to be split.
    #[cfg(test)]
    pub fn wish(&self, spot: Spot) -> u8 {
        Self::wish_at(self.distance_at_m(spot), self.reaches_m(spot)).0
    }

    /// The halves of a square that want to be split, in a distance and with the reaches of both; and the slack of both
    /// answers.
    #[inline]
    pub fn wish_at(distance_m: f64, [north_west_m, south_east_m]: [f64; 2]) -> (u8, f64) {
        let [north_west, south_east] = [answer(distance_m, north_west_m), answer(distance_m, south_east_m)];
        let halves = Half::NorthWest.bit() * north_west.near as u8 + Half::SouthEast.bit() * south_east.near as u8;
        (halves, sooner(north_west.slack_m, south_east.slack_m))
    }

    /// How far the halves of a square reach.
    #[inline(always)] // in the innermost loop of a jump
    pub fn reaches_m(&self, Spot { square, index, .. }: Spot) -> [f64; 2] {
        match &self.metric {
            Metric::Distance { reach_m } => [reach_m[square.level as usize]; 2],
            Metric::Box { reach_per_metre } => {
                [reach_per_metre * self.grid.longest_edge_m(square) / self.grid.k as f64; 2]
            }
            Metric::Error { table, reach_per_step_m } => {
                let [north_west, south_east] = table.plain_both(square.level, index);
                [north_west as f64 * reach_per_step_m, south_east as f64 * reach_per_step_m]
            }
        }
    }

    /// No child of a square reaches farther; of one above level 1.
    #[inline]
    pub fn children_reach_m(&self, Spot { square, index, .. }: Spot) -> f64 {
        match &self.metric {
            Metric::Distance { reach_m } => reach_m[square.level as usize - 1],
            Metric::Box { .. } => f64::INFINITY, // as far as the square itself, for all that is known
            Metric::Error { table, reach_per_step_m } => {
                table.worst_child(square.level, index) as f64 * reach_per_step_m
            }
        }
    }

    /// The error of a border child with a mask, in steps; 0 without a mask, since the plain patch is never too bad.
    pub fn block_error(&self, parent: Patch, child: &BorderChild, mask: u8) -> u16 {
        match &self.metric {
            Metric::Error { table, .. } if mask != 0 => table.block(self.grid, parent, child, mask),
            _ => 0,
        }
    }

    /// The largest error of a patch's border children where these sides are coarser.
    #[inline]
    pub fn worst_block_error(&self, parent: Spot, half: Half, coarser: u8) -> u16 {
        match &self.metric {
            Metric::Error { table, .. } => table.worst_block(parent, half, coarser),
            _ => 0,
        }
    }

    /// Whether an error in steps is too large in a square.
    #[inline]
    pub fn is_too_bad(&self, distance_m: f64, error: u16) -> Answer {
        match &self.metric {
            Metric::Error { reach_per_step_m, .. } => answer(distance_m, error as f64 * reach_per_step_m),
            _ => Answer { near: false, slack_m: f64::INFINITY },
        }
    }

    /// How many pixels the metric counts for the worst of some halves of a square, where the limit would split them.
    pub fn patch_px(&self, square: Square, halves: u8) -> f64 {
        let reaches_m = Half::BOTH.map(|half| (half, self.reaches_m(self.grid.spot(square))[half as usize]));
        let of = reaches_m.into_iter().filter(|(half, _)| halves & half.bit() != 0).map(|(_, reach_m)| reach_m);
        self.px(square, of.fold(0.0, f64::max))
    }

    /// The same for a block with an error in steps.
    pub fn block_px(&self, square: Square, error: u16) -> f64 {
        match &self.metric {
            Metric::Error { reach_per_step_m, .. } => self.px(square, error as f64 * reach_per_step_m),
            _ => 0.0,
        }
    }

    /// At its reach a length is as long as allowed.
    fn px(&self, square: Square, reach_m: f64) -> f64 {
        self.limit_px * reach_m / self.distance_m(square)
    }

    /// Whether a square may be in sight.
    pub fn sees(&self, square: Square) -> bool {
        self.view.sees(&self.grid.bounds_world(square))
    }

    #[inline]
    pub fn distance_m(&self, square: Square) -> f64 {
        self.distance_at_m(self.grid.spot(square))
    }

    /// The same where its position is known.
    #[inline]
    pub fn distance_at_m(&self, spot: Spot) -> f64 {
        self.view.distance_m(&self.grid.bounds_world_at(spot))
    }

    /// Finds the ways to a square's children.
    pub fn measure_ways(&self, parent: Square, ways: &mut Ways) {
        let (grid, level, k) = (self.grid, parent.level - 1, self.grid.k);
        let [x, y, z] = self.view.eye_world.to_array();
        ways.eye_m = y;
        for at in 0..k {
            let column_m = way_m(x, grid.interval_m(0, level, parent.column * k + at));
            let row_m = way_m(z, grid.interval_m(1, level, parent.row * k + at));
            (ways.columns_m2[at as usize], ways.rows_m2[at as usize]) = (column_m * column_m, row_m * row_m);
        }
    }
}

/// The smaller of two numbers, which `f64::min` does not count on.
#[inline]
pub(crate) fn sooner(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

#[inline]
fn answer(distance_m: f64, reach_m: f64) -> Answer {
    Answer { near: distance_m < reach_m, slack_m: (distance_m - reach_m).abs() }
}

/// The distance in metres at which `length_m` covers `length_px`: distance and pixels trade places in
/// [`View::pixels`].
pub(crate) fn reach_m(view: &View, length_m: f64, length_px: f64) -> f64 {
    view.pixels(length_m, length_px)
}
