//! The methods' choices by their names on the command line and in suites: the method crates know neither.

use clap::ValueEnum;
use htp_lod::{Batching, LevelMetric, Loading};
use serde::{Deserialize, Serialize};
use tin_lod::{EdgePolicy, IndexStore, Schedule, Selector, Triangulator};

/// Which samples the TIN keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SelectorName {
    /// The paper's, whose tolerance is no bound
    Algorithm1,
    /// The tolerance is a bound
    #[default]
    Bounded,
}

impl From<SelectorName> for Selector {
    fn from(name: SelectorName) -> Self {
        match name {
            SelectorName::Algorithm1 => Self::Algorithm1,
            SelectorName::Bounded => Self::Bounded,
        }
    }
}

/// When the TIN's patches are updated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ScheduleName {
    /// In the plan, which waits for it
    #[default]
    Blocking,
    /// Behind the plans, by a worker thread, as in the paper
    Live,
}

impl From<ScheduleName> for Schedule {
    fn from(name: ScheduleName) -> Self {
        match name {
            ScheduleName::Blocking => Self::Blocking,
            ScheduleName::Live => Self::Live,
        }
    }
}

/// Which of the TIN's edges follow when a patch is selected anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EdgePolicyName {
    /// All four, and the neighbours with them
    #[default]
    Matched,
    /// Those whose patches are both updated, as in the paper
    Paper,
}

impl From<EdgePolicyName> for EdgePolicy {
    fn from(name: EdgePolicyName) -> Self {
        match name {
            EdgePolicyName::Matched => Self::Matched,
            EdgePolicyName::Paper => Self::Paper,
        }
    }
}

/// What connects the TIN's selected samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TriangulatorName {
    /// Our own kernel for patches of a grid
    #[default]
    Grid,
    /// The crate delaunator
    Delaunator,
    /// The crate spade
    Spade,
}

impl From<TriangulatorName> for Triangulator {
    fn from(name: TriangulatorName) -> Self {
        match name {
            TriangulatorName::Grid => Self::Grid,
            TriangulatorName::Delaunator => Self::Delaunator,
            TriangulatorName::Spade => Self::Spade,
        }
    }
}

/// How the TIN's patches share the index buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum IndexStoreName {
    /// Room for a fully refined patch each, as in the paper
    Fixed,
    /// Rooms by need, 2-byte indices
    #[default]
    Packed,
}

impl From<IndexStoreName> for IndexStore {
    fn from(name: IndexStoreName) -> Self {
        match name {
            IndexStoreName::Fixed => Self::Fixed,
            IndexStoreName::Packed => Self::Packed,
        }
    }
}

/// What decides which patches HTP splits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MetricName {
    /// By distance, as in the paper: the leg of a triangle on the screen
    Distance,
    /// By the longest edge of the bounding box, the paper's alternative
    Box,
    /// By error: the tolerance is a bound
    Error,
}

impl From<MetricName> for LevelMetric {
    fn from(name: MetricName) -> Self {
        match name {
            MetricName::Distance => Self::Distance,
            MetricName::Box => Self::Box,
            MetricName::Error => Self::Error,
        }
    }
}

/// How HTP's visible patches become draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BatchingName {
    /// One draw a patch, as in the paper
    PerPatch,
    /// One draw a cell
    MergedCell,
    /// At most 7 instanced draws
    Instanced,
}

impl From<BatchingName> for Batching {
    fn from(name: BatchingName) -> Self {
        match name {
            BatchingName::PerPatch => Self::PerPatch,
            BatchingName::MergedCell => Self::MergedCell,
            BatchingName::Instanced => Self::Instanced,
        }
    }
}

/// Whether HTP's plans wait for the cells that they want.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoadingName {
    /// They wait: the same plans every time
    #[default]
    Blocking,
    /// A thread reads, and coarse levels stand in for what has not arrived
    Live,
}

impl From<LoadingName> for Loading {
    fn from(name: LoadingName) -> Self {
        match name {
            LoadingName::Blocking => Self::Blocking,
            LoadingName::Live => Self::Live,
        }
    }
}

/// The name of a choice as users write it.
pub fn name_of(choice: impl ValueEnum) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().to_string())
}
