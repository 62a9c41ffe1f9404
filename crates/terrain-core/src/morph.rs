//! Geomorphing: vertices that glide onto the next coarser level before it takes over, so that nothing pops.
//!
//! For methods whose levels are nested grids of samples with steps of `k^level`. A sample belongs to one level for good:
//! the finest whose next coarser grid leaves it out. There the next coarser mesh has a height of its own for it, and the
//! drawn height moves to that one with the distance from the eye.
//!
//! ```text
//!   o-----.-----.-----o     o  vertices of level n + 1       The step of level n + 1 is 3 steps of level n.
//!   |                /      .  vertices of level n, each     Its target is on the edge or inside the
//!   .     .     .   .          with a target on a triangle   triangle of level n + 1 around it.
//!   |            /             of level n + 1
//!   .     .   .
//!   |      /
//!   .  .
//!   o
//! ```
//!
//! So the drawn height is a function of the sample and of the eye alone, whichever patch draws it, at whatever level:
//! patches that share a vertex agree on it to the bit, with any mix of levels, and no crack can open. Targets stand on
//! heights of the DEM. That the vertices of a target's triangle do not glide themselves at the same time is a matter of
//! the ranges: a level glides between [`Morph::START`] and [`Morph::END`] of its reach, and the reach of the next one is
//! `k` times as long. Only with legs so long that such a ring is narrower than a patch do the two overlap. Then some
//! popping is left, and still no crack.
//!
//! At the DEM's last column and row, where patches are clamped, a triangle of a target is clamped like the mesh is.

use glam::DVec3;

use crate::{Heightmap, Sample};

/// How the heights of displaced vertices follow the eye in one frame. `shaders/terrain.wgsl` computes the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Morph {
    /// Position of the eye in metres.
    pub eye_world: [f64; 3],
    /// Steps of one level in steps of the next finer one; 2 or more.
    pub k: u32,
    /// Levels that glide: all but the coarsest.
    pub levels: u32,
    /// No triangle of level 0 is farther from the eye than this, but for those that hang over with their patch; of level
    /// n, `k^n` times as far.
    pub reach_m: f64,
}

impl Morph {
    /// The share of a level's reach at which its vertices begin to leave the DEM. With any `k` that is beyond the reach of
    /// the next finer level, since it is more than one half.
    pub const START: f64 = 0.7;
    /// The share at which they have arrived. Less than 1, so that a whole row of vertices has arrived where patches
    /// beyond the reach make a side collapse: the strip beside it is triangulated otherwise then.
    pub const END: f64 = 0.95;

    /// The height in metres that a sample is drawn at.
    pub fn height_m(&self, heightmap: &Heightmap, at: Sample) -> f32 {
        let own_m = heightmap.height_m(at);
        let Some(level) = self.level_of(heightmap, at) else { return own_m };
        let distance_m = DVec3::from(heightmap.world(at)).distance(DVec3::from(self.eye_world));
        let share = self.share(distance_m, level);
        (1.0 - share) * own_m + share * self.target_m(heightmap, at, level)
    }

    /// The level that a sample glides with; none for vertices of the coarsest level.
    fn level_of(&self, heightmap: &Heightmap, at: Sample) -> Option<u32> {
        let last = [heightmap.columns() - 1, heightmap.rows() - 1];
        let stays = |at: u32, last: u32, side: u32| at.is_multiple_of(side) || at == last;
        (0..self.levels).find(|level| {
            let side = self.k.pow(level + 1);
            !stays(at.column, last[0], side) || !stays(at.row, last[1], side)
        })
    }

    /// How far the vertices of a level have come at a distance: 0 on the DEM, 1 on the next level.
    fn share(&self, distance_m: f64, level: u32) -> f32 {
        let reach_m = self.reach_m * self.k.pow(level) as f64;
        let share = (distance_m / reach_m - Self::START) / (Self::END - Self::START);
        share.clamp(0.0, 1.0) as f32
    }

    /// The height of the next coarser mesh at a sample: squares of `side` intervals, clamped to the DEM, with diagonals
    /// from south-west to north-east.
    fn target_m(&self, heightmap: &Heightmap, at: Sample, level: u32) -> f32 {
        let side = self.k.pow(level + 1);
        let (west, east, u) = span(at.column, side, heightmap.columns() - 1);
        let (north, south, v) = span(at.row, side, heightmap.rows() - 1);
        let height_m = |column, row| heightmap.height_m(Sample { column, row });
        let (north_east_m, south_west_m) = (height_m(east, north), height_m(west, south));
        if u + v <= 1.0 {
            let apex_m = height_m(west, north);
            return apex_m + u * (north_east_m - apex_m) + v * (south_west_m - apex_m);
        }
        let apex_m = height_m(east, south);
        apex_m + (1.0 - u) * (south_west_m - apex_m) + (1.0 - v) * (north_east_m - apex_m)
    }
}

