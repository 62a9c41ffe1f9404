//! Equal-error curves: what a method costs against the error that was measured of it, a curve a family.
//!
//! A mark is a run of the sweep. The line joins those that no other of the family beats in error and in the first cost, as
//! `equal_error.rs` has it; faint marks are beaten. A ring is a number of `equal-error.csv`, so it lies on the line.

use std::fmt::Write;

use crate::equal_error::{Point, front, without_swept};
use crate::fault::Fault;
use crate::report::axis::{Axis, Scale};
use crate::report::chart::{Chart, X_ENDS, Y_ENDS};
use crate::report::headline::ERRORS;
use crate::report::html::escape;
use crate::report::look::Look;
use crate::report::marks::{line_boxes, marker_box, place_labels};
use crate::report::runs::{Known, Run, labels, settings};
use crate::report::sheet::Sheet;

/// A cost: column of the summary, beginning of the id, what a title calls it, what its axis says.
type Cost = (&'static str, &'static str, &'static str, &'static str);

const COSTS: [Cost; 4] = [
    ("triangles_mean", "equal-error-triangles", "Triangles", "mean triangles a frame, logarithmic"),
    ("draws_mean", "equal-error-draws", "Draw calls", "mean draws a frame, each a call; logarithmic"),
    ("plan_ms_p50", "equal-error-plan-time", "Plan time", "median plan time, ms, logarithmic"),
    ("frame_ms_p50", "equal-error-frame-time", "Frame time", "median frame time, ms, logarithmic"),
];

/// The families of a sweep.
pub struct Families {
    /// For the legend.
    pub runs: Vec<Run>,
    pub charts: Vec<Chart>,
}

/// Bench, method, and the words of the setting that are not swept.
type Name = [String; 3];

/// A family in one chart.
struct Curve<'a> {
    run: &'a Run,
    /// Error and cost of all its runs.
    marks: Vec<[f64; 2]>,
    line: Vec<[f64; 2]>,
    rings: Vec<[f64; 2]>,
}

/// Of all rows; `equal_error` is `equal-error.csv`. The families are numbered from `first`.
pub fn of(summary: &Sheet, equal_error: &Sheet, first: usize) -> Result<Families, Fault> {
    let mut names: Vec<Name> = Vec::new();
    let mut runs: Vec<Run> = Vec::new();
    for row in (0..summary.len()).filter(|row| summary.text(*row, "err").is_empty()) {
        let name = name(summary, row);
        match names.iter().position(|other| *other == name) {
            Some(family) => runs[family].rows.push(row),
            None => {
                let look = Look { run: first + runs.len(), family: runs.len(), rank: 0 };
                runs.push(Run { look, rows: vec![row], ..Default::default() });
                names.push(name);
            }
        }
    }
    let methods: Vec<&str> = names.iter().map(|name| name[1].as_str()).collect();
    let found = labels(&methods, &names.iter().map(known).collect::<Vec<_>>());
    runs.iter_mut().zip(found).for_each(|(run, label)| run.label = label);
    let mut charts = Vec::new();
    for cost in COSTS {
        for (error, title, x_label) in ERRORS {
            let curves =
                runs.iter().zip(&names).map(|(run, name)| curve(summary, equal_error, run, name, cost.0, error));
            let curves: Vec<Curve> = curves.collect::<Result<_, Fault>>()?;
            charts.extend(chart(cost, [error, title], x_label, &curves));
        }
    }
    Ok(Families { runs, charts })
}

fn name(summary: &Sheet, row: usize) -> Name {
    let setting = without_swept(summary.text(row, "setting"));
    [summary.text(row, "bench").into(), summary.text(row, "method").into(), setting]
}

/// What tells families of one method apart; their bench, if nothing else does.
fn known([bench, _, setting]: &Name) -> Known {
    let settings = settings(setting).map(|(name, value)| (name.to_owned(), value.to_owned()));
    settings.chain([("bench".to_owned(), bench.clone())]).collect()
}

