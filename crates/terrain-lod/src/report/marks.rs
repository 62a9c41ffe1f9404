//! What charts show: lines and scattered points.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::report::axis::Axis;
use crate::report::chart::{X_ENDS, Y_ENDS};
use crate::report::html::{digits, escape};
use crate::report::look::Look;
use crate::report::runs::Run;

/// A run's line: x, and y where there is one.
pub struct Series {
    pub look: Look,
    pub points: Vec<(f64, Option<f64>)>,
}

impl Series {
    pub fn has_any(&self) -> bool {
        self.points.iter().any(|(_, y)| y.is_some())
    }
}

/// All y of some series.
pub fn values(series: &[Series]) -> impl Iterator<Item = f64> + Clone {
    series.iter().flat_map(|series| series.points.iter().filter_map(|(_, y)| *y))
}

/// The lines. `steps`: a value holds until the next x.
pub fn lines(all: &[Series], [x, y]: [&Axis; 2], steps: bool) -> String {
    let mut from_below: Vec<&Series> = all.iter().collect();
    from_below.sort_by_key(|series| series.look.layer());
    let mut text = String::new();
    for series in from_below {
        let path = path(&series.points, [x, y], steps);
        let _ = writeln!(text, "<g class=\"{}\"><path class=\"line\" d=\"{path}\"/></g>", series.look.classes());
    }
    text
}

/// Broken where a point has no y. A point alone is a line of no length, which round caps show.
fn path(points: &[(f64, Option<f64>)], [x, y]: [&Axis; 2], steps: bool) -> String {
    let mut path = String::new();
    for part in points.split(|(_, value)| value.is_none()) {
        for (i, (at, value)) in part.iter().enumerate() {
            let (x, y) = (x.at(*at), y.at(value.unwrap_or_default()));
            let _ = match (i, steps) {
                (0, _) => write!(path, "M{x:.1} {y:.1}"),
                (_, true) => write!(path, "H{x:.1}V{y:.1}"),
                (_, false) => write!(path, "L{x:.1} {y:.1}"),
            };
        }
        if part.len() == 1 {
            path += "h0";
        }
    }
    path
}

/// A run in a scatter chart.
#[derive(Clone, Debug)]
pub struct Point {
    pub run: usize,
    pub x: f64,
    pub y: f64,
    /// Of y.
    pub interval: Option<[f64; 2]>,
}

/// The points with their intervals, a line through each family, and a label beside each that has room for one.
pub fn scatter(points: &[Point], runs: &[Run], [x, y]: [&Axis; 2]) -> String {
    let places: Vec<[f64; 2]> = points.iter().map(|point| [x.at(point.x), y.at(point.y)]).collect();
    let mut text = chains(points, &places, runs);
    let whiskers: Vec<Option<[f64; 2]>> =
        points.iter().map(|point| point.interval.map(|ends| ends.map(|end| y.at(end)))).collect();
    let names: Vec<&str> = points.iter().map(|point| runs[point.run].label.as_str()).collect();
    let drawn = places.iter().zip(&whiskers).filter_map(|([x, _], ends)| Some((x, (*ends)?)));
    let taken = drawn.map(|(x, [low, high])| [x - 4.0, high, x + 4.0, low]).chain(places.iter().map(marker_box));
    let labels = place_labels(&places, &names, taken.collect());
    for (((point, place), whisker), label) in points.iter().zip(&places).zip(whiskers).zip(labels) {
        let Run { look, label: name, .. } = &runs[point.run];
        let name = escape(name);
        let _ = write!(text, "<g class=\"{}\">", look.classes());
        let _ = write!(text, "<title>{name}: {}, {}</title>", digits(point.x), digits(point.y));
        text += &whisker.map_or_else(String::new, |ends| whisker_path(place[0], ends));
        text += &look.marker(*place);
        text += &label.map_or_else(String::new, |label| label.svg(&name));
        text += "</g>\n";
    }
    text
}

/// A whisker; an end outside the chart has no bar.
fn whisker_path(x: f64, ends: [f64; 2]) -> String {
    let [low, high] = ends.map(|end| end.clamp(Y_ENDS[1], Y_ENDS[0]));
    let mut path = format!("M{x:.1} {low:.1}V{high:.1}");
    for end in ends.into_iter().filter(|end| (Y_ENDS[1]..=Y_ENDS[0]).contains(end)) {
        let _ = write!(path, "M{:.1} {end:.1}h8", x - 4.0);
    }
    format!("<path class=\"whisker\" d=\"{path}\"/>")
}

fn chains(points: &[Point], places: &[[f64; 2]], runs: &[Run]) -> String {
    let mut families: BTreeMap<usize, Vec<[f64; 2]>> = BTreeMap::new();
    for (point, place) in points.iter().zip(places) {
        families.entry(runs[point.run].look.family).or_default().push(*place);
    }
    let mut text = String::new();
    for links in families.values_mut().filter(|links| links.len() > 1) {
        links.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let links: Vec<String> = links.iter().map(|[x, y]| format!("{x:.1} {y:.1}")).collect();
        let _ = writeln!(text, "<path class=\"chain\" d=\"M{}\"/>", links.join("L"));
    }
    text
}

/// About the width of a letter, at the size that `page.css` gives labels on narrow screens.
const LETTER: f64 = 7.4;

/// Left, top, right, bottom.
pub type Box4 = [f64; 4];

/// Where a label goes, and how it is anchored.
#[derive(Clone, Copy)]
pub struct Label {
    at: [f64; 2],
    anchor: &'static str,
}

