//! Markdown tables whose columns line up, so that they read well as plain text too.

use std::fmt::Write;

/// The head of a column.
pub struct Heading {
    pub text: String,
    /// Whether its cells stand to the right, as numbers do.
    pub right: bool,
}

/// The table, a line each for the headings, the rule and every row of cells.
pub fn table(headings: &[Heading], rows: &[Vec<String>]) -> String {
    let length = |text: &str| text.chars().count();
    let widest = |i: usize| rows.iter().map(|row| length(&row[i])).max().unwrap_or(0);
    let widths: Vec<usize> =
        headings.iter().enumerate().map(|(i, head)| widest(i).max(length(&head.text)).max(2)).collect();
    let rules = headings.iter().zip(&widths).map(|(head, w)| match head.right {
        true => format!("{:->w$}:", "", w = w - 1),
        false => "-".repeat(*w),
    });
    let texts: Vec<String> = headings.iter().map(|head| head.text.clone()).collect();
    let mut text = line(headings, &texts, &widths) + "\n";
    let _ = writeln!(text, "| {} |", rules.collect::<Vec<_>>().join(" | "));
    for row in rows {
        let _ = writeln!(text, "{}", line(headings, row, &widths));
    }
    text
}

fn line(headings: &[Heading], cells: &[String], widths: &[usize]) -> String {
    let padded = cells.iter().zip(widths).zip(headings).map(|((cell, w), head)| match head.right {
        true => format!("{cell:>w$}"),
        false => format!("{cell:<w$}"),
    });
    format!("| {} |", padded.collect::<Vec<_>>().join(" | "))
}
