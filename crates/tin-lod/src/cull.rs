//! Which patches are in view: a tree of boxes over the patches, so that the cost follows what is in view and not the
//! size of the DEM.
//!
//! Beyond the paper, which tests every patch and names the tree as an improvement (section 4).

use terrain_core::{Aabb, View};

use crate::patches::{PatchGrid, PatchId};

/// Boxes of blocks of 1 x 1, 2 x 2, 4 x 4, ... patches, up to one that holds all.
pub(crate) struct PatchTree {
    /// Finest first.
    layers: Vec<Layer>,
}

struct Layer {
    across: u32,
    down: u32,
    /// Row by row.
    bounds_world: Vec<Aabb>,
}

impl PatchTree {
    pub fn new(grid: &PatchGrid, bounds_world: Vec<Aabb>) -> Self {
        let [across, down] = grid.size();
        let mut layers = vec![Layer { across, down, bounds_world }];
        while let Some(coarser) = layers.last().and_then(Layer::coarser) {
            layers.push(coarser);
        }
        Self { layers }
    }

    /// Fills `visible` with the patches whose boxes may be in view, or with all of them; in ascending order.
    pub fn visible(&self, view: &View, culling: bool, visible: &mut Vec<PatchId>) {
        visible.clear();
        if culling {
            self.descend(self.layers.len() - 1, 0, 0, view, visible);
            visible.sort_unstable();
        } else {
            visible.extend(0..self.layers[0].bounds_world.len() as PatchId);
        }
    }

    fn descend(&self, layer: usize, column: u32, row: u32, view: &View, visible: &mut Vec<PatchId>) {
        let Layer { across, down, bounds_world } = &self.layers[layer];
        if column >= *across || row >= *down {
            return;
        }
        let block = row * across + column;
        if !view.sees(&bounds_world[block as usize]) {
            return;
        }
        if layer == 0 {
            visible.push(block);
            return;
        }
        for (c, r) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            self.descend(layer - 1, 2 * column + c, 2 * row + r, view, visible);
        }
    }
}

impl Layer {
    /// The layer above, where there is one.
    fn coarser(&self) -> Option<Self> {
        if self.bounds_world.len() == 1 {
            return None;
        }
        let (across, down) = (self.across.div_ceil(2), self.down.div_ceil(2));
        let block = |i: u32| {
            let (column, row) = (2 * (i % across), 2 * (i / across));
            let members = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(c, r)| (column + c, row + r));
            let inside = members.into_iter().filter(|(c, r)| *c < self.across && *r < self.down);
            let bounds = inside.map(|(c, r)| self.bounds_world[(r * self.across + c) as usize]);
            bounds.reduce(union).expect("a block has a north-western patch")
        };
        Some(Self { across, down, bounds_world: (0..across * down).map(block).collect() })
    }
}

/// The box around two boxes.
pub(crate) fn union(a: Aabb, b: Aabb) -> Aabb {
    let each = |choose: fn(f64, f64) -> f64, a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| choose(a[i], b[i]));
    Aabb { min: each(f64::min, a.min, b.min), max: each(f64::max, a.max, b.max) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::Heightmap;
    use terrain_core::walk::RandomWalk;

    #[test]
    fn finds_the_same_patches_as_a_test_of_every_one() {
        let heights = (0..97 * 61).map(|i| (i * 37 % 101) as f32).collect();
        let dem = Heightmap::new(97, 61, [10.0, 20.0], heights).unwrap();
        let grid = PatchGrid::new(&dem, 8);
        let bounds: Vec<Aabb> =
            (0..grid.patches()).map(|p| dem.bounds_world(grid.area(p).first, grid.area(p).last())).collect();
        let tree = PatchTree::new(&grid, bounds.clone());
        let mut visible = Vec::new();
        for (frame, view) in RandomWalk::new(9, &dem).take(500).enumerate() {
            tree.visible(&view, true, &mut visible);
            let expected: Vec<PatchId> = (0..grid.patches()).filter(|p| view.sees(&bounds[*p as usize])).collect();
            assert_eq!(visible, expected, "frame {frame}");
        }
        tree.visible(&RandomWalk::new(9, &dem).next().unwrap(), false, &mut visible);
        assert_eq!(visible.len() as u32, grid.patches());
    }
}
