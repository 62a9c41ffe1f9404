//! One bench with all that is drawn of it.

use crate::fault::Fault;
use crate::report::chart::Chart;
use crate::report::curves::{self, Curves};
use crate::report::folder::Folder;
use crate::report::runs::{self, Run};
use crate::report::{distributions, headline};

pub struct BenchPage {
    pub folder: Folder,
    pub runs: Vec<Run>,
    pub headline: Vec<Chart>,
    pub curves: Curves,
    pub distributions: Vec<Chart>,
}

impl BenchPage {
    /// The runs are numbered from `first`.
    pub fn of(folder: Folder, first: usize) -> Result<Self, Fault> {
        let runs = runs::of(&folder, first);
        let headline = headline::charts(&folder, &runs)?;
        let curves = curves::of(&folder, &runs)?;
        let distributions = distributions::charts(&folder, &runs)?;
        Ok(Self { folder, runs, headline, curves, distributions })
    }

    pub fn charts(&self) -> impl Iterator<Item = &Chart> {
        self.headline.iter().chain(&self.curves.charts).chain(&self.distributions)
    }
}
