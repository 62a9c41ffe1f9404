//! Two measurements of one run side by side: the A/A check within a bench, and `cmp` between benches.

use serde::Serialize;

use crate::frame_times::{RepeatTimes, SHORTEST_MS};
use crate::interval::{Interval, Verdict};
use crate::output::tidy;

/// One number of a run, in A and in B.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Of a suite of several; empty where there is one bench.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub bench: String,
    pub method: String,
    pub setting: String,
    pub tolerance_px: f64,
    /// The column of the summary.
    pub measure: String,
    pub a: Option<f64>,
    pub b: Option<f64>,
    /// b / a; empty where a is 0 or one of them was not measured.
    pub ratio: Option<f64>,
    /// Ends of the ratio's 95 % interval, for times with repeats.
    pub low: Option<f64>,
    pub high: Option<f64>,
    pub verdict: Verdict,
}

/// The run that is compared.
#[derive(Clone, Copy)]
pub struct Who<'a> {
    pub bench: &'a str,
    pub method: &'a str,
    pub setting: &'a str,
    pub tolerance_px: f64,
}

impl Who<'_> {
    /// A comparison without an interval yet.
    pub fn compare(&self, measure: &str, a: Option<f64>, b: Option<f64>, verdict: Verdict) -> Comparison {
        Comparison {
            bench: self.bench.into(),
            method: self.method.into(),
            setting: self.setting.into(),
            tolerance_px: self.tolerance_px,
            measure: measure.into(),
            a,
            b,
            ratio: a.zip(b).filter(|(a, _)| *a != 0.0).map(|(a, b)| tidy(b / a)),
            low: None,
            high: None,
            verdict,
        }
    }

    /// One statistic over the repeats of both; `None` where one of them does not have it.
    pub fn compare_times(&self, statistic: &str, a: &RepeatTimes, b: &RepeatTimes) -> Option<Comparison> {
        let [a_values, b_values] = [a, b].map(|times| readable(times.get(statistic)));
        let medians = [a.median(statistic)?, b.median(statistic)?];
        Some(self.compare_by(statistic, medians, Interval::of_ratio(&a_values, &b_values)))
    }

    /// One statistic by the interval of its ratio. Without one, nothing is known to differ.
    pub fn compare_by(&self, statistic: &str, [a, b]: [f64; 2], ratio: Option<Interval>) -> Comparison {
        let Some(ratio) = ratio else {
            return self.compare(statistic, Some(a), Some(b), Verdict::Same);
        };
        let verdict = if is_better_when_larger(statistic) { ratio.inverse().verdict() } else { ratio.verdict() };
        let compared = self.compare(statistic, Some(a), Some(b), verdict);
        let Interval { estimate, low, high } = ratio;
        Comparison { ratio: Some(tidy(estimate)), low: Some(tidy(low)), high: Some(tidy(high)), ..compared }
    }
}

/// Frames a second, of all that is measured.
pub fn is_better_when_larger(measure: &str) -> bool {
    measure.starts_with("fps")
}

/// Times as far as the clock can tell them.
fn readable(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| value.max(SHORTEST_MS)).collect()
}
