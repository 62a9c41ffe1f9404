//! The patches along the sides of a split patch: only they can meet something coarser, and only there.
//!
//! Of the `k * k` children of a patch, `3k - 3` touch its sides, all of them of its own half: three at its corners,
//! which touch two sides, and `3k - 6` between them, which touch one. Three sides touch none (for k >= 2), so that the
//! block with all sides collapsed is never needed.
//!
//! ```text
//!      +-------+-------+-------+
//!      |  LR  /|   R  /|  RH  /        k = 3: the sides that each child touches
//!      |    /  |    /  |    /          L left, R right, H hypotenuse
//!      |  /    |  /    |  /
//!      +-------+-------+
//!      |   L  /|   H  /
//!      |    /  |    /
//!      |  /    |  /
//!      +-------+
//!      |  LH  /
//!      |    /
//!      |  /
//!      +
//! ```

use crate::blocks::{MASKS, Side};
use crate::grid::{Grid, Half, Patch, Square};

/// A child that touches sides of its parent, and the masks that it can have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BorderChild {
    /// Column and row among the children of a north-west half.
    place: [u32; 2],
    /// The sides that it touches, as a mask: those that can be collapsed.
    pub touched: u8,
    /// Where its masks begin among the masks of all border children.
    first_mask: usize,
}

impl BorderChild {
    /// Column and row among the children of a half.
    fn place_in(&self, half: Half, k: u32) -> [u32; 2] {
        match half {
            Half::NorthWest => self.place,
            Half::SouthEast => self.place.map(|at| k - 1 - at),
        }
    }

    /// Position of a mask, one of [`Self::masks`], among the masks of all border children.
    #[inline]
    pub fn mask_index(&self, mask: u8) -> usize {
        debug_assert!(mask != 0 && mask & !self.touched == 0);
        let low = self.touched & self.touched.wrapping_neg();
        let (has_low, has_high) = (mask & low != 0, mask & !low != 0);
        self.first_mask + has_low as usize + 2 * has_high as usize - 1
    }

    /// The masks that it can have but 0: each comes after those that it contains.
    pub fn masks(&self) -> impl Iterator<Item = u8> + use<> {
        let touched = self.touched;
        (1..=touched).filter(move |mask| mask & !touched == 0)
    }
}

/// The border children of all patches of one `k`.
pub(crate) struct Border {
    k: u32,
    pub children: Vec<BorderChild>,
    /// Masks of all border children: `3k + 3`.
    pub masks: usize,
    /// By mask of the parent's sides: what [`Self::masks_along`] returns.
    along: [Vec<usize>; MASKS],
    /// By half and side: what [`Self::positions`] returns.
    positions: [[Vec<usize>; 3]; 2],
}

impl Border {
    pub fn new(grid: &Grid) -> Self {
        let mut border = Self {
            k: grid.k,
            children: Vec::new(),
            masks: 0,
            along: Default::default(),
            positions: Default::default(),
        };
        for (i, j) in (0..grid.k).flat_map(|j| (0..grid.k - j).map(move |i| (i, j))) {
            let touched = grid.kin(Square { level: 0, column: i, row: j }).touched[Half::NorthWest as usize];
            if touched != 0 {
                let child = BorderChild { place: [i, j], touched, first_mask: border.masks };
                border.masks += child.masks().count();
                border.children.push(child);
            }
        }
        for (sides, along) in border.along.iter_mut().enumerate() {
            let masks = border.children.iter().map(|child| (child, sides as u8 & child.touched));
            along.extend(masks.filter(|(_, mask)| *mask != 0).map(|(child, mask)| child.mask_index(mask)));
        }
        for child in &border.children {
            for (half, side) in
                Half::BOTH.into_iter().flat_map(|half| sides_of(child.touched).map(move |side| (half, side)))
            {
                let [i, j] = child.place_in(half, grid.k);
                border.positions[half as usize][side as usize].push((j * grid.k + i) as usize);
            }
        }
        border
    }

    /// Positions in the brood of the children of a half that touch a side of it.
    #[inline]
    pub fn positions(&self, half: Half, side: Side) -> &[usize] {
        &self.positions[half as usize][side as usize]
    }

    /// Positions of the masks that the border children have where these sides of their parent are coarser, but 0.
    #[inline]
    pub fn masks_along(&self, sides: u8) -> &[usize] {
        &self.along[sides as usize]
    }

    /// A border child of a patch; none beyond the DEM.
    pub fn child(&self, grid: &Grid, parent: Patch, child: &BorderChild) -> Option<Patch> {
        let Square { level, column, row } = parent.square;
        let [i, j] = child.place_in(parent.half, self.k);
        let square = Square { level: level - 1, column: column * self.k + i, row: row * self.k + j };
        grid.exists(square).then_some(square.half(parent.half))
    }

    /// The border children of a patch that touch a side, or several, of a mask.
    pub fn touching(&self, grid: &Grid, parent: Patch, sides: u8) -> impl Iterator<Item = (BorderChild, Patch)> {
        let touching = self.children.iter().filter(move |child| child.touched & sides != 0);
        touching.filter_map(move |child| Some((*child, self.child(grid, parent, child)?)))
    }
}

/// The sides of a mask.
pub(crate) fn sides_of(mask: u8) -> impl Iterator<Item = Side> {
    Side::ALL.into_iter().filter(move |side| mask & side.bit() != 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Options;
    use std::collections::BTreeSet;
    use terrain_core::Heightmap;

    #[test]
    fn border_children_are_those_that_touch_a_side() {
        for k in 2..=16 {
            let heightmap = Heightmap::new(70, 50, [1.0; 2], vec![0.0; 3500]).unwrap();
            let grid = Grid::new(&heightmap, &Options { k, layers: 2, ..Options::default() });
            let border = Border::new(&grid);
            assert_eq!((border.children.len() as u32, border.masks as u32), (3 * k - 3, 3 * k + 3));
            for parent in grid.squares(1).flat_map(|square| Half::BOTH.map(|half| square.half(half))) {
                let all = grid.children(parent.square).map(|child| child.half(parent.half));
                let is_border = |child: &Patch| {
                    grid.parent(*child) == Some(parent) && grid.kin(child.square).touched[child.half as usize] != 0
                };
                let expected: Vec<Patch> = all.filter(is_border).collect();
                let mut found: Vec<Patch> = border.touching(&grid, parent, 7).map(|(_, patch)| patch).collect();
                found.sort_by_key(|patch| (patch.square.row, patch.square.column));
                assert_eq!(found, expected, "k {k}, {parent:?}");
                for (child, patch) in border.touching(&grid, parent, 7) {
                    assert_eq!(child.touched, grid.kin(patch.square).touched[patch.half as usize]);
                }
            }
        }
    }

    #[test]
    fn every_mask_has_its_place_after_those_that_it_contains() {
        for k in 2..=16 {
            let heightmap = Heightmap::new(2, 2, [1.0; 2], vec![0.0; 4]).unwrap();
            let border = Border::new(&Grid::new(&heightmap, &Options { k, layers: 1, ..Options::default() }));
            let index = |child: &BorderChild| child.masks().map(|mask| child.mask_index(mask)).collect::<Vec<_>>();
            let all: Vec<usize> = border.children.iter().flat_map(index).collect();
            assert_eq!(all, (0..border.masks).collect::<Vec<_>>());
            let seen: BTreeSet<u8> = border.children.iter().flat_map(|child| child.masks()).collect();
            assert_eq!(seen, (1..7).collect(), "k {k}");
        }
    }
}
