//! What the runs need besides the DEM: made once for all of them and all passes.

use crate::cells::Cells;
use crate::maps::Maps;

/// Empty until [`Bench::prepare`](crate::suite::Bench::prepare).
#[derive(Default)]
pub struct Prepared {
    /// For the bounded TIN.
    pub maps: Maps,
    /// For HTP with a window.
    pub cells: Cells,
}