fn curve<'a>(
    summary: &Sheet,
    equal_error: &Sheet,
    run: &'a Run,
    name: &Name,
    cost: &str,
    error: &str,
) -> Result<Curve<'a>, Fault> {
    // The cost that decides is the first of the file.
    let deciding = if equal_error.len() > 0 { equal_error.text(0, "cost") } else { COSTS[0].0 };
    let mut points: Vec<Point> = Vec::new();
    for row in &run.rows {
        let costs = vec![summary.number(*row, deciding)?, summary.number(*row, cost)?];
        let point = summary.number(*row, error)?.map(|error_px| Point { error_px, costs });
        // A method without a tolerance has the same row for each yardstick.
        points.extend(point.filter(|point| !points.contains(point)));
    }
    let place = |point: &Point| Some([point.error_px, point.costs[1]?]);
    let line: Vec<[f64; 2]> = front(&points).into_iter().filter_map(place).collect();
    let mut rings = Vec::new();
    for row in 0..equal_error.len() {
        let text = |column: &str| equal_error.text(row, column);
        if [text("bench"), text("method"), text("family")] == *name
            && [text("measure"), text("cost"), text("state")] == [error, cost, "is"]
        {
            let (error_px, value) = (equal_error.number(row, "error_px")?, equal_error.number(row, "value")?);
            rings.extend(error_px.zip(value).map(|(error_px, value)| [error_px, value]));
        }
    }
    Ok(Curve { run, marks: points.iter().filter_map(place).collect(), line, rings })
}

/// `None` where no family has the cost.
fn chart(cost: Cost, [error, title]: [&str; 2], x_label: &'static str, curves: &[Curve]) -> Option<Chart> {
    let (_, id, name, y_label) = cost;
    let values = |axis: usize| curves.iter().flat_map(move |curve| curve.marks.iter().map(move |place| place[axis]));
    values(0).next()?;
    let x = Axis::fit(values(0), Scale::Log, X_ENDS);
    let y = Axis::fit(values(1), Scale::Log, Y_ENDS);
    let measure = if error == "error_px_p99" { "p99-error" } else { "largest-error" };
    Some(Chart {
        id: format!("{id}-by-{measure}"),
        title: format!("{name} and {title}"),
        x_label,
        y_label: y_label.into(),
        marks: marks(curves, [&x, &y]),
        x,
        y,
        has_cursor: false,
        keys: Vec::new(),
    })
}

