//! SRTM and NASADEM tiles (`.hgt`): a square of big-endian int16, the northern row first, and nothing else.
//!
//! The file's name is the south-western corner of a square of one degree (`N44W122.hgt`); its rim samples lie on the
//! degrees, so that a tile of 1201 has a spacing of 3 arc-seconds (SRTM Topography, NASA, section 2.1.2).

use crate::DemError;
use crate::formats::packed::{PackedGrid, Rows};
use crate::georef::{GeoKeys, Place, Spacing};
use crate::input::Input;
use crate::raster::Facts;
use crate::samples::{ByteOrder, Packing, SampleType};

/// Samples a side of the tiles of 3 and of 1 arc-second: known by their size, whatever their name.
const SIDES: [u32; 2] = [1201, 3601];

/// Whether the size or the name says that this is a tile. There is nothing else to go by.
pub fn is_one(input: &Input) -> bool {
    input.ending() == "hgt"
        || side(input).is_some_and(|side| SIDES.contains(&side) || corner(&input.file_name).is_some())
}

pub fn open(input: Input) -> Result<PackedGrid, DemError> {
    let Some(side) = side(&input) else {
        let reason = format!(
            "{} bytes are no square of int16; expected an .hgt tile, such as 2884802 bytes for 1201 x 1201: fetch it again",
            input.length
        );
        return Err(input.refuse(reason));
    };
    let mut facts = Facts::new("SRTM tile (.hgt)", side, side, SampleType::I16);
    facts.nodata = Some(-32768.0);
    match corner(&input.file_name) {
        Some([south, west]) => {
            let step = [1.0 / (side - 1) as f64; 2];
            facts.spacing = Some(Spacing::Degrees { degrees: step, latitude: south + 0.5 });
            facts.place = Some(Place { west, north: south + 1.0, step });
            facts.crs = Some("EPSG:4326 (by the name)".to_owned());
            facts.keys = Some(GeoKeys::wgs84());
        }
        None => facts.warnings.push(
            "the name is not that of a tile, such as N44W122.hgt, so that its latitude and spacing are unknown"
                .to_owned(),
        ),
    }
    let packing = Packing { samples: SampleType::I16, order: ByteOrder::Big, stride: 2 };
    PackedGrid::new(input, facts, Rows { packing, first_byte: 0, row_bytes: side as u64 * 2 })
}

/// Samples a side, where the length is that of a square.
fn side(input: &Input) -> Option<u32> {
    let side = (input.length / 2).isqrt();
    (input.length == side * side * 2 && side >= 2).then_some(u32::try_from(side).ok()?)
}

/// Latitude and longitude of the south-western sample, by a name such as `N44W122.hgt` or `n44_w122_1arc_v3.hgt`.
fn corner(file_name: &str) -> Option<[f64; 2]> {
    let plain: String = file_name.to_uppercase().chars().filter(char::is_ascii_alphanumeric).collect();
    let plain = plain.strip_prefix("NASADEMHGT").unwrap_or(&plain);
    let (south, west) = (plain.get(..3)?, plain.get(3..7)?);
    let number = |text: &str, signs: [char; 2]| {
        let digits = text.strip_prefix(signs)?;
        let number: f64 = digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok())??;
        Some(if text.starts_with(signs[1]) { -number } else { number })
    };
    let west = number(west, ['E', 'W']).filter(|west| west.abs() <= 180.0)?;
    let south = number(south, ['N', 'S']).filter(|south| (-90.0..90.0).contains(south))?;
    Some([south, west])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_by_name() {
        let cases = [
            ("N44W122.hgt", Some([44.0, -122.0])),
            ("s01e009.hgt", Some([-1.0, 9.0])),
            ("n44_w122_1arc_v3.hgt", Some([44.0, -122.0])),
            ("NASADEM_HGT_n44w122.hgt", Some([44.0, -122.0])),
            ("N95W122.hgt", None),
            ("N44W222.hgt", None),
            ("N4xW122.hgt", None),
            ("tile.hgt", None),
            ("", None),
        ];
        for (name, expected) in cases {
            assert_eq!(corner(name), expected, "{name}");
        }
    }
}
