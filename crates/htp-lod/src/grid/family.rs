//! Children, parents and neighbours of squares and patches.

use super::{Grid, Half, Patch, Spot, Square};
use crate::blocks::Side;

/// How the halves of a child square lie in its parent: the same for all children in that column and row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kin {
    /// By half: the half of the parent in which it lies.
    pub parents: [Half; 2],
    /// By half: the sides of that half which it touches, as a mask.
    pub touched: [u8; 2],
    /// By set of the parent's halves: the halves that lie in them.
    inside: [u8; 4],
}

impl Kin {
    /// By row and column among a square's children.
    pub(super) fn all(k: u32) -> Vec<Self> {
        (0..k).flat_map(|j| (0..k).map(move |i| Self::new(k, i, j))).collect()
    }

    fn new(k: u32, i: u32, j: u32) -> Self {
        let parents = Half::BOTH.map(|half| parent_half(k, half, i, j));
        let inside = |set: u8| {
            let halves = Half::BOTH.into_iter().filter(|half| set & parents[*half as usize].bit() != 0);
            halves.map(Half::bit).sum()
        };
        Self { parents, touched: Half::BOTH.map(|half| touched_sides(k, half, i, j)), inside: [0, 1, 2, 3].map(inside) }
    }

    /// The halves that lie in the given halves of the parent.
    #[inline]
    pub fn inside(&self, parents: u8) -> u8 {
        self.inside[parents as usize]
    }
}

/// A child patch of a half of a square: the same for all squares.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Child {
    /// Column and row of its square among the children.
    place: [u32; 2],
    /// The position of its square in the brood.
    at: usize,
    pub half: Half,
    /// The sides of its parent that it touches, as a mask.
    pub touched: u8,
}

impl Child {
    /// Those of one half of a square, row by row.
    pub(super) fn all(k: u32, parent: Half) -> Vec<Self> {
        let places = (0..k).flat_map(|j| (0..k).map(move |i| [i, j]));
        let patches = places.flat_map(|place| Half::BOTH.map(|half| (place, half)));
        let inside = patches.filter(|([i, j], half)| parent_half(k, *half, *i, *j) == parent);
        let child = |(place @ [i, j], half): ([u32; 2], Half)| Self {
            place,
            at: (j * k + i) as usize,
            half,
            touched: touched_sides(k, half, i, j),
        };
        inside.map(child).collect()
    }
}

/// The half of the parent square in which a child patch lies; `i` and `j` are its square's column and row there.
fn parent_half(k: u32, child: Half, i: u32, j: u32) -> Half {
    if i + j + (child as u32) < k { Half::NorthWest } else { Half::SouthEast }
}

/// The sides of the parent that a child patch touches: none unless it is the parent's own half.
fn touched_sides(k: u32, child: Half, i: u32, j: u32) -> u8 {
    let [i, j] = match child {
        Half::NorthWest => [i, j],
        Half::SouthEast => [k - 1 - i, k - 1 - j],
    };
    let touched = [(Side::Left, i == 0), (Side::Right, j == 0), (Side::Hypotenuse, i + j == k - 1)];
    let touched: u8 = touched.iter().map(|(side, touches)| side.bit() * *touches as u8).sum();
    if i + j < k { touched } else { 0 }
}

/// Children of a square that are side by side in the DEM.
pub(crate) struct BroodRow<'a> {
    /// The first one.
    pub first: Spot,
    /// Its row among the children.
    pub j: usize,
    /// Of each.
    pub kin: &'a [Kin],
}

impl<'a> BroodRow<'a> {
    /// With their kin.
    #[inline]
    pub fn children(self) -> impl Iterator<Item = (Spot, &'a Kin)> {
        let Spot { square, index, at } = self.first;
        let child = move |i| Spot {
            square: Square { column: square.column + i as u32, ..square },
            index: index + i,
            at: at + i,
        };
        self.kin.iter().enumerate().map(move |(i, kin)| (child(i), kin))
    }
}

impl Grid {
    /// Where the first child of a square is stored.
    #[inline]
    pub fn brood_start(&self, Square { level, column, row }: Square) -> usize {
        self.layers[level as usize - 1].brood_start([column, row])
    }

