//! USGS ASCII DEM (`.dem`; USGS, "Standards for Digital Elevation Models", part 2): blocks of 1024 letters, the first one
//! the header (record A), then a profile (record B) a column, the western one first, each from south to north. Those of a
//! quadrangle in UTM begin and end at rows of their own.

use crate::DemError;
use crate::HeightUnit;
use crate::formats::{convert, words};
use crate::georef::{Place, Spacing};
use crate::input::Input;
use crate::raster::{Facts, Grid, Heights};
use crate::samples::SampleType;

const BLOCK: u64 = 1024;

/// Heights in a profile's first block, after its own header, and in those that follow.
const FIRST: usize = 146;
const NEXT: usize = 170;
const PROFILE_HEADER: usize = 144;

/// Letters of a whole number, and of one with an exponent.
const WHOLE: usize = 6;
const DOUBLE: usize = 24;

const NODATA: f64 = -32_767.0;

/// How far a profile may lie beside the grid's lines, in samples.
const MOST_OFF: f64 = 0.05;

struct Profile {
    /// In bytes.
    at: u64,
    heights: u32,
    /// Of its southern sample.
    x: f64,
    y: f64,
    datum: f64,
}

pub struct UsgsGrid {
    input: Input,
    facts: Facts,
    profiles: Vec<Profile>,
    /// Units of height a step.
    resolution: f64,
    south: f64,
    step: f64,
}

/// By the pattern of the grid (regular) and the kind of its coordinates.
pub fn is_one(input: &Input) -> bool {
    let start = &input.start;
    let [pattern, system] = [150, 156].map(|at| start.get(at..at + WHOLE).and_then(|word| whole(word, 0)));
    start.is_ascii()
        && start.len() > 168
        && pattern == Some(1)
        && system.is_some_and(|system| (0..=2).contains(&system))
}

fn text(bytes: &[u8], at: usize, length: usize) -> Option<&str> {
    std::str::from_utf8(bytes.get(at..at + length)?).ok().map(str::trim)
}

fn whole(bytes: &[u8], at: usize) -> Option<i64> {
    text(bytes, at, WHOLE)?.parse().ok()
}

/// Fortran writes `0.1D+02`.
fn double(bytes: &[u8], at: usize, length: usize) -> Option<f64> {
    words::number(&text(bytes, at, length)?.replace(['D', 'd'], "E")).filter(|number| number.is_finite())
}

pub fn open(mut input: Input) -> Result<UsgsGrid, DemError> {
    let record = input.bytes_at(0, BLOCK)?;
    let Some(header) = Header::parse(&record) else {
        let remedy = convert(&input.shown);
        return Err(
            input.refuse(format!("a USGS DEM with a broken header; expected units, steps and counts: {remedy}"))
        );
    };
    let profiles = profiles(&mut input, &header)?;
    let [x, z] = header.step;
    let end = |profile: &Profile| profile.y + profile.heights.saturating_sub(1) as f64 * z;
    let south = profiles.iter().map(|profile| profile.y).fold(f64::INFINITY, f64::min);
    let north = profiles.iter().map(end).fold(f64::NEG_INFINITY, f64::max);
    let west = profiles[0].x;
    let is_off = |number: f64| (number - number.round()).abs() > MOST_OFF;
    let beside = profiles.iter().zip(0..).any(|(profile, column)| {
        ((profile.x - west) / x - f64::from(column)).abs() > MOST_OFF || is_off((profile.y - south) / z)
    });
    if beside {
        let remedy = convert(&input.shown);
        return Err(input.refuse(format!("a USGS DEM whose profiles do not lie in a grid; expected one: {remedy}")));
    }
    let rows = ((north - south) / z).round() + 1.0;
    // What is beyond any size saturates, and is refused for it.
    let mut facts = Facts::new("USGS ASCII DEM", profiles.len() as u32, rows as u32, SampleType::Text);
    (facts.unit, facts.nodata) = (Some(header.unit), Some(NODATA));
    let (units, middle) = (header.metres, (north + south) / 2.0);
    facts.crs = header.crs;
    match units {
        Some(metres) => facts.spacing = Some(Spacing::Metres([x * metres, z * metres])),
        // Arc-seconds.
        None => {
            let [degrees, latitude] = [[x, z].map(|second| second / 3600.0), [middle / 3600.0; 2]];
            facts.spacing = Some(Spacing::Degrees { degrees, latitude: latitude[0] });
        }
    }
    let each = if units.is_none() { 3600.0 } else { 1.0 };
    facts.place = Some(Place { west: west / each, north: north / each, step: [x / each, z / each] });
    Ok(UsgsGrid { input, facts, profiles, resolution: header.resolution, south, step: z })
}

