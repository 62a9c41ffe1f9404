//! The TOML file beside a DEM that says what its numbers mean.

use std::io::ErrorKind;
use std::path::Path;

use serde::Deserialize;
use terrain_core::source::{SourceError, SourceText};
use toml::{Spanned, Value};

use crate::georef::{GeoKeys, Georeference, Place, Spacing};
use crate::raster::Facts;
use crate::{DemError, RawLayout};

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sidecar {
    pub spacing_m: Option<[f64; 2]>,
    pub scale: Option<f64>,
    pub offset_m: Option<f64>,
    pub nodata: Option<f64>,
    pub raw: Option<RawLayout>,
    pub crs: Option<String>,
    pub place: Option<Georeference>,
    pub source: Option<String>,
    pub licence: Option<String>,
    pub notice: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SidecarToml {
    spacing_m: Option<Spanned<Value>>,
    scale: Option<Spanned<f64>>,
    offset_m: Option<Spanned<f64>>,
    nodata: Option<f64>,
    raw: Option<Spanned<String>>,
    crs: Option<String>,
    place: Option<Spanned<PlaceToml>>,
    source: Option<String>,
    licence: Option<String>,
    notice: Option<String>,
}

/// Where the DEM lies, and its coordinate system by GeoTIFF's keys.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlaceToml {
    west: f64,
    north: f64,
    step: [f64; 2],
    keys: Vec<[u16; 4]>,
    #[serde(default)]
    doubles: Vec<f64>,
    #[serde(default)]
    texts: String,
}

impl Sidecar {
    /// A file that is not there says nothing.
    pub fn read(path: &Path) -> Result<Self, DemError> {
        let name = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Ok(Self::parse(&name, &text)?),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(Self::default()),
            Err(e) if e.kind() == ErrorKind::InvalidData => {
                Err(DemError::input(&name, "not UTF-8; expected a TOML file".to_owned()))
            }
            Err(e) => Err(DemError::io("read", path, e)),
        }
    }

    /// Tells a file where it lies. A place is that of the sidecar's own spacing: without one nobody can tell whether it fits.
    pub fn put_place(&self, facts: &mut Facts) {
        facts.crs = self.crs.clone().or(facts.crs.take());
        let (Some(Georeference { place, keys }), Some(spacing_m)) = (&self.place, self.spacing_m) else { return };
        facts.place = Some(*place);
        facts.keys = Some(keys.clone());
        facts.spacing = Some(Spacing::Metres(spacing_m));
    }

    pub fn parse(name: &str, text: &str) -> Result<Self, SourceError> {
        let source = SourceText { name, text };
        let toml: SidecarToml = source.parse()?;
        Ok(Self {
            spacing_m: toml.spacing_m.map(|value| spacing_m(&source, &value)).transpose()?,
            scale: toml.scale.map(|value| finite(&source, &value, "scale")).transpose()?,
            offset_m: toml.offset_m.map(|value| finite(&source, &value, "offset_m")).transpose()?,
            nodata: toml.nodata,
            raw: toml.raw.map(|value| raw(&source, &value)).transpose()?,
            crs: toml.crs,
            place: toml.place.map(|value| place(&source, value)).transpose()?,
            source: toml.source,
            licence: toml.licence,
            notice: toml.notice,
        })
    }
}

/// One positive number for both axes, or two.
fn spacing_m(source: &SourceText, value: &Spanned<Value>) -> Result<[f64; 2], SourceError> {
    let found = value.get_ref();
    let spacing = match found {
        Value::Array(both) => match both.as_slice() {
            [x, z] => metres(x).zip(metres(z)),
            _ => None,
        },
        both => metres(both).zip(metres(both)),
    };
    let refuse = || {
        let expected = "a positive number of metres, or one for x and one for z, such as [74.8, 92.5]";
        source.error(value.span(), format!("`spacing_m` is {}; expected {expected}", found.to_string().escape_debug()))
    };
    spacing.map(<[f64; 2]>::from).ok_or_else(refuse)
}

fn metres(value: &Value) -> Option<f64> {
    let number = value.as_float().or(value.as_integer().map(|integer| integer as f64))?;
    (number.is_finite() && number > 0.0).then_some(number)
}

fn place(source: &SourceText, value: Spanned<PlaceToml>) -> Result<Georeference, SourceError> {
    let span = value.span();
    let PlaceToml { west, north, step, keys, doubles, texts } = value.into_inner();
    let keys = GeoKeys { entries: keys, doubles, texts };
    let found = Georeference { place: Place { west, north, step }, keys };
    let refuse = || {
        let expected = "finite coordinates of the north-western sample, positive steps, and keys with all their values";
        source.error(span, format!("`place` is not one; expected {expected}"))
    };
    if is_sound(&found) { Ok(found) } else { Err(refuse()) }
}

fn is_sound(Georeference { place: Place { west, north, step }, keys }: &Georeference) -> bool {
    let is_step = |step: &f64| step.is_finite() && *step > 0.0;
    let is_finite = [west, north].into_iter().chain(&keys.doubles).all(|number| number.is_finite());
    is_finite && step.iter().all(is_step) && keys.are_whole()
}

/// Coordinate system and place as sidecars say them, line by line; empty where neither is known.
pub fn whereabouts(crs: Option<&str>, georeference: Option<&Georeference>) -> String {
    let crs = crs.map_or(String::new(), |crs| format!("crs = {}\n", Value::from(crs)));
    georeference.map_or(String::new(), place_text) + &crs
}

