//! TOML to [`Flight`].

use std::ops::{Range, RangeInclusive};

use glam::DVec3;
use serde::Deserialize;
use toml::Spanned;

use super::key::{Clearance, Direction, Key, Position};
use super::{Flight, MAX_FRAMES};
use crate::source::{SourceError, SourceText};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FlightToml {
    name: String,
    fov_y_deg: Option<Spanned<f64>>,
    steps_per_second: Option<Spanned<f64>>,
    #[serde(default)]
    allow_outside: bool,
    #[serde(default)]
    allow_below_ground: bool,
    #[serde(default)]
    key: Vec<Spanned<KeyToml>>,
}

/// All ways to write a key at once: an enum of the legal ones would refuse the others without saying why. Points are of
/// any length: serde would drop what is too much for an array.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyToml {
    time_s: Spanned<f64>,
    position_m: Option<Spanned<Vec<f64>>>,
    at: Option<Spanned<Vec<f64>>>,
    above_ground_m: Option<Spanned<f64>>,
    above_ground_share: Option<Spanned<f64>>,
    look_at_m: Option<Spanned<Vec<f64>>>,
    look_at: Option<Spanned<Vec<f64>>>,
    look_at_above_ground_m: Option<Spanned<f64>>,
    heading_deg: Option<Spanned<f64>>,
    pitch_deg: Option<Spanned<f64>>,
}

const FINITE: RangeInclusive<f64> = f64::MIN..=f64::MAX;

pub fn flight(source: &SourceText) -> Result<Flight, SourceError> {
    let toml: FlightToml = source.parse()?;
    let keys = toml.key.iter().map(|key| self::key(source, key)).collect::<Result<Vec<_>, _>>()?;
    if keys.len() < 2 {
        let reason = format!("{} [[key]]; expected at least 2, equal ones for a camera that stands", keys.len());
        return Err(source.error(0..0, reason));
    }
    check_times(source, &toml.key)?;
    check_kinds(source, &toml.key, &keys)?;
    let optional = |value: &Option<_>, name, range, default| match value {
        Some(value) => number(source, value, name, range),
        None => Ok(default),
    };
    let flight = Flight {
        source_name: source.name.to_owned(),
        fov_y: optional(&toml.fov_y_deg, "fov_y_deg", 1.0..=170.0, 60.0)?.to_radians(),
        steps_per_second: optional(&toml.steps_per_second, "steps_per_second", 0.001..=1000.0, 60.0)?,
        name: toml.name,
        allow_outside: toml.allow_outside,
        allow_below_ground: toml.allow_below_ground,
        keys,
    };
    check_length(&flight)?;
    Ok(flight)
}

fn key(source: &SourceText, key: &Spanned<KeyToml>) -> Result<Key, SourceError> {
    let span = key.span();
    let key = key.get_ref();
    Ok(Key {
        written_at: source.position(span.start),
        time_s: number(source, &key.time_s, "time_s", FINITE)?,
        position: position(source, key, span.clone())?,
        direction: direction(source, key, span)?,
    })
}

fn position(source: &SourceText, key: &KeyToml, span: Range<usize>) -> Result<Position, SourceError> {
    match (&key.position_m, &key.at, &key.above_ground_m, &key.above_ground_share) {
        (Some(point), None, None, None) => Ok(Position::World(vector(source, point, "position_m")?.into())),
        (None, Some(at), Some(metres), None) => Ok(Position::OverGround(
            vector(source, at, "at")?,
            Clearance::Metres(number(source, metres, "above_ground_m", FINITE)?),
        )),
        (None, Some(at), None, Some(share)) => Ok(Position::OverGround(
            vector(source, at, "at")?,
            Clearance::Share(number(source, share, "above_ground_share", FINITE)?),
        )),
        (point, at, metres, share) => {
            let found = present([
                ("position_m", point.is_some()),
                ("at", at.is_some()),
                ("above_ground_m", metres.is_some()),
                ("above_ground_share", share.is_some()),
            ]);
            let expected = "`position_m`, or `at` with either `above_ground_m` or `above_ground_share`";
            Err(source.error(span, format!("position from {found}; expected {expected}")))
        }
    }
}

