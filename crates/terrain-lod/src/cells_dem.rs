//! A file of cells as a DEM: its heights, as they were before it was cut.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use htp_lod::{CellFile, CellsHeader};
use terrain_core::{HeightFormat, Heightmap};
use terrain_dem::{
    Dem, Georeference, HeightUnit, MAX_SAMPLES, ReadOptions, Reading, VoidMask, VoidPolicy, count_voids,
    parse_whereabouts,
};

use crate::cells_file;
use crate::fault::{Cause, Fault};

/// Cells of which one row is in memory at a time.
pub struct CellsDem {
    path: PathBuf,
    file: CellFile,
    /// Where the heights are the fill of voids.
    voids: Option<Arc<VoidMask>>,
    policy: VoidPolicy,
    georeference: Option<Georeference>,
    pub reading: Reading,
}

impl CellsDem {
    /// Refuses settings that a file of cells has no use for: it says all itself.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self, Fault> {
        let ReadOptions { max_samples, voids: policy, .. } = *options;
        if *options != (ReadOptions { max_samples, voids: policy, ..ReadOptions::default() }) {
            let message = "a file of cells, whose heights are metres; expected --max-samples and --voids alone of the \
                           reading options";
            return Err(Fault::usage(format_args!("{}: {message}", path.display())));
        }
        let (file, _) = cells_file::open(path)?;
        let limit = max_samples.unwrap_or(MAX_SAMPLES).min(MAX_SAMPLES);
        let [columns, rows] = file.header().samples;
        if columns as u64 * rows as u64 > limit {
            let message = format_args!("{}: {columns} x {rows} samples; expected at most {limit}", path.display());
            return Err(Fault::new(Cause::BadInput, message));
        }
        let place = file.header().provenance.place.as_deref().unwrap_or_default();
        let (crs, georeference) = parse_whereabouts(&format!("{}, its place", path.display()), place)?;
        let (voids, warnings) = read_voids(path, &file, policy)?.unzip();
        let reading = Reading { crs, warnings: warnings.into_iter().collect(), ..reading(&file) };
        Ok(Self { path: path.to_owned(), file, voids: voids.map(Arc::new), policy, georeference, reading })
    }

    pub fn header(&self) -> &CellsHeader {
        self.file.header()
    }

    /// The voids, unless the fill counts.
    pub fn open_voids(&self) -> Option<&Arc<VoidMask>> {
        self.voids.as_ref().filter(|_| self.policy == VoidPolicy::Hole)
    }

    /// Calls with each row in metres until that breaks.
    pub fn for_each(&self, on_row: &mut dyn FnMut(&[f32]) -> ControlFlow<()>) -> Result<(), Fault> {
        for row in 0..self.header().cells()[1] {
            let heights_m = self.file.heights_m(row).map_err(|error| cells_file::fault(&self.path, &error))?;
            let mut rows = heights_m.chunks(self.header().samples[0] as usize);
            if rows.any(|row_m| on_row(row_m).is_break()) {
                break;
            }
        }
        Ok(())
    }

    /// All heights.
    pub fn load(self) -> Result<Dem, Fault> {
        let CellsHeader { samples: [columns, rows], spacing_m, provenance, .. } = self.header().clone();
        let mut heights_m = Vec::with_capacity(columns as usize * rows as usize);
        self.for_each(&mut |row_m| {
            heights_m.extend_from_slice(row_m);
            ControlFlow::Continue(())
        })?;
        let refuse = |e| Fault::new(Cause::BadInput, format_args!("{}: {e}", self.path.display()));
        let mut heightmap = Heightmap::new(columns, rows, spacing_m, heights_m).map_err(refuse)?;
        if let Some(voids) = self.open_voids() {
            heightmap = heightmap.with_voids(voids.clone()).map_err(refuse)?;
        }
        Ok(Dem {
            name: self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            heightmap: Arc::new(heightmap),
            source: provenance.source,
            licence: provenance.licence,
            notice: provenance.notice,
            voids: self.voids,
            georeference: self.georeference,
            reading: self.reading,
        })
    }
}

/// The voids, and what to say of them.
fn read_voids(path: &Path, file: &CellFile, policy: VoidPolicy) -> Result<Option<(VoidMask, String)>, Fault> {
    let Some(mask) = file.voids().map_err(|error| cells_file::fault(path, &error))? else { return Ok(None) };
    let all = u64::from(mask.columns()) * u64::from(mask.rows());
    let said = policy.apply(&count_voids(mask.count(), all));
    let refuse = |reason| Fault::new(Cause::BadInput, format_args!("{}: {reason}", path.display()));
    Ok(Some((mask, said.map_err(refuse)?)))
}

fn reading(file: &CellFile) -> Reading {
    let header = file.header();
    let (samples, scale, offset_m) = match header.format {
        HeightFormat::F32 => ("float32", 1.0, 0.0),
        HeightFormat::U16 { scale_m, offset_m } => ("uint16", scale_m, offset_m),
    };
    let ([columns, rows], side) = (header.cells(), header.cell_side());
    let CellsHeader { k, layers, streamed, .. } = header;
    Reading {
        format: format!(
            "{columns} x {rows} cells of {side} x {side} intervals, k of {k}, {layers} layers, {streamed} of them loaded \
             by cell; {} bytes a cell, {} resident",
            file.cell_bytes(),
            file.resident_bytes()
        ),
        samples,
        bands: 1,
        spacing_from: "the file".to_owned(),
        crs: None,
        unit: Some(HeightUnit::Metre),
        scale,
        offset_m,
        nodata: None,
        warnings: Vec::new(),
    }
}
