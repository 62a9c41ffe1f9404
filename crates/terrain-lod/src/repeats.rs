//! What the repeats are good for: the A/A check, and how narrow `--until-ci` has made the intervals.

use std::fmt::Write;

use crate::compare::{Comparison, Who};
use crate::frame_times::RepeatTimes;
use crate::interval::Verdict;
use crate::suite::Suite;
use crate::summary::SummaryRow;

/// The two sets of flights of one run, compared by the time that stands for it.
pub fn check_aa(row: &SummaryRow, a: &RepeatTimes, b: &RepeatTimes) -> Option<Comparison> {
    let who = Who { bench: "", method: &row.method, setting: &row.setting, tolerance_px: row.tolerance_px };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::speed_pass::SpeedFrame;

    /// Flights of one frame each.
    fn times(frame_ms: &[f64]) -> RepeatTimes {
        let frame =
            |(repeat, frame_ms): (u32, &f64)| SpeedFrame { repeat, frame_ms: Some(*frame_ms), ..SpeedFrame::default() };
        RepeatTimes::of(&(0..).zip(frame_ms).map(frame).collect::<Vec<_>>())
    }

    fn row() -> SummaryRow {
        SummaryRow { method: "tin".into(), setting: "x".into(), tolerance_px: 1.0, repeats: 4, ..Default::default() }
    }

    #[test]
    fn copies_that_differ_are_named() {
        let a = times(&[10.0, 10.1, 9.9, 10.0]);
        let said = |b: &[f64]| describe_aa(check_aa(&row(), &a, &times(b)).as_slice());
        assert!(
            said(&[10.1, 10.0, 9.9, 10.0]).contains("- tin x 1 px: frame_ms_p50 B / A = 1.000 ("),
            "a heading, too"
        );
        assert!(said(&[10.1, 10.0, 9.9, 10.0]).ends_with("): same\n"));
        assert!(said(&[12.1, 12.0, 11.9, 12.0]).ends_with("): DIFFERENT\n"));
        assert!(said(&[12.0]).ends_with("(no interval from one repeat): same\n"));
        assert_eq!(describe_aa(&[]), "");
    }

    #[test]
    fn intervals_that_stay_wide_are_named() {
        let suite = Suite { until_ci: Some(0.05), ..Suite::default() };
        let (row, narrow, wide) = (row(), times(&[10.0; 4]), times(&[10.0, 12.0, 8.0, 10.0]));
        let said = describe_width(&suite, &[(&row, &narrow)]);
        assert_eq!(said, "\nAfter 4 repeats the intervals of all medians are narrower than 5 %.\n");
        let said = describe_width(&suite, &[(&row, &narrow), (&row, &wide)]);
        assert!(
            said.starts_with("\nStopped at 4 repeats (--max-repeats) with intervals wider than 5 %:\n\n- tin x 1 px")
        );
        assert_eq!(said.lines().count(), 4, "{said}");
        assert_eq!(describe_width(&Suite::default(), &[(&row, &wide)]), "");
    }
}
