//! How much of a square may be in sight, found from the top down: from the whole DEM to cells, and on to their squares.

use crate::grid::{Grid, Region, Spot};
use terrain_core::{Aabb, Planes, View};

/// Regions with no more cells along a side are not cut any further.
const FEW_CELLS: u32 = 2;

/// How much of a square may be in sight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    None,
    Part,
    Whole,
}

/// A view, and the planes of its frustum that may cut what is inside of a square; nothing where all of it is in sight.
#[derive(Clone, Copy)]
pub(crate) struct Culling<'a>(Option<(&'a View, Planes)>);

impl<'a> Culling<'a> {
    /// Nothing is out of sight.
    pub const OFF: Self = Self(None);

    /// For all there is.
    pub fn new(view: &'a View) -> Self {
        Self(Some((view, Planes::ALL)))
    }

    /// Whether all is in sight.
    #[inline]
    pub fn is_whole(self) -> bool {
        self.0.is_none()
    }

    pub fn sight(self) -> Sight {
        if self.is_whole() { Sight::Whole } else { Sight::Part }
    }

    /// For what is inside of a square, in what this one is for; none where it is out of sight.
    #[inline]
    pub fn inside(self, grid: &Grid, spot: Spot) -> Option<Self> {
        let Some((view, planes)) = self.0 else { return Some(self) };
        Self::across(view, &grid.bounds_world_at(spot), planes)
    }

    #[inline]
    fn across(view: &'a View, bounds: &Aabb, planes: Planes) -> Option<Self> {
        let planes = view.planes_across(bounds, planes)?;
        Some(Self((planes != Planes::NONE).then_some((view, planes))))
    }

    /// Passes on all cells, each with what is for some cells around it; none where these are out of sight.
    pub fn cells(self, grid: &Grid, visit: &mut impl FnMut(Spot, Option<Self>)) {
        self.cells_of(grid, grid.whole(), visit);
    }

    /// The same without those that are found to be out of sight.
    pub fn cells_in_sight(self, grid: &Grid, mut visit: impl FnMut(Spot, Self)) {
        self.cells(grid, &mut |cell, culling| {
            if let Some(culling) = culling {
                visit(cell, culling);
            }
        });
    }

    /// Those of a region, cut in halves where the frustum's planes do.
    fn cells_of(self, grid: &Grid, region: Region, visit: &mut impl FnMut(Spot, Option<Self>)) {
        let culling = match self.0 {
            Some((view, planes)) => Self::across(view, &grid.region_bounds_world(region), planes),
            None => Some(self),
        };
        match culling {
            Some(inside) if !inside.is_whole() && region.longest_side() > FEW_CELLS => {
                region.halves().into_iter().for_each(|half| inside.cells_of(grid, half, visit));
            }
            _ => grid.cells(region).for_each(|cell| visit(cell, culling)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use std::collections::BTreeSet;
    use terrain_core::walk::RandomWalk;
    use terrain_core::{Heightmap, SplitMix64};

    #[test]
    fn cells_are_found_by_regions_as_one_by_one() {
        let mut random = SplitMix64::new(1);
        let heights_m = (0..150 * 90).map(|_| random.range(0.0, 40.0) as f32).collect();
        let heightmap = Heightmap::new(150, 90, [1.0; 2], heights_m).unwrap();
        let grid = Grid::new(&heightmap, &Options { k: 2, layers: 2, ..Options::default() });
        let mut sights = [0; 3];
        for view in RandomWalk::new(1, &heightmap).take(200) {
            let (mut visited, mut found) = (BTreeSet::new(), BTreeSet::new());
            let culling = Culling::new(&view);
            culling.cells(&grid, &mut |cell, around| {
                assert_eq!((cell.index, cell.at), (grid.spot(cell.square).index, grid.spot(cell.square).at));
                assert!(visited.insert(cell.index), "{cell:?} comes twice");
                let alone = culling.inside(&grid, cell).map_or(Sight::None, Culling::sight);
                let sight = around.and_then(|around| around.inside(&grid, cell));
                assert_eq!(sight.map_or(Sight::None, Culling::sight), alone, "{cell:?}");
                sights[alone as usize] += 1;
                if around.is_some() {
                    found.insert(cell.index);
                }
            });
            assert_eq!(visited.len(), grid.squares(grid.top()).count());
            let mut in_sight = BTreeSet::new();
            culling.cells_in_sight(&grid, |cell, _| assert!(in_sight.insert(cell.index)));
            assert_eq!(in_sight, found);
        }
        assert!(sights.iter().all(|count| *count > 1000), "out of sight, in part, whole: {sights:?}");
    }
}
