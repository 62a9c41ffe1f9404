//! What a TIFF says of its place and its numbers: GeoTIFF keys (OGC 19-008r4) and GDAL's own tags.

use crate::georef::{GeoKeys, Place, Spacing};
use crate::input::Input;
use crate::raster::Facts;
use crate::{DemError, HeightUnit};

use super::ifd::Tags;

const SCALE: u16 = 33550;
const TIE_POINTS: u16 = 33922;
const TRANSFORMATION: u16 = 34264;
pub const KEYS: u16 = 34735;
const KEY_DOUBLES: u16 = 34736;
const KEY_TEXTS: u16 = 34737;
const METADATA: u16 = 42112;
const NODATA: u16 = 42113;

const MODEL_TYPE: u16 = 1024;
const RASTER_TYPE: u16 = 1025;
const CITATION: u16 = 1026;
const GEOGRAPHIC_CRS: u16 = 2048;
const GEOGRAPHIC_CITATION: u16 = 2049;
const ANGULAR_UNIT: u16 = 2054;
const PROJECTED_CRS: u16 = 3072;
const PROJECTED_CITATION: u16 = 3073;
const LINEAR_UNIT: u16 = 3076;
const LINEAR_UNIT_METRES: u16 = 3077;
const VERTICAL_UNIT: u16 = 4099;

/// A value that the user defines, or none.
const USER_DEFINED: u16 = 32767;

const WEB_MERCATOR: u16 = 3857;

/// `band` counts from 0.
pub fn read(input: &mut Input, tags: &Tags, band: u32, facts: &mut Facts) -> Result<(), DemError> {
    facts.nodata = nodata(input, tags, facts)?;
    read_metadata(&tags.text(input, METADATA)?.unwrap_or_default(), band, facts);
    let keys = Keys::read(input, tags)?;
    facts.crs = keys.crs();
    facts.unit = facts.unit.or(keys.height_unit());
    let Some(affine) = Affine::read(input, tags)? else { return Ok(()) };
    if affine.is_negative {
        facts.warnings.push("its scale in y is negative: taken as north-up, as GDAL takes it".to_owned());
    }
    let [x, z] = affine.step(input)?;
    facts.south_up = z > 0.0;
    // Places are of samples, or of the corners of the cells around them.
    let half = if keys.whole(RASTER_TYPE) == Some(2) { 0.0 } else { 0.5 };
    let last_row = facts.rows.saturating_sub(1) as f64;
    let y = |row: f64| affine.y + (row + half - affine.at[1]) * z;
    let (west, north) = (affine.x + (half - affine.at[0]) * x, y(0.0).max(y(last_row)));
    facts.place = Some(Place { west, north, step: [x, z.abs()] });
    facts.keys = geo_keys(input, tags)?;
    match keys.spacing([x, z.abs()], [west, y(last_row / 2.0)], facts) {
        Ok(spacing) => facts.spacing = Some(spacing),
        Err(reason) => facts.no_spacing = Some(reason),
    }
    Ok(())
}

/// The keys as they are, to be written again. `None` without any.
fn geo_keys(input: &mut Input, tags: &Tags) -> Result<Option<GeoKeys>, DemError> {
    let directory = tags.wholes(input, KEYS)?;
    let numbers: Vec<u16> = directory.iter().map(|number| *number as u16).collect();
    // The first four are versions and a count.
    let entries: Vec<[u16; 4]> = numbers.as_chunks().0.get(1..).unwrap_or_default().to_vec();
    let (doubles, texts) = (tags.doubles(input, KEY_DOUBLES)?, tags.text(input, KEY_TEXTS)?.unwrap_or_default());
    Ok((!entries.is_empty()).then_some(GeoKeys { entries, doubles, texts }))
}

fn nodata(input: &mut Input, tags: &Tags, facts: &mut Facts) -> Result<Option<f64>, DemError> {
    let Some(text) = tags.text(input, NODATA)? else { return Ok(None) };
    let number = crate::formats::words::number(text.trim());
    if number.is_none() && !text.trim().is_empty() {
        let found = text.trim().chars().take(20).collect::<String>();
        facts.warnings.push(format!("NODATA is \"{}\", which is no number; --nodata says it", found.escape_debug()));
    }
    Ok(number.map(|number| facts.samples.rounded(number)))
}

