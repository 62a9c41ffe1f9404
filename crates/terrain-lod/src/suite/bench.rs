//! A suite with all that its passes need.

use std::path::Path;

use terrain_core::flight;
use terrain_core::{Flight, FlightPath, View};
use terrain_dem::{Dem, ReadOptions};
use terrain_renderer::{Look, Submission};

use super::{NamedSuite, Suite};
use crate::cli::BenchArgs;
use crate::dem;
use crate::fault::{Cause, Fault};
use crate::maps::Kept;
use crate::methods::Run;
use crate::prepared::Prepared;

/// A flight by its built-in name or its file.
pub fn open_flight(spec: &str) -> Result<Flight, Fault> {
    if let Some(flight) = Flight::built_in(spec) {
        return Ok(flight);
    }
    let built_in: Vec<&str> = flight::BUILT_IN.iter().map(|flight| flight.0).collect();
    let expected = &format!("a flight file, or one of the built-in flights {}", built_in.join(", "));
    let text = std::fs::read_to_string(spec).map_err(|e| Fault::read(Path::new(spec), &e, expected))?;
    Ok(Flight::parse(spec, &text)?)
}

/// Everything that the passes need, checked.
pub struct Bench {
    pub suite_name: String,
    /// Its name in a suite of several.
    pub name: Option<String>,
    pub suite: Suite,
    pub runs: Vec<Run>,
    pub dem: Dem,
    pub prepared: Prepared,
    pub flight_name: String,
    pub path: FlightPath,
    /// Frames at the start of each flight of the speed pass that are not timed.
    pub warm_up: u32,
    pub submission: Submission,
    pub look: Look,
}

impl Bench {
    /// One bench of a suite.
    pub fn of(suite_name: &str, named: &NamedSuite, args: &BenchArgs) -> Result<Self, Fault> {
        let bench = Self::new(suite_name, named.suite.clone(), args.dem.read_options())?;
        let look = Look { normals: named.suite.normals.into(), ..args.look() };
        Ok(Self { name: named.name.clone(), look, ..bench })
    }

    /// Reads and checks DEM, flight and settings.
    pub fn new(suite_name: &str, suite: Suite, read: ReadOptions) -> Result<Self, Fault> {
        let refuse = |reason| Fault::new(Cause::BadInput, format_args!("suite {suite_name}: {reason}"));
        suite.validate().map_err(refuse)?;
        let runs = suite.runs()?;
        let flight = open_flight(&suite.flight)?;
        let dem = dem::open(&suite.dem, &suite.read_options(read).map_err(refuse)?)?;
        let frames = suite.frames.unwrap_or_else(|| flight.default_frames());
        let path = FlightPath::new(&flight, &dem.heightmap, frames)?;
        Ok(Self {
            suite_name: suite_name.into(),
            name: None,
            runs,
            dem,
            prepared: Prepared::default(),
            flight_name: flight.name().to_string(),
            path,
            // A short flight still has frames to time.
            warm_up: suite.warm_up.min(frames / 2),
            submission: suite.submission.into(),
            look: Look::default(),
            suite,
        })
    }

    /// Gets what the runs need, once for all passes. That takes a while. `keep`: threshold maps in files beside the DEM's,
    /// which are read, and written if `may_write`.
    pub fn prepare(&mut self, keep: bool, may_write: bool) -> Result<(), Fault> {
        let (file, needs_maps) = (Path::new(&self.suite.dem), self.runs.iter().any(Run::needs_maps));
        if keep && needs_maps && !file.is_file() {
            let message =
                format!("{}: no file to keep threshold maps beside; expected a DEM in a file", self.suite.dem);
            return Err(Fault::usage(message + ", or no --keep-maps"));
        }
        let kept = keep.then_some(Kept { beside: file, may_write });
        self.prepared.add(&self.runs, &self.dem, &self.suite.dem, kept)
    }

    /// The view of one frame.
    pub fn view(&self, frame: u32) -> Result<View, Fault> {
        Ok(self.path.view(frame, self.suite.size_px)?)
    }
}
