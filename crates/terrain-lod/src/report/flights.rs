//! The curves over the flight that a suite asks for (`flight_curves.rs`), from the frames of the speed pass.

use std::collections::BTreeMap;

use crate::fault::Fault;
use crate::flight_curves::{FlightCurves, FlightMeasure};
use crate::pivot::Series as Only;
use crate::report::axis::{Axis, Scale};
use crate::report::bench_page::BenchPage;
use crate::report::chart::{Chart, Key, X_ENDS, Y_ENDS};
use crate::report::curves::MOST_POINTS;
use crate::report::look::Look;
use crate::report::marks::{self, Series};
use crate::report::runs::{Run, settings};
use crate::report::sheet::Sheet;

/// Charts of one kind, with what is said of them.
pub struct Flights {
    pub curves: FlightCurves,
    /// Of the bench that they are of, among the parts; `None` where none of those asked for was flown.
    pub part: Option<usize>,
    pub charts: Vec<Chart>,
    /// Frames that a point stands for.
    pub width: u32,
}

/// What the updates of one frame did, over all repeats.
#[derive(Clone, Copy, Default)]
struct Work {
    update_ms: f64,
    stages_ms: f64,
    triangulate_ms: f64,
    triangles: f64,
}

/// The charts; their curves are numbered from `first`, so that no legend hides them.
pub fn of(curves: FlightCurves, parts: &[BenchPage], first: usize) -> Result<Flights, Fault> {
    let is_asked =
        |name: &String| parts.iter().position(|part| part.folder.name == *name && part.folder.summary.len() > 0);
    let part = if curves.benches.is_empty() {
        (!parts.is_empty()).then_some(0)
    } else {
        curves.benches.iter().find_map(is_asked)
    };
    let mut flights = Flights { curves, part, charts: Vec::new(), width: 1 };
    let Some(part) = part.map(|i| &parts[i]) else { return Ok(flights) };
    let last = part.folder.machine["frames"].as_u64().map_or(0, |frames| frames.saturating_sub(1) as u32);
    flights.width = last.div_ceil(MOST_POINTS).max(1);
    for series in flights.curves.all_series() {
        flights.charts.extend(chart(&flights, part, &series, first, last)?);
    }
    Ok(flights)
}

/// `None` where the series has no updates.
fn chart(flights: &Flights, part: &BenchPage, only: &Only, first: usize, last: u32) -> Result<Option<Chart>, Fault> {
    let Flights { curves, width, .. } = flights;
    let summary = &part.folder.summary;
    let is_asked = |run: &&Run| {
        let row = run.rows.first().copied();
        row.is_some_and(|row| only.only.iter().all(|(name, values)| values.contains(&value(summary, row, name))))
    };
    let (mut lines, mut keys) = (Vec::new(), Vec::new());
    for run in part.runs.iter().filter(is_asked) {
        let Some(frames) = run.stem.as_ref().and_then(|stem| part.folder.frames.get(stem)?.speed.as_ref()) else {
            continue;
        };
        let points = points(curves.measure, frames, last, *width)?;
        let look = Look { run: first + keys.len(), family: keys.len(), rank: 0 };
        if points.iter().any(|(_, value)| value.is_some()) {
            lines.push(Series { look, points });
            keys.push(Key { look, label: label(curves, summary, run.rows[0]) });
        }
    }
    if lines.is_empty() {
        return Ok(None);
    }
    let (x, y) = axes(curves.measure, &lines, last);
    let of_series = if only.name.is_empty() { String::new() } else { format!(", {}", only.name) };
    Ok(Some(Chart {
        id: [curves.file.clone(), slug(&only.name)].join("-").trim_end_matches('-').into(),
        title: format!("{}{of_series}", curves.title),
        x_label: "frame",
        y_label: y_label(curves.measure).into(),
        marks: marks::lines(&lines, [&x, &y], false),
        x,
        y,
        has_cursor: false,
        keys,
    }))
}

fn axes(measure: FlightMeasure, lines: &[Series], last: u32) -> (Axis, Axis) {
    let whole = if measure == FlightMeasure::TriangulationShare { Some(100.0) } else { None };
    let y = Axis::fit(marks::values(lines).chain(whole), Scale::Linear, Y_ENDS);
    (Axis::counting([0.0, last.into()], X_ENDS), y)
}

