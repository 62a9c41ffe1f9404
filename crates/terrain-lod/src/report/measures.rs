//! Columns of `summary.csv` that the bench's own table has no room for, in groups; a row a run. What no run has is left out.

use std::fmt::Write;

use crate::fault::Fault;
use crate::report::bench_page::BenchPage;
use crate::report::html::{Column, digits, escape, group, table};

/// Title, and columns of the summary with their heads.
type Group = (&'static str, &'static [(&'static str, &'static str)]);

const GROUPS: [Group; 5] = [
    (
        "Frame times, ms",
        &[
            ("fps_mean", "fps"),
            ("fps_low_1pct", "fps 1 % low"),
            ("frame_ms_p50", "P50"),
            ("frame_ms_p95", "P95"),
            ("frame_ms_p99", "P99"),
            ("frame_ms_p999", "P99.9"),
            ("frame_ms_max", "max"),
            ("jank_ms", "jank a flight"),
        ],
    ),
    (
        "Where the time goes, ms",
        &[
            ("plan_ms_p50", "plan P50"),
            ("plan_ms_p99", "plan P99"),
            ("cull_ms_p50", "cull P50"),
            ("update_ms_mean", "update mean"),
            ("update_ms_max", "update max"),
            ("upload_ms_p50", "upload P50"),
            ("encode_ms_p50", "encode P50"),
            ("gpu_ms_p50", "GPU P50"),
            ("cpu_ms_mean", "process CPU mean"),
        ],
    ),
    (
        "Triangles, draws and bytes",
        &[
            ("triangles_mean", "triangles"),
            ("triangles_max", "max"),
            ("triangles_by_level_mean", "by level, finest first"),
            ("draws_mean", "draws"),
            ("draw_calls_mean", "draw calls"),
            ("first_upload_bytes", "first upload"),
            ("upload_bytes_mean", "upload a frame"),
            ("index_bytes_reserved", "index bytes reserved"),
            ("index_bytes_used", "used"),
            ("resident_bytes", "resident"),
        ],
    ),
    (
        "Error and popping, px",
        &[
            ("error_px_rms", "error RMS"),
            ("error_px_p95", "P95"),
            ("error_px_p99", "P99"),
            ("error_px_p999", "P99.9"),
            ("error_px_max", "max"),
            ("error_m_max", "max, m"),
            ("displacement_px_p99", "displacement P99"),
            ("displacement_px_max", "max"),
            ("popping_px_p99", "popping P99"),
            ("popping_px_max", "max"),
            ("changed_triangles_mean", "changed triangles"),
        ],
    ),
    (
        "Pictures against those of the full grid, means over the moments",
        &[
            ("picture_flat_rmse", "geometry alone: RMSE"),
            ("picture_flat_mssim", "MSSIM"),
            ("picture_flat_flip", "FLIP"),
            ("picture_depth_rmse_m", "depth RMSE, m"),
            ("picture_shaded_rmse", "shaded: RMSE"),
            ("picture_shaded_mssim", "MSSIM"),
            ("picture_shaded_flip", "FLIP"),
        ],
    ),
];

/// All groups of which anything was measured, folded.
pub fn html(page: &BenchPage) -> Result<String, Fault> {
    let mut text = String::new();
    for (title, columns) in GROUPS {
        if let Some(table) = of_group(page, columns)? {
            let _ = writeln!(text, "<details><summary>{title}</summary>\n{table}</details>");
        }
    }
    Ok(text)
}

fn of_group(page: &BenchPage, columns: &[(&str, &str)]) -> Result<Option<String>, Fault> {
    let summary = &page.folder.summary;
    let rows: Vec<usize> = page.runs.iter().filter_map(|run| run.rows.first().copied()).collect();
    let is_any = |(column, _): &&(&str, &str)| rows.iter().any(|row| !summary.text(*row, column).is_empty());
    let columns: Vec<&(&str, &str)> = columns.iter().filter(is_any).collect();
    if columns.is_empty() {
        return Ok(None);
    }
    let heads = columns.iter().map(|(_, head)| Column::new(escape(head), true));
    let heads: Vec<Column> = std::iter::once(Column::new("run".into(), false)).chain(heads).collect();
    let mut cells = Vec::new();
    for run in page.runs.iter().filter(|run| !run.rows.is_empty()) {
        let mut row = vec![format!("{} {}", run.look.swatch(&run.label), escape(&run.label))];
        for (column, _) in &columns {
            row.push(cell(summary.text(run.rows[0], column)));
        }
        cells.push(row);
    }
    Ok(Some(format!("<div class=\"summary\">{}</div>\n", table(&heads, &cells))))
}

/// A number with four digits; several, as of the levels, each by itself.
fn cell(text: &str) -> String {
    let words = text.split(' ').map(|word| match word.parse::<f64>() {
        Ok(number) if number.is_finite() && word.contains('.') => digits(number),
        _ => group(word),
    });
    escape(&words.collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A misspelt name would be a column that no run has.
    #[test]
    fn the_groups_name_columns_of_the_summary() {
        let row = serde_json::to_value(crate::summary::SummaryRow::default()).unwrap();
        let names = GROUPS.iter().flat_map(|(_, columns)| columns.iter().map(|(column, _)| *column));
        for column in names.filter(|column| !column.starts_with("picture_")) {
            assert!(row.get(column).is_some(), "{column} is no column");
        }
    }

    #[test]
    fn numbers_are_short_and_lists_stay_lists() {
        assert_eq!(
            ["12.3456", "29626", "120 0 31456", ""].map(cell),
            ["12.35", "29\u{202f}626", "120 0 31\u{202f}456", ""]
        );
    }
}
