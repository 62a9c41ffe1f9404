//! The comparison as a text.

use serde::Serialize;

use super::pair::Pairs;
use super::side::Side;
use crate::cmp_args::CmpFormat;
use crate::compare::Comparison;
use crate::interval::Verdict;
use crate::table::{Column, number, table};

const COLUMNS: [Column<Comparison>; 9] = [
    ("method", false, |c| c.method.clone()),
    ("setting", false, |c| c.setting.clone()),
    ("tolerance px", true, |c| c.tolerance_px.to_string()),
    ("measure", false, |c| c.measure.clone()),
    ("A", true, |c| whole(c.a)),
    ("B", true, |c| whole(c.b)),
    ("B / A", true, |c| number(c.ratio, 3)),
    ("95 % interval", true, interval),
    ("verdict", false, |c| c.verdict.as_str().into()),
];

pub fn text(pairs: &Pairs, a: &Side, b: &Side, format: CmpFormat) -> String {
    match format {
        CmpFormat::Markdown => markdown(pairs, a, b),
        CmpFormat::Csv => csv(&pairs.comparisons),
        CmpFormat::Json => json(pairs, a, b),
    }
}

/// Times, which have an interval to be read, and what has changed. Counters that are equal are counted.
fn markdown(pairs: &Pairs, a: &Side, b: &Side) -> String {
    let says_something = |c: &&Comparison| c.low.is_some() || c.verdict != Verdict::Same;
    let shown: Vec<&Comparison> = pairs.comparisons.iter().filter(says_something).collect();
    let mut text = format!("A = {}, B = {}\n\n", a.name, b.name);
    for of_bench in shown.chunk_by(|a, b| a.bench == b.bench) {
        match of_bench[0].bench.as_str() {
            "" => {}
            bench => text += &format!("## {bench}\n\n"),
        }
        text += &(table(&COLUMNS, of_bench) + "\n");
    }
    let [worse, better, same] = [Verdict::Worse, Verdict::Better, Verdict::Same].map(|verdict| pairs.count(verdict));
    text += &format!("{worse} worse, {better} better, {same} same");
    for verdict in [Verdict::Lost, Verdict::New] {
        match pairs.count(verdict) {
            0 => {}
            count => text += &format!(", {count} {}", verdict.as_str()),
        }
    }
    text.push('\n');
    for (name, runs) in [("A", &pairs.only_in_a), ("B", &pairs.only_in_b)] {
        runs.iter().for_each(|run| text += &format!("only in {name}: {run}\n"));
    }
    text
}

fn csv(comparisons: &[Comparison]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    comparisons.iter().try_for_each(|row| writer.serialize(row)).expect("plain rows become CSV in memory");
    String::from_utf8(writer.into_inner().expect("memory takes all bytes")).expect("texts and numbers are UTF-8")
}

fn json(pairs: &Pairs, a: &Side, b: &Side) -> String {
    #[derive(Serialize)]
    struct File<'a> {
        a: &'a str,
        b: &'a str,
        comparisons: &'a [Comparison],
        only_in_a: &'a [String],
        only_in_b: &'a [String],
    }
    let Pairs { comparisons, only_in_a, only_in_b } = pairs;
    let file = File { a: &a.name, b: &b.name, comparisons, only_in_a, only_in_b };
    serde_json::to_string_pretty(&file).expect("texts and numbers become JSON") + "\n"
}

fn whole(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

fn interval(c: &Comparison) -> String {
    c.low.zip(c.high).map_or_else(String::new, |(low, high)| format!("{low:.3} to {high:.3}"))
}
