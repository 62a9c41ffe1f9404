//! The runs of a suite: every combination of its lists, once.

use std::collections::HashSet;

use regex_lite::Regex;

use super::Suite;
use crate::choices::{EdgePolicyName, SelectorName, TriangulatorName};
use crate::fault::Fault;
use crate::methods::{Run, Settings};

impl Suite {
    /// One run for each method and each value of its own settings, in the order of the lists.
    pub fn runs(&self) -> Result<Vec<Run>, Fault> {
        let runs = self.runs_or_none()?;
        match (&self.filter, runs.is_empty()) {
            (Some(filter), true) => {
                Err(Fault::usage(format!("no run matches the filter '{filter}'; --dry-run lists them")))
            }
            _ => Ok(runs),
        }
    }

    /// The same, where a filter may leave none.
    pub(super) fn runs_or_none(&self) -> Result<Vec<Run>, Fault> {
        let filter = self.filter.as_deref().map(parse_filter).transpose()?;
        let asked_for = |run: &Run| filter.as_ref().is_none_or(|filter| filter.is_match(&run.title()));
        let (mut runs, mut stems) = (Vec::new(), HashSet::new());
        for method in &self.methods {
            for settings in self.all_settings() {
                let run = Run { method: *method, settings };
                run.validate()?;
                // Values of settings that the method does not have would only repeat it.
                if asked_for(&run) && stems.insert(run.file_stem()) {
                    runs.push(run);
                }
            }
        }
        Ok(runs)
    }

    /// The most flights of each run in the speed pass.
    pub fn most_repeats(&self) -> u32 {
        if self.until_ci.is_some() { self.repeats.max(self.max_repeats) } else { self.repeats }
    }

    /// Every combination of the lists.
    fn all_settings(&self) -> Vec<Settings> {
        let all = vec![self.first_settings()];
        let all = with_each(all, &self.tolerance_px, |settings, px| settings.tolerance_px = px);
        let all = with_each(all, &self.selector, |settings, selector| settings.selector = selector);
        let all = with_each(all, &self.triangulator, |settings, name| settings.triangulator = name);
        let all = with_each(all, &self.schedule, |settings, schedule| settings.schedule = schedule);
        let all = with_each(all, &self.patch, |settings, patch| settings.patch = patch);
        let all = with_each(all, &self.leg_px, |settings, px| settings.leg_px = px);
        let all = with_each(all, &self.k, |settings, k| settings.k = k);
        let all = with_each_or_none(all, &self.batching, |settings, name| settings.batching = name);
        let all = with_each_or_none(all, &self.metric, |settings, name| settings.metric = name);
        let all = with_each_or_none(all, &self.window_mib, |settings, mib| settings.window_mib = mib);
        let all = with_each_or_none(all, &self.group, |settings, group| settings.group = group);
        let all = with_each(all, &self.blocks, |settings, blocks| settings.blocks = blocks);
        let all = with_each(all, &self.edge_policy, |settings, policy| settings.edge_policy = policy);
        let all = with_each(all, &self.index_store, |settings, store| settings.index_store = store);
        let all = with_each_or_none(all, &self.layers, |settings, layers| settings.layers = layers);
        let all = with_each(all, &self.geomorph, |settings, geomorph| settings.geomorph = geomorph);
        let all = with_each(all, &self.threads, |settings, threads| settings.threads = threads.into());
        let mut all = with_each(all, &self.step, |settings, step| settings.step = step);
        all.retain(|settings| settings.selector != SelectorName::Bounded || self.fits_bounded(settings));
        all
    }

    /// The bounded selector knows one triangulator and one edge policy. The others of a list are for algorithm 1.
    fn fits_bounded(&self, settings: &Settings) -> bool {
        let (grid, matched) = (TriangulatorName::Grid, EdgePolicyName::Matched);
        let triangulator = settings.triangulator == grid || !self.triangulator.contains(&grid);
        triangulator && (settings.edge_policy == matched || !self.edge_policy.contains(&matched))
    }

    /// The first of each list.
    pub(super) fn first_settings(&self) -> Settings {
        Settings {
            tolerance_px: self.tolerance_px[0],
            selector: self.selector[0],
            patch: self.patch[0],
            max_spacing: self.max_spacing,
            group: None,
            blocks: self.blocks[0],
            schedule: self.schedule[0],
            triangulator: self.triangulator[0],
            index_store: self.index_store[0],
            edge_policy: self.edge_policy[0],
            jitter: self.jitter,
            smoothing: self.smoothing,
            metric: None,
            batching: None,
            leg_px: self.leg_px[0],
            k: self.k[0],
            layers: None,
            geomorph: self.geomorph[0],
            window_mib: None,
            loading: self.loading,
            step: self.step[0],
            distance_m: self.distance_m,
            threads: self.threads[0].into(),
        }
    }

    /// The tolerances that a run has a row for: its own, or all of them as yardsticks.
    pub fn tolerances_of(&self, run: &Run) -> Vec<f64> {
        if run.takes_tolerance() { vec![run.settings.tolerance_px] } else { self.tolerance_px.clone() }
    }
}

fn parse_filter(text: &str) -> Result<Regex, Fault> {
    Regex::new(text).map_err(|error| Fault::usage(format_args!("filter '{text}': {error}")))
}

/// The settings with each value of a list in turn.
fn with_each<T: Copy>(all: Vec<Settings>, list: &[T], set: fn(&mut Settings, T)) -> Vec<Settings> {
    let with = |mut settings: Settings, value: &T| {
        set(&mut settings, *value);
        settings
    };
    all.into_iter().flat_map(|settings| list.iter().map(move |value| with(settings, value))).collect()
}

/// Likewise; without any value, the settings as they are.
fn with_each_or_none<T: Copy>(all: Vec<Settings>, list: &[T], set: fn(&mut Settings, Option<T>)) -> Vec<Settings> {
    if list.is_empty() { all } else { with_each(all, &list.iter().map(|value| Some(*value)).collect::<Vec<_>>(), set) }
}

#[cfg(test)]
mod tests {
    use terrain_core::source::SourceText;

    use super::*;

    fn stems(text: &str) -> Vec<String> {
        let source = SourceText { name: "a suite", text };
        source.parse::<Suite>().unwrap().runs().unwrap().iter().map(Run::file_stem).collect()
    }

    #[test]
    fn one_value_is_a_list_of_one() {
        let expected = ["tin-bounded-1px-patch32-grid-blocking-group1-fixed-threads2"];
        let rest = "methods = ['tin']\ngroup = 1\nindex_store = 'fixed'\nthreads = 2";
        assert_eq!(stems(rest), expected);
        assert_eq!(stems("methods = ['tin']\ngroup = [1]\nindex_store = ['fixed']\nthreads = [2]"), expected);
        let source = SourceText { name: "a suite", text: "threads = 'two'" };
        let refused = source.parse::<Suite>().unwrap_err().to_string();
        assert!(refused.starts_with("a suite:1:") && refused.contains("expected u16"), "{refused}");
    }

    #[test]
    fn every_combination_has_a_file_of_its_own_and_the_bounded_selector_its_own_policy() {
        let lists = "methods = ['tin']\nselector = ['algorithm1', 'bounded']\nedge_policy = ['matched', 'paper']\n\
                     index_store = ['fixed', 'packed']\nthreads = [1, 2]";
        let stems = stems(lists);
        assert_eq!(stems.len(), 4 * 2 + 4, "{stems:?}");
        assert!(!stems.iter().any(|stem| stem.contains("bounded") && stem.contains("paper")), "{stems:?}");
    }
}