impl Label {
    /// `name` is SVG.
    pub fn svg(self, name: &str) -> String {
        let Self { at: [x, y], anchor } = self;
        format!("<text class=\"name\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{name}</text>")
    }
}

/// What a marker covers.
pub fn marker_box([x, y]: &[f64; 2]) -> Box4 {
    [x - 5.0, y - 5.0, x + 5.0, y + 5.0]
}

/// What a line covers, in pieces no longer than a letter.
pub fn line_boxes(line: &[[f64; 2]]) -> Vec<Box4> {
    let mut boxes = Vec::new();
    for (from, to) in line.iter().zip(line.iter().skip(1)) {
        let pieces = ((to[0] - from[0]).hypot(to[1] - from[1]) / LETTER).ceil().max(1.0);
        for i in 1..pieces as u32 {
            let [x, y] = [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * f64::from(i) / pieces);
            boxes.push([x - 2.0, y - 2.0, x + 2.0, y + 2.0]);
        }
    }
    boxes
}

/// A label for each place. The first free one of right, left, above and below; none where all are taken, since a label on
/// another is worse than one that the legend has to give.
pub fn place_labels(places: &[[f64; 2]], names: &[&str], mut taken: Vec<Box4>) -> Vec<Option<Label>> {
    let mut labels = Vec::with_capacity(places.len());
    for ([x, y], name) in places.iter().zip(names) {
        let width = name.chars().count() as f64 * LETTER;
        let choices = [
            ([x + 8.0, y + 4.0], "start", x + 8.0),
            ([x - 8.0, y + 4.0], "end", x - 8.0 - width),
            ([*x, y - 9.0], "middle", x - width / 2.0),
            ([*x, y + 17.0], "middle", x - width / 2.0),
        ];
        let found = choices.into_iter().find_map(|(at, anchor, left)| {
            let space = [left, at[1] - 11.0, left + width, at[1] + 3.0];
            is_free(&space, &taken).then_some((at, anchor, space))
        });
        labels.push(found.map(|(at, anchor, space)| {
            taken.push(space);
            Label { at, anchor }
        }));
    }
    labels
}

fn is_free(space: &Box4, taken: &[Box4]) -> bool {
    let meets = |other: &Box4| space[0] < other[2] && other[0] < space[2] && space[1] < other[3] && other[1] < space[3];
    let is_inside = space[0] > X_ENDS[0]
        && space[2] < X_ENDS[1] + 18.0
        && space[1] > Y_ENDS[1] - 12.0
        && space[3] < Y_ENDS[0] + 8.0;
    is_inside && !taken.iter().any(meets)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::axis::Scale;

    fn axes(values: &[f64]) -> [Axis; 2] {
        [X_ENDS, Y_ENDS].map(|ends| Axis::fit(values.iter().copied(), Scale::Linear, ends))
    }

    #[test]
    fn a_line_breaks_where_nothing_was_measured() {
        let [x, y] = axes(&[4.0]);
        let points = [(0.0, Some(1.0)), (1.0, Some(2.0)), (2.0, None), (3.0, Some(1.0)), (4.0, None)];
        let path = path(&points, [&x, &y], false);
        assert_eq!(path.matches('M').count(), 2);
        assert!(path.ends_with("h0"), "{path}");
    }

    #[test]
    fn an_end_outside_the_chart_has_no_bar() {
        assert_eq!(whisker_path(100.0, [200.0, 100.0]).matches("h8").count(), 2);
        let clipped = whisker_path(100.0, [900.0, 100.0]);
        assert!(clipped.matches("h8").count() == 1 && clipped.contains("M100.0 286.0V100.0"), "{clipped}");
    }

    #[test]
    fn a_label_makes_way_for_a_line() {
        let right_of = [[205.0, 200.0], [205.0 + 90.0, 200.0]];
        let place = |taken: Vec<Box4>| place_labels(&[[200.0, 200.0]], &["a label"], taken)[0].unwrap().anchor;
        assert_eq!((place(Vec::new()), place(line_boxes(&right_of))), ("start", "end"));
        assert!(line_boxes(&[[1.0, 1.0]]).is_empty());
    }

    #[test]
    fn labels_never_cover_each_other() {
        let run = |i| Run { label: format!("method {i}"), ..Default::default() };
        let runs: Vec<Run> = (0..60).map(run).collect();
        let point =
            |i: usize| Point { run: i, x: 1.0 + (i % 7) as f64 / 9.0, y: 1.0 + (i % 4) as f64 / 30.0, interval: None };
        let points: Vec<Point> = (0..60).map(point).collect();
        let [x, y] = axes(&[2.0]);
        let places: Vec<[f64; 2]> = points.iter().map(|point| [x.at(point.x), y.at(point.y)]).collect();
        let names: Vec<&str> = runs.iter().map(|run| run.label.as_str()).collect();
        let labels: Vec<Box4> = place_labels(&places, &names, places.iter().map(marker_box).collect())
            .into_iter()
            .zip(&runs)
            .filter_map(|(label, run)| {
                let Label { at, anchor } = label?;
                let width = run.label.len() as f64 * LETTER;
                let left = match anchor {
                    "start" => at[0],
                    "end" => at[0] - width,
                    _ => at[0] - width / 2.0,
                };
                Some([left, at[1] - 11.0, left + width, at[1] + 3.0])
            })
            .collect();
        assert!(labels.len() > 5);
        for (i, label) in labels.iter().enumerate() {
            assert!(labels[..i].iter().all(|other| is_free(label, &[*other])), "{label:?}");
        }
    }
}
