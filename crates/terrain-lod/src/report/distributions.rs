//! How times and jumps are distributed over a flight.

use crate::fault::Fault;
use crate::report::axis::{Axis, Scale};
use crate::report::chart::{Chart, X_ENDS, Y_ENDS};
use crate::report::folder::{Folder, Frames};
use crate::report::marks::{self, Series};
use crate::report::runs::Run;
use crate::report::sheet::Sheet;

/// Steps of a distribution: as many as its chart can show.
const MOST_STEPS: usize = 300;

/// One distribution: id, title, label of the x axis, pass, column.
type Distribution = (&'static str, &'static str, &'static str, fn(&Frames) -> Option<&Sheet>, &'static str);

const DISTRIBUTIONS: [Distribution; 3] = [
    ("distribution-frame-time", "Frames that took at most so long", "frame time, ms", |f| f.speed.as_ref(), "frame_ms"),
    ("distribution-plan-time", "Plans that took at most so long", "plan time, ms", |f| f.speed.as_ref(), "plan_ms"),
    (
        "distribution-live-plan-time",
        "Live plans that took at most so long",
        "plan time, ms",
        |f| f.live.as_ref(),
        "plan_ms",
    ),
];

/// Of frame times and plan times, where there are any.
pub fn charts(folder: &Folder, runs: &[Run]) -> Result<Vec<Chart>, Fault> {
    let mut charts = Vec::new();
    for (id, title, x_label, pass, column) in DISTRIBUTIONS {
        let mut series = Vec::new();
        for (look, stem) in runs.iter().filter_map(|run| Some((run.look, run.stem.as_ref()?))) {
            let Some(sheet) = folder.frames.get(stem).and_then(pass) else { continue };
            series.push(Series { look, points: cumulative(timed(sheet, column)?) });
        }
        if series.iter().any(Series::has_any) {
            charts.push(chart(folder.id(id), title, x_label, &series));
        }
    }
    charts.extend(popping(folder, runs)?);
    Ok(charts)
}

/// All frames of all repeats but those of the warm-up.
fn timed(sheet: &Sheet, column: &str) -> Result<Vec<f64>, Fault> {
    let values = sheet.numbers(column)?;
    let is_timed = |row: usize| sheet.text(row, "warm_up") != "true";
    Ok(values.into_iter().enumerate().filter(|(row, _)| is_timed(*row)).filter_map(|(_, value)| value).collect())
}

/// What share of the values, in percent, is at most as large.
fn cumulative(mut values: Vec<f64>) -> Vec<(f64, Option<f64>)> {
    values.sort_by(f64::total_cmp);
    let count = values.len();
    let Some(first) = values.first() else { return Vec::new() };
    let stride = count.div_ceil(MOST_STEPS);
    let share = |rank: usize| Some(100.0 * rank as f64 / count as f64);
    let ranks = (1..=count).filter(|rank| rank % stride == 0 || *rank == count);
    std::iter::once((*first, Some(0.0))).chain(ranks.map(|rank| (values[rank - 1], share(rank)))).collect()
}

fn chart(id: String, title: &str, x_label: &'static str, series: &[Series]) -> Chart {
    let times = series.iter().flat_map(|series| series.points.iter().map(|(time, _)| *time));
    let x = Axis::fit(times, Scale::Log, X_ENDS);
    let y = Axis::fit([100.0].into_iter(), Scale::Linear, Y_ENDS);
    Chart {
        id,
        title: title.into(),
        x_label,
        y_label: "share of the frames, %".into(),
        marks: marks::lines(series, [&x, &y], true),
        x,
        y,
        has_cursor: false,
        keys: Vec::new(),
    }
}

/// The histogram of `popping.csv`, where the bench has measured it.
fn popping(folder: &Folder, runs: &[Run]) -> Result<Option<Chart>, Fault> {
    let Some(sheet) = &folder.popping else { return Ok(None) };
    let mut series = Vec::new();
    for run in runs {
        let points = bins(sheet, &folder.summary, run)?;
        series.push(Series { look: run.look, points });
    }
    if !series.iter().any(Series::has_any) {
        return Ok(None);
    }
    let x = Axis::fit(series.iter().flat_map(|s| s.points.iter().map(|(px, _)| *px)), Scale::Log, X_ENDS);
    let y = Axis::fit(marks::values(&series), Scale::Log, Y_ENDS);
    Ok(Some(Chart {
        id: folder.id("histogram-popping"),
        title: "Samples that jump so far when the mesh changes".into(),
        x_label: "jump on the screen, px",
        y_label: "samples of the whole flight, logarithmic".into(),
        marks: marks::lines(&series, [&x, &y], true),
        x,
        y,
        has_cursor: false,
        keys: Vec::new(),
    }))
}

/// Where a run's bins begin, with their counts, and where the last ends: it has no end, so it is drawn an octave wide.
fn bins(sheet: &Sheet, summary: &Sheet, run: &Run) -> Result<Vec<(f64, Option<f64>)>, Fault> {
    let Some(row) = run.rows.first() else { return Ok(Vec::new()) };
    let mut points = Vec::new();
    for bin in 0..sheet.len() {
        let is_same = |column: &str| sheet.text(bin, column) == summary.text(*row, column);
        let is_any_tolerance = sheet.text(bin, "tolerance_px").is_empty();
        if is_same("method") && is_same("setting") && (is_any_tolerance || is_same("tolerance_px")) {
            points.extend(sheet.number(bin, "from_px")?.map(|from| (from, sheet.number(bin, "popping_samples"))));
        }
    }
    let mut points = points.into_iter().map(|(from, count)| Ok((from, count?))).collect::<Result<Vec<_>, Fault>>()?;
    points.extend(points.last().copied().map(|(from, count)| (from * 2.0, count)));
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distribution_ends_at_all_of_the_values() {
        assert_eq!(cumulative(vec![3.0, 1.0]), [(1.0, Some(0.0)), (1.0, Some(50.0)), (3.0, Some(100.0))]);
        let many = cumulative((0..1000).map(f64::from).collect());
        assert!(many.len() <= MOST_STEPS + 1 && many.last() == Some(&(999.0, Some(100.0))));
        assert!(cumulative(Vec::new()).is_empty());
    }

    #[test]
    fn bins_belong_to_their_run() {
        let popping = b"method,setting,tolerance_px,from_px,to_px,popping_samples\n\
            tin,a=1,1.0,0,0.5,7\ntin,a=1,2.0,0,0.5,8\ntin,a=1,1.0,0.5,,3\nfull-grid,,,0,,0\n";
        let popping = Sheet::parse("", popping).unwrap();
        let summary = Sheet::parse("", b"method,setting,tolerance_px\ntin,a=1,1.0\nfull-grid,,1.0\n").unwrap();
        let bins = |row| bins(&popping, &summary, &Run { rows: vec![row], ..Default::default() }).unwrap();
        assert_eq!(bins(0), [(0.0, Some(7.0)), (0.5, Some(3.0)), (1.0, Some(3.0))]);
        assert_eq!(bins(1), [(0.0, Some(0.0)), (0.0, Some(0.0))]);
    }
}