/// `<Item name="SCALE" sample="0" role="scale">0.1</Item>`: of our band, or of none.
fn read_metadata(xml: &str, band: u32, facts: &mut Facts) {
    for item in xml.split("<Item ").skip(1) {
        let Some((attributes, rest)) = item.split_once('>') else { continue };
        let text = rest.split('<').next().unwrap_or_default().trim();
        let is_ours = !attributes.contains("sample=") || attributes.contains(&format!("sample=\"{band}\""));
        let role = attributes.split("role=\"").nth(1).and_then(|role| role.split('"').next());
        match role.filter(|_| is_ours) {
            Some("scale") => facts.scale = text.parse().ok().filter(|scale: &f64| scale.is_finite()),
            Some("offset") => facts.offset = text.parse().ok().filter(|offset: &f64| offset.is_finite()),
            Some("unittype") => {
                facts.unit = HeightUnit::parse(text);
                if facts.unit.is_none() && !text.is_empty() {
                    let found = text.chars().take(20).collect::<String>();
                    let warning =
                        format!("unit \"{}\" is not known: taken as metres; --unit says it", found.escape_debug());
                    facts.warnings.push(warning);
                }
            }
            _ => {}
        }
    }
}

/// From samples to coordinates: `x` and `y` are the place of the column and row `at`.
struct Affine {
    /// Coordinates a column: to the east, to the north.
    column: [f64; 2],
    /// Coordinates a row.
    down: [f64; 2],
    at: [f64; 2],
    x: f64,
    y: f64,
    /// By a scale that says so; GDAL takes its absolute value, unless it is told to honour the sign.
    is_negative: bool,
}

impl Affine {
    fn read(input: &mut Input, tags: &Tags) -> Result<Option<Self>, DemError> {
        if let &[a, b, _, x, c, d, _, y, ..] = tags.doubles(input, TRANSFORMATION)?.as_slice() {
            return Ok(Some(Self { column: [a, c], down: [b, d], at: [0.0; 2], x, y, is_negative: false }));
        }
        let scale = tags.doubles(input, SCALE)?;
        let ties = tags.doubles(input, TIE_POINTS)?;
        Ok(match (scale.as_slice(), ties.as_slice()) {
            (&[x_step, y_step, ..], &[column, row, _, x, y, ..]) => {
                let (down, is_negative) = ([0.0, -y_step.abs()], y_step < 0.0);
                Some(Self { column: [x_step, 0.0], down, at: [column, row], x, y, is_negative })
            }
            _ => None,
        })
    }

    /// Coordinates a column and a row; refused where the grid does not lie along them.
    fn step(&self, input: &Input) -> Result<[f64; 2], DemError> {
        let ([x, c], [b, z]) = (self.column, self.down);
        let remedy = format!("gdalwarp {} OUT.tif", input.shown);
        let is_turned = c.abs() > 1e-6 * x.abs() || b.abs() > 1e-6 * z.abs();
        if is_turned {
            return Err(input.refuse(format!("a rotated grid; expected rows from west to east: {remedy}")));
        }
        if x < 0.0 {
            return Err(input.refuse(format!("a mirrored grid; expected rows from west to east: {remedy}")));
        }
        Ok([x, z])
    }
}

/// The GeoTIFF keys: number, and what it says.
struct Keys(Vec<(u16, Value)>);

enum Value {
    Whole(u16),
    Double(f64),
    Text(String),
}

impl Keys {
    fn read(input: &mut Input, tags: &Tags) -> Result<Self, DemError> {
        let directory = tags.wholes(input, KEYS)?;
        let doubles = tags.doubles(input, KEY_DOUBLES)?;
        let texts = tags.text(input, KEY_TEXTS)?.unwrap_or_default();
        let key = |entry: &[u64]| {
            let &[key, place, count, value] = entry else { return None };
            let (from, count) = (value as usize, count as usize);
            let value = match place as u16 {
                0 => Value::Whole(value as u16),
                KEY_DOUBLES => Value::Double(*doubles.get(from)?),
                KEY_TEXTS => {
                    Value::Text(texts.get(from..from.checked_add(count)?)?.trim_matches(['|', ' ', '\0']).to_owned())
                }
                _ => return None,
            };
            Some((key as u16, value))
        };
        // The first four numbers are versions and a count.
        Ok(Self(directory.get(4..).unwrap_or_default().chunks_exact(4).filter_map(key).collect()))
    }

    fn get(&self, key: u16) -> Option<&Value> {
        self.0.iter().find(|(own, _)| *own == key).map(|(_, value)| value)
    }

    fn whole(&self, key: u16) -> Option<u16> {
        match self.get(key)? {
            Value::Whole(whole) => Some(*whole),
            _ => None,
        }
    }

