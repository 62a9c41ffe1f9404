//! What methods cost at one measured error: settings differ in what they promise, the error on the screen does not.
//!
//! ```toml
//! [[equal_error]]
//! title = "At equal error"
//! errors_px = [0.5, 1, 2, 4]
//! measures = ["error_px_max", "error_px_p99"]
//! costs = ["triangles_mean", "plan_ms_p50"]   # the first decides which setting is the cheapest
//! ```
//!
//! A family is a method with all settings but the one that is swept: the tolerance, `leg-px` or `step`. Of its runs those
//! stay that no other beats in error and in the first cost at once, so a setting that is dearer and worse than another
//! counts nowhere. The asked error lies between two of what stays; the costs are interpolated between these two, straight
//! in the logarithms of both. There is no extrapolation: below the smallest error a family has not reached it, and above the
//! largest its coarsest setting is a bound, since coarser ones were not flown.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use crate::layout::{self, Heading};
use crate::record::{Record, digits, distinct, named, number, validate_columns};

/// Words of `setting` that make no family: what is swept.
const SWEPT: [&str; 2] = ["leg-px=", "step="];

/// Tables of one kind.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EqualError {
    pub title: String,
    /// What a reader must know; lines under the title.
    pub note: String,
    pub errors_px: Vec<f64>,
    /// Columns of the summary that are errors in pixels.
    pub measures: Vec<String>,
    /// Columns of the summary; the first decides which setting is the cheapest.
    pub costs: Vec<String>,
}

/// One run of a family: its measured error, and its costs.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    pub error_px: f64,
    pub costs: Vec<Option<f64>>,
}

/// A cost at an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cost {
    /// Between two settings.
    Is(f64),
    /// Even the coarsest setting has a smaller error.
    AtMost(f64),
    /// Even the finest setting has a larger error.
    NotReached,
    NotMeasured,
}

/// One row of `equal-error.csv`.
#[derive(Serialize)]
pub struct EqualErrorRow {
    bench: String,
    method: String,
    family: String,
    measure: String,
    error_px: f64,
    cost: String,
    /// `is`, `at most`, `not reached` or `not measured`.
    state: &'static str,
    value: Option<f64>,
}

impl EqualError {
    /// Refuses what would be no table.
    pub fn validate(&self) -> Result<(), String> {
        let refuse = |reason: String| format!("equal_error {:?}: {reason}", self.title);
        validate_columns(self.measures.iter().chain(&self.costs)).map_err(refuse)?;
        if self.measures.is_empty() || self.costs.is_empty() || self.errors_px.is_empty() {
            return Err(refuse("expected errors_px, measures and costs".into()));
        }
        match self.errors_px.iter().find(|px| !(**px > 0.0 && px.is_finite())) {
            Some(px) => Err(refuse(format!("errors_px {px}; expected numbers above 0"))),
            None => Ok(()),
        }
    }

    /// Every family at every error, by every measure.
    pub fn rows(&self, records: &[Record]) -> Vec<EqualErrorRow> {
        let mut rows = Vec::new();
        for measure in &self.measures {
            for family in distinct(records.iter().map(family)) {
                let points = self.points(records, &family, measure);
                for error_px in &self.errors_px {
                    let costs = at(&points, *error_px, self.costs.len());
                    let row = |(name, cost): (&String, Cost)| row_of(&family, measure, *error_px, name, cost);
                    rows.extend(self.costs.iter().zip(costs).map(row));
                }
            }
        }
        rows
    }

    fn points(&self, records: &[Record], of: &[String; 3], measure: &str) -> Vec<Point> {
        let point = |record: &Record| {
            let costs = self.costs.iter().map(|name| number(record, name)).collect();
            Some(Point { error_px: number(record, measure)?, costs })
        };
        let sound = records.iter().filter(|record| named(record, "err").is_empty());
        sound.filter(|record| family(record) == *of).filter_map(point).collect()
    }

    /// A table for each measure and cost: families down, errors across.
    pub fn markdown(&self, rows: &[EqualErrorRow]) -> String {
        let mut text = format!("### {}\n", self.title);
        if !self.note.is_empty() {
            let _ = write!(text, "\n{}\n", self.note.trim());
        }
        for measure in &self.measures {
            for cost in &self.costs {
                let rows: Vec<_> = rows.iter().filter(|row| row.measure == *measure && row.cost == *cost).collect();
                // Without a GPU there are no frame times.
                if rows.iter().all(|row| row.value.is_none()) {
                    continue;
                }
                let name = |name: &str| name.replace('_', " ");
                let _ = write!(text, "\n{} by {}\n\n{}", name(cost), name(measure), self.table(&rows));
            }
        }
        text
    }

