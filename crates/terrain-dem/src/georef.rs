//! From the coordinates that files speak in to metres between samples.

use std::f64::consts::PI;

/// Distance between neighbouring samples in x and z, as a file gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spacing {
    /// Metres.
    Metres([f64; 2]),
    /// Degrees of longitude and latitude, and the latitude of the DEM's middle.
    Degrees {
        /// In x and z.
        degrees: [f64; 2],
        /// Northern ones positive.
        latitude: f64,
    },
}

impl Spacing {
    /// Metres between samples in x and z; the reason where there are none.
    pub fn metres(self) -> Result<[f64; 2], String> {
        let (spacing, unit) = match self {
            Self::Metres(metres) => (metres, "m"),
            Self::Degrees { degrees, .. } => (degrees, "degrees"),
        };
        if !spacing.iter().all(|s| s.is_finite() && *s > 0.0) {
            let [x, z] = spacing;
            return Err(format!("a spacing of {x} x {z} {unit}; expected two positive numbers, or --spacing"));
        }
        match self {
            Self::Metres(metres) => Ok(metres),
            Self::Degrees { degrees: [x, z], latitude } => {
                if latitude.is_nan() || latitude.abs() >= 90.0 {
                    return Err(format!("a middle at latitude {latitude}; expected -90 to 90 degrees, or --spacing"));
                }
                let [metres_x, metres_z] = metres_a_degree(latitude);
                Ok([x * metres_x, z * metres_z])
            }
        }
    }

    /// In words, for a person.
    pub fn describe(self) -> String {
        match self {
            Self::Metres([x, z]) => format!("{x} x {z} m"),
            Self::Degrees { degrees: [x, z], latitude } => {
                format!("{} x {} arc-seconds at latitude {latitude:.4}", tidy(x * 3600.0), tidy(z * 3600.0))
            }
        }
    }
}

fn tidy(number: f64) -> f64 {
    (number * 1e6).round() / 1e6
}

/// Metres in a degree of longitude and of latitude on the WGS 84 ellipsoid: its radii of curvature, first of the prime
/// vertical times the cosine, then of the meridian. `libm` gives the same metres on every machine.
fn metres_a_degree(latitude: f64) -> [f64; 2] {
    const RADIUS_M: f64 = 6_378_137.0;
    const ECCENTRICITY_2: f64 = 6.694_379_990_141_316e-3;
    let angle = latitude * PI / 180.0;
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let w = (1.0 - ECCENTRICITY_2 * sin * sin).sqrt();
    let prime_vertical_m = RADIUS_M / w;
    let meridian_m = RADIUS_M * (1.0 - ECCENTRICITY_2) / (w * w * w);
    [prime_vertical_m * cos * PI / 180.0, meridian_m * PI / 180.0]
}

/// Where a grid lies, in the coordinates of its file: degrees, or the unit of its map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Of the middle of the north-western sample.
    pub west: f64,
    pub north: f64,
    /// From one sample to the next, to the east and to the south; both positive.
    pub step: [f64; 2],
}

impl Place {
    /// Of every `thin`-th sample from a column and row on.
    pub fn part(self, [column, row]: [u32; 2], thin: u32) -> Self {
        let [x, z] = self.step;
        let (west, north) = (self.west + f64::from(column) * x, self.north - f64::from(row) * z);
        Self { west, north, step: self.step.map(|step| step * f64::from(thin)) }
    }
}

/// Where a DEM lies and in which coordinate system: what it takes to write that into a GeoTIFF.
#[derive(Clone, Debug, PartialEq)]
pub struct Georeference {
    pub(crate) place: Place,
    pub(crate) keys: GeoKeys,
}

/// A coordinate system as a GeoTIFF says it (OGC 19-008r4).
#[derive(Clone, Debug, PartialEq)]
pub struct GeoKeys {
    /// Key, where its value is, how many, and the value or its index.
    pub entries: Vec<[u16; 4]>,
    pub doubles: Vec<f64>,
    pub texts: String,
}

impl GeoKeys {
    fn of(entries: &[[u16; 4]]) -> Self {
        Self { entries: entries.into(), doubles: Vec::new(), texts: String::new() }
    }

    /// Longitude and latitude, WGS 84.
    pub fn wgs84() -> Self {
        Self::of(&[[1024, 0, 1, 2], [1025, 0, 1, 2], [2048, 0, 1, 4326], [2054, 0, 1, 9102]])
    }

    /// Metres on a map that nobody else knows.
    pub fn metres() -> Self {
        Self::of(&[[1024, 0, 1, 1], [1025, 0, 1, 2], [3072, 0, 1, 32767], [3076, 0, 1, 9001]])
    }

    /// Whether every key finds its values: in its own entry, among the numbers, or in the text.
    pub fn are_whole(&self) -> bool {
        self.entries.iter().all(|&[_, tag, count, at]| {
            let held = match tag {
                0 => return count == 1,
                34736 => self.doubles.len(),
                34737 => self.texts.len(),
                _ => return false,
            };
            usize::from(at) + usize::from(count) <= held
        })
    }

    /// For heights in metres at places of samples, whatever they were.
    pub fn of_samples_in_metres(&self) -> Self {
        const RASTER_TYPE: u16 = 1025;
        const VERTICAL: std::ops::Range<u16> = 4096..5120;
        let is_other = |[key, ..]: &[u16; 4]| *key != RASTER_TYPE && !VERTICAL.contains(key);
        let mut entries: Vec<[u16; 4]> = self.entries.iter().copied().filter(is_other).collect();
        entries.push([RASTER_TYPE, 0, 1, 2]);
        // Readers may look for them in order.
        entries.sort_unstable();
        Self { entries, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The usual table of lengths of a degree (WGS 84).
    #[test]
    fn a_degree_in_metres() {
        for (latitude, expected) in
            [(0.0, [111_319.5, 110_574.3]), (45.0, [78_846.8, 111_131.8]), (-60.0, [55_800.0, 111_412.3])]
        {
            let [x, z] = metres_a_degree(latitude);
            assert!((x - expected[0]).abs() < 0.1 && (z - expected[1]).abs() < 0.1, "{latitude}: {x} {z}");
        }
    }

    #[test]
    fn no_metres_from_nonsense() {
        let degrees = |latitude| Spacing::Degrees { degrees: [0.1; 2], latitude }.metres();
        assert!(degrees(44.5).is_ok() && degrees(90.0).is_err() && degrees(f64::NAN).is_err());
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Spacing::Metres([30.0, wrong]).metres().is_err(), "{wrong}");
        }
    }
}
