//! How much of a square may be in sight, found from the top down.

use crate::grid::{Grid, Spot};
use terrain_core::{Planes, View};

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
        let planes = view.planes_across(&grid.bounds_world_at(spot), planes)?;
        Some(Self((planes != Planes::NONE).then_some((view, planes))))
    }
}