    fn table(&self, all: &[&EqualErrorRow]) -> String {
        let left = ["bench", "method", "family"].map(|text| Heading { text: text.into(), right: false });
        let right = self.errors_px.iter().map(|px| Heading { text: format!("{px} px"), right: true });
        let headings: Vec<Heading> = left.into_iter().chain(right).collect();
        let line = |of_family: &[&EqualErrorRow]| {
            let (rows, first) = (of_family, of_family[0]);
            let names = [first.bench.clone(), first.method.clone(), first.distinctive(all)];
            names.into_iter().chain(rows.iter().map(|row| row.text())).collect()
        };
        layout::table(&headings, &all.chunks(self.errors_px.len()).map(line).collect::<Vec<_>>())
    }
}

impl EqualErrorRow {
    /// The words of the family that not all families of its method have: the file has all of them.
    fn distinctive(&self, all: &[&EqualErrorRow]) -> String {
        let is_common = |word: &&str| {
            let mut alike = all.iter().filter(|row| row.method == self.method);
            alike.all(|row| row.family.split(' ').any(|other| other == *word))
        };
        self.family.split(' ').filter(|word| !is_common(word)).collect::<Vec<_>>().join(" ")
    }

    fn text(&self) -> String {
        match self.value {
            None => self.state.to_owned(),
            Some(value) if self.state == "at most" => format!("<= {}", digits(value)),
            Some(value) => digits(value),
        }
    }
}

/// Bench, method, and the settings that are not swept.
fn family(record: &Record) -> [String; 3] {
    [named(record, "bench"), named(record, "method"), without_swept(&named(record, "setting"))]
}

/// The words of a setting that make a family.
pub fn without_swept(setting: &str) -> String {
    let words = setting.split(' ').filter(|word| !SWEPT.iter().any(|swept| word.starts_with(swept)));
    words.collect::<Vec<_>>().join(" ")
}

fn row_of([bench, method, family]: &[String; 3], measure: &str, error_px: f64, cost: &str, at: Cost) -> EqualErrorRow {
    let (state, value) = match at {
        Cost::Is(value) => ("is", Some(value)),
        Cost::AtMost(value) => ("at most", Some(value)),
        Cost::NotReached => ("not reached", None),
        Cost::NotMeasured => ("not measured", None),
    };
    let [bench, method, family, measure, cost] = [bench, method, family, measure, cost].map(String::from);
    EqualErrorRow { bench, method, family, measure, error_px, cost, state, value }
}

/// The costs of a family at an error; `costs` says how many there are.
pub fn at(points: &[Point], error_px: f64, costs: usize) -> Vec<Cost> {
    let front = front(points);
    let above = front.partition_point(|point| point.error_px <= error_px);
    let of =
        |cost: fn(f64) -> Cost, point: &Point| point.costs.iter().map(|c| c.map_or(Cost::NotMeasured, cost)).collect();
    match (above.checked_sub(1).map(|below| front[below]), front.get(above)) {
        (None, _) => vec![Cost::NotReached; costs],
        (Some(below), _) if below.error_px == error_px => of(Cost::Is, below),
        // Between an error of 0 and another there is no straight line in logarithms.
        (Some(below), Some(above)) if below.error_px > 0.0 => between(below, above, error_px),
        (Some(below), _) => of(Cost::AtMost, below),
    }
}

/// The points that no other beats in error and first cost at once, by rising error and falling cost.
pub fn front(points: &[Point]) -> Vec<&Point> {
    let mut sorted: Vec<(&Point, f64)> = points.iter().filter_map(|p| Some((p, *p.costs.first()?.as_ref()?))).collect();
    sorted.sort_by(|a, b| a.0.error_px.total_cmp(&b.0.error_px).then(a.1.total_cmp(&b.1)));
    let mut cheapest = f64::INFINITY;
    sorted.retain(|(_, cost)| {
        let is_cheaper = *cost < cheapest;
        cheapest = cheapest.min(*cost);
        is_cheaper
    });
    sorted.into_iter().map(|(point, _)| point).collect()
}

