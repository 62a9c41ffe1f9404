//! Curves over the flight that a suite asks for, such as the papers' figures: what `report` makes of the frames' CSV.
//!
//! ```toml
//! [[flight_curves]]
//! file = "figure-6"               # its SVG file
//! title = "Share of an update spent in triangulation"
//! benches = ["1025", "257"]       # the first of these that was flown; without, the only bench
//! measure = "triangulation-share"
//! curves = "tolerance_px"         # a curve for each value
//! series = [{ name = "published", only = { selector = "algorithm1" } }]   # a chart for each
//! ```

use serde::{Deserialize, Serialize};

use crate::pivot::{Series, is_name};

/// Charts of one kind.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlightCurves {
    /// The beginning of the name of its files.
    pub file: String,
    pub title: String,
    /// What a reader must know.
    #[serde(default)]
    pub note: String,
    #[serde(default)]
    pub benches: Vec<String>,
    pub measure: FlightMeasure,
    pub curves: String,
    #[serde(default)]
    pub series: Vec<Series>,
}

/// What is shown of each frame, from all its repeats together. Frames without an update have none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FlightMeasure {
    /// Time spent triangulating, per cent of the update. On several threads both stages are summed over them, so the share
    /// is of the stages' sum.
    TriangulationShare,
    /// Triangles that the updates made, by the time that the updates took.
    TrianglesPerSecond,
}

impl FlightCurves {
    /// Refuses what would be no chart. `benches` are the suite's; none where it is one.
    pub fn validate(&self, benches: &[&str]) -> Result<(), String> {
        let refuse = |reason: String| Err(format!("flight_curves {:?}: {reason}", self.file));
        let is_plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if self.file.is_empty() || !self.file.chars().all(is_plain) {
            return refuse("file is the name of a file; expected small letters, digits and dashes".into());
        }
        let names = self.series.iter().flat_map(|series| series.only.keys()).chain([&self.curves]);
        if let Some(name) = names.into_iter().find(|name| !is_name(name)) {
            return refuse(format!("{name} is no column of summary.csv and no setting"));
        }
        match self.benches.iter().find(|name| !benches.contains(&name.as_str())) {
            Some(name) => refuse(format!("{name} is no bench of the suite")),
            None => Ok(()),
        }
    }

    /// The series, or all runs as one.
    pub fn all_series(&self) -> Vec<Series> {
        if self.series.is_empty() { vec![Series::default()] } else { self.series.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_be_no_chart_is_refused() {
        let parse = |curves: &str, benches: &str, file: &str| {
            let text = format!(
                "file = '{file}'\ntitle = 'T'\nmeasure = 'triangulation-share'\ncurves = '{curves}'\nbenches = [{benches}]"
            );
            toml::from_str::<FlightCurves>(&text).unwrap().validate(&["small"])
        };
        assert_eq!(parse("tolerance_px", "'small'", "figure-6"), Ok(()));
        assert!(
            parse("tolerence_px", "", "figure-6").unwrap_err().ends_with("no column of summary.csv and no setting")
        );
        assert!(parse("k", "'large'", "figure-6").unwrap_err().ends_with("large is no bench of the suite"));
        assert!(parse("k", "", "../x").unwrap_err().contains("expected small letters"));
    }
}