    /// The number of the coordinate system, and its name.
    fn crs(&self) -> Option<String> {
        let is_known = |code: &u16| *code != 0 && *code != USER_DEFINED;
        let code = self.whole(PROJECTED_CRS).or(self.whole(GEOGRAPHIC_CRS)).filter(is_known);
        let text = |key| match self.get(key) {
            Some(Value::Text(text)) if !text.is_empty() => Some(text.chars().take(80).collect::<String>()),
            _ => None,
        };
        let name = [PROJECTED_CITATION, CITATION, GEOGRAPHIC_CITATION].into_iter().find_map(text);
        match (code, name) {
            (Some(code), Some(name)) => Some(format!("EPSG:{code} ({name})")),
            (Some(code), None) => Some(format!("EPSG:{code}")),
            (None, name) => name,
        }
    }

    fn height_unit(&self) -> Option<HeightUnit> {
        match self.whole(VERTICAL_UNIT)? {
            9001 => Some(HeightUnit::Metre),
            9002 => Some(HeightUnit::Foot),
            9003 => Some(HeightUnit::UsFoot),
            _ => None,
        }
    }

    /// `step` in coordinates; `place` is the western rim and the middle in y.
    fn spacing(&self, step: [f64; 2], place: [f64; 2], facts: &mut Facts) -> Result<Spacing, String> {
        let [_, latitude] = place;
        match self.whole(MODEL_TYPE) {
            Some(2) => match self.whole(ANGULAR_UNIT).unwrap_or(9102) {
                // Degrees, by two numbers.
                9102 | 9122 => Ok(Spacing::Degrees { degrees: step, latitude }),
                unit => Err(format!("an angular unit of EPSG:{unit}; expected degrees, or --spacing")),
            },
            Some(1) => {
                let metres = self.linear_unit()?;
                if self.whole(PROJECTED_CRS) == Some(WEB_MERCATOR) {
                    let warning =
                        "web Mercator metres are too long away from the equator: gdalwarp to the zone's UTM mends it";
                    facts.warnings.push(warning.to_owned());
                }
                let utm_or_mercator =
                    |epsg: &u32| [32601..=32660, 32701..=32760, 3857..=3857].iter().any(|r| r.contains(epsg));
                if let (None, Some(epsg)) = (self.whole(LINEAR_UNIT), self.whole(PROJECTED_CRS).map(u32::from))
                    && !utm_or_mercator(&epsg)
                    && epsg != u32::from(USER_DEFINED)
                {
                    let warning =
                        format!("the unit of EPSG:{epsg} is not in the file: taken as metres; --spacing if not");
                    facts.warnings.push(warning);
                }
                if facts.unit.is_none() && metres != 1.0 {
                    let warning =
                        "places are in feet, heights say no unit and are taken as metres; --unit us-foot if not";
                    facts.warnings.push(warning.to_owned());
                }
                Ok(Spacing::Metres(step.map(|s| s * metres)))
            }
            Some(3) => {
                Err("geocentric coordinates; expected a map's: gdalwarp -t_srs EPSG:32611 IN OUT.tif, or another map"
                    .to_owned())
            }
            _ => Ok(guess(step, place, facts)),
        }
    }

    /// Metres in the unit of the places.
    fn linear_unit(&self) -> Result<f64, String> {
        match (self.whole(LINEAR_UNIT), self.get(LINEAR_UNIT_METRES)) {
            (None | Some(9001), _) => Ok(1.0),
            (Some(9002), _) => Ok(HeightUnit::Foot.metres()),
            (Some(9003), _) => Ok(HeightUnit::UsFoot.metres()),
            (Some(9036), _) => Ok(1000.0),
            (Some(USER_DEFINED), Some(Value::Double(metres))) => Ok(*metres),
            (Some(unit), _) => Err(format!("a linear unit of EPSG:{unit}; expected metres or feet, or --spacing")),
        }
    }
}

/// Without keys nothing says whether the places are in degrees or metres; see `place.rs` for the bound.
fn guess(step: [f64; 2], [west, latitude]: [f64; 2], facts: &mut Facts) -> Spacing {
    let [x, z] = step;
    if x < 0.1 && z < 0.1 && (-181.0..=361.0).contains(&west) && latitude.abs() < 90.0 {
        facts.warnings.push(format!("steps of {x} x {z} at {west}, {latitude} are taken as degrees; --spacing if not"));
        return Spacing::Degrees { degrees: step, latitude };
    }
    Spacing::Metres(step)
}