fn between(below: &Point, above: &Point, error_px: f64) -> Vec<Cost> {
    let share = (error_px / below.error_px).ln() / (above.error_px / below.error_px).ln();
    let cost = |(below, above): (&Option<f64>, &Option<f64>)| match (below, above) {
        (Some(below), Some(above)) if *below > 0.0 && *above > 0.0 => Cost::Is(below * (above / below).powf(share)),
        // A cost of 0 has no logarithm.
        (Some(below), Some(above)) => Cost::Is(below + share * (above - below)),
        _ => Cost::NotMeasured,
    };
    below.costs.iter().zip(&above.costs).map(cost).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::record;
    use crate::summary::SummaryRow;

    fn points(all: &[(f64, f64)]) -> Vec<Point> {
        all.iter().map(|(error_px, cost)| Point { error_px: *error_px, costs: vec![Some(*cost)] }).collect()
    }

    fn cost(all: &[(f64, f64)], error_px: f64) -> Cost {
        at(&points(all), error_px, 1)[0]
    }

    #[test]
    fn between_two_settings_the_line_is_straight_in_logarithms() {
        let sweep = [(0.5, 4000.0), (2.0, 1000.0), (8.0, 250.0)];
        let Cost::Is(value) = cost(&sweep, 1.0) else { panic!("not reached") };
        assert!((value - 2000.0).abs() < 1e-9, "{value}");
        assert_eq!(cost(&sweep, 2.0), Cost::Is(1000.0), "a setting is itself");
    }

    #[test]
    fn nothing_is_extrapolated() {
        let sweep = [(0.5, 4000.0), (2.0, 1000.0)];
        assert_eq!((cost(&sweep, 0.49), cost(&sweep, 4.0)), (Cost::NotReached, Cost::AtMost(1000.0)));
        assert_eq!((cost(&[], 1.0), cost(&[(0.0, 9.0)], 1.0)), (Cost::NotReached, Cost::AtMost(9.0)));
        assert_eq!(cost(&[(0.0, 9.0), (2.0, 3.0)], 1.0), Cost::AtMost(9.0), "0 has no logarithm");
    }

    #[test]
    fn of_a_family_that_is_not_monotone_the_cheapest_within_the_error_counts() {
        // The setting of 900 triangles has the error 3, and one of 500 has 2: nobody would take the first.
        let sweep = [(1.0, 1000.0), (3.0, 900.0), (2.0, 500.0), (4.0, 600.0), (8.0, 125.0)];
        assert_eq!((cost(&sweep, 2.0), cost(&sweep, 1.0)), (Cost::Is(500.0), Cost::Is(1000.0)));
        let Cost::Is(value) = cost(&sweep, 4.0) else { panic!("not reached") };
        assert!((value - 250.0).abs() < 1e-9, "between 2 and 8 px: {value}");
        let mut turned = sweep;
        turned.reverse();
        assert_eq!(cost(&turned, 4.0), cost(&sweep, 4.0), "whatever the order of the sweep");
    }

    #[test]
    fn further_costs_are_those_of_the_same_settings() {
        let point = |error_px, triangles, ms| Point { error_px, costs: vec![Some(triangles), ms] };
        let sweep = [point(1.0, 100.0, Some(0.0)), point(4.0, 50.0, Some(2.0)), point(16.0, 25.0, None)];
        assert_eq!(at(&sweep, 2.0, 2)[1], Cost::Is(1.0), "0 has no logarithm, so the line is straight");
        assert_eq!(at(&sweep, 8.0, 2)[1], Cost::NotMeasured);
    }

    #[test]
    fn what_is_swept_makes_no_family_and_failed_runs_do_not_count() {
        let row = |setting: &str, error_px_max, triangles, err: &str| SummaryRow {
            method: "htp".into(),
            setting: setting.into(),
            error_px_max: Some(error_px_max),
            triangles_mean: Some(triangles),
            err: err.into(),
            ..Default::default()
        };
        let rows = [
            row("metric=distance leg-px=4 k=3", 0.5, 4000.0, ""),
            row("metric=distance leg-px=8 k=3", 2.0, 1000.0, ""),
            row("metric=distance leg-px=2 k=3", 0.1, 10.0, "failed"),
            row("metric=error k=3", 2.0, 700.0, ""),
        ];
        let records: Vec<Record> = rows.iter().map(|row| record("", row)).collect();
        let [measures, costs] = ["error_px_max", "triangles_mean"].map(|name| vec![name.to_owned()]);
        let table = EqualError { errors_px: vec![1.0, 4.0], measures, costs, ..Default::default() };
        table.validate().unwrap();
        let text = table.markdown(&table.rows(&records));
        assert!(text.contains("| htp    | metric=distance |        2000 | <= 1000 |"), "{text}");
        assert!(text.contains("| htp    | metric=error    | not reached |  <= 700 |"), "{text}");
    }
}
