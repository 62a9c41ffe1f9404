//! The one table that the user reads: Markdown, on stdout and in `summary.md`.

use std::fmt::Write;

use crate::layout::{self, Heading};
use crate::summary::SummaryRow;

/// Heading, alignment to the right, and content of a column.
pub type Column<T> = (&'static str, bool, fn(&T) -> String);

/// What every run has. What was asked for (`tolerance px`) stands beside what came out (`error max px` and the rest).
const COLUMNS: [Column<SummaryRow>; 17] = [
    ("method", false, |r| r.method.clone()),
    ("setting", false, |r| r.setting.clone()),
    ("tolerance px", true, |r| r.tolerance_px.to_string()),
    ("error max px", true, |r| number(r.error_px_max, 2)),
    ("error P99 px", true, |r| number(r.error_px_p99, 2)),
    ("error RMS px", true, |r| number(r.error_px_rms, 3)),
    ("over tolerance %", true, |r| percent(r.over_tolerance_share)),
    ("cracks", true, |r| count(r.cracks)),
    ("triangles", true, |r| number(r.triangles_mean, 0)),
    ("draws", true, |r| number(r.draws_mean, 0)),
    ("draw calls", true, |r| number(r.draw_calls_mean, 0)),
    ("plan P50 ms", true, |r| number(r.plan_ms_p50, 2)),
    ("plan P99 ms", true, |r| number(r.plan_ms_p99, 2)),
    ("encode ms", true, |r| number(r.encode_ms_p50, 2)),
    ("frame P50 ms", true, |r| number(r.frame_ms_p50, 1)),
    ("frame P99 ms", true, |r| number(r.frame_ms_p99, 1)),
    ("fps", true, |r| number(r.fps_mean, 1)),
];

/// What live runs have besides.
const LIVE_COLUMNS: [Column<SummaryRow>; 17] = [
    ("method", false, |r| r.method.clone()),
    ("setting", false, |r| r.setting.clone()),
    ("tolerance px", true, |r| r.tolerance_px.to_string()),
    ("live error max px", true, |r| number(r.live_error_px_max, 2)),
    ("P99 px", true, |r| number(r.live_error_px_p99, 2)),
    ("RMS px", true, |r| number(r.live_error_px_rms, 3)),
    ("over tolerance %", true, |r| percent(r.live_over_tolerance_share)),
    ("cracks", true, |r| count(r.live_cracks)),
    ("stale frames %", true, |r| percent(r.stale_frames_share)),
    ("stale patches", true, |r| number(r.stale_patches_mean, 1)),
    ("latency P50 ms", true, |r| number(r.latency_ms_p50, 1)),
    ("latency P99 ms", true, |r| number(r.latency_ms_p99, 1)),
    ("plan P50 ms", true, |r| number(r.live_plan_ms_p50, 2)),
    ("plan P99 ms", true, |r| number(r.live_plan_ms_p99, 2)),
    ("plan max ms", true, |r| number(r.live_plan_ms_max, 2)),
    ("plan CPU max ms", true, |r| number(r.live_plan_cpu_ms_max, 2)),
    ("late frames", true, |r| count(r.late_frames)),
];

/// Empty where nothing was measured.
pub fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or_else(String::new, |v| format!("{v:.decimals$}"))
}

fn percent(share: Option<f64>) -> String {
    number(share.map(|s| s * 100.0), 2)
}

fn count(value: Option<u64>) -> String {
    value.map_or_else(String::new, |count| count.to_string())
}

/// The table, with a line on what was flown where, and a line for each run that failed. Live runs have a second table.
pub fn markdown(rows: &[&SummaryRow]) -> String {
    let mut text = String::new();
    if let Some(row) = rows.first() {
        let _ = writeln!(text, "{}\n", caption(row));
    }
    text += &table(&COLUMNS, rows);
    let live: Vec<&SummaryRow> = rows.iter().copied().filter(|row| row.live_fps.is_some()).collect();
    if let Some(row) = live.first() {
        let fps = number(row.live_fps, 1);
        let _ = writeln!(text, "\nLive, in the flight's own time at {fps} frames a second, nothing drawn:\n");
        text += &table(&LIVE_COLUMNS, &live);
    }
    for row in rows.iter().filter(|row| !row.err.is_empty()) {
        let _ = writeln!(text, "\n{} ({}, {} px) failed: {}", row.method, row.setting, row.tolerance_px, row.err);
    }
    text
}

/// Rows as a Markdown table.
pub fn table<T>(columns: &[Column<T>], rows: &[&T]) -> String {
    let headings: Vec<Heading> =
        columns.iter().map(|(text, right, _)| Heading { text: (*text).to_owned(), right: *right }).collect();
    let cells: Vec<Vec<String>> = rows.iter().map(|row| columns.iter().map(|column| column.2(row)).collect()).collect();
    layout::table(&headings, &cells)
}

/// What was flown where.
pub fn caption(row: &SummaryRow) -> String {
    let adapter = match (row.adapter.as_str(), row.adapter_type.as_str()) {
        ("", _) => "without a GPU: no frame times, no pictures".to_string(),
        (name, "software") => format!("on {name}, a **software adapter**: its frame times say little about a GPU"),
        (name, kind) => format!("on {name} ({kind})"),
    };
    format!(
        "DEM {} ({} x {} samples), flight {}, {} frames of {} x {} px, field of view {} degrees, {adapter}.",
        row.dem, row.dem_columns, row.dem_rows, row.flight, row.frames, row.width, row.height, row.fov_y_deg
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_has_the_same_width_and_failures_are_named() {
        let good = SummaryRow { method: "tin".into(), error_px_max: Some(12.3456), ..Default::default() };
        let bad = SummaryRow { method: "htp".into(), err: "no luck".into(), ..Default::default() };
        let text = markdown(&[&good, &bad]);
        let table: Vec<&str> = text.lines().filter(|l| l.starts_with('|')).collect();
        assert_eq!(table.len(), 4);
        assert!(table.iter().all(|l| l.len() == table[0].len()), "{text}");
        assert!(table[2].contains(" 12.35 ") && text.contains("htp (, 0 px) failed: no luck"), "{text}");
    }
}
