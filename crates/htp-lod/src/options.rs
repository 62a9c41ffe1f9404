//! The settings of the method, and why some of them are refused.

/// How the visible patches reach the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Batching {
    /// As published: one draw a patch, from vertices of its own (section 3, phases 5 and 6). Method name `htp`.
    #[default]
    PerPatch,
    /// One instanced draw an index list: at most 7 draws a frame. Method name `htp-instanced`.
    Instanced,
}

/// Settings of [`Htp`](crate::Htp), fixed for its life.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Small triangles along each side of a patch; 2 to 255, default 3.
    ///
    /// Deviation: any `k`, as section 2.1 defines patches; the paper's index lists (4.1) and blocks are for 3.
    pub k: u32,
    /// Layers of the hierarchy, which is the number of levels of detail; 1 to 6, default 3.
    /// A cell is `k^layers` sample intervals wide; the coarsest step, `k^(layers - 1)`, is at most 32,767.
    ///
    /// Deviation: the paper has 3 "for the simplicity" (section 3, phase 2).
    pub layers: u32,
    /// The longest screen length, in pixels, that the leg of a small triangle may have; positive, default 8. The leg
    /// counts with its length on the map, as if seen square-on from where the eye is nearest to its patch. On the
    /// finest layer legs may be longer.
    pub leg_px: f64,
    /// How the visible patches reach the GPU; default [`Batching::PerPatch`].
    pub batching: Batching,
}

impl Default for Options {
    fn default() -> Self {
        Self { k: 3, layers: 3, leg_px: 8.0, batching: Batching::default() }
    }
}

impl Options {
    /// The largest `k`: the 8 index lists stay below 7 MB, and a patch stays a patch.
    pub const MAX_K: u32 = 255;
    /// The largest number of layers.
    pub const MAX_LAYERS: u32 = 6;

    /// Refuses settings outside the ranges stated at the fields.
    pub fn validate(&self) -> Result<(), HtpError> {
        let Self { k, layers, leg_px, .. } = *self;
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
        if !(leg_px > 0.0 && leg_px.is_finite()) {
            return Err(HtpError::LegPx(leg_px));
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
    /// The coarsest step, `k^(layers - 1)` sample intervals, is too long.
    #[error("k of {k} with {layers} layers makes steps of {step} sample intervals: expected at most {max}",
        step = coarsest_step(*.k, *.layers), max = i16::MAX)]
    Step {
        /// [`Options::k`].
        k: u32,
        /// [`Options::layers`].
        layers: u32,
    },
    /// The DEM has too many patches for vertices of their own ([`Batching::PerPatch`]).
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
        assert_eq!(refuse(Options { k: 1, ..good }), "k of 1: expected 2 to 255");
        assert_eq!(refuse(Options { k: 256, ..good }), "k of 256: expected 2 to 255");
        assert_eq!(refuse(Options { layers: 0, ..good }), "0 layers: expected 1 to 6");
        assert_eq!(refuse(Options { layers: 7, ..good }), "7 layers: expected 1 to 6");
        let steps = "k of 9 with 6 layers makes steps of 59049 sample intervals: expected at most 32767";
        assert_eq!(refuse(Options { k: 9, layers: 6, ..good }), steps);
        for leg_px in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(
                refuse(Options { leg_px, ..good }),
                format!("leg of {leg_px} px: expected a positive, finite number")
            );
        }
    }
}
