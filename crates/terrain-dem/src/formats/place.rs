//! Where an ESRI grid lies: its cell size in a coordinate system that a `.prj` beside it names, if there is one.

use std::fs::File;
use std::io::Read;

use crate::formats::keys::Keys;
use crate::georef::{Place, Spacing};
use crate::input::Input;
use crate::raster::Facts;

/// Why a grid in degrees may have no spacing.
const NO_LATITUDE: &str = "its cells are in degrees, and it does not say at what latitude";

/// The longest `.prj` that is read, in bytes.
const MAX_PRJ: u64 = 1 << 16;

/// Sets spacing and coordinate system by the header's keys.
pub fn set(facts: &mut Facts, keys: &Keys, input: &Input) {
    let both = keys.number("cellsize");
    let x = keys.number("dx").or(keys.number("xdim")).or(both);
    let z = keys.number("dy").or(keys.number("ydim")).or(both);
    let (Some(x), Some(z)) = (x, z) else { return };
    let north = first(keys, ["ulymap", "yllcenter", "yllcorner"], (facts.rows.saturating_sub(1)) as f64 * z, z / 2.0);
    let middle = north.map(|north| north - facts.rows.saturating_sub(1) as f64 * z / 2.0);
    let west = first(keys, ["ulxmap", "xllcenter", "xllcorner"], 0.0, x / 2.0);
    facts.place = west.zip(north).map(|(west, north)| Place { west, north, step: [x, z] });

    let prj = prj(input);
    facts.crs = prj.as_deref().map(crs_name);
    if prj.is_some() && prj.as_deref().and_then(system).is_none() {
        facts
            .warnings
            .push("the .prj beside it is not understood; if the spacing below is wrong, say --spacing".into());
    }
    facts.spacing = match (prj.as_deref().and_then(system), middle) {
        (Some(System::Projected { metres }), _) => Some(Spacing::Metres([x * metres, z * metres])),
        (Some(System::Geographic), Some(latitude)) => Some(Spacing::Degrees { degrees: [x, z], latitude }),
        (Some(System::Geographic), None) => {
            facts.no_spacing = Some(NO_LATITUDE.into());
            None
        }
        // Without a `.prj` nothing says which it is. A cell of less than 0.1 at a place that degrees can name is in
        // degrees: the finest DEMs have decimetres, the coarsest in degrees a few arc-minutes.
        (None, Some(latitude)) if x < 0.1 && z < 0.1 && latitude.abs() < 90.0 => {
            let warning =
                format!("cells of {x} x {z} around {latitude} are taken as degrees; if they are metres, say --spacing");
            facts.warnings.push(warning);
            Some(Spacing::Degrees { degrees: [x, z], latitude })
        }
        _ => Some(Spacing::Metres([x, z])),
    };
}

/// One coordinate of the north-western sample: its own, that of the south-western sample, which is `across` off, or of a
/// corner of the cell around that, half a cell off.
fn first(keys: &Keys, [own, centre, corner]: [&str; 3], across: f64, half: f64) -> Option<f64> {
    let south_west = || keys.number(centre).or(keys.number(corner).map(|corner| corner + half));
    keys.number(own).or(south_west().map(|south_west| south_west + across))
}

/// The text of the `.prj`, on one line.
fn prj(input: &Input) -> Option<String> {
    let file = File::open(input.sibling(&["prj"])?).ok()?;
    let mut bytes = Vec::new();
    file.take(MAX_PRJ).read_to_end(&mut bytes).ok()?;
    Some(String::from_utf8_lossy(&bytes).split_ascii_whitespace().collect::<Vec<_>>().join(" "))
}

#[derive(Debug, PartialEq)]
enum System {
    Geographic,
    Projected {
        /// Metres in its unit.
        metres: f64,
    },
}

/// What a well-known text, or ESRI's older list of words, says.
fn system(prj: &str) -> Option<System> {
    let upper = prj.to_uppercase();
    // A system of heights after that of the plane has a unit of its own.
    let plane = ["VERTCS", "VERT_CS", "VERTCRS"].iter().filter_map(|word| upper.find(word)).min();
    let upper = &upper[..plane.unwrap_or(upper.len())];
    let start = upper.find("PROJC").or(upper.find("GEOGC")).filter(|_| upper.starts_with("COMP")).unwrap_or(0);
    let upper = &upper[start..];
    if upper.starts_with("GEOGCS") || upper.starts_with("GEOGCRS") || upper.contains("PROJECTION GEOGRAPHIC") {
        return Some(System::Geographic);
    }
    if upper.starts_with("PROJCS") || upper.starts_with("PROJCRS") {
        // The last unit is that of the plane, the ones before it are angles.
        let unit = upper.rfind("UNIT[")?;
        let factor = upper[unit..].split(',').nth(1)?.split([']', ',']).next()?.trim().parse().ok()?;
        return Some(System::Projected { metres: factor });
    }
    let is_old_list = upper.starts_with("PROJECTION ");
    let unit = [("UNITS METERS", 1.0), ("UNITS FEET", 1200.0 / 3937.0)].into_iter().find(|unit| upper.contains(unit.0));
    unit.filter(|_| is_old_list).map(|(_, metres)| System::Projected { metres })
}

/// The name in `PROJCS["name",...`, or the start of the text.
fn crs_name(prj: &str) -> String {
    prj.split('"').nth(1).unwrap_or(prj).chars().take(80).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems() {
        let utm = r#"PROJCS["WGS_1984_UTM_Zone_11N",GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137,298.25]],PRIMEM["Greenwich",0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],UNIT["Meter",1]]"#;
        assert_eq!(system(utm), Some(System::Projected { metres: 1.0 }));
        assert_eq!(crs_name(utm), "WGS_1984_UTM_Zone_11N");
        let feet = utm.replace(r#"UNIT["Meter",1]"#, r#"UNIT["Foot_US",0.3048006096012192]"#);
        assert_eq!(system(&feet), Some(System::Projected { metres: 1200.0 / 3937.0 }));
        assert_eq!(system(r#"GEOGCS["WGS 84",UNIT["degree",0.0174]]"#), Some(System::Geographic));
        assert_eq!(system("Projection GEOGRAPHIC Datum WGS84"), Some(System::Geographic));
        assert_eq!(system("something else"), None);
        let heights = r#",VERTCS["NAVD88",VDATUM["NAVD88"],UNIT["Foot_US",0.3048006096012192]]"#;
        assert_eq!(system(&[utm, heights].concat()), Some(System::Projected { metres: 1.0 }));
        let compound = format!(r#"COMPD_CS["both",{utm}{heights}]"#);
        assert_eq!(system(&compound), Some(System::Projected { metres: 1.0 }));
        let old = "Projection STATEPLANE Datum NAD83 Zunits NO Units FEET Spheroid GRS1980";
        assert_eq!(system(old), Some(System::Projected { metres: 1200.0 / 3937.0 }));
    }
}
