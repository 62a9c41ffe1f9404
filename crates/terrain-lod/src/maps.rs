//! The threshold maps of the bounded TIN: each computed once for all runs and passes, or taken from a file beside the DEM.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use terrain_core::Heightmap;
use terrain_dem::write_atomically;
use tin_lod::{NodeMaps, Nodes};

use crate::methods::Run;
use crate::progress::Progress;

/// Maps for the patches and groups of some runs.
#[derive(Default)]
pub struct Maps(Vec<Arc<NodeMaps>>);

/// Maps in files beside the DEM's.
#[derive(Clone, Copy)]
pub struct Kept<'a> {
    /// The DEM's file.
    pub beside: &'a Path,
    /// Whether maps that are computed are written, too.
    pub may_write: bool,
}

impl Maps {
    /// Gets the maps that these runs need and that are not there yet.
    pub fn add(&mut self, runs: &[Run], heightmap: &Heightmap, kept: Option<Kept>) {
        for nodes in runs.iter().filter_map(|run| run.nodes(heightmap)) {
            if self.get(&nodes).is_none() {
                let found = match kept {
                    Some(kept) => read_or_build(kept, heightmap, nodes),
                    None => build(heightmap, nodes),
                };
                self.0.push(Arc::new(found));
            }
        }
    }

    pub fn get(&self, nodes: &Nodes) -> Option<Arc<NodeMaps>> {
        self.0.iter().find(|maps| maps.nodes() == nodes).cloned()
    }
}

fn build(heightmap: &Heightmap, nodes: Nodes) -> NodeMaps {
    let progress = Progress::new("threshold maps", nodes.len() as u64);
    NodeMaps::build_with_progress(heightmap, nodes, &|_, _| progress.step())
}

fn file_beside(dem: &Path, nodes: &Nodes) -> PathBuf {
    let mut name = dem.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".patch{}-group{}.tin-maps", nodes.patches().side(), nodes.group()));
    dem.with_file_name(name)
}

/// The maps of a file; computed and written where there is none, or not the right one. A file that cannot be written is no
/// reason to do without the maps.
fn read_or_build(kept: Kept, heightmap: &Heightmap, nodes: Nodes) -> NodeMaps {
    let file = file_beside(kept.beside, &nodes);
    if let Ok(bytes) = fs::read(&file) {
        match NodeMaps::read(&bytes, heightmap, nodes.clone()) {
            Ok(maps) => return maps,
            Err(reason) => eprintln!("note: {}: {reason}; computed anew", file.display()),
        }
    }
    let maps = build(heightmap, nodes);
    if kept.may_write
        && let Err(error) = write_atomically(&file, |out| maps.write(heightmap, out))
    {
        eprintln!("note: cannot write {}: {error}; the maps will be computed again", file.display());
    }
    maps
}
