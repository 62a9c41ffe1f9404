//! Per-frame curves of all runs, and the same numbers for the script that shows them at the cursor.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::fault::Fault;
use crate::report::axis::Axis;
use crate::report::chart::{Chart, X_ENDS, Y_ENDS};
use crate::report::folder::{Folder, Frames};
use crate::report::html;
use crate::report::look::Look;
use crate::report::marks::{self, Series};
use crate::report::runs::Run;
use crate::report::sheet::Sheet;

/// More points than this are no more than a chart's pixels can show.
pub const MOST_POINTS: u32 = 600;

/// One number a frame.
struct Measure {
    id: &'static str,
    title: &'static str,
    unit: &'static str,
    pass: fn(&Frames) -> Option<&Sheet>,
    column: &'static str,
}

const fn of_error(id: &'static str, title: &'static str, unit: &'static str, column: &'static str) -> Measure {
    Measure { id, title, unit, pass: |frames| frames.error.as_ref(), column }
}

const fn of_speed(id: &'static str, title: &'static str, unit: &'static str, column: &'static str) -> Measure {
    Measure { id, title, unit, pass: |frames| frames.speed.as_ref(), column }
}

const fn of_live(id: &'static str, title: &'static str, unit: &'static str, column: &'static str) -> Measure {
    Measure { id, title, unit, pass: |frames| frames.live.as_ref(), column }
}

const MEASURES: [Measure; 11] = [
    of_error("frame-triangles", "Triangles", "triangles", "triangles"),
    of_error("frame-error-max", "Largest error", "px", "error_px_max"),
    of_error("frame-error-p99", "P99 error", "px", "error_px_p99"),
    of_speed("frame-time", "Frame time", "ms, median of the repeats", "frame_ms"),
    of_speed("frame-plan-time", "Plan time", "ms, median of the repeats", "plan_ms"),
    of_error("frame-upload", "Upload", "bytes", "upload_bytes"),
    of_error("frame-popping-max", "Largest popping", "px", "popping_px_max"),
    of_error("frame-popping-p99", "P99 popping", "px", "popping_px_p99"),
    of_live("live-error-max", "Largest error, live", "px, median of the repeats", "error_px_max"),
    of_live("live-plan-time", "Plan time, live", "ms, median of the repeats", "plan_ms"),
    of_live("live-stale-patches", "Stale patches, live", "patches, median of the repeats", "stale_patches"),
];

/// The charts, and what the script knows of them.
pub struct Curves {
    pub charts: Vec<Chart>,
    /// JSON: `{"frames": [0, 1], "width": 1, "charts": {"frame-time": {"0": [16.2, null]}}}`.
    pub values: String,
    /// Frames that a point stands for, by the largest of them.
    pub width: u32,
    /// Titles of what no run has.
    pub absent: Vec<&'static str>,
}

/// Values by frame.
type ByFrame = BTreeMap<u32, f64>;

pub fn of(folder: &Folder, runs: &[Run]) -> Result<Curves, Fault> {
    let mut found: Vec<(&Measure, Vec<(usize, ByFrame)>)> = Vec::new();
    for measure in &MEASURES {
        found.push((measure, of_runs(measure, folder, runs)?));
    }
    let is_absent = |of_runs: &[(usize, ByFrame)]| of_runs.iter().all(|(_, values)| values.is_empty());
    let absent = found.iter().filter(|(_, of_runs)| is_absent(of_runs)).map(|(measure, _)| measure.title).collect();
    found.retain(|(_, of_runs)| !is_absent(of_runs));
    let last = found.iter().flat_map(|(_, runs)| runs.iter().filter_map(|(_, values)| values.keys().last())).max();
    let last = last.copied().unwrap_or(0);
    let width = last.div_ceil(MOST_POINTS).max(1);
    let mut curves = Curves { charts: Vec::new(), values: String::new(), width, absent };
    let mut json = Vec::new();
    for (measure, of_runs) in found {
        let series =
            of_runs.into_iter().map(|(run, values)| thinned(runs[run].look, &values, last, width)).collect::<Vec<_>>();
        let id = folder.id(measure.id);
        json.push(format!("\"{id}\":{}", values_json(&series)));
        curves.charts.push(chart(id, measure, &series, last));
    }
    let frames: Vec<String> = (0..=last / width).map(|point| (point * width).to_string()).collect();
    curves.values =
        format!("{{\"frames\":[{}],\"width\":{width},\"charts\":{{{}}}}}", frames.join(","), json.join(",\n"));
    Ok(curves)
}

