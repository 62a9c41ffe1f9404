//! The rows of two benches side by side.

use std::cmp::Ordering;

use super::columns::{TIMES, is_counter};
use super::side::Side;
use super::summary::Row;
use crate::compare::{Comparison, Who};
use crate::interval::Verdict;

/// The numbers of the runs that both benches have, and the runs that one of them lacks.
pub struct Pairs {
    pub comparisons: Vec<Comparison>,
    pub only_in_a: Vec<String>,
    pub only_in_b: Vec<String>,
}

impl Pairs {
    /// In the order of A, bench by bench.
    pub fn of(a: &Side, b: &Side) -> Self {
        let mut comparisons = Vec::new();
        for bench in &a.benches {
            for row in &bench.summary.rows {
                if let Some(other) = partner(row, &bench.name, b) {
                    comparisons.extend(compare_rows(&bench.name, row, other));
                }
            }
        }
        Self { comparisons, only_in_a: without(a, b), only_in_b: without(b, a) }
    }

    pub fn count(&self, verdict: Verdict) -> usize {
        self.comparisons.iter().filter(|comparison| comparison.verdict == verdict).count()
    }
}

fn partner<'a>(row: &Row, bench: &str, of: &'a Side) -> Option<&'a Row> {
    of.bench(bench)?.rows.iter().find(|other| other.key() == row.key())
}

/// The runs of one side that the other lacks.
fn without(side: &Side, other: &Side) -> Vec<String> {
    let rows =
        side.benches.iter().flat_map(|bench| bench.summary.rows.iter().map(move |row| (bench.name.as_str(), row)));
    rows.filter(|(bench, row)| partner(row, bench, other).is_none()).map(|(bench, row)| title(bench, row)).collect()
}

fn title(bench: &str, row: &Row) -> String {
    let (method, setting, tolerance_px) = row.key();
    let bench = if bench.is_empty() { String::new() } else { format!("{bench}: ") };
    format!("{bench}{method} {setting} {tolerance_px} px")
}

fn compare_rows(bench: &str, a: &Row, b: &Row) -> Vec<Comparison> {
    let tolerance_px = a.number("tolerance_px").unwrap_or(0.0);
    let who = Who { bench, method: a.text("method"), setting: a.text("setting"), tolerance_px };
    let failed = [a, b].map(|row| f64::from(u8::from(!row.text("err").is_empty())));
    let mut found = Vec::new();
    if failed[0] != failed[1] {
        found.extend(compare_counter(&who, "err", failed.map(Some)));
    }
    let counters = a.columns.keys().chain(b.columns.keys().filter(|column| !a.columns.contains_key(*column)));
    let counters = counters.filter(|column| is_counter(column));
    let compared = counters.filter_map(|column| compare_counter(&who, column, [a.number(column), b.number(column)]));
    // Of a run that failed in one bench alone `err` says why numbers are lost.
    let is_told = |c: &Comparison| failed[0] == failed[1] || !matches!(c.verdict, Verdict::Lost | Verdict::New);
    found.extend(compared.filter(is_told));
    found.extend(TIMES.iter().filter_map(|time| compare_time(&who, time, a, b)));
    found
}

/// Of all counters less is better. `None` where neither bench has it.
fn compare_counter(who: &Who, column: &str, [a, b]: [Option<f64>; 2]) -> Option<Comparison> {
    let verdict = match (a, b) {
        (None, None) => return None,
        (Some(_), None) => Verdict::Lost,
        (None, Some(_)) => Verdict::New,
        (Some(a), Some(b)) => match a.total_cmp(&b) {
            Ordering::Less => Verdict::Worse,
            Ordering::Equal => Verdict::Same,
            Ordering::Greater => Verdict::Better,
        },
    };
    Some(who.compare(column, a, b, verdict))
}

/// By the repeats where both have them, else by the intervals of the columns.
fn compare_time(who: &Who, time: &str, a: &Row, b: &Row) -> Option<Comparison> {
    if let Some(compared) = who.compare_times(time, &a.times, &b.times) {
        return Some(compared);
    }
    let (a_ms, b_ms) = (a.number(time)?, b.number(time)?);
    let ratio = a.interval(time).zip(b.interval(time)).and_then(|(a, b)| a.ratio_to(&b));
    Some(who.compare_by(time, [a_ms, b_ms], ratio))
}