    /// The squares of the next finer level in a square, row by row.
    #[inline]
    pub fn brood(&self, square: Square) -> impl Iterator<Item = BroodRow<'_>> {
        let k = self.k as usize;
        let first = Square { level: square.level - 1, column: square.column * self.k, row: square.row * self.k };
        let layer = self.layer(first);
        let [columns, rows] =
            [layer.size[0] - first.column, layer.size[1] - first.row].map(|left| left.min(self.k) as usize);
        let start = self.brood_start(square);
        (0..rows).map(move |j| BroodRow {
            first: Spot { square: Square { row: first.row + j as u32, ..first }, index: start + j * k, at: j * k },
            j,
            kin: &self.kin[j * k..][..columns],
        })
    }

    /// The children of a patch.
    #[inline]
    pub fn child_patches(&self, Patch { square, half }: Patch) -> impl Iterator<Item = (Spot, &Child)> {
        let first = Square { level: square.level - 1, column: square.column * self.k, row: square.row * self.k };
        let (size, start) = (self.layer(first).size, self.brood_start(square));
        self.in_half[half as usize].iter().filter_map(move |child| {
            let [column, row] = [first.column + child.place[0], first.row + child.place[1]];
            let spot = Spot { square: Square { column, row, ..first }, index: start + child.at, at: child.at };
            (column < size[0] && row < size[1]).then_some((spot, child))
        })
    }

    /// The squares alone.
    pub fn children(&self, square: Square) -> impl Iterator<Item = Square> {
        self.brood(square).flat_map(|row| row.children().map(|(child, _)| child.square))
    }

    /// How a square lies in its parent.
    #[inline]
    pub fn kin(&self, child: Square) -> &Kin {
        &self.kin[(child.row % self.k * self.k + child.column % self.k) as usize]
    }

    /// The same by its position in the brood.
    #[inline]
    pub fn kin_at(&self, at: usize) -> &Kin {
        &self.kin[at]
    }

    /// The patch of which this one is a single triangle; none on the top layer.
    pub fn parent(&self, patch: Patch) -> Option<Patch> {
        let half = self.kin(patch.square).parents[patch.half as usize];
        (patch.square.level < self.top()).then(|| self.parent_square(patch.square).half(half))
    }

    /// The square of the next coarser level that a square lies in.
    #[inline]
    pub fn parent_square(&self, Square { level, column, row }: Square) -> Square {
        Square { level: level + 1, column: column / self.k, row: row / self.k }
    }

    /// The square of the coarsest level that a square lies in.
    pub fn cell_of(&self, square: Square) -> Square {
        (square.level..self.top()).fold(square, |square, _| self.parent_square(square))
    }

    /// The patch of the same level on the other side of an edge; none beyond the DEM.
    #[inline]
    pub fn neighbour(&self, patch: Patch, side: Side) -> Option<Patch> {
        let Square { level, column, row } = patch.square;
        let (column, row) = match (patch.half, side) {
            (_, Side::Hypotenuse) => (column, row),
            (Half::NorthWest, Side::Left) => (column.checked_sub(1)?, row),
            (Half::NorthWest, Side::Right) => (column, row.checked_sub(1)?),
            (Half::SouthEast, Side::Left) => (column + 1, row),
            (Half::SouthEast, Side::Right) => (column, row + 1),
        };
        let square = Square { level, column, row };
        self.exists(square).then_some(square.half(patch.half.other()))
    }

    /// What there is of the squares in the west, north, east and south of a stored one, by their index; `beyond` for
    /// those beyond the DEM.
    #[inline(always)]
    pub fn around<T: Copy>(&self, spot: Spot, of: impl Fn(usize) -> T, beyond: T) -> [T; 4] {
        let layer = self.layer(spot.square);
        let is_inside = |at: u32, count: u32| at.wrapping_sub(1) < count.saturating_sub(2);
        let Square { column, row, .. } = spot.square;
        if !layer.wraps && is_inside(column, layer.size[0]) && is_inside(row, layer.size[1]) {
            return layer.positions[spot.at].around.map(|away| of(spot.index.wrapping_add_signed(away)));
        }
        self.around_at_ends(spot, of, beyond)
    }

    /// The same at the ends of the DEM or of a window: of few squares, so kept out of the way of the others.
    #[inline(never)]
    fn around_at_ends<T: Copy>(&self, Spot { square, index, at }: Spot, of: impl Fn(usize) -> T, beyond: T) -> [T; 4] {
        let (layer, Square { level, column, row }) = (self.layer(square), square);
        let [columns, rows] = layer.size;
        let exist = [column > 0, row > 0, column + 1 < columns, row + 1 < rows];
        if layer.wraps {
            let index = |(column, row): (u32, u32)| self.index(Square { level, column, row });
            let west_to_south =
                [(column.wrapping_sub(1), row), (column, row.wrapping_sub(1)), (column + 1, row), (column, row + 1)];
            return std::array::from_fn(|side| if exist[side] { of(index(west_to_south[side])) } else { beyond });
        }
        let away = layer.positions[at].around;
        std::array::from_fn(|side| if exist[side] { of(index.wrapping_add_signed(away[side])) } else { beyond })
    }
}
