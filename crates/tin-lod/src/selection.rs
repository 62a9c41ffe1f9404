//! What a node keeps: its inside at its own level, and on its border what the rule for borders (`border.rs`) says.

use crate::border::Cut;
use crate::ladder::Level;
use crate::nodes::NodeId;
use crate::patches::PatchArea;
use crate::select::{Border, Mask};
use crate::triangulate::KeptSamples;
use crate::vertices::VertexPlace;

/// What a node keeps at its level, among nodes at levels of their own.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    level: Level,
    border: Border,
    interior: Vec<Mask>,
    /// Samples of the border that the node itself does not need.
    extra: Border,
}

impl Selection {
    /// Selects a node of a mesh anew, in the memory of the last selection.
    pub fn select(&mut self, cut: &Cut, node: NodeId) {
        let sides = [0, 1, 2, 3];
        let border = |[north, south, west, east]: [Mask; 4]| Border { north, south, west, east };
        let needed = sides.map(|side| cut.needed(node, side));
        let kept = sides.map(|side| cut.kept(node, side, needed[side]));
        self.level = cut.level(node);
        self.border = border(kept);
        self.extra = border(sides.map(|side| kept[side] & !needed[side]));
        cut.maps.interior(node, self.level, &mut self.interior);
    }

    /// The level of the node.
    pub fn level(&self) -> Level {
        self.level
    }

    /// The samples that the four sides keep.
    pub fn border(&self) -> Border {
        self.border
    }

    /// The samples that the inner rows keep, before any repair.
    pub fn interior(&self) -> &[Mask] {
        &self.interior
    }

    /// Samples of the border that the node itself does not need. Without such nothing is checked.
    pub fn extra(&self) -> Border {
        self.extra
    }

    pub(crate) fn kept_samples(&self, area: PatchArea, place: VertexPlace) -> KeptSamples<'_> {
        KeptSamples {
            width: area.width,
            depth: area.depth,
            border: self.border,
            interior: &self.interior,
            first_index: place.first_index,
            row_stride: place.row_stride,
        }
    }

    /// Whether the triangles of both are the same: the same samples, checked against the same limit or not at all.
    pub fn gives_the_mesh_of(&self, other: &Self) -> bool {
        let unchecked = self.extra == Border::default() && other.extra == Border::default();
        (unchecked || self.level == other.level) && self.border == other.border && self.interior == other.interior
    }
}