fn direction(source: &SourceText, key: &KeyToml, span: Range<usize>) -> Result<Direction, SourceError> {
    match (&key.look_at_m, &key.look_at, &key.look_at_above_ground_m, &key.heading_deg, &key.pitch_deg) {
        (Some(point), None, None, None, None) => {
            Ok(Direction::LookAtWorld(DVec3::from(vector(source, point, "look_at_m")?)))
        }
        (None, Some(at), above, None, None) => {
            let above_m = above.as_ref().map(|m| number(source, m, "look_at_above_ground_m", FINITE)).transpose()?;
            Ok(Direction::LookAtGround(vector(source, at, "look_at")?, above_m.unwrap_or(0.0)))
        }
        (None, None, None, Some(heading), Some(pitch)) => Ok(Direction::Angles {
            heading: number(source, heading, "heading_deg", -36_000.0..=36_000.0)?.to_radians(),
            pitch: number(source, pitch, "pitch_deg", -90.0..=90.0)?.to_radians(),
        }),
        (point, at, above, heading, pitch) => {
            let found = present([
                ("look_at_m", point.is_some()),
                ("look_at", at.is_some()),
                ("look_at_above_ground_m", above.is_some()),
                ("heading_deg", heading.is_some()),
                ("pitch_deg", pitch.is_some()),
            ]);
            let expected = "`look_at_m`, or `look_at`, or `heading_deg` and `pitch_deg`";
            Err(source.error(span, format!("direction from {found}; expected {expected}")))
        }
    }
}

/// "`at`, `above_ground_m`": the names of the keys that are there.
fn present<const N: usize>(keys: [(&str, bool); N]) -> String {
    let names: Vec<String> = keys.iter().filter(|(_, there)| *there).map(|(name, _)| format!("`{name}`")).collect();
    if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
}

fn number(
    source: &SourceText,
    value: &Spanned<f64>,
    name: &str,
    range: RangeInclusive<f64>,
) -> Result<f64, SourceError> {
    let found = *value.get_ref();
    if range.contains(&found) {
        return Ok(found);
    }
    let expected = match range == FINITE {
        true => "a finite number".to_owned(),
        false => format!("{} to {}", range.start(), range.end()),
    };
    Err(source.error(value.span(), format!("`{name}` is {found}; expected {expected}")))
}

fn vector<const N: usize>(source: &SourceText, value: &Spanned<Vec<f64>>, name: &str) -> Result<[f64; N], SourceError> {
    match <[f64; N]>::try_from(value.get_ref().as_slice()) {
        Ok(point) if point.iter().all(|number| number.is_finite()) => Ok(point),
        _ => {
            let found = value.get_ref();
            Err(source.error(value.span(), format!("`{name}` is {found:?}; expected {N} finite numbers")))
        }
    }
}

fn check_times(source: &SourceText, keys: &[Spanned<KeyToml>]) -> Result<(), SourceError> {
    for pair in keys.windows(2) {
        let [earlier, later] = [&pair[0], &pair[1]].map(|key| &key.get_ref().time_s);
        if later.get_ref() <= earlier.get_ref() {
            let line = source.position(earlier.span().start).line;
            let reason = format!(
                "`time_s` is {} after {} on line {line}; expected times that rise",
                later.get_ref(),
                earlier.get_ref()
            );
            return Err(source.error(later.span(), reason));
        }
    }
    Ok(())
}

fn check_kinds(source: &SourceText, toml: &[Spanned<KeyToml>], keys: &[Key]) -> Result<(), SourceError> {
    let first = &keys[0];
    let refuse = |span, what: &str, kind: &str, first_kind: &str| {
        let line = first.written_at.line;
        let reason = format!(
            "{what} by `{kind}`, but by `{first_kind}` in the key on line {line}; expected one kind of {what} in all keys"
        );
        Err(source.error(span, reason))
    };
    for (toml, key) in toml.iter().zip(keys) {
        if !key.position.is_same_kind(&first.position) {
            return refuse(toml.span(), "position", key.position.kind(), first.position.kind());
        }
        if !key.direction.is_same_kind(&first.direction) {
            return refuse(toml.span(), "direction", key.direction.kind(), first.direction.kind());
        }
    }
    Ok(())
}

fn check_length(flight: &Flight) -> Result<(), SourceError> {
    let frames = flight.duration_s() * flight.steps_per_second + 1.0;
    if frames <= MAX_FRAMES as f64 {
        return Ok(());
    }
    let last = &flight.keys[flight.keys.len() - 1];
    let reason = format!(
        "{} s at {} steps a second; expected at most {MAX_FRAMES} frames",
        flight.duration_s(),
        flight.steps_per_second
    );
    Err(flight.error_at(last.written_at, reason))
}
