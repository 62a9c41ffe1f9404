//! The cells that runs with a window fly over: those of the file that the DEM came from, where it was cut for the same
//! hierarchy, or else cut in memory, once for all runs and passes.

use std::path::Path;
use std::sync::Arc;

use htp_lod::{CellFile, CellSource, Options, Resident, Scan, cut_steps};
use terrain_dem::Dem;

use crate::cells_file;
use crate::fault::Fault;
use crate::methods::Run;

/// By `k` and layers.
#[derive(Default)]
pub struct Cells(Vec<([u32; 2], Arc<dyn CellSource>)>);

impl Cells {
    /// Gets the cells that these runs need and that are not there yet, and refuses windows that are too small for them.
    pub fn add(&mut self, runs: &[Run], dem: &Dem, spec: &str) -> Result<(), Fault> {
        for options in runs.iter().filter_map(Run::streamed) {
            let key = [options.k, options.layers];
            if self.get(key).is_none() {
                let file = from_file(Path::new(spec), key)?;
                self.0.push((key, file.map_or_else(|| cut(dem, &options), Ok)?));
            }
            self.open(&options)?.0.header().check(&options).map_err(Fault::usage)?;
        }
        Ok(())
    }

    /// The cells for a run's options.
    pub fn open(&self, options: &Options) -> Result<(CellFile, Resident), Fault> {
        let source = self.get([options.k, options.layers]).expect("the cells of every run are there");
        CellFile::open(source).map_err(Fault::usage)
    }

    fn get(&self, key: [u32; 2]) -> Option<Arc<dyn CellSource>> {
        self.0.iter().find(|cells| cells.0 == key).map(|cells| cells.1.clone())
    }
}

/// The file that the DEM came from, if it is one of cells of this hierarchy.
fn from_file(path: &Path, [k, layers]: [u32; 2]) -> Result<Option<Arc<dyn CellSource>>, Fault> {
    if !cells_file::is_one(path) {
        return Ok(None);
    }
    let (file, _) = cells_file::open(path)?;
    let fits = [file.header().k, file.header().layers] == [k, layers];
    if fits { cells_file::source(path).map(Some) } else { Ok(None) }
}

fn cut(dem: &Dem, options: &Options) -> Result<Arc<dyn CellSource>, Fault> {
    let (heightmap, declared) = (&dem.heightmap, Some([dem.reading.scale, dem.reading.offset_m]));
    // What cannot be cut is refused in one line.
    Scan::new([heightmap.columns(), heightmap.rows()], heightmap.spacing_m(), declared, options)
        .map_err(Fault::usage)?;
    Ok(Arc::new(cut_steps(heightmap, declared, options)))
}
