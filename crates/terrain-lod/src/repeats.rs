//! What the repeats are good for: the A/A check, and how narrow `--until-ci` has made the intervals.

use std::fmt::Write;

use crate::compare::{Comparison, Who};
use crate::frame_times::RepeatTimes;
use crate::interval::Verdict;
use crate::suite::Suite;
use crate::summary::SummaryRow;

/// The two sets of flights of one run, compared by the time that stands for it.
pub fn check_aa(row: &SummaryRow, a: &RepeatTimes, b: &RepeatTimes) -> Option<Comparison> {
    let who = Who { method: &row.method, setting: &row.setting, tolerance_px: row.tolerance_px };
    who.compare_times(a.headline(), a, b)
}

/// What a reader is told of the A/A check; nothing where there was none.
pub fn describe_aa(checked: &[Comparison]) -> String {
    if checked.is_empty() {
        return String::new();
    }
    let mut text = "\nA/A check, each run flown twice:\n\n".to_string();
    for c in checked {
        let verdict = if c.verdict == Verdict::Same { "same" } else { "DIFFERENT" };
        let number = |value: Option<f64>| value.map_or("?".to_string(), |value| format!("{value:.3}"));
        let interval = match c.low {
            Some(_) => format!("{} to {}", number(c.low), number(c.high)),
            None => "no interval from one repeat".to_string(),
        };
        let (run, ratio) = (format!("{} {} {} px", c.method, c.setting, c.tolerance_px), number(c.ratio));
        let _ = writeln!(text, "- {run}: {} B / A = {ratio} ({interval}): {verdict}", c.measure);
    }
    text
}

/// What a reader is told of the repeats that `--until-ci` has made; nothing without it.
pub fn describe_width(suite: &Suite, runs: &[(&SummaryRow, &RepeatTimes)]) -> String {
    let Some(asked) = suite.until_ci else { return String::new() };
    let flown = runs.iter().map(|(row, _)| row.repeats).max().unwrap_or(0);
    let percent = 100.0 * asked;
    let is_wide = |times: &RepeatTimes| times.headline_width().is_none_or(|width| width > asked);
    let wide: Vec<_> = runs.iter().filter(|(row, times)| row.err.is_empty() && is_wide(times)).collect();
    if wide.is_empty() {
        return format!("\nAfter {flown} repeats the intervals of all medians are narrower than {percent} %.\n");
    }
    let mut text = format!("\nStopped at {flown} repeats (--max-repeats) with intervals wider than {percent} %:\n\n");
    for (row, times) in wide {
        let width = times.headline_width().map_or("none".into(), |width| format!("{:.1} % wide", 100.0 * width));
        let _ =
            writeln!(text, "- {} {} {} px: {} {width}", row.method, row.setting, row.tolerance_px, times.headline());
    }
    text
}
