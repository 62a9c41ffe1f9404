//! `summary.json`: the table with what it rests on, for programs. Its schema is `schema/summary.schema.json`.

use serde::Serialize;
use serde_json::Value;

use crate::compare::Comparison;
use crate::frame_times::RepeatTimes;
use crate::summary::SummaryRow;

/// Goes up when a reader of older files would be misled: not for further columns.
pub const SCHEMA: u32 = 1;

/// The whole file.
#[derive(Serialize)]
pub struct SummaryFile<'a> {
    pub schema: u32,
    /// As `machine.json`.
    pub machine: Value,
    pub rows: Vec<SummaryFileRow<'a>>,
    /// The A/A check, where it was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub aa: Vec<Comparison>,
}

/// A row of `summary.csv`, and each repeat's times.
#[derive(Serialize)]
pub struct SummaryFileRow<'a> {
    #[serde(flatten)]
    pub row: &'a SummaryRow,
    pub repeat_times: &'a RepeatTimes,
}
