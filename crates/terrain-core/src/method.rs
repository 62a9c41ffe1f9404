//! The one trait of the project.

use crate::{BufferSizes, FramePlan, View};

/// Decides, for each view, what the GPU should draw. Knows nothing of any graphics API.
///
/// Every implementation passes [`contract::check`](crate::contract::check):
///
/// 1. Draws touch only bytes that this or an earlier plan uploaded.
/// 2. Draws are triangle lists, counter-clockwise seen from above; vertices are DEM samples with the DEM's heights;
///    areas are positive (zero is allowed on the DEM's outline, and where two corners are one sample). Heights that are
///    smoothed on purpose pass [`contract::check_smoothed`](crate::contract::check_smoothed) instead, those of plans
///    with a [`Morph`](crate::Morph) [`contract::check_morphed`](crate::contract::check_morphed).
/// 3. With culling off the triangles are watertight and cover the DEM exactly once, in every frame. With culling on
///    they are those that may be in view.
/// 4. The plan is a pure function of construction and the views so far, byte for byte, on any number of threads
///    ([`WorkReport`](crate::WorkReport)s, which hold times, aside).
/// 5. The second plan for an unchanged view uploads nothing.
pub trait LodMethod: Send {
    /// Short name for command lines, tables and file names, such as "full-grid".
    fn name(&self) -> &'static str;

    /// What the three buffers must hold before the next plan. Only plans change it, and they say so
    /// ([`FramePlan::growths`]).
    fn buffers(&self) -> BufferSizes;

    /// Whether plans leave out what is out of view; `true` at first. What is promised of what is in view does not depend on it.
    fn set_culling(&mut self, culling: bool);

    /// Writes into `plan` (cleared first) what this frame uploads and draws.
    fn plan(&mut self, view: &View, plan: &mut FramePlan);

    /// What the user is to be told since the last time, a line each. Only methods that read have anything to tell.
    fn take_messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}
