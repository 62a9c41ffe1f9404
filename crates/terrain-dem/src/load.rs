//! From a file to a DEM: the one place that knows what wins, the user, the sidecar or the file.

use std::path::Path;
use std::sync::Arc;

use terrain_core::Heightmap;

use crate::input::Input;
use crate::part::{self, Window, part};
use crate::raster::{ABSURD, Decoded, Facts, Grid, Heights, Meaning, OnRow};
use crate::resample::resample;
use crate::samples::SampleType;
use crate::sidecar::Sidecar;
use crate::spikes::{self, Census, PLAUSIBLE_M, Spikes};
use crate::voids::{self, VoidMask};
use crate::{Dem, DemError, Georeference, HeightUnit, ReadOptions, Reading, VoidPolicy, formats};

/// A void where none is declared: the lowest int16, which SRTM and its descendants use.
const UNDECLARED: f64 = -32_768.0;

/// A void that many programs write and do not declare. Some place under the sea may be so low.
const SUSPECT: f64 = -9999.0;

/// Reads a DEM as a whole.
pub fn load(input: Input, sidecar: Sidecar, options: &ReadOptions) -> Result<Dem, DemError> {
    let (shown, name) = (input.shown.clone(), name(&input));
    whole(name, input, sidecar, options).map_err(|unread| unread.of(&shown))
}

/// Reads a DEM row by row, if that can be done; and if it still has the columns and rows that it had, where some are given.
pub fn load_rows(
    input: Input,
    sidecar: &Sidecar,
    options: &ReadOptions,
    expected: Option<[u32; 2]>,
    on_row: OnRow,
) -> Result<ByRows, DemError> {
    let (shown, name) = (input.shown.clone(), name(&input));
    let opened = open(input, sidecar, options).map_err(|unread| unread.of(&shown))?;
    if expected.is_some_and(|expected| expected != [opened.facts.columns, opened.facts.rows]) {
        return Ok(ByRows::Refused("it has another size than before".to_owned()));
    }
    by_rows(name, opened, options, on_row).map_err(|unread| unread.of(&shown))
}

/// What came of reading row by row.
pub enum ByRows {
    /// All rows were taken.
    Done(Box<RowsOf>),
    /// Whoever took them had enough.
    Stopped,
    /// It cannot be done, for a reason in words.
    Refused(String),
}

/// A DEM without its heights.
#[derive(Debug)]
pub struct RowsOf {
    pub name: String,
    pub samples: [u32; 2],
    pub spacing_m: [f64; 2],
    pub georeference: Option<Georeference>,
    pub reading: Reading,
}