/// What record A says.
struct Header {
    /// In a unit of the map; `None` for arc-seconds.
    metres: Option<f64>,
    unit: HeightUnit,
    step: [f64; 2],
    /// Units of height a step of the numbers.
    resolution: f64,
    columns: u32,
    crs: Option<String>,
}

impl Header {
    fn parse(record: &[u8]) -> Option<Self> {
        let metres = match whole(record, 528)? {
            1 => Some(HeightUnit::Foot.metres()),
            2 => Some(1.0),
            3 => None,
            _ => return None,
        };
        let unit = match whole(record, 534)? {
            1 => HeightUnit::Foot,
            2 => HeightUnit::Metre,
            _ => return None,
        };
        let [x, z, resolution] = [816, 828, 840].map(|at| double(record, at, 12).filter(|step| *step > 0.0));
        let crs = match whole(record, 156)? {
            0 => Some("geographic".to_owned()),
            1 => Some(format!("UTM zone {}", whole(record, 162)?)),
            _ => Some(format!("state plane zone {}", whole(record, 162)?)),
        };
        let columns = u32::try_from(whole(record, 858)?).ok().filter(|columns| *columns > 0)?;
        Some(Self { metres, unit, step: [x?, z?], resolution: resolution?, columns, crs })
    }
}

/// Where the profiles are, by the header of each.
fn profiles(input: &mut Input, header: &Header) -> Result<Vec<Profile>, DemError> {
    let mut profiles = Vec::new();
    let mut at = BLOCK;
    for column in 0..header.columns {
        let bytes = input.bytes_at(at, PROFILE_HEADER as u64)?;
        let heights = whole(&bytes, 2 * WHOLE).and_then(|heights| u32::try_from(heights).ok());
        let doubles = [24, 48, 72].map(|at| double(&bytes, at, DOUBLE));
        let (Some(heights @ 1..), [Some(x), Some(y), Some(datum)]) = (heights, doubles) else {
            let remedy = convert(&input.shown);
            let reason =
                format!("a USGS DEM whose profile {column} is broken; expected blocks of 1024 letters: {remedy}");
            return Err(input.refuse(reason));
        };
        profiles.push(Profile { at, heights, x, y, datum });
        at += BLOCK * (1 + (heights as u64).saturating_sub(FIRST as u64).div_ceil(NEXT as u64));
    }
    Ok(profiles)
}

impl Grid for UsgsGrid {
    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn decode(&mut self, heights: &mut Heights) -> Result<(), DemError> {
        for column in 0..self.profiles.len() {
            let profile = &self.profiles[column];
            let first = ((profile.y - self.south) / self.step).round() as u32;
            let (count, datum) = (profile.heights as usize, profile.datum);
            let found = read_profile(&mut self.input, profile.at, count)?;
            for (i, value) in (0..).zip(found) {
                let height = if value == NODATA { NODATA } else { value * self.resolution + datum };
                heights.put(self.facts.rows - 1 - first - i, column as u32, std::iter::once(height));
            }
        }
        Ok(())
    }
}

fn read_profile(input: &mut Input, at: u64, count: usize) -> Result<Vec<f64>, DemError> {
    let (mut values, mut block) = (Vec::new(), 0);
    while values.len() < count {
        let (skipped, most) = if block == 0 { (PROFILE_HEADER, FIRST) } else { (0, NEXT) };
        let here = most.min(count - values.len());
        let bytes = input.bytes_at(at + block * BLOCK + skipped as u64, (here * WHOLE) as u64)?;
        for i in 0..here {
            let Some(value) = whole(&bytes, i * WHOLE) else {
                let found = bytes[i * WHOLE..(i + 1) * WHOLE].escape_ascii();
                return Err(
                    input.refuse(format!("a USGS DEM with a height \"{found}\"; expected a number: fetch it again"))
                );
            };
            values.push(value as f64);
        }
        block += 1;
    }
    Ok(values)
}
