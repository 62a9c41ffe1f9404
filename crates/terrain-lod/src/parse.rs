//! Values on the command line: each refused with what was expected.

use std::ops::RangeInclusive;

use clap::builder::TypedValueParser;

use crate::suite::{PIXELS, SHARES, SIDE_PX};

pub fn parse_finite(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("expected a finite number".into()),
    }
}

pub fn parse_positive(text: &str) -> Result<f64, String> {
    parse_finite(text).ok().filter(|number| *number > 0.0).ok_or_else(|| "expected a number above 0".into())
}

pub fn parse_pixels(text: &str) -> Result<f64, String> {
    let expected = || format!("expected pixels, {:e} to {:e}", PIXELS.start(), PIXELS.end());
    parse_finite(text).ok().filter(|px| PIXELS.contains(px)).ok_or_else(expected)
}

/// A share as people write it: `5%`.
pub fn parse_percent(text: &str) -> Result<f64, String> {
    let share = text.trim().strip_suffix('%').and_then(|number| Some(parse_finite(number).ok()? / 100.0));
    let [low, high] = [SHARES.start(), SHARES.end()].map(|share| 100.0 * share);
    share.filter(|share| SHARES.contains(share)).ok_or_else(|| format!("expected {low}% to {high}%, such as 5%"))
}

pub fn within(range: RangeInclusive<u32>) -> impl TypedValueParser<Value = u32> {
    clap::value_parser!(u32).range(*range.start() as i64..=*range.end() as i64)
}

pub fn parse_spacing(text: &str) -> Result<[f64; 2], String> {
    let numbers: Result<Vec<f64>, String> = text.split(',').map(parse_positive).collect();
    match numbers.as_deref() {
        Ok([both]) => Ok([*both; 2]),
        Ok([x, z]) => Ok([*x, *z]),
        _ => Err("expected metres between samples: 30, or 52.5,92.7 for x and z".into()),
    }
}

/// Width and height in pixels: `640x360`.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides
        .filter(|sides: &[u32; 2]| sides.iter().all(|side| SIDE_PX.contains(side)))
        .ok_or_else(|| "expected width x height in pixels, such as 640x360, each 1 to 16384".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_written_as_percent() {
        assert_eq!((parse_percent("5%"), parse_percent(" 0.5 %")), (Ok(0.05), Ok(0.005)));
        for wrong in ["5", "0%", "-1%", "nan%", "%", "1001%"] {
            assert!(parse_percent(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn spacings_and_sizes() {
        assert_eq!(parse_spacing("30"), Ok([30.0, 30.0]));
        assert_eq!(parse_spacing("52.5,92.7"), Ok([52.5, 92.7]));
        assert!(parse_spacing("1,2,3").is_err() && parse_spacing("0").is_err() && parse_spacing("nan").is_err());
        assert_eq!(parse_size("640x360"), Ok([640, 360]));
        assert!(parse_size("640").is_err() && parse_size("0x4").is_err() && parse_size("-1x4").is_err());
    }
}
