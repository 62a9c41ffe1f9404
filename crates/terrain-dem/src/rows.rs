//! DEMs that are not loaded: their rows pass by one at a time, as often as they are asked for.

use std::ops::ControlFlow;
use std::sync::Arc;

use terrain_core::{Heightmap, VoidMask};

use crate::load::{ByRows, RowsOf, load_rows};
use crate::raster::OnRow;
use crate::sidecar::Sidecar;
use crate::{Dem, DemError, Georeference, ReadOptions, Reading, find, open, open_synthetic, synthetic, tiles_of};

/// Whole DEMs of so few samples are not worth a warning: 64 MiB.
const FEW_SAMPLES: usize = 1 << 24;

/// A DEM whose heights come row by row.
#[derive(Debug)]
pub struct DemRows {
    /// As in [`Dem`].
    pub name: String,
    /// Columns and rows.
    pub samples: [u32; 2],
    /// Metres between neighbouring samples in x and in z.
    pub spacing_m: [f64; 2],
    /// As in [`Dem`].
    pub source: Option<String>,
    /// As in [`Dem`].
    pub licence: Option<String>,
    /// As in [`Dem`].
    pub notice: Option<String>,
    /// Where rows hold the fill of voids, unless that counts as filled.
    pub voids: Option<Arc<VoidMask>>,
    /// As in [`Dem`].
    pub georeference: Option<Georeference>,
    /// What the file was taken for.
    pub reading: Reading,
    heights: Heights,
}

#[derive(Debug)]
enum Heights {
    /// Decoded anew in each pass.
    File { spec: String, options: ReadOptions },
    /// Computed anew.
    Synthetic { seed: u64 },
    /// The file has no rows, or voids.
    Whole(Box<Dem>),
}

/// Opens what [`open`](crate::open) does, with the same meaning and the same heights, and reads it once to know that its
/// rows can be had: greyscale or coloured PNG, packed samples (raw, `.bil`, `.flt`, `.hgt`, PGM, `.npy`), TIFF in strips,
/// text grids. Interlaced and tiled files, those that begin in the south, DEMs with voids and parts of DEMs are loaded as a
/// whole, with a warning where that takes much memory.
pub fn open_rows(spec: &str, options: &ReadOptions) -> Result<DemRows, DemError> {
    if options.crop.is_some() || options.thin.is_some() || options.resample_m.is_some() {
        return Ok(DemRows::of(open(spec, options)?));
    }
    if let Some((_, _, seed)) = synthetic::parse(spec).filter(|_| options.scale.is_none() && options.offset_m.is_none())
    {
        return synthetic_rows(spec, options, seed);
    }
    if spec.starts_with(synthetic::PREFIX) {
        return Ok(DemRows::of(open(spec, options)?));
    }
    if tiles_of(spec)?.is_some() {
        let mut dem = DemRows::of(open(spec, options)?);
        dem.warn_of_memory("tiles are joined in memory");
        return Ok(dem);
    }
    let (input, sidecar) = find(spec)?;
    match load_rows(input, &sidecar, options, None, &mut |_| ControlFlow::Continue(()))? {
        ByRows::Done(found) => {
            let RowsOf { name, samples, spacing_m, georeference, reading } = *found;
            let heights = Heights::File { spec: spec.to_owned(), options: *options };
            let Sidecar { source, licence, notice, .. } = sidecar;
            let voids = None;
            Ok(DemRows { name, samples, spacing_m, source, licence, notice, voids, georeference, reading, heights })
        }
        ByRows::Refused(reason) => {
            let mut dem = DemRows::of(open(spec, options)?);
            dem.warn_of_memory(&reason);
            Ok(dem)
        }
        ByRows::Stopped => unreachable!("nobody stopped it"),
    }
}

fn synthetic_rows(spec: &str, options: &ReadOptions, seed: u64) -> Result<DemRows, DemError> {
    // All that is said of it, without its heights.
    let [columns, rows] = synthetic::parse(spec).map(|(columns, rows, _)| [columns, rows]).expect("a checked spec");
    let small = open_synthetic(&format!("{}2x2:{seed}", synthetic::PREFIX), options)?;
    let spacing_m = small.heightmap.spacing_m();
    let Dem { source, licence, notice, voids, georeference, reading, .. } = small;
    let (name, heights) = (format!("synthetic-{columns}x{rows}-{seed}"), Heights::Synthetic { seed });
    let samples = [columns, rows];
    Ok(DemRows { name, samples, spacing_m, source, licence, notice, voids, georeference, reading, heights })
}

impl DemRows {
    fn of(dem: Dem) -> Self {
        Self {
            name: dem.name.clone(),
            samples: [dem.heightmap.columns(), dem.heightmap.rows()],
            spacing_m: dem.heightmap.spacing_m(),
            source: dem.source.clone(),
            licence: dem.licence.clone(),
            notice: dem.notice.clone(),
            voids: dem.voids.clone().filter(|_| dem.heightmap.voids().is_some()),
            georeference: dem.georeference.clone(),
            reading: dem.reading.clone(),
            heights: Heights::Whole(Box::new(dem)),
        }
    }

    fn warn_of_memory(&mut self, reason: &str) {
        let samples = self.samples.iter().map(|side| *side as usize).product::<usize>();
        if samples > FEW_SAMPLES {
            let mib = samples >> 18;
            self.reading.warnings.push(format!("{reason}: the whole DEM is loaded, which takes {mib} MiB"));
        }
    }

    /// Calls with each row in metres, from the northern one on, until that breaks; false if it did.
    pub fn for_each(&self, on_row: OnRow) -> Result<bool, DemError> {
        match &self.heights {
            Heights::Whole(dem) => Ok(each_row(&dem.heightmap, on_row)),
            Heights::Synthetic { seed } => Ok(self.each_synthetic(*seed, on_row)),
            Heights::File { spec, options } => self.each_of_file(spec, options, on_row),
        }
    }

    fn each_synthetic(&self, seed: u64, on_row: OnRow) -> bool {
        let [columns, rows] = self.samples;
        let mut row_m = vec![0.0; columns as usize];
        (0..rows).all(|row| {
            synthetic::Kind::Ridged.fill_row(seed, row, &mut row_m);
            on_row(&row_m).is_continue()
        })
    }

    fn each_of_file(&self, spec: &str, options: &ReadOptions, on_row: OnRow) -> Result<bool, DemError> {
        let (input, sidecar) = find(spec)?;
        match load_rows(input, &sidecar, options, Some(self.samples), on_row)? {
            ByRows::Done(now) if now.spacing_m == self.spacing_m => Ok(true),
            ByRows::Stopped => Ok(false),
            _ => {
                Err(DemError::input(spec, "changed while it was read; expected the same file in every pass".to_owned()))
            }
        }
    }
}

fn each_row(heightmap: &Heightmap, on_row: OnRow) -> bool {
    heightmap.heights_m().chunks(heightmap.columns() as usize).all(|row_m| on_row(row_m).is_continue())
}
