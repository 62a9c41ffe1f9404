//! What every decoder fills: a grid of heights, and what the file says of itself.

use std::ops::{ControlFlow, Range};

use terrain_core::Heightmap;

use crate::extremes::{self, Extremes};
use crate::georef::{GeoKeys, Georeference, Place, Spacing};
use crate::part::Window;
use crate::samples::SampleType;
use crate::spikes::Spikes;
use crate::{DemError, HeightUnit};

/// A file whose header has been read and found to agree with its length.
pub trait Grid {
    /// What the header says.
    fn facts(&self) -> &Facts;

    /// Puts all samples, each once and in any order. Samples that are never put are voids. May end early once
    /// [`Heights::is_stopped`].
    fn decode(&mut self, heights: &mut Heights) -> Result<(), DemError>;

    /// Whether whole rows are put, the northern one first, in little memory.
    fn is_by_rows(&self) -> bool {
        false
    }
}

/// What a file says of itself. `None` where it is silent.
#[derive(Clone, Debug)]
pub struct Facts {
    /// In words: `GeoTIFF, tiles of 256 x 256, LZW`.
    pub format: String,
    pub columns: u32,
    pub rows: u32,
    pub samples: SampleType,
    /// Samples at one place, of which one band is read.
    pub bands: u32,
    pub spacing: Option<Spacing>,
    pub place: Option<Place>,
    /// The coordinate system of the place, where it is known beyond its name.
    pub keys: Option<GeoKeys>,
    /// Why there is no spacing, if more can be said than that.
    pub no_spacing: Option<String>,
    /// The southern row comes first, so that the decoder's rows are turned.
    pub south_up: bool,
    /// Units a step of the file's values.
    pub scale: Option<f64>,
    /// Units at the value 0.
    pub offset: Option<f64>,
    pub unit: Option<HeightUnit>,
    /// The value that stands for no height.
    pub nodata: Option<f64>,
    /// Coordinate system in words.
    pub crs: Option<String>,
    /// What the user should know, one line each.
    pub warnings: Vec<String>,
}

impl Facts {
    /// A grid of which no more is known.
    pub fn new(format: impl Into<String>, columns: u32, rows: u32, samples: SampleType) -> Self {
        Self {
            format: format.into(),
            columns,
            rows,
            samples,
            bands: 1,
            spacing: None,
            place: None,
            keys: None,
            no_spacing: None,
            south_up: false,
            scale: None,
            offset: None,
            unit: None,
            nodata: None,
            crs: None,
            warnings: Vec::new(),
        }
    }

    /// From those of the file to those of a part of it.
    pub fn crop(&mut self, window: Window) {
        [self.columns, self.rows] = window.size;
        self.place = self.place.map(|place| place.part(window.first, 1));
    }

    pub fn count(&self) -> u64 {
        self.columns as u64 * self.rows as u64
    }

    /// Where the grid lies, if its spacing is the file's own: whoever says another one does not trust the place either.
    /// Metres without a system are those of a map that nobody else knows; degrees would be of any earth.
    pub fn georeference(&self, spacing_m: [f64; 2]) -> Option<Georeference> {
        let (place, own_m) = (self.place?, self.spacing?.metres().ok()?);
        // The metres of a degree are those at the middle of the DEM that this may be a part of.
        let is_near = |axis: usize| (0.8..1.25).contains(&(own_m[axis] / spacing_m[axis]));
        if !is_near(0) || !is_near(1) {
            return None;
        }
        let is_metres = self.spacing == Some(Spacing::Metres(place.step));
        let keys = self.keys.clone().or_else(|| is_metres.then(GeoKeys::metres))?;
        Some(Georeference { place, keys })
    }

    /// Whether a heightmap can have this size and `max_samples` allow it.
    pub fn check_size(&self, max_samples: u64) -> Result<(), String> {
        let side = 2..=Heightmap::MAX_SIDE;
        if side.contains(&self.columns) && side.contains(&self.rows) && self.count() <= max_samples {
            return Ok(());
        }
        let (columns, rows, max_side) = (self.columns, self.rows, Heightmap::MAX_SIDE);
        Err(format!(
            "{columns} x {rows} samples; expected 2 to {max_side} a side and at most {max_samples} in all: crop it"
        ))
    }
}