/// The ends of the span of `side` intervals that a coordinate is in, and how far along it is there, 0 to 1.
fn span(at: u32, side: u32, last: u32) -> (u32, u32, f32) {
    let first = at / side * side;
    let end = (first + side).min(last);
    (first, end, (at - first) as f32 / (end - first).max(1) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    /// 17 x 12 samples: squares of 3 and of 9 intervals cross both rims or end on them.
    fn dem(spacing_m: f64, height_m: impl Fn(u32, u32) -> f64) -> Heightmap {
        let heights = (0..12).flat_map(|row| (0..17).map(move |column| (column, row)));
        let heights = heights.map(|(column, row)| height_m(column, row) as f32).collect();
        Heightmap::new(17, 12, [spacing_m; 2], heights).unwrap()
    }

    fn rough() -> Heightmap {
        dem(10.0, |column, row| SplitMix64::new((31 * column + row) as u64).range(0.0, 100.0))
    }

    fn samples() -> impl Iterator<Item = Sample> {
        (0..12).flat_map(|row| (0..17).map(move |column| Sample { column, row }))
    }

    /// Two levels that glide, above the sample in the north-west.
    fn morph(reach_m: f64) -> Morph {
        Morph { eye_world: [0.0, 1000.0, 0.0], k: 3, levels: 2, reach_m }
    }

    #[test]
    fn near_the_eye_nothing_moves_and_vertices_of_the_coarsest_level_never_do() {
        let dem = rough();
        assert!(samples().all(|at| morph(1e9).height_m(&dem, at) == dem.height_m(at)));
        let far = morph(1e-3);
        let stays = |at: &Sample| [0, 9, 16].contains(&at.column) && [0, 9, 11].contains(&at.row);
        for at in samples() {
            assert_eq!(far.height_m(&dem, at) == dem.height_m(at), stays(&at), "{at:?}");
        }
    }

    /// Level 0 is on level 1, and level 1 where it was: 3 x 3 intervals are two triangles.
    #[test]
    fn between_two_levels_the_finer_one_lies_on_the_coarser() {
        let dem = rough();
        // The eye is 900 to 1,020 m away.
        let morph = morph(900.0);
        assert_eq!((morph.share(900.0, 0), morph.share(1_020.0, 1)), (1.0, 0.0));
        let drawn_m = |column, row| morph.height_m(&dem, Sample { column, row }) as f64;
        let near = |found: f64, expected: f64, what: &str| assert!((found - expected).abs() < 1e-4, "{what}: {found}");
        // An edge along a row, the diagonal, and a point inside of each half of one square.
        let corner = |column, row| dem.height_m(Sample { column, row }) as f64;
        let (nw, ne, sw, se) = (corner(3, 3), corner(6, 3), corner(3, 6), corner(6, 6));
        near(drawn_m(4, 3), (2.0 * nw + ne) / 3.0, "edge");
        near(drawn_m(5, 4), (2.0 * ne + sw) / 3.0, "diagonal");
        near(drawn_m(4, 4), (nw + ne + sw) / 3.0, "north-west");
        near(drawn_m(5, 5), (se + ne + sw) / 3.0, "south-east");
        // The last square of a row is one interval wide, the last one of a column two intervals long.
        near(drawn_m(16, 4), (2.0 * corner(16, 3) + corner(16, 6)) / 3.0, "eastern rim");
        near(drawn_m(4, 11), (2.0 * corner(3, 11) + corner(6, 11)) / 3.0, "southern rim");
        near(drawn_m(3, 10), (corner(3, 9) + corner(3, 11)) / 2.0, "a short square");
        near(drawn_m(15, 10), (corner(15, 9) + corner(15, 11)) / 2.0, "the last square");
    }

    #[test]
    fn heights_glide_from_the_dem_to_the_target() {
        let (dem, at) = (dem(10.0, |column, _| if column == 1 { 100.0 } else { 0.0 }), Sample { column: 1, row: 0 });
        let distance_m = DVec3::from(dem.world(at)).distance([0.0, 1000.0, 0.0].into());
        let height_m = |share_of_reach: f64| morph(distance_m / share_of_reach).height_m(&dem, at);
        assert_eq!([0.1, 0.7, 0.95, 1.0, 5.0].map(height_m), [100.0, 100.0, 0.0, 0.0, 0.0]);
        assert!((height_m(0.825) - 50.0).abs() < 1e-3);
        assert!(height_m(0.75) > height_m(0.76));
    }

    #[test]
    fn a_plane_stays_a_plane() {
        let dem = dem(10.0, |column, row| (8 * column + 16 * row) as f64);
        for at in samples() {
            let moved_m = morph(900.0).height_m(&dem, at) - dem.height_m(at);
            assert!(moved_m.abs() < 1e-3, "{at:?}: {moved_m}");
        }
    }
}
