//! From a file to a DEM: the one place that knows what wins, the user, the sidecar or the file.

use std::path::Path;
use std::sync::Arc;

use terrain_core::Heightmap;

use crate::input::Input;
use crate::part::part;
use crate::raster::{ABSURD, Decoded, Facts, Grid, Heights, Meaning, OnRow};
use crate::samples::SampleType;
use crate::sidecar::Sidecar;
use crate::voids::{self, VoidMask};
use crate::{Dem, DemError, HeightUnit, ReadOptions, Reading, VoidPolicy, formats};

/// A void where none is declared: the lowest int16, which SRTM and its descendants use.
const UNDECLARED: f64 = -32_768.0;

/// A void that many programs write and do not declare. Some place under the sea may be so low.
const SUSPECT: f64 = -9999.0;

/// The deepest and highest places of this planet, with some room, in metres.
const PLAUSIBLE_M: std::ops::RangeInclusive<f32> = -11_500.0..=9_500.0;

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
    pub reading: Reading,
}

fn name(input: &Input) -> String {
    Path::new(&input.file_name).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// A reason still lacks the file's name.
enum Unread {
    Reason(String),
    Error(DemError),
}

impl Unread {
    fn of(self, shown: &str) -> DemError {
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
struct Opened {
    grid: Box<dyn Grid>,
    facts: Facts,
    spacing_m: [f64; 2],
    spacing_from: String,
    meaning: Meaning,
}

fn open(input: Input, sidecar: &Sidecar, options: &ReadOptions) -> Result<Opened, Unread> {
    let grid = formats::open(input, options)?;
    let mut facts = grid.facts().clone();
    facts.check_size(options.limit())?;
    check_band(&facts, options)?;
    let (spacing_m, spacing_from) = spacing(&facts, sidecar, options)?;
    let meaning = meaning(&facts, sidecar, options)?;
    if facts.samples.bytes() == 1 && !options.allow_8_bit {
        facts.warnings.push("8 bits a sample: the 256 heights show as steps".to_owned());
    }
    Ok(Opened { grid, facts, spacing_m, spacing_from, meaning })
}

fn by_rows(name: String, opened: Opened, options: &ReadOptions, on_row: OnRow) -> Result<ByRows, Unread> {
    let Opened { mut grid, mut facts, spacing_m, spacing_from, meaning } = opened;
    if !grid.is_by_rows() {
        return Ok(ByRows::Refused(format!("{} is not in rows from the north", facts.format)));
    }
    check_spacing(spacing_m)?;
    let mut is_asked = false;
    let mut on_row = |row_m: &[f32]| {
        let flow = on_row(row_m);
        is_asked = flow.is_break();
        flow
    };
    let mut heights = Heights::by_rows(&facts, meaning, &mut on_row);
    grid.decode(&mut heights)?;
    let decoded = heights.finish();
    if is_asked {
        return Ok(ByRows::Stopped);
    }
    if decoded.found < facts.count() {
        return Ok(ByRows::Refused("voids are filled from their whole rim".to_owned()));
    }
    warn_of_range(&mut facts.warnings, meaning, decoded.range_m);
    let samples = [facts.columns, facts.rows];
    let reading = reading(facts, meaning, spacing_from, options);
    Ok(ByRows::Done(Box::new(RowsOf { name, samples, spacing_m, reading })))
}

/// As a heightmap would.
fn check_spacing(spacing_m: [f64; 2]) -> Result<(), String> {
    Heightmap::new(2, 2, spacing_m, vec![0.0; 4]).map(drop).map_err(|e| e.to_string())
}

fn whole(name: String, input: Input, sidecar: Sidecar, options: &ReadOptions) -> Result<Dem, Unread> {
    let Opened { mut grid, mut facts, spacing_m, spacing_from, meaning } = open(input, &sidecar, options)?;
    let mut heights = Heights::new(&facts, meaning);
    grid.decode(&mut heights)?;
    drop(grid);
    let decoded = heights.finish();
    let range_m = decoded.range_m;
    let (heights_m, mask) = settle_voids(&mut facts, meaning, decoded, options.voids)?;
    warn_of_range(&mut facts.warnings, meaning, range_m);

    let heightmap = Heightmap::new(facts.columns, facts.rows, spacing_m, heights_m).map_err(|e| e.to_string())?;
    let reading = reading(facts, meaning, spacing_from, options);
    let Sidecar { source, licence, notice, .. } = sidecar;
    let (heightmap, voids) = (Arc::new(heightmap), mask.map(Arc::new));
    let whole = Dem { name, heightmap, source, licence, notice, voids, reading };
    Ok(with_holes(part(whole, options.crop, options.thin.unwrap_or(1))?, options.voids))
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
    let nodata = options.nodata.map(|nodata| facts.samples.rounded(nodata)).or(facts.nodata);
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
    policy: VoidPolicy,
) -> Result<(Vec<f32>, Option<VoidMask>), String> {
    let Decoded { mut heights_m, found, absurd, undeclared, .. } = decoded;
    let all = facts.count();
    if found == all {
        return Ok((heights_m, None));
    }
    if found == 0 {
        return Err(format!("none of its {all} samples has a height; expected some: mend --nodata, or fetch it again"));
    }
    let (mask, count) = (VoidMask::of(facts.columns, &heights_m), all - found);
    let mut found = format!("{count} of {all} samples ({:.3} %) are voids", count as f64 / all as f64 * 100.0);
    if undeclared > 0 {
        found += &format!(", {undeclared} of them {UNDECLARED}, which the file does not declare");
    }
    if absurd > 0 && !meaning.nodata.is_some_and(f64::is_nan) {
        found += &format!(", {absurd} of them NaN, infinite or beyond {ABSURD:e}");
    }
    if policy == VoidPolicy::Error {
        return Err(format!("{found}; expected none, or --voids hole or fill"));
    }
    let what_becomes = match policy {
        VoidPolicy::Hole => "left open (--voids fill fills them from their rim)",
        _ => "filled from their rim",
    };
    facts.warnings.push(format!("{found}: {what_becomes}"));
    voids::fill(&mask, facts.rows, &mut heights_m);
    Ok((heights_m, Some(mask)))
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