/// How the file's values become metres, and which of them are voids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meaning {
    /// Metres a step.
    pub scale: f64,
    /// Metres at the value 0.
    pub offset_m: f64,
    /// The void that the file or the user declares.
    pub nodata: Option<f64>,
    /// A value that is a void although nobody declares it.
    pub undeclared: Option<f64>,
}

/// Values this far from 0 are leftovers of a void (such as -3.4e38), whatever their unit.
pub const ABSURD: f64 = 1e30;

/// As [`Meaning`], with NaN for what is not there: no value equals it, and that is all a comparison needs.
struct Rule {
    scale: f64,
    offset_m: f64,
    is_plain: bool,
    nodata: f64,
    undeclared: f64,
}

impl Rule {
    fn of(meaning: Meaning) -> Self {
        let Meaning { scale, offset_m, nodata, undeclared } = meaning;
        // The sum would lose the sign of -0.
        let is_plain = scale == 1.0 && offset_m == 0.0;
        Self {
            scale,
            offset_m,
            is_plain,
            nodata: nodata.unwrap_or(f64::NAN),
            undeclared: undeclared.unwrap_or(f64::NAN),
        }
    }

    /// NaN at voids. Without a branch, so that a row goes through vector instructions.
    fn height_m(&self, value: f64) -> f32 {
        let height_m = if self.is_plain { value } else { value * self.scale + self.offset_m } as f32;
        // A scale can carry a finite value beyond f32.
        let is_absurd = value.is_nan() | (value.abs() >= ABSURD) | !height_m.is_finite();
        if (value == self.nodata) | (value == self.undeclared) | is_absurd { f32::NAN } else { height_m }
    }

    /// Whether all of some floats are heights as they stand. One next to a void of more digits may count as none: whoever
    /// then asks [`Self::height_m`] is told.
    fn keeps(&self, values: &[f32], extremes: &Extremes) -> bool {
        let [low, high] = extremes.range_m();
        let are_heights = !extremes.has_nan() && low > -ABSURD as f32 && high < ABSURD as f32;
        let voids = [self.nodata, self.undeclared].map(|void| void as f32);
        // Most are out of the range.
        let is_none = |void: f32| !(low..=high).contains(&void) || !values.contains(&void);
        self.is_plain && are_heights && voids.into_iter().all(is_none)
    }
}

/// A range that holds another one, too.
fn widened([low, high]: [f32; 2], [lower, higher]: [f32; 2]) -> [f32; 2] {
    [low.min(lower), high.max(higher)]
}

/// What takes the rows of a DEM one by one, and says when it has enough.
pub type OnRow<'a> = &'a mut dyn FnMut(&[f32]) -> ControlFlow<()>;

/// The heights in metres as they are decoded; NaN at voids.
pub struct Heights<'a> {
    columns: u32,
    rows: u32,
    /// The part that is kept; all of it without.
    window: Option<Window>,
    south_up: bool,
    rule: Rule,
    /// All of them, or those of one row: as far as they have been put, so that memory is first touched by a height.
    heights_m: Vec<f32>,
    /// How many they become.
    kept: usize,
    /// Takes each row, if they are not kept.
    on_row: Option<OnRow<'a>>,
    is_stopped: bool,
    found: u64,
    range_m: [f32; 2],
    /// Voids of these two kinds; the others are declared.
    absurd: u64,
    undeclared: u64,
    notes: Vec<String>,
}

/// The heights in metres, NaN at voids, and what the voids were.
#[derive(Debug)]
pub struct Decoded {
    pub heights_m: Vec<f32>,
    /// Samples that have a height.
    pub found: u64,
    /// The lowest and the highest of them.
    pub range_m: [f32; 2],
    /// NaN, infinities, and values beyond [`ABSURD`].
    pub absurd: u64,
    /// Samples of the value [`Meaning::undeclared`].
    pub undeclared: u64,
    /// Samples that lie between tiles.
    pub gaps: u64,
    /// What the decoder found on its way, for the user.
    pub notes: Vec<String>,
}

