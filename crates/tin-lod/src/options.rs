//! What a user may choose.

use terrain_core::{Heightmap, SplitMix64};

use crate::patches::PatchId;
use crate::triangulate::{Jitter, KeptSamples, Triangulator};
use crate::vertices::VertexStrips;

/// Which samples of a patch are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Selector {
    /// Those that Algorithm 1 of the paper selects. The tolerance steers it and is **not** a bound of the error.
    Algorithm1,
    /// Those that a greedy insertion needs at the patch's tolerance: no sample of the DEM in a patch is farther from
    /// its mesh than the tolerance. Needs [`Triangulator::Grid`] and [`EdgePolicy::Matched`], and threshold maps:
    /// a byte a sample for each size of node, computed before the first plan.
    #[default]
    Bounded,
}

/// Which edges follow when a patch is selected anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EdgePolicy {
    /// All four. The neighbour of an edge that changes is triangulated in the same update and swapped in the same plan.
    #[default]
    Matched,
    /// The paper's (section 3.2): an edge keeps its state until both of its patches are updated for the same request.
    Paper,
}

/// How the triangles of all patches share the index buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IndexStore {
    /// The paper's (section 4): room for a fully refined patch for each, in 4-byte indices; the vertex buffer holds
    /// each sample once, row by row.
    Fixed,
    /// Rooms by need, in a buffer that grows when it is full, and 2-byte indices. The vertex buffer is in strips as
    /// wide as the largest group; it holds the columns between them twice.
    #[default]
    Packed,
}

/// When patches are updated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Schedule {
    /// In the plan, which waits for it: what is drawn fits the view, and is the same every time.
    #[default]
    Blocking,
    /// Behind the plans, by a worker thread (the paper's Algorithm 2): no plan waits, and what is drawn may be stale.
    Live,
}

/// Options of the method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Side of a patch in grid intervals: 8, 16, 32 or 64. Default 32, the paper's best (its Table 2).
    pub patch: u32,
    /// The allowed error in pixels ("pixel error" in the paper), above 0. Default 1.
    pub tolerance_px: f64,
    /// Which samples are kept. Default [`Selector::Bounded`].
    pub selector: Selector,
    /// Algorithm 1: largest distance between selected samples in grid intervals, 1 to `patch`. Default (`None`) half a
    /// patch.
    pub max_spacing: Option<u32>,
    /// Bounded: side of the largest group in patches, 1 (no groups), 2 or 4, of at most 64 grid intervals. Where one
    /// triangulation of a whole group costs no more than its members, it is drawn in their place: a draw counts as 8
    /// triangles. Default
    /// (`None`) the largest that fits: 4 for patches of 8 or 16, 2 for 32, 1 for 64.
    pub group: Option<u32>,
    /// Bounded: whether the blocks of 8 x 8 samples of patches near the eye have tolerances of their own, in place of the
    /// tolerance of the patch's nearest point: fewer triangles, more updates. Default true.
    pub blocks: bool,
    /// Which edges follow a patch. Default [`EdgePolicy::Matched`].
    pub edge_policy: EdgePolicy,
    /// When patches are updated. Default [`Schedule::Blocking`].
    pub schedule: Schedule,
    /// What connects the selected samples. Default [`Triangulator::Grid`]. The selection does not depend on it.
    pub triangulator: Triangulator,
    /// How the patches share the index buffer. Default [`IndexStore::Packed`]. The triangles do not depend on it.
    pub index_store: IndexStore,
    /// The seed of the paper's random offsets before samples are connected (section 3.3), for fidelity: our
    /// triangulators need none. The offsets are those that keep the mesh sound ([`Jitter::SLIGHT`]), so all that they
    /// change is which diagonal is taken where either will do. Not with [`Triangulator::Grid`]. Default: none.
    pub jitter: Option<u64>,
    /// Algorithm 1: whether a selected sample inside a patch gets the mean height of itself and its neighbours that
    /// are not selected (section 3.3, last paragraph). Updates then write vertices, too. Measured, the RMS error changes
    /// by less than 2 %, down or up; the largest error near the ground was up to 5 times as large. Default: no.
    pub smoothing: bool,
    /// Threads that triangulate, 1 or more. Default 1. The result does not depend on it.
    pub threads: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            patch: 32,
            tolerance_px: 1.0,
            selector: Selector::default(),
            max_spacing: None,
            group: None,
            blocks: true,
            edge_policy: EdgePolicy::default(),
            schedule: Schedule::default(),
            triangulator: Triangulator::default(),
            index_store: IndexStore::default(),
            jitter: None,
            smoothing: false,
            threads: 1,
        }
    }
}