fn of_runs(measure: &Measure, folder: &Folder, runs: &[Run]) -> Result<Vec<(usize, ByFrame)>, Fault> {
    let sheet = |run: &Run| run.stem.as_ref().and_then(|stem| folder.frames.get(stem)).and_then(measure.pass);
    let sheets = runs.iter().enumerate().filter_map(|(i, run)| Some((i, sheet(run)?)));
    sheets.map(|(i, sheet)| Ok((i, by_frame(sheet, measure.column)?))).collect()
}

/// The median over the repeats, without warm-up frames.
fn by_frame(sheet: &Sheet, column: &str) -> Result<ByFrame, Fault> {
    let (frames, values) = (sheet.numbers("frame")?, sheet.numbers(column)?);
    let mut repeats: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for (row, (frame, value)) in frames.into_iter().zip(values).enumerate() {
        if let (Some(frame), Some(value), false) = (frame, value, sheet.text(row, "warm_up") == "true") {
            repeats.entry(frame as u32).or_default().push(value);
        }
    }
    Ok(repeats.into_iter().map(|(frame, values)| (frame, median(values))).collect())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { (values[middle - 1] + values[middle]) / 2.0 }
}

/// A point for each `width` frames: the largest of them.
fn thinned(look: Look, values: &ByFrame, last: u32, width: u32) -> Series {
    let largest = |first: u32| values.range(first..=first.saturating_add(width - 1)).map(|(_, v)| *v).reduce(f64::max);
    let points = (0..=last / width).map(|point| point * width).map(|first| (first.into(), largest(first))).collect();
    Series { look, points }
}

fn chart(id: String, measure: &Measure, series: &[Series], last: u32) -> Chart {
    let values = marks::values(series);
    let x = Axis::counting([0.0, last.into()], X_ENDS);
    let y = Axis::fit(values.clone(), Axis::scale_for(values), Y_ENDS);
    Chart {
        id,
        title: measure.title.into(),
        x_label: "frame",
        y_label: format!("{}{}", measure.unit, if y.is_log() { ", logarithmic" } else { "" }),
        marks: marks::lines(series, [&x, &y], false),
        x,
        y,
        has_cursor: true,
        keys: Vec::new(),
    }
}

fn values_json(series: &[Series]) -> String {
    let number = |value: &Option<f64>| value.map_or("null".into(), html::plain_digits);
    let mut text = String::from("{");
    for (i, series) in series.iter().filter(|series| series.has_any()).enumerate() {
        let values: Vec<String> = series.points.iter().map(|(_, value)| number(value)).collect();
        let comma = if i > 0 { "," } else { "" };
        let _ = write!(text, "{comma}\"{}\":[{}]", series.look.run, values.join(","));
    }
    text + "}"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_have_a_median_and_warm_up_frames_do_not_count() {
        let csv = b"repeat,frame,warm_up,plan_ms\n0,0,true,9\n0,1,false,1\n1,0,true,9\n1,1,false,3\n2,1,false,70\n";
        let values = by_frame(&Sheet::parse("", csv).unwrap(), "plan_ms").unwrap();
        assert_eq!(values, ByFrame::from([(1, 3.0)]));
        assert_eq!(median(vec![4.0, 1.0]), 2.5);
    }

    #[test]
    fn long_flights_keep_their_peaks() {
        let values: ByFrame = (0..5000).map(|frame| (frame, if frame == 1234 { 7.0 } else { 1.0 })).collect();
        let series = thinned(Look::default(), &values, 4999, 9);
        assert_eq!(series.points.len(), 556);
        assert_eq!(series.points[1234 / 9], (1233.0, Some(7.0)));
    }
}