impl Decoded {
    /// Heights with NaN at voids of which no more is known.
    pub fn of(heights_m: Vec<f32>) -> Self {
        let range_m = extremes::range_m(&heights_m);
        let found = heights_m.iter().filter(|height_m| !height_m.is_nan()).count() as u64;
        Self { heights_m, found, range_m, absurd: 0, undeclared: 0, gaps: 0, notes: Vec::new() }
    }

    /// Once spikes have become voids.
    pub fn without(self, spikes: &Spikes) -> Self {
        let Self { absurd, undeclared, gaps, notes, .. } = self;
        let rest = Self { absurd, undeclared, gaps, notes, ..Self::of(self.heights_m) };
        debug_assert_eq!(rest.found + spikes.count, self.found);
        rest
    }
}

impl<'a> Heights<'a> {
    pub fn new(facts: &Facts, meaning: Meaning, window: Option<Window>) -> Self {
        let [columns, rows] = window.map_or([facts.columns, facts.rows], |window| window.size);
        Self { window, ..Self::with(facts, meaning, columns as u64 * rows as u64, None) }
    }

    /// Keeps no more than a row; for a grid that [`is_by_rows`](Grid::is_by_rows). Stops at the first void.
    pub fn by_rows(facts: &Facts, meaning: Meaning, on_row: OnRow<'a>) -> Self {
        Self::with(facts, meaning, facts.columns as u64, Some(on_row))
    }

    fn with(facts: &Facts, meaning: Meaning, kept: u64, on_row: Option<OnRow<'a>>) -> Self {
        let Facts { columns, rows, south_up, .. } = *facts;
        Self {
            columns,
            rows,
            window: None,
            south_up,
            rule: Rule::of(meaning),
            heights_m: Vec::with_capacity(kept as usize),
            kept: kept as usize,
            on_row,
            is_stopped: false,
            found: 0,
            range_m: [f32::INFINITY, f32::NEG_INFINITY],
            absurd: 0,
            undeclared: 0,
            notes: Vec::new(),
        }
    }

    /// What the user should know of the samples.
    pub fn note(&mut self, note: String) {
        self.notes.push(note);
    }

    /// Whether nobody wants more rows.
    pub fn is_stopped(&self) -> bool {
        self.is_stopped
    }

    /// Puts values into a row of the file, from a column on; what is over at its end is dropped.
    pub fn put(&mut self, row: u32, column: u32, values: impl Iterator<Item = f64>) {
        if self.on_row.is_none() {
            let row = if self.south_up { self.rows - 1 - row } else { row };
            return match self.window {
                None => self.put_at(row as usize * self.columns as usize, self.columns, column, values),
                Some(window) => self.put_within(window, row, column, values),
            };
        }
        // A row that was left out, or one with a void in it, is for whoever fills voids.
        let before = row as u64 * self.columns as u64;
        self.is_stopped |= self.found != before;
        if !self.is_stopped {
            self.put_at(0, self.columns, column, values);
            self.is_stopped = self.found != before + self.columns as u64 || self.hand_on().is_break();
        }
    }

    fn hand_on(&mut self) -> ControlFlow<()> {
        self.on_row.as_mut().map_or(ControlFlow::Continue(()), |on_row| on_row(&self.heights_m))
    }

    /// What of a row, which counts from the north, lies in the window.
    fn put_within(&mut self, window: Window, row: u32, column: u32, values: impl Iterator<Item = f64>) {
        let Window { first: [first, first_row], size: [columns, rows] } = window;
        let Some(row) = row.checked_sub(first_row).filter(|row| *row < rows) else { return };
        let before = first.saturating_sub(column);
        let at = (column + before - first).min(columns);
        self.put_at(row as usize * columns as usize, columns, at, values.skip(before as usize));
    }

    /// Whether a part is kept, so that rows are better looked for than read through.
    pub fn is_part(&self) -> bool {
        self.window.is_some()
    }

