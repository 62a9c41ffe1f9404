//! The headline charts: what a run costs against the error that was measured of it, a mark a run.

use crate::fault::Fault;
use crate::report::axis::{Axis, Scale};
use crate::report::chart::{Chart, X_ENDS, Y_ENDS};
use crate::report::folder::Folder;
use crate::report::marks::{self, Point};
use crate::report::runs::Run;
use crate::report::sheet::Sheet;

/// What the y axis shows.
struct Cost {
    ids: [&'static str; 2],
    /// Of the summary; its interval is in the columns `<column>_low` and `<column>_high`.
    column: &'static str,
    name: &'static str,
    unit: &'static str,
}

const FRAME_TIME: Cost = Cost {
    ids: ["frame-time-by-p99-error", "frame-time-by-largest-error"],
    column: "frame_ms_p50",
    name: "Frame time",
    unit: "median frame time, ms",
};
const PLAN_TIME: Cost = Cost {
    ids: ["plan-time-by-p99-error", "plan-time-by-largest-error"],
    column: "plan_ms_p50",
    name: "Plan time",
    unit: "median plan time, ms",
};
const TRIANGLES: Cost = Cost {
    ids: ["triangles-by-p99-error", "triangles-by-largest-error"],
    column: "triangles_mean",
    name: "Triangles",
    unit: "mean triangles a frame",
};

/// Column of the error, what a title calls it, what its axis says.
pub const ERRORS: [(&str, &str, &str); 2] = [
    ("error_px_p99", "P99 error", "P99 of the measured error, px"),
    ("error_px_max", "largest error", "largest measured error, px"),
];

/// By how much the end of an interval may widen an axis.
const WIDEST: f64 = 3.0;

/// Whether any run has frame times.
pub fn has_frame_times(folder: &Folder) -> Result<bool, Fault> {
    Ok(folder.summary.numbers(FRAME_TIME.column)?.iter().any(Option::is_some))
}

/// Time and triangles, each against both errors. What was not measured at all has no chart.
pub fn charts(folder: &Folder, runs: &[Run]) -> Result<Vec<Chart>, Fault> {
    let time = if has_frame_times(folder)? { FRAME_TIME } else { PLAN_TIME };
    let mut charts = Vec::new();
    for cost in [time, TRIANGLES] {
        for (id, error) in cost.ids.into_iter().zip(ERRORS) {
            charts.extend(chart(&cost, folder.id(id), error, &folder.summary, runs)?);
        }
    }
    Ok(charts)
}

fn chart(
    cost: &Cost,
    id: String,
    (column, error, x_label): (&str, &str, &'static str),
    summary: &Sheet,
    runs: &[Run],
) -> Result<Option<Chart>, Fault> {
    let points = points(cost, column, summary, runs)?;
    if points.is_empty() {
        return Ok(None);
    }
    let costs = points.iter().map(|point| point.y).filter(|cost| *cost > 0.0);
    let (low, high) = (costs.clone().fold(f64::INFINITY, f64::min), costs.fold(0.0, f64::max));
    // The interval of few repeats can be so wide that nothing else could be seen: the axis does not follow all of it.
    let is_near = |end: &f64| (low / WIDEST..=high * WIDEST).contains(end);
    let ends = points.iter().flat_map(|point| point.interval.into_iter().flatten()).filter(is_near);
    let x = Axis::fit(points.iter().map(|point| point.x), Scale::Log, X_ENDS);
    let y = Axis::fit(points.iter().map(|point| point.y).chain(ends), Scale::Log, Y_ENDS);
    Ok(Some(Chart {
        id,
        title: format!("{} and {error}", cost.name),
        x_label,
        y_label: cost.unit.into(),
        marks: marks::scatter(&points, runs, [&x, &y]),
        x,
        y,
        has_cursor: false,
        keys: Vec::new(),
    }))
}

fn points(cost: &Cost, error: &str, summary: &Sheet, runs: &[Run]) -> Result<Vec<Point>, Fault> {
    let mut points = Vec::new();
    for (i, run) in runs.iter().enumerate() {
        let (x, y) = (run.number(summary, error)?, run.number(summary, cost.column)?);
        let low = run.number(summary, &format!("{}_low", cost.column))?;
        let high = run.number(summary, &format!("{}_high", cost.column))?;
        if let (Some(x), Some(y)) = (x, y) {
            let interval = low.zip(high).map(|(low, high)| [low, high]);
            points.push(Point { run: i, x, y, interval });
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_measured_has_no_mark() {
        let csv = b"method,error_px_p99,frame_ms_p50,frame_ms_p50_low,frame_ms_p50_high\ntin,0.5,10,9,12\nrqt,0.4,,,\nhtp,3,20,,\n";
        let summary = Sheet::parse("", csv).unwrap();
        let run = |row| Run { rows: vec![row], ..Default::default() };
        let runs: Vec<Run> = (0..3).map(run).collect();
        let points = points(&FRAME_TIME, "error_px_p99", &summary, &runs).unwrap();
        let found: Vec<_> = points.iter().map(|point| (point.run, point.interval)).collect();
        assert_eq!(found, [(0, Some([9.0, 12.0])), (2, None)]);
    }
}