fn y_label(measure: FlightMeasure) -> &'static str {
    match measure {
        FlightMeasure::TriangulationShare => "triangulation, % of the update",
        FlightMeasure::TrianglesPerSecond => "triangles a second of update",
    }
}

fn label(curves: &FlightCurves, summary: &Sheet, row: usize) -> String {
    let value = value(summary, row, &curves.curves);
    if curves.curves == "tolerance_px" { format!("{value} px") } else { format!("{} {value}", curves.curves) }
}

/// A column of the summary, or a setting.
fn value(summary: &Sheet, row: usize, name: &str) -> String {
    let text = match summary.columns().iter().any(|column| column == name) {
        true => summary.text(row, name),
        false => {
            settings(summary.text(row, "setting")).find(|(other, _)| *other == name).map_or("", |(_, value)| value)
        }
    };
    text.strip_suffix(".0").unwrap_or(text).to_owned()
}

/// A point for each `width` frames, of what their updates did together. Frames of the warm-up count: they are part of the
/// flight, and what is slow in them is not the method.
fn points(measure: FlightMeasure, frames: &Sheet, last: u32, width: u32) -> Result<Vec<(f64, Option<f64>)>, Fault> {
    let columns = ["frame", "update_ms", "select_ms", "triangulate_ms", "updated_triangles"];
    let [frame, update, select, triangulate, triangles] = columns.map(|column| frames.numbers(column));
    let (update, select, triangulate, triangles) = (update?, select?, triangulate?, triangles?);
    let mut all: BTreeMap<u32, Work> = BTreeMap::new();
    for (row, frame) in frame?.into_iter().enumerate() {
        let (Some(frame), Some(update_ms)) = (frame, update[row]) else { continue };
        let work = all.entry(frame as u32 / width).or_default();
        let triangulate_ms = triangulate[row].unwrap_or_default();
        work.update_ms += update_ms;
        work.triangulate_ms += triangulate_ms;
        work.stages_ms += triangulate_ms + select[row].unwrap_or_default();
        work.triangles += triangles[row].unwrap_or_default();
    }
    let point = |i: u32| ((i * width).into(), all.get(&i).and_then(|work| work.value(measure)));
    Ok((0..=last / width).map(point).collect())
}

impl Work {
    fn value(&self, measure: FlightMeasure) -> Option<f64> {
        let is_idle = self.update_ms <= 0.0;
        match measure {
            _ if is_idle => None,
            // On several threads the stages take longer than the update that they are part of.
            FlightMeasure::TriangulationShare => Some(100.0 * self.triangulate_ms / self.update_ms.max(self.stages_ms)),
            // Of an older version.
            FlightMeasure::TrianglesPerSecond if self.triangles == 0.0 => None,
            FlightMeasure::TrianglesPerSecond => Some(self.triangles / (self.update_ms / 1e3)),
        }
    }
}

/// A name as a file's.
fn slug(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-").to_ascii_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAMES: &[u8] = b"repeat,frame,warm_up,update_ms,select_ms,triangulate_ms,updated_triangles\n\
        0,0,true,4,2,1,300\n0,1,false,0,0,0,0\n0,2,false,2,2,2,70\n1,0,true,6,1,4,300\n1,1,false,0,0,0,0\n";

    fn values(measure: FlightMeasure, width: u32) -> Vec<Option<f64>> {
        let points = points(measure, &Sheet::parse("", FRAMES).unwrap(), 3, width).unwrap();
        points.into_iter().map(|(_, value)| value).collect()
    }

    #[test]
    fn a_frame_is_all_its_repeats_together_and_one_without_an_update_has_no_value() {
        assert_eq!(values(FlightMeasure::TriangulationShare, 1), [Some(50.0), None, Some(50.0), None]);
        assert_eq!(values(FlightMeasure::TrianglesPerSecond, 1), [Some(60_000.0), None, Some(35_000.0), None]);
        assert_eq!(values(FlightMeasure::TrianglesPerSecond, 2), [Some(60_000.0), Some(35_000.0)]);
    }

    #[test]
    fn values_are_columns_or_settings() {
        let summary = Sheet::parse("", b"setting,tolerance_px\npatch=32 selector=bounded,1.0\n").unwrap();
        assert_eq!(["tolerance_px", "selector", "k"].map(|name| value(&summary, 0, name)), ["1", "bounded", ""]);
        assert_eq!(slug("the paper's system"), "the-paper-s-system");
    }
}
