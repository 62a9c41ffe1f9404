//! The tables of `summary.md`. Those with a row a run begin with the run's mark, and their settings, which are long, end
//! them; the first has besides the intervals that `summary.csv` has.

use crate::fault::Fault;
use crate::report::bench_page::BenchPage;
use crate::report::html::{Column, digits, escape, group, table};
use crate::report::markdown::{self, Block, Table, inline};
use crate::report::measures;

/// What the tables of the bench begin with, where a row is a run.
const IDENTITY: [&str; 3] = ["method", "setting", "tolerance px"];

/// All of `summary.md` as HTML.
pub fn html(part: &BenchPage) -> Result<String, Fault> {
    let mut text = String::new();
    let mut intervals = intervals(part)?;
    for block in markdown::read(&part.folder.summary_md) {
        text += &match block {
            Block::Table(table) if table.heads.starts_with(&IDENTITY.map(str::to_owned)) => {
                of_runs(part, &table, std::mem::take(&mut intervals))
            }
            other => markdown::html(&[other], 3),
        };
    }
    match text.is_empty() {
        true => Ok("<p>This folder has no <code>summary.md</code>: the bench has not come so far.</p>\n".into()),
        false => Ok(text + &measures::html(part)?),
    }
}

/// A column of intervals: its head, and a cell for each row of the summary.
type Intervals = (String, Vec<String>);

/// Of all `<name>_low` that have a `<name>_high`, and any number in them.
fn intervals(part: &BenchPage) -> Result<Vec<Intervals>, Fault> {
    let summary = &part.folder.summary;
    let mut all = Vec::new();
    for name in summary.columns().iter().filter_map(|name| name.strip_suffix("_low")) {
        let high = format!("{name}_high");
        if summary.columns().contains(&high) {
            let ends = summary.numbers(&format!("{name}_low"))?.into_iter().zip(summary.numbers(&high)?);
            let cell = |(low, high): (Option<f64>, Option<f64>)| match low.zip(high) {
                Some((low, high)) => format!("{} to {}", digits(low), digits(high)),
                None => String::new(),
            };
            let cells: Vec<String> = ends.map(cell).collect();
            if cells.iter().any(|cell| !cell.is_empty()) {
                all.push((format!("{} interval", name.replace('_', " ")), cells));
            }
        }
    }
    Ok(all)
}

fn of_runs(part: &BenchPage, source: &Table, intervals: Vec<Intervals>) -> String {
    let right = |i: usize| source.right.get(i).copied().unwrap_or(false);
    let mut columns = vec![Column::new("run".into(), false)];
    columns.extend(source.heads.iter().enumerate().skip(2).map(|(i, head)| Column::new(inline(head), right(i))));
    columns.extend(intervals.iter().map(|(head, _)| Column::new(escape(head), true)));
    columns.push(Column { head: "setting".into(), class: "setting" });
    let row = |cells: &Vec<String>| {
        let found = row_of(part, cells);
        let mut row = vec![found.and_then(|row| mark(part, row)).unwrap_or_else(|| inline(&cells[0]))];
        row.extend(
            cells
                .iter()
                .enumerate()
                .skip(2)
                .map(|(i, cell)| inline(&if right(i) { group(cell) } else { cell.clone() })),
        );
        row.extend(intervals.iter().map(|(_, cells)| found.map_or_else(String::new, |row| cells[row].clone())));
        row.push(inline(&cells[1]));
        row
    };
    let rows: Vec<Vec<String>> =
        source.rows.iter().filter(|cells| cells.len() == source.heads.len()).map(row).collect();
    format!("<div class=\"summary\">{}</div>\n", table(&columns, &rows))
}

/// The row of `summary.csv` that a row of a table was made from.
fn row_of(part: &BenchPage, cells: &[String]) -> Option<usize> {
    let summary = &part.folder.summary;
    let is_same = |row: &usize| {
        let tolerance = summary.text(*row, "tolerance_px");
        let tolerance = tolerance.strip_suffix(".0").unwrap_or(tolerance);
        [summary.text(*row, "method"), summary.text(*row, "setting"), tolerance] == cells[..3]
    };
    (0..summary.len()).find(is_same)
}

/// The mark and label of the run that has a row.
fn mark(part: &BenchPage, row: usize) -> Option<String> {
    let run = part.runs.iter().find(|run| run.rows.contains(&row))?;
    Some(format!("{} {}", run.look.swatch(&run.label), escape(&run.label)))
}
