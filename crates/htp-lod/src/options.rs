//! The settings of the method, and why some of them are refused.

/// How the visible patches reach the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Batching {
    /// As published: one draw a patch, from vertices of its own (section 3, phases 5 and 6).
    #[default]
    PerPatch,
    /// One draw a cell: the patches of a cell in one index list, written when the levels of a visible cell change.
    /// Vertices are those of [`Batching::PerPatch`].
    MergedCell,
    /// One instanced draw an index list: at most 7 draws a frame.
    Instanced,
}

/// Whether a plan waits for the cells that it wants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Loading {
    /// A thread reads; plans take what has arrived, and draw the coarse levels of the rest.
    #[default]
    Live,
    /// Each plan reads all cells around the eye that it lacks: plans depend on the views so far and on nothing else.
    Blocking,
}

/// What decides which patches are split (section 3, phase 4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LevelMetric {
    /// The paper's: levels in proportion to the distance, as a longest screen length of a triangle's leg
    /// ([`Options::leg_px`]).
    #[default]
    Distance,
    /// The paper's alternative: by the edges of the bounding box. The longest edge of a square's box, its height
    /// among them, counts as the leg of a patch of `k` segments: the k-th part of it is held to [`Options::leg_px`].
    Box,
    /// The error that a patch or block makes: no sample of the DEM is farther off on the screen than
    /// [`Options::tolerance_px`].
    Error,
}

/// Settings of [`Htp`](crate::Htp), fixed for its life. The default is the paper's; see also [`Options::bounded`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Small triangles along each side of a patch; 2 to 16, default 3.
    ///
    /// Deviation: any `k`, as section 2.1 defines patches; the paper's index lists (4.1) and blocks are for 3.
    pub k: u32,
    /// Layers of the hierarchy, which is the number of levels of detail; 1 to 6, default 3.
    /// A cell is `k^layers` sample intervals wide; the coarsest step, `k^(layers - 1)`, is at most 32,767.
    ///
    /// Deviation: the paper has 3 "for the simplicity" (section 3, phase 2).
    pub layers: u32,
    /// What decides which patches are split; default [`LevelMetric::Distance`].
    pub metric: LevelMetric,
    /// For [`LevelMetric::Distance`] and [`LevelMetric::Box`]: the longest screen length, in pixels, that the leg of a
    /// small triangle may have; positive, default 8. The leg counts as if seen square-on from where the eye is nearest
    /// to its patch: with its length on the map, or with the k-th part of the box's longest edge. On the finest layer
    /// legs may be longer.
    pub leg_px: f64,
    /// For [`LevelMetric::Error`]: the largest distance, in pixels, between the mesh and any sample of the DEM;
    /// positive, default 1. Both are measured by [`View::pixels`](terrain_core::View::pixels).
    pub tolerance_px: f64,
    /// How the visible patches reach the GPU; default [`Batching::PerPatch`].
    pub batching: Batching,
    /// Whether levels glide into one another instead of popping ([`Morph`](terrain_core::Morph)); default `false`.
    /// For [`LevelMetric::Distance`] with [`Batching::Instanced`]: see `geomorph` for why no other.
    pub geomorph: bool,
    /// For [`Htp::stream`](crate::Htp::stream): MiB that all that is kept of the DEM may take, the GPU's heights
    /// included; default 256.
    pub window_mib: u32,
    /// For [`Htp::stream`](crate::Htp::stream): whether plans wait for cells; default [`Loading::Live`].
    pub loading: Loading,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            k: 3,
            layers: 3,
            metric: LevelMetric::default(),
            leg_px: 8.0,
            tolerance_px: 1.0,
            batching: Batching::default(),
            geomorph: false,
            window_mib: 256,
            loading: Loading::default(),
        }
    }
}

impl Options {
    /// The largest `k`. From 5 on, most terrain needs nearly every sample: a level is then as coarse as `k * k` of the
    /// next finer one.
    pub const MAX_K: u32 = 16;
    /// The largest number of layers.
    pub const MAX_LAYERS: u32 = 6;

    /// Beyond the paper: levels by error, four layers, instances.
    pub fn bounded() -> Self {
        Self { layers: 4, metric: LevelMetric::Error, batching: Batching::Instanced, ..Self::default() }
    }

    /// Refuses settings outside the ranges stated at the fields.
    pub fn validate(&self) -> Result<(), HtpError> {
        let Self { k, layers, leg_px, tolerance_px, .. } = *self;
        if !(2..=Self::MAX_K).contains(&k) {
            return Err(HtpError::K(k));
        }
        if !(1..=Self::MAX_LAYERS).contains(&layers) {
            return Err(HtpError::Layers(layers));
        }
        // Steps along a patch's legs travel to the GPU as 16-bit integers.
        if coarsest_step(k, layers) > i16::MAX as u64 {
            return Err(HtpError::Step { k, layers });
        }
        if self.geomorph && self.metric != LevelMetric::Distance {
            return Err(HtpError::GeomorphMetric);
        }
        if self.geomorph && self.batching != Batching::Instanced {
            return Err(HtpError::GeomorphBatching);
        }
        let is_length = |px: f64| px > 0.0 && px.is_finite();
        if !is_length(leg_px) {
            return Err(HtpError::LegPx(leg_px));
        }
        if !is_length(tolerance_px) {
            return Err(HtpError::TolerancePx(tolerance_px));
        }
        Ok(())
    }