/// An option out of its range, or threads that could not be started.
#[derive(Debug, thiserror::Error)]
pub enum TinError {
    /// The patch size is none of the four.
    #[error("patch of {0} intervals: expected 8, 16, 32 or 64")]
    Patch(u32),
    /// The tolerance is no positive number.
    #[error("tolerance of {0} px: expected a finite number above 0")]
    Tolerance(f64),
    /// The spacing does not fit the patch.
    #[error("maximum spacing of {found} intervals: expected 1 to {patch}, the side of a patch")]
    MaxSpacing {
        /// The spacing given.
        found: u32,
        /// The side of a patch.
        patch: u32,
    },
    /// The group is none of the three, or too large.
    #[error("group of {found} x {found} patches of {patch} intervals: expected 1, 2 or 4, and at most 64 intervals")]
    Group {
        /// The group's side in patches.
        found: u32,
        /// The side of a patch.
        patch: u32,
    },
    /// The bound rests on the grid kernel's tie-break, and on edges that follow at once.
    #[error("the bounded selector needs the triangulator grid and the edge policy matched")]
    Bounded,
    /// Maps that do not fit the DEM and the options.
    #[error("threshold maps of a DEM of another size, or of other patches or groups")]
    Maps,
    /// The grid kernel works in integers.
    #[error("the jitter needs the triangulator delaunator or spade")]
    Jitter,
    /// The bound is one for the DEM's heights.
    #[error("smoothing needs the selector algorithm1")]
    Smoothing,
    /// More vertices, or more room for indices, than 32 bits number.
    #[error("{vertices} vertices and room for {indices} indices: expected at most 2^31 and 2^32; use a smaller DEM")]
    Size {
        /// Vertices of the DEM.
        vertices: u64,
        /// Indices of all rooms, where rooms are fixed.
        indices: u64,
    },
    /// No thread at all.
    #[error("0 threads: expected 1 or more")]
    NoThreads,
    /// The thread pool could not be started.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// The number asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}

impl Options {
    /// Refuses options out of their range.
    pub fn validate(&self) -> Result<(), TinError> {
        if ![8, 16, 32, 64].contains(&self.patch) {
            return Err(TinError::Patch(self.patch));
        }
        if !(self.tolerance_px > 0.0 && self.tolerance_px.is_finite()) {
            return Err(TinError::Tolerance(self.tolerance_px));
        }
        let fits_bounded = self.triangulator == Triangulator::Grid && self.edge_policy == EdgePolicy::Matched;
        if self.selector == Selector::Bounded && !fits_bounded {
            return Err(TinError::Bounded);
        }
        if self.jitter.is_some() && self.triangulator == Triangulator::Grid {
            return Err(TinError::Jitter);
        }
        if self.smoothing && self.selector == Selector::Bounded {
            return Err(TinError::Smoothing);
        }
        if self.threads == 0 {
            return Err(TinError::NoThreads);
        }
        if let Some(found) = self.group
            && !([1, 2, 4].contains(&found) && found * self.patch <= 64)
        {
            return Err(TinError::Group { found, patch: self.patch });
        }
        match self.max_spacing {
            Some(found) if found == 0 || found > self.patch => Err(TinError::MaxSpacing { found, patch: self.patch }),
            _ => Ok(()),
        }
    }

    /// The vertex buffer that the index store needs.
    pub(crate) fn vertex_strips(&self, heightmap: &Heightmap) -> VertexStrips {
        match self.index_store {
            IndexStore::Fixed => VertexStrips::one(heightmap),
            IndexStore::Packed => VertexStrips::new(heightmap, self.patch * self.group()),
        }
    }

    /// Connects the kept samples of a patch.
    pub(crate) fn triangulate(&self, patch: PatchId, kept: &KeptSamples, indices: &mut Vec<u32>) {
        match self.jitter {
            None => self.triangulator.triangulate(kept, indices),
            Some(seed) => {
                let jitter = Jitter { amplitude: Jitter::SLIGHT, seed: seed ^ SplitMix64::mix(patch.into()) };
                self.triangulator.triangulate_jittered(kept, jitter, indices);
            }
        }
    }

    /// [`Options::max_spacing`] with its default.
    pub(crate) fn max_spacing(&self) -> u32 {
        self.max_spacing.unwrap_or(self.patch / 2)
    }

    /// [`group`](field@Options::group) with its default; Algorithm 1 has no groups.
    pub fn group(&self) -> u32 {
        match self.selector {
            Selector::Algorithm1 => 1,
            Selector::Bounded => self.group.unwrap_or((64 / self.patch).min(4)),
        }
    }
}
