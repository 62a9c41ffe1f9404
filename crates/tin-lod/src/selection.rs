//! What a node keeps: its inside at its own level, and on its border what the rule for borders (`border.rs`) says.

use crate::border::Cut;
use crate::ladder::FULL;
use crate::levels::NodeLevels;
use crate::nodes::NodeId;
use crate::patches::PatchArea;
use crate::select::{Border, Mask};
use crate::triangulate::KeptSamples;
use crate::vertices::VertexPlace;

/// What a node keeps at its level, among nodes at levels of their own.
#[derive(Clone, Debug)]
pub struct Selection {
    levels: NodeLevels,
    border: Border,
    interior: Vec<Mask>,
    /// Samples of the border that the node itself does not need.
    extra: Border,
}

impl Default for Selection {
    fn default() -> Self {
        let none = Border::default();
        Self { levels: NodeLevels::Uniform(FULL), border: none, interior: Vec::new(), extra: none }
    }
}

impl Selection {
    /// Selects a node of a mesh anew, in the memory of the last selection.
    pub fn select(&mut self, cut: &Cut, node: NodeId) {
        let sides = [0, 1, 2, 3];
        let border = |[north, south, west, east]: [Mask; 4]| Border { north, south, west, east };
        let needed_and_kept = sides.map(|side| cut.needed_and_kept(node, side));
        self.levels = *cut.levels(node);
        self.border = border(needed_and_kept.map(|(_, kept)| kept));
        self.extra = border(needed_and_kept.map(|(needed, kept)| kept & !needed));
        self.interior.clear();
        self.interior.extend(cut.maps.interior(node, &self.levels));
    }

    /// The levels of the node.
    pub fn levels(&self) -> &NodeLevels {
        &self.levels
    }

    /// The samples that the four sides keep.
    pub fn border(&self) -> Border {
        self.border
    }

    /// The samples that the inner rows keep, before any repair.
    pub fn interior(&self) -> &[Mask] {
        &self.interior
    }

    /// Samples of the border that the node itself does not need. Without such a node with one level is not checked.
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

    /// Whether the triangles of both are the same: the same samples, checked against the same limits or not at all.
    pub fn gives_the_mesh_of(&self, other: &Self) -> bool {
        let is_uniform = |selection: &Self| matches!(selection.levels, NodeLevels::Uniform(_));
        let unchecked = |selection: &Self| selection.extra == Border::default() && is_uniform(selection);
        let same_limits = unchecked(self) && unchecked(other) || self.levels == other.levels;
        same_limits && self.border == other.border && self.interior == other.interior
    }
}
