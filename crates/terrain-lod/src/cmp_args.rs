//! The part of the command line that compares results.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::parse::parse_percent;

#[derive(Debug, Args)]
pub struct CmpArgs {
    /// What was: a result folder, that of a suite of several benches, or a summary.json or summary.csv (which has no
    /// repeats: intervals are then put together from its columns)
    #[arg(value_name = "A")]
    pub a: PathBuf,
    /// What is now
    #[arg(value_name = "B")]
    pub b: PathBuf,
    /// Exit with code 3 where something is worse by more than this (a counter, or a time beyond noise), or B lacks a run
    #[arg(long, value_name = "PERCENT", value_parser = parse_percent)]
    pub fail_on: Option<f64>,
    /// Compare in spite of another adapter, CPU, DEM, flight or build, or of an incomplete bench
    #[arg(long)]
    pub force: bool,
    /// Markdown names what differs and all times; csv and json have every number
    #[arg(long, value_name = "FORMAT", default_value = "markdown")]
    pub format: CmpFormat,
}

/// How the comparison is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CmpFormat {
    /// A table
    Markdown,
    /// A row for each number of each run
    Csv,
    /// One object
    Json,
}
