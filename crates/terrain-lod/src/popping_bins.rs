//! `popping.csv`: how many samples each run's changes of the mesh moved, and how far.

use serde::{Deserialize, Serialize};
use terrain_core::popping::Popping;

use crate::methods::Run;

/// One bin of one run: moves of `from_px` or more and less than `to_px`, of all samples in view of all frames.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PoppingBin {
    pub method: String,
    pub setting: String,
    /// Where it is a setting of the method.
    pub tolerance_px: Option<f64>,
    pub from_px: f32,
    /// Empty for the last bin, which has no end.
    pub to_px: Option<f32>,
    /// Moves by the usual formula.
    pub popping_samples: u64,
    /// Moves as displacements on the screen.
    pub displaced_samples: u64,
}

/// The bins of one run.
pub fn bins(run: &Run, popping: &Popping) -> Vec<PoppingBin> {
    let bin = |i: usize| {
        let (from_px, to_px) = (Popping::BINS_PX[i], Popping::BINS_PX.get(i + 1).copied());
        let end_px = to_px.unwrap_or(f32::INFINITY);
        PoppingBin {
            method: run.method.as_str().into(),
            setting: run.setting(),
            tolerance_px: run.takes_tolerance().then_some(run.settings.tolerance_px),
            from_px,
            to_px,
            popping_samples: popping.pixels().count(from_px, end_px),
            displaced_samples: popping.displacements().count(from_px, end_px),
        }
    };
    (0..Popping::BINS_PX.len()).map(bin).collect()
}