fn name(input: &Input) -> String {
    Path::new(&input.file_name).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// A reason still lacks the file's name.
pub enum Unread {
    Reason(String),
    Error(DemError),
}

impl Unread {
    pub fn of(self, shown: &str) -> DemError {
        match self {
            Self::Reason(reason) => DemError::input(shown, reason),
            Self::Error(error) => error,
        }
    }
}

impl From<String> for Unread {
    fn from(reason: String) -> Self {
        Self::Reason(reason)
    }
}

impl From<DemError> for Unread {
    fn from(error: DemError) -> Self {
        Self::Error(error)
    }
}

/// A file whose header has been read, and what its samples mean.
pub struct Opened {
    /// `None` once it is decoded.
    grid: Option<Box<dyn Grid>>,
    pub facts: Facts,
    spacing_m: [f64; 2],
    spacing_from: String,
    pub meaning: Meaning,
    /// The part of the file that is kept; the facts are those of this part.
    window: Option<Window>,
}

impl Opened {
    /// What was made of several files.
    pub fn joined(facts: Facts, meaning: Meaning, sidecar: &Sidecar, options: &ReadOptions) -> Result<Self, String> {
        let (spacing_m, spacing_from) = spacing(&facts, sidecar, options)?;
        Ok(Self { grid: None, facts, spacing_m, spacing_from, meaning, window: None })
    }

    /// Tells a part of the file from the whole.
    fn name_of_part(&self, name: String) -> String {
        let (Some(window), Some(grid)) = (self.window, &self.grid) else { return name };
        part::name(&name, window, [grid.facts().columns, grid.facts().rows], 1)
    }

    /// All samples; closes the file.
    pub fn decode(&mut self) -> Result<Decoded, Unread> {
        let mut grid = self.grid.take().expect("a file is decoded once");
        let mut heights = Heights::new(grid.facts(), self.meaning, self.window);
        grid.decode(&mut heights)?;
        Ok(heights.finish())
    }
}

pub fn open(input: Input, sidecar: &Sidecar, options: &ReadOptions) -> Result<Opened, Unread> {
    let grid = formats::open(input, &ReadOptions { raw: options.raw.or(sidecar.raw), ..*options })?;
    let mut facts = grid.facts().clone();
    sidecar.put_place(&mut facts);
    let window = options.crop.map(|crop| crop.window_in([facts.columns, facts.rows])).transpose()?;
    if let Some(window) = window {
        facts.crop(window);
    }
    facts.check_size(options.limit())?;
    check_band(&facts, options)?;
    let (spacing_m, spacing_from) = spacing(&facts, sidecar, options)?;
    let meaning = meaning(&facts, sidecar, options)?;
    if facts.samples.bytes() == 1 && !options.allow_8_bit {
        facts.warnings.push("8 bits a sample: the 256 heights show as steps".to_owned());
    }
    Ok(Opened { grid: Some(grid), facts, spacing_m, spacing_from, meaning, window })
}

fn by_rows(name: String, opened: Opened, options: &ReadOptions, on_row: OnRow) -> Result<ByRows, Unread> {
    let Opened { grid, mut facts, spacing_m, spacing_from, meaning, .. } = opened;
    let mut grid = grid.expect("a file that was just opened");
    if !grid.is_by_rows() {
        return Ok(ByRows::Refused(format!("{} is not in rows from the north", facts.format)));
    }
    check_spacing(spacing_m)?;
    let mut is_asked = false;
    let mut census = Census::default();
    let mut on_row = |row_m: &[f32]| {
        census.add(row_m);
        let flow = on_row(row_m);
        is_asked = flow.is_break();
        flow
    };
    let mut heights = Heights::by_rows(&facts, meaning, &mut on_row);
    grid.decode(&mut heights)?;
    let mut decoded = heights.finish();
    facts.warnings.append(&mut decoded.notes);
    if is_asked {
        return Ok(ByRows::Stopped);
    }
    if decoded.found < facts.count() {
        return Ok(ByRows::Refused("voids are filled from their whole rim".to_owned()));
    }
    if census.has_spikes(decoded.found) {
        return Ok(ByRows::Refused("spikes are told from mountains by all heights".to_owned()));
    }
    warn_of_range(&mut facts.warnings, meaning, decoded.range_m);
    let samples = [facts.columns, facts.rows];
    let georeference = facts.georeference(spacing_m);
    let reading = reading(facts, meaning, spacing_from, options);
    Ok(ByRows::Done(Box::new(RowsOf { name, samples, spacing_m, georeference, reading })))
}

/// As a heightmap would.
fn check_spacing(spacing_m: [f64; 2]) -> Result<(), String> {
    Heightmap::new(2, 2, spacing_m, vec![0.0; 4]).map(drop).map_err(|e| e.to_string())
}

fn whole(name: String, input: Input, sidecar: Sidecar, options: &ReadOptions) -> Result<Dem, Unread> {
    let mut opened = open(input, &sidecar, options)?;
    let name = opened.name_of_part(name);
    let decoded = opened.decode()?;
    finish(name, opened, decoded, sidecar, &ReadOptions { crop: None, ..*options })
}

/// From samples to a DEM: voids, range, the part that is asked for.
pub fn finish(
    name: String,
    opened: Opened,
    mut decoded: Decoded,
    sidecar: Sidecar,
    options: &ReadOptions,
) -> Result<Dem, Unread> {
    let Opened { mut facts, spacing_m, spacing_from, meaning, .. } = opened;
    facts.warnings.append(&mut decoded.notes);
    let spikes = spikes::strike(&mut decoded.heights_m, decoded.found, decoded.range_m);
    if let Some(spikes) = &spikes {
        decoded = decoded.without(spikes);
    }
    let range_m = decoded.range_m;
    let (heights_m, mask) = settle_voids(&mut facts, meaning, decoded, spikes, options.voids)?;
    warn_of_range(&mut facts.warnings, meaning, range_m);

    let size @ [columns, rows] = [facts.columns, facts.rows];
    // What has a height is finite; the mean of two may not be.
    let heightmap = match mask {
        None => Heightmap::of_finite(size, spacing_m, heights_m),
        Some(_) => Heightmap::new(columns, rows, spacing_m, heights_m),
    };
    let heightmap = heightmap.map_err(|e| e.to_string())?;
    let georeference = facts.georeference(spacing_m);
    let reading = reading(facts, meaning, spacing_from, options);
    let Sidecar { source, licence, notice, .. } = sidecar;
    let (heightmap, voids) = (Arc::new(heightmap), mask.map(Arc::new));
    let whole = Dem { name, heightmap, source, licence, notice, voids, georeference, reading };
    let part = part(whole, options.crop, options.thin.unwrap_or(1))?;
    Ok(with_holes(resample(part, options.resample_m)?, options.voids))
}

/// Tells the heightmap which of its samples are voids, unless the fill counts. Comes last: every step before has a heightmap
/// of its own.
fn with_holes(dem: Dem, policy: VoidPolicy) -> Dem {
    let Some(voids) = dem.voids.clone().filter(|_| policy == VoidPolicy::Hole) else { return dem };
    let heightmap = Arc::unwrap_or_clone(dem.heightmap).with_voids(voids).expect("the mask is that of the same grid");
    Dem { heightmap: Arc::new(heightmap), ..dem }
}

fn check_band(facts: &Facts, options: &ReadOptions) -> Result<(), String> {
    let (band, bands) = (options.band.unwrap_or(1), facts.bands);
    (1..=bands).contains(&band).then_some(()).ok_or_else(|| format!("no band {band}; expected 1 to {bands}"))
}

fn reading(facts: Facts, meaning: Meaning, spacing_from: String, options: &ReadOptions) -> Reading {
    Reading {
        format: facts.format,
        samples: facts.samples.name(),
        bands: facts.bands,
        spacing_from,
        crs: facts.crs,
        unit: options.unit.or(facts.unit),
        scale: meaning.scale,
        offset_m: meaning.offset_m,
        nodata: meaning.nodata,
        warnings: facts.warnings,
    }
}

/// Metres between samples, and who says so.
fn spacing(facts: &Facts, sidecar: &Sidecar, options: &ReadOptions) -> Result<([f64; 2], String), String> {
    if let Some(spacing_m) = options.spacing_m {
        return Ok((spacing_m, "--spacing".to_owned()));
    }
    if let Some(spacing_m) = sidecar.spacing_m {
        return Ok((spacing_m, "the sidecar".to_owned()));
    }
    match facts.spacing {
        Some(spacing) => Ok((spacing.metres()?, format!("the file: {}", spacing.describe()))),
        None => {
            let reason = facts.no_spacing.as_deref().unwrap_or(
                "no spacing; expected `spacing_m = [30.0, 30.0]` (metres) in a file of the same name that ends in .toml, \
                 or --spacing 30",
            );
            Err(reason.to_owned())
        }
    }
}

/// A scale by the user or the sidecar is in metres a step, so that the file's own unit is none of its business.
fn meaning(facts: &Facts, sidecar: &Sidecar, options: &ReadOptions) -> Result<Meaning, String> {
    let metres = options.unit.or(facts.unit).unwrap_or(HeightUnit::Metre).metres();
    let asked_metres = options.unit.map_or(1.0, HeightUnit::metres);
    let scale = match options.scale.or(sidecar.scale) {
        Some(scale) => scale * asked_metres,
        None => facts.scale.unwrap_or(1.0) * metres,
    };
    let offset_m = options.offset_m.or(sidecar.offset_m).unwrap_or(facts.offset.unwrap_or(0.0) * metres);
    if !scale.is_finite() || !offset_m.is_finite() {
        return Err(format!("scale {scale}, offset {offset_m}: expected two finite numbers"));
    }
    let nodata = options.nodata.or(sidecar.nodata).map(|nodata| facts.samples.rounded(nodata)).or(facts.nodata);
    // A scaled number may well be -32768.
    let can_be_void = facts.samples == SampleType::I16 || facts.samples.is_float() && scale == 1.0;
    let undeclared = Some(UNDECLARED).filter(|void| can_be_void && nodata != Some(*void));
    Ok(Meaning { scale, offset_m, nodata, undeclared })
}

/// Finds the voids, and fills or refuses them. Holes are filled, too: meshes pass through the fill.
fn settle_voids(
    facts: &mut Facts,
    meaning: Meaning,
    decoded: Decoded,
    spikes: Option<Spikes>,
    policy: VoidPolicy,
) -> Result<(Vec<f32>, Option<VoidMask>), String> {
    let Decoded { mut heights_m, found, absurd, undeclared, gaps, .. } = decoded;
    let all = facts.count();
    if found == all {
        return Ok((heights_m, None));
    }
    if found == 0 {
        return Err(format!("none of its {all} samples has a height; expected some: mend --nodata, or fetch it again"));
    }
    let (mask, count) = (VoidMask::of(facts.columns, &heights_m), all - found);
    let mut found = count_voids(count, all);
    if gaps > 0 {
        found += &format!(", {gaps} of them between the tiles");
    }
    if undeclared > 0 {
        found += &format!(", {undeclared} of them {UNDECLARED}, which the file does not declare");
    }
    if absurd > 0 && !meaning.nodata.is_some_and(f64::is_nan) {
        found += &format!(", {absurd} of them NaN, infinite or beyond {ABSURD:e}");
    }
    if let Some(Spikes { count, height_m, index }) = spikes {
        let columns = facts.columns as usize;
        let (column, row) = (index % columns, index / columns);
        found += &format!(", {count} of them spikes, such as {height_m} m at column {column}, row {row}");
    }
    facts.warnings.push(policy.apply(&found)?);
    voids::fill(&mask, facts.rows, &mut heights_m);
    Ok((heights_m, Some(mask)))
}

/// How many there are and what share that is, as every message about them begins.
pub fn count_voids(count: u64, all: u64) -> String {
    format!("{count} of {all} samples ({:.3} %) are voids", count as f64 / all as f64 * 100.0)
}

fn warn_of_range(warnings: &mut Vec<String>, meaning: Meaning, [low, high]: [f32; 2]) {
    let suspect_m = (SUSPECT * meaning.scale + meaning.offset_m) as f32;
    if low == suspect_m {
        warnings.push(format!("the lowest samples are {SUSPECT}: if these are voids, say --nodata {SUSPECT}"));
    } else if !PLAUSIBLE_M.contains(&low) || !PLAUSIBLE_M.contains(&high) {
        warnings.push(format!(
            "heights of {low} to {high} m are not of this planet: --nodata, --unit or --scale may mend them"
        ));
    }
}