    /// Whether any sample of some rows and columns of the file is kept.
    pub fn wants(&self, rows: Range<u32>, columns: Range<u32>) -> bool {
        let Some(Window { first, size }) = self.window else { return true };
        let rows = if self.south_up { self.rows - rows.end..self.rows - rows.start } else { rows };
        let overlaps =
            |range: Range<u32>, axis: usize| range.start < first[axis] + size[axis] && range.end > first[axis];
        overlaps(columns, 0) && overlaps(rows, 1)
    }

    /// Puts floats into a row of the file, from a column on: as [`Self::put`], and much sooner where all are heights as they
    /// stand.
    pub fn put_floats(&mut self, row: u32, column: u32, floats: &[[u8; 4]]) {
        if !self.are_rows_as_filed() {
            return self.put(row, column, floats.iter().map(|float| f32::from_le_bytes(*float) as f64));
        }
        let start = row as usize * self.columns as usize;
        let target = room(&mut self.heights_m, start, self.columns, column);
        target.iter_mut().zip(floats).for_each(|(target, float)| *target = f32::from_le_bytes(*float));
        let count = floats.len().min(target.len());
        self.judge(start, column, count);
    }

    /// Whole rows of the file to be filled with floats, where they are kept as they stand there; then
    /// [`Self::judge_rows`] must have them.
    pub fn rows_to_fill(&mut self, rows: Range<u32>) -> Option<&mut [f32]> {
        let [start, end] = [rows.start, rows.end].map(|row| row as usize * self.columns as usize);
        self.are_rows_as_filed().then(|| {
            if self.heights_m.len() < end {
                self.heights_m.resize(start.max(self.heights_m.len()), f32::NAN);
                self.heights_m.resize(end, 0.0);
            }
            &mut self.heights_m[start..end]
        })
    }

    /// Finds the voids in rows that were filled.
    pub fn judge_rows(&mut self, rows: Range<u32>) {
        rows.for_each(|row| self.judge(row as usize * self.columns as usize, 0, self.columns as usize));
    }

    fn are_rows_as_filed(&self) -> bool {
        self.window.is_none() && self.on_row.is_none() && !self.south_up
    }

    /// Finds the voids among so many values of the row that begins at `start`, from a column on.
    fn judge(&mut self, start: usize, column: u32, count: usize) {
        let values = &self.heights_m[start + column as usize..][..count];
        let extremes = Extremes::of(values);
        if self.rule.keeps(values, &extremes) {
            self.range_m = widened(self.range_m, extremes.range_m());
            self.found += count as u64;
        } else {
            let values = values.to_vec();
            self.put_at(start, self.columns, column, values.into_iter().map(f64::from));
        }
    }

    /// Into the row of `columns` that begins at `start`.
    fn put_at(&mut self, start: usize, columns: u32, column: u32, values: impl Iterator<Item = f64>) {
        let target = room(&mut self.heights_m, start, columns, column);
        let [mut all, mut found, mut declared, mut undeclared] = [0u32; 4];
        for (target, value) in target.iter_mut().zip(values) {
            let height_m = self.rule.height_m(value);
            *target = height_m;
            all += 1;
            found += u32::from(!height_m.is_nan());
            declared += u32::from(value == self.rule.nodata);
            undeclared += u32::from(value == self.rule.undeclared);
        }
        self.range_m = widened(self.range_m, extremes::range_m(&target[..all as usize]));
        self.found += u64::from(found);
        self.undeclared += u64::from(undeclared);
        self.absurd += u64::from(all - found - declared - undeclared);
    }

    pub fn finish(self) -> Decoded {
        let Self { mut heights_m, kept, found, range_m, absurd, undeclared, notes, .. } = self;
        heights_m.resize(kept, f32::NAN);
        Decoded { heights_m, found, range_m, absurd, undeclared, gaps: 0, notes }
    }
}

/// The rest of the row of `columns` that begins at `start`, from a column on. What lies before it and was never put is void.
fn room(heights_m: &mut Vec<f32>, start: usize, columns: u32, column: u32) -> &mut [f32] {
    let end = start + columns as usize;
    if heights_m.len() < end {
        heights_m.resize(end, f32::NAN);
    }
    &mut heights_m[start + column as usize..end]
}
