//! What the runs need besides the DEM: made once for all of them and all passes.

use terrain_dem::Dem;

use crate::cells::Cells;
use crate::fault::Fault;
use crate::maps::{Kept, Maps};
use crate::methods::Run;

/// Empty until [`Prepared::add`].
#[derive(Default)]
pub struct Prepared {
    /// For the bounded TIN.
    pub maps: Maps,
    /// For HTP with a window.
    pub cells: Cells,
}

impl Prepared {
    /// Gets what these runs need and what is not there yet; `spec` is the DEM's name on the command line. That takes a
    /// while.
    pub fn add(&mut self, runs: &[Run], dem: &Dem, spec: &str, kept: Option<Kept>) -> Result<(), Fault> {
        self.maps.add(runs, &dem.heightmap, kept);
        self.cells.add(runs, dem, spec)
    }
}