/// The curves, with a label at the end of each that has room for one.
fn marks(curves: &[Curve], [x, y]: [&Axis; 2]) -> String {
    let place = |[error, cost]: &[f64; 2]| [x.at(*error), y.at(*cost)];
    let places: Vec<Vec<[f64; 2]>> = curves.iter().map(|curve| curve.marks.iter().map(place).collect()).collect();
    let ends = curves.iter().map(|curve| curve.line.last().or(curve.marks.last()).map(place));
    let (named, ends): (Vec<&Curve>, Vec<[f64; 2]>) =
        curves.iter().zip(ends).filter_map(|(c, end)| Some((c, end?))).unzip();
    let names: Vec<&str> = named.iter().map(|curve| curve.run.label.as_str()).collect();
    // Between 0 and another number there is no straight line in logarithms.
    let is_positive = |place: &&[f64; 2]| place[0] > 0.0 && place[1] > 0.0;
    let line = |curve: &Curve| -> Vec<[f64; 2]> { curve.line.iter().filter(is_positive).map(place).collect() };
    let lines: Vec<Vec<[f64; 2]>> = curves.iter().map(line).collect();
    let taken = places.iter().flatten().map(marker_box).chain(lines.iter().flat_map(|line| line_boxes(line)));
    let labels = place_labels(&ends, &names, taken.collect());
    let mut text = String::new();
    for ((curve, places), line) in curves.iter().zip(&places).zip(&lines) {
        let Run { look, label, .. } = curve.run;
        let name = escape(label);
        let _ = write!(text, "<g class=\"{}\"><title>{name}</title>", look.classes());
        let line: Vec<String> = line.iter().map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
        if line.len() > 1 {
            let _ = write!(text, "<path class=\"line\" d=\"M{}\"/>", line.join("L"));
        }
        for (mark, place) in curve.marks.iter().zip(places) {
            let beaten = if curve.line.contains(mark) { "" } else { " class=\"beaten\"" };
            let _ = write!(text, "<g{beaten}>{}</g>", look.marker(*place));
        }
        for [x, y] in curve.rings.iter().map(place) {
            let _ = write!(text, "<circle class=\"ring\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5.5\"/>");
        }
        let label = named.iter().position(|other| std::ptr::eq(*other, curve)).and_then(|i| labels[i]);
        text += &label.map_or_else(String::new, |label| label.svg(&name));
        text += "</g>\n";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equal_error::{EqualError, EqualErrorRow};
    use crate::record::{Record, record};
    use crate::summary::SummaryRow;

    /// Two families in one bench; the second has a setting that is beaten, and one whose error is 0.
    fn rows() -> Vec<SummaryRow> {
        let row = |method: &str, setting: &str, px: f64, triangles: f64| SummaryRow {
            method: method.into(),
            setting: setting.into(),
            error_px_max: Some(px),
            triangles_mean: Some(triangles),
            draws_mean: Some(triangles / 100.0 + px),
            ..Default::default()
        };
        vec![
            row("htp", "k=3 leg-px=4", 0.6, 4000.0),
            row("htp", "k=3 leg-px=8", 2.5, 1100.0),
            row("htp", "k=3 leg-px=16", 9.0, 300.0),
            row("decimated", "step=1", 0.0, 9000.0),
            row("decimated", "step=2", 0.8, 2300.0),
            row("decimated", "step=3", 3.0, 2400.0),
            row("decimated", "step=4", 5.0, 600.0),
        ]
    }

    fn sheet<T: serde::Serialize>(rows: &[T]) -> Sheet {
        let mut writer = csv::Writer::from_writer(Vec::new());
        rows.iter().for_each(|row| writer.serialize(row).unwrap());
        Sheet::parse("", &writer.into_inner().unwrap()).unwrap()
    }

    fn families() -> Families {
        let rows = rows();
        let records: Vec<Record> = rows.iter().map(|row| record("", row)).collect();
        let [measures, costs] = [&["error_px_max"][..], &["triangles_mean", "draws_mean"]]
            .map(|names| names.iter().map(|name| name.to_string()).collect());
        let table = EqualError { errors_px: vec![1.0, 2.0, 4.0], measures, costs, ..Default::default() };
        let found: Vec<EqualErrorRow> = table.rows(&records);
        of(&sheet(&rows), &sheet(&found), 10).unwrap()
    }

    /// Two writers, one meaning: the bench interpolates the numbers, the report draws the lines.
    #[test]
    fn the_numbers_of_the_bench_lie_on_the_curves() {
        let Families { charts, .. } = families();
        let mut rings = 0;
        for chart in &charts {
            for group in chart.marks.split("</g>\n") {
                let numbers = |text: &str| -> Vec<f64> { text.split([' ', 'L']).map(|n| n.parse().unwrap()).collect() };
                let Some(path) = group.split("class=\"line\" d=\"M").nth(1) else { continue };
                let line = numbers(path.split('"').next().unwrap());
                for ring in group.split("class=\"ring\" cx=\"").skip(1) {
                    let x: f64 = ring.split('"').next().unwrap().parse().unwrap();
                    let y: f64 = ring.split("cy=\"").nth(1).unwrap().split('"').next().unwrap().parse().unwrap();
                    let (a, b) =
                        line.chunks(2).zip(line.chunks(2).skip(1)).find(|(a, b)| a[0] <= x && x <= b[0]).unwrap();
                    let on_line = a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
                    assert!((on_line - y).abs() < 0.3, "{x} {y}: the line is at {on_line}");
                    rings += 1;
                }
            }
        }
        assert_eq!(rings, 2 * (3 + 3), "two charts, three errors that both families reach");
    }

    #[test]
    fn a_chart_for_each_cost_and_error_that_was_measured() {
        let Families { runs, charts } = families();
        let ids: Vec<&str> = charts.iter().map(|chart| chart.id.as_str()).collect();
        assert_eq!(ids, ["equal-error-triangles-by-largest-error", "equal-error-draws-by-largest-error"]);
        let labels: Vec<(&str, usize)> = runs.iter().map(|run| (run.label.as_str(), run.look.run)).collect();
        assert_eq!(labels, [("htp", 10), ("decimated", 11)]);
        assert_eq!(charts[0].marks.matches("class=\"beaten\"").count(), 1, "step 3 is worse and dearer than step 2");
        assert_eq!(charts[0].marks.matches("class=\"marker\"").count(), 7);
    }
}