/// What such lines say, which came from a place of this name.
pub fn parse_whereabouts(name: &str, text: &str) -> Result<(Option<String>, Option<Georeference>), DemError> {
    let Sidecar { crs, place, .. } = Sidecar::parse(name, text)?;
    Ok((crs, place))
}

/// A place as [`Sidecar::parse`] reads it; nothing for one that it would refuse.
fn place_text(georeference: &Georeference) -> String {
    if !is_sound(georeference) {
        return String::new();
    }
    let Georeference { place: Place { west, north, step }, keys: GeoKeys { entries, doubles, texts } } = georeference;
    let (place, texts) = (format!("west = {west:?}, north = {north:?}, step = {step:?}"), Value::from(texts.as_str()));
    format!("place = {{ {place}, keys = {entries:?}, doubles = {doubles:?}, texts = {texts} }}\n")
}

fn raw(source: &SourceText, value: &Spanned<String>) -> Result<RawLayout, SourceError> {
    let found = value.get_ref();
    let refuse = || {
        let expected = "COLUMNSxROWS:TYPE, such as 513x513:uint16 or 100x80:float32be";
        source.error(value.span(), format!("`raw` is \"{}\"; expected {expected}", found.escape_debug()))
    };
    RawLayout::parse(found).ok_or_else(refuse)
}

fn finite(source: &SourceText, value: &Spanned<f64>, name: &str) -> Result<f64, SourceError> {
    let found = *value.get_ref();
    let refuse = || source.error(value.span(), format!("`{name}` is {found}; expected a finite number"));
    found.is_finite().then_some(found).ok_or_else(refuse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_read() {
        let text = "spacing_m = [74.5, 93]\nscale = 0.1\noffset_m = -10\nnodata = 0\nraw = '3x2:uint16'\n\
                    crs = 'c'\nplace = { west = 1, north = 2.5, step = [0.5, 30], keys = [[1024, 0, 1, 2]] }\n\
                    source = 's'\nlicence = 'l'\nnotice = 'n'\n";
        let expected = Sidecar {
            spacing_m: Some([74.5, 93.0]),
            scale: Some(0.1),
            offset_m: Some(-10.0),
            nodata: Some(0.0),
            raw: RawLayout::parse("3x2:uint16"),
            crs: Some("c".to_owned()),
            place: Some(Georeference {
                place: Place { west: 1.0, north: 2.5, step: [0.5, 30.0] },
                keys: GeoKeys { entries: vec![[1024, 0, 1, 2]], doubles: Vec::new(), texts: String::new() },
            }),
            source: Some("s".to_owned()),
            licence: Some("l".to_owned()),
            notice: Some("n".to_owned()),
        };
        assert_eq!(Sidecar::parse("a.toml", text), Ok(expected));
        assert_eq!(Sidecar::parse("a.toml", "spacing_m = 30").unwrap().spacing_m, Some([30.0, 30.0]));
        assert_eq!(Sidecar::parse("a.toml", ""), Ok(Sidecar::default()));
    }

    #[test]
    fn mistakes_are_refused_where_they_are() {
        const SPACING: &str = "expected a positive number of metres, or one for x and one for z, such as [74.8, 92.5]";
        let cases = [
            (
                "scale = 1\nspacing = 30",
                "2:1: unknown field `spacing`, expected one of `spacing_m`, `scale`, \
              `offset_m`, `nodata`, `raw`, `crs`, `place`, `source`, `licence`, `notice`"
                    .to_owned(),
            ),
            ("\nspacing_m = 0", format!("2:13: `spacing_m` is 0; {SPACING}")),
            ("spacing_m = [1.5, nan]", format!("1:13: `spacing_m` is [1.5, nan]; {SPACING}")),
            ("spacing_m = [1, 2, 3]", format!("1:13: `spacing_m` is [1, 2, 3]; {SPACING}")),
            ("spacing_m = '30 m'", format!("1:13: `spacing_m` is \\\"30 m\\\"; {SPACING}")),
            ("scale = inf", "1:9: `scale` is inf; expected a finite number".to_owned()),
            ("offset_m = 'low'", "1:12: invalid type: string \"low\", expected f64".to_owned()),
            (
                "raw = '3x2'",
                "1:7: `raw` is \"3x2\"; expected COLUMNSxROWS:TYPE, such as 513x513:uint16 or 100x80:float32be"
                    .to_owned(),
            ),
            (
                "place = { west = 1, north = 2, step = [1, 0], keys = [] }",
                "1:9: `place` is not one; expected finite coordinates of the north-western sample, positive steps, and keys \
                 with all their values"
                    .to_owned(),
            ),
            (
                "place = { west = 1, north = 2, step = [1, 1], keys = [[2057, 34736, 1, 0]] }",
                "1:9: `place` is not one; expected finite coordinates of the north-western sample, positive steps, and keys \
                 with all their values"
                    .to_owned(),
            ),
            ("scale = 1\nscale = 2", "2:1: duplicate key".to_owned()),
        ];
        for (text, expected) in cases {
            assert_eq!(Sidecar::parse("a.toml", text).unwrap_err().to_string(), format!("a.toml:{expected}"));
        }
    }
}
