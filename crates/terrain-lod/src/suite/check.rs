//! What a suite file must keep, as the flags of the same names do.

use std::ops::RangeInclusive;

use terrain_dem::{Crop, ReadOptions, VoidPolicy};

use super::{FRAMES, PIXELS, REPEATS, SHARES, SIDE_PX, STEPS, Suite, THREADS};
use crate::equal_error::EqualError;
use crate::figures;
use crate::pivot::Pivot;

/// More than anybody flies, and few enough to be listed in no time.
const MAX_COMBINATIONS: u64 = 1 << 16;

impl Suite {
    /// How the DEM is read: as the flags say, and else as the suite says.
    pub(super) fn read_options(&self, flags: ReadOptions) -> Result<ReadOptions, String> {
        let crop = self.crop.as_deref().map(|text| {
            Crop::parse(text)
                .ok_or_else(|| format!("crop = {text:?}; expected such as \"513x513\" or \"513x513+100+0\""))
        });
        Ok(ReadOptions {
            crop: flags.crop.or(crop.transpose()?),
            thin: flags.thin.or(self.thin),
            spacing_m: flags.spacing_m.or(self.spacing_m),
            scale: flags.scale.or(self.scale),
            offset_m: flags.offset_m.or(self.offset_m),
            voids: self.voids.map_or(flags.voids, VoidPolicy::from),
            ..flags
        })
    }

    /// What the command line checks flag by flag, a suite file must keep as well.
    pub(super) fn validate(&self) -> Result<(), String> {
        let within = |name: &str, value: u32, range: RangeInclusive<u32>| match range.contains(&value) {
            true => Ok(()),
            false => Err(format!("{name} = {value}; expected {} to {}", range.start(), range.end())),
        };
        let pixels = |name: &str, list: &[f64]| match list.iter().find(|px| !PIXELS.contains(*px)) {
            Some(px) => Err(format!("{name} = {px}; expected {:e} to {:e}", PIXELS.start(), PIXELS.end())),
            None => Ok(()),
        };
        let lists = [
            ("methods", self.methods.len()),
            ("selector", self.selector.len()),
            ("patch", self.patch.len()),
            ("k", self.k.len()),
            ("step", self.step.len()),
            ("schedule", self.schedule.len()),
            ("triangulator", self.triangulator.len()),
            ("index_store", self.index_store.len()),
            ("edge_policy", self.edge_policy.len()),
            ("blocks", self.blocks.len()),
            ("geomorph", self.geomorph.len()),
            ("threads", self.threads.len()),
            ("tolerance_px", self.tolerance_px.len()),
            ("leg_px", self.leg_px.len()),
        ];
        if let Some((name, _)) = lists.iter().find(|(_, length)| *length == 0) {
            return Err(format!("{name} is empty; expected at least one"));
        }
        let may_be_empty =
            [&self.metric.len(), &self.batching.len(), &self.window_mib.len(), &self.group.len(), &self.layers.len()];
        let lengths = lists.iter().map(|(_, length)| length).chain(may_be_empty);
        let combinations = lengths.fold(1_u64, |all, length| all.saturating_mul((*length).max(1) as u64));
        if combinations > MAX_COMBINATIONS {
            return Err(format!("the lists have {combinations} combinations; expected at most {MAX_COMBINATIONS}"));
        }
        pixels("tolerance_px", &self.tolerance_px)?;
        pixels("leg_px", &self.leg_px)?;
        self.step.iter().try_for_each(|step| within("step", *step, STEPS))?;
        if let Some(distance_m) = self.distance_m.filter(|m| !(*m > 0.0 && m.is_finite())) {
            return Err(format!("distance_m = {distance_m}; expected a number above 0"));
        }
        within("thin", self.thin.unwrap_or(1), 1..=65_535)?;
        if let Some(spacing_m) = self.spacing_m.filter(|sides| !sides.iter().all(|m| *m > 0.0 && m.is_finite())) {
            return Err(format!("spacing_m = {spacing_m:?}; expected two numbers above 0"));
        }
        let finite = |name: &str, value: Option<f64>| match value.filter(|value| !value.is_finite()) {
            Some(value) => Err(format!("{name} = {value}; expected a finite number")),
            None => Ok(()),
        };
        finite("scale", self.scale)?;
        finite("offset_m", self.offset_m)?;
        within("size_px", self.size_px[0], SIDE_PX)?;
        within("size_px", self.size_px[1], SIDE_PX)?;
        within("frames", self.frames.unwrap_or(1), FRAMES)?;
        within("repeats", self.repeats, REPEATS)?;
        within("max_repeats", self.max_repeats, REPEATS)?;
        if let Some(share) = self.until_ci.filter(|share| !SHARES.contains(share)) {
            return Err(format!("until_ci = {share}; expected {} to {}", SHARES.start(), SHARES.end()));
        }
        self.threads.iter().try_for_each(|threads| within("threads", (*threads).into(), THREADS))?;
        self.tables.iter().try_for_each(Pivot::validate)?;
        self.equal_error.iter().try_for_each(EqualError::validate)?;
        self.flight_curves.iter().try_for_each(|curves| curves.validate(&[]))?;
        figures::validate(&self.figures)
    }
}

#[cfg(test)]
mod tests {
    use crate::suite::check_suite;

    /// Twenty short lists would fill any memory before a word is said.
    #[test]
    fn lists_with_too_many_combinations_are_refused() {
        let ten = "[1, 2, 3, 4, 5, 6, 7, 8, 9, 10]";
        let lists = |names: &[&str]| names.iter().map(|name| format!("{name} = {ten}\n")).collect::<String>();
        let all = lists(&["tolerance_px", "leg_px", "step", "threads", "group"]) + "methods = ['tin']";
        let expected = "the lists have 100000 combinations; expected at most 65536";
        assert_eq!(check_suite("a suite", &all).unwrap_err().to_string(), expected);
        check_suite("a suite", &(lists(&["tolerance_px", "leg_px", "step"]) + "methods = ['tin']")).unwrap();
    }
}