    /// Refuses what cells that are loaded one by one cannot do, besides.
    pub fn validate_streamed(&self) -> Result<(), HtpError> {
        self.validate()?;
        if self.batching != Batching::Instanced {
            return Err(HtpError::StreamedBatching);
        }
        if self.layers < 2 {
            return Err(HtpError::StreamedLayers);
        }
        if self.geomorph {
            return Err(HtpError::GeomorphStreamed);
        }
        Ok(())
    }
}

/// Legs of the coarsest small triangles in sample intervals.
fn coarsest_step(k: u32, layers: u32) -> u64 {
    (k as u64).pow(layers - 1)
}

/// Settings that the method cannot work with.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HtpError {
    /// [`Options::k`] out of range.
    #[error("k of {0}: expected 2 to {max}", max = Options::MAX_K)]
    K(u32),
    /// [`Options::layers`] out of range.
    #[error("{0} layers: expected 1 to {max}", max = Options::MAX_LAYERS)]
    Layers(u32),
    /// [`Options::leg_px`] not positive or not finite.
    #[error("leg of {0} px: expected a positive, finite number")]
    LegPx(f64),
    /// [`Options::tolerance_px`] not positive or not finite.
    #[error("tolerance of {0} px: expected a positive, finite number")]
    TolerancePx(f64),
    /// [`Options::geomorph`] with levels that do not go by the distance alone.
    #[error(
        "geomorph needs the metric distance: other levels end at distances that a vertex shared by patches cannot know"
    )]
    GeomorphMetric,
    /// [`Options::geomorph`] with vertices that have heights of their own.
    #[error("geomorph needs the batching instanced: vertices with heights of their own cannot glide")]
    GeomorphBatching,
    /// [`Options::geomorph`] over cells that are loaded one by one: a vertex glides towards samples of other levels, which
    /// lie elsewhere.
    #[error("geomorphing with cells that are loaded one by one: expected the whole DEM in memory")]
    GeomorphStreamed,
    /// The coarsest step, `k^(layers - 1)` sample intervals, is too long.
    #[error("k of {k} with {layers} layers makes steps of {step} sample intervals: expected at most {max}",
        step = coarsest_step(*.k, *.layers), max = i16::MAX)]
    Step {
        /// [`Options::k`].
        k: u32,
        /// [`Options::layers`].
        layers: u32,
    },
    /// Cells are streamed for instances alone, since no other batching takes its heights from elsewhere.
    #[error("cells that are loaded one by one are drawn by instances alone")]
    StreamedBatching,
    /// One layer has nothing coarser that could stand in for a cell.
    #[error("cells that are loaded one by one need 2 layers or more")]
    StreamedLayers,
    /// Cells that were cut for other settings.
    #[error("cells of k {} with {} layers: expected k {} with {} layers; cut them again or change the settings",
        found[0], found[1], expected[0], expected[1])]
    OtherCells {
        /// `k` and layers of the cells.
        found: [u32; 2],
        /// [`Options::k`] and [`Options::layers`].
        expected: [u32; 2],
    },
    /// [`Options::window_mib`] too small for what is always resident and one cell.
    #[error("window of {window_mib} MiB: expected at least {needed_mib} for these cells")]
    WindowMib {
        /// [`Options::window_mib`].
        window_mib: u32,
        /// The smallest window.
        needed_mib: u64,
    },
    /// The thread that reads cells could not be started.
    #[error("no thread to read cells: {0}; load them blocking")]
    Thread(String),
    /// The DEM has too many patches for vertices of their own ([`Batching::PerPatch`], [`Batching::MergedCell`]).
    #[error("{patches} patches with vertices of their own: expected at most {limit}; use instances")]
    Patches {
        /// Patches of all layers of all cells.
        patches: u64,
        /// The largest number that can be addressed with this `k`.
        limit: u64,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unusable_settings_are_refused_in_one_line() {
        let refuse = |options: Options| options.validate().unwrap_err().to_string();
        let good = Options::default();
        assert_eq!(good.validate(), Ok(()));
        assert_eq!(Options::bounded().validate(), Ok(()));
        assert_eq!(refuse(Options { k: 1, ..good }), "k of 1: expected 2 to 16");
        assert_eq!(refuse(Options { k: 17, ..good }), "k of 17: expected 2 to 16");
        assert_eq!(refuse(Options { layers: 0, ..good }), "0 layers: expected 1 to 6");
        assert_eq!(refuse(Options { layers: 7, ..good }), "7 layers: expected 1 to 6");
        let steps = "k of 9 with 6 layers makes steps of 59049 sample intervals: expected at most 32767";
        assert_eq!(refuse(Options { k: 9, layers: 6, ..good }), steps);
        let gliding = Options { geomorph: true, ..Options::bounded() };
        assert!(refuse(gliding).starts_with("geomorph needs the metric distance"));
        let gliding = Options { metric: LevelMetric::Distance, ..gliding };
        assert_eq!(gliding.validate(), Ok(()));
        assert!(
            refuse(Options { batching: Batching::MergedCell, ..gliding }).starts_with("geomorph needs the batching")
        );
        for px in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let expected = format!("{px} px: expected a positive, finite number");
            assert_eq!(refuse(Options { leg_px: px, ..good }), format!("leg of {expected}"));
            assert_eq!(refuse(Options { tolerance_px: px, ..good }), format!("tolerance of {expected}"));
        }
    }
}
