//! What the user says about a DEM.

use crate::MAX_SAMPLES;
use crate::part::Crop;
use crate::samples::{ByteOrder, SampleType};

/// What the user says about a DEM. `None` leaves it to the sidecar, then to the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Metres between neighbouring samples in x and z, positive. Without it the sidecar or the file must say it.
    pub spacing_m: Option<[f64; 2]>,
    /// Metres a unit of the file's values, whatever unit and scale the file declares.
    pub scale: Option<f64>,
    /// Height of the value 0 in metres.
    pub offset_m: Option<f64>,
    /// Take a PNG of 8 bits a sample too, whose 256 heights show as steps; off by default.
    pub allow_8_bit: bool,
    /// The value, as it is in the file, that stands for no height; in place of the file's own.
    pub nodata: Option<f64>,
    /// The unit of the heights, in place of the file's own; metres if that does not say it either.
    pub unit: Option<HeightUnit>,
    /// Which band to read, from 1; the first by default.
    pub band: Option<u32>,
    /// What becomes of samples without a height.
    pub voids: VoidPolicy,
    /// The largest DEM to load, in samples; [`MAX_SAMPLES`](crate::MAX_SAMPLES) by default, and at most.
    pub max_samples: Option<u64>,
    /// The part of the DEM to take; all by default.
    pub crop: Option<Crop>,
    /// Take every n-th column and row of that; every one by default.
    pub thin: Option<u32>,
    /// Metres in x and z that the samples of what was taken are brought to, bilinearly; as they are by default.
    pub resample_m: Option<[f64; 2]>,
    /// Which overview of a TIFF to read, from 1, the finest of them; the picture itself by default.
    pub overview: Option<u32>,
    /// How a colour PNG packs its heights; off by default.
    pub colours: Option<ColourCode>,
    /// The layout of a file without any header; such files are refused without it.
    pub raw: Option<RawLayout>,
}

impl ReadOptions {
    pub(crate) fn limit(&self) -> u64 {
        self.max_samples.unwrap_or(MAX_SAMPLES).min(MAX_SAMPLES)
    }
}

/// What becomes of voids, the samples without a height.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VoidPolicy {
    /// They are left out of what is drawn, measured and exported, as
    /// [`Heightmap::voids`](terrain_core::Heightmap::voids) says; meshes beneath pass through the fill.
    #[default]
    Hole,
    /// They take smooth heights from their rim, and these count as any others.
    Fill,
    /// A DEM with voids is refused.
    Error,
}

impl VoidPolicy {
    /// As the command line spells it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hole => "hole",
            Self::Fill => "fill",
            Self::Error => "error",
        }
    }

    /// What a user should know of voids that were `found`; the refusal, if none may be.
    pub fn apply(self, found: &str) -> Result<String, String> {
        match self {
            Self::Hole => Ok(format!("{found}: left open (--voids fill fills them from their rim)")),
            Self::Fill => Ok(format!("{found}: filled from their rim")),
            Self::Error => Err(format!("{found}; expected none, or --voids hole or fill")),
        }
    }
}

/// The unit that heights are in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightUnit {
    /// The metre.
    Metre,
    /// The international foot, 0.3048 m.
    Foot,
    /// The US survey foot, 1200/3937 m.
    UsFoot,
    /// A tenth of a metre.
    Decimetre,
    /// A hundredth of a metre.
    Centimetre,
}

impl HeightUnit {
    /// Metres in one.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Foot => 0.3048,
            Self::UsFoot => 1200.0 / 3937.0,
            Self::Decimetre => 0.1,
            Self::Centimetre => 0.01,
        }
    }

    /// As the command line spells it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Metre => "metre",
            Self::Foot => "foot",
            Self::UsFoot => "us-foot",
            Self::Decimetre => "decimetre",
            Self::Centimetre => "centimetre",
        }
    }

    /// As files spell it: `m`, `Meters`, `US survey foot`, ...
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let plain: String = text.to_lowercase().chars().filter(char::is_ascii_alphanumeric).collect();
        match plain.as_str() {
            "m" | "metre" | "metres" | "meter" | "meters" => Some(Self::Metre),
            "ft" | "foot" | "feet" | "internationalfoot" => Some(Self::Foot),
            "usfoot" | "ussurveyfoot" | "ftus" | "usft" | "footus" | "footussurvey" | "ussurveyfeet" => {
                Some(Self::UsFoot)
            }
            "dm" | "decimetre" | "decimetres" | "decimeter" | "decimeters" => Some(Self::Decimetre),
            "cm" | "centimetre" | "centimetres" | "centimeter" | "centimeters" => Some(Self::Centimetre),
            _ => None,
        }
    }
}

/// How the colours of a picture make a height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourCode {
    /// `red * 256 + green + blue / 256 - 32768` metres.
    Terrarium,
    /// `(red * 65536 + green * 256 + blue) / 10 - 10000` metres.
    Mapbox,
}

/// The layout of a file that holds samples and nothing else, row by row, the northern row first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawLayout {
    /// Samples along x.
    pub columns: u32,
    /// Samples along z.
    pub rows: u32,
    pub(crate) samples: SampleType,
    pub(crate) order: ByteOrder,
}

impl RawLayout {
    /// `COLUMNSxROWS:TYPE`, with `be` at its end if the high byte comes first: `513x513:uint16`, `100x80:float32be`.
    pub fn parse(text: &str) -> Option<Self> {
        let (size, samples) = text.split_once(':')?;
        let (columns, rows) = size.split_once('x')?;
        let (samples, order) = match samples.strip_suffix("be") {
            Some(samples) => (samples, ByteOrder::Big),
            None => (samples.strip_suffix("le").unwrap_or(samples), ByteOrder::Little),
        };
        let samples = SampleType::parse(samples)?;
        Some(Self { columns: columns.parse().ok()?, rows: rows.parse().ok()?, samples, order })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_as_files_spell_them() {
        for (text, unit) in
            [("Meters", HeightUnit::Metre), ("ft", HeightUnit::Foot), ("US survey foot", HeightUnit::UsFoot)]
        {
            assert_eq!(HeightUnit::parse(text), Some(unit));
        }
        assert_eq!(HeightUnit::parse("furlong"), None);
    }

    #[test]
    fn raw_layouts() {
        let layout = RawLayout { columns: 3, rows: 2, samples: SampleType::U16, order: ByteOrder::Little };
        assert_eq!(RawLayout::parse("3x2:uint16"), Some(layout));
        assert_eq!(RawLayout::parse("3x2:uint16be"), Some(RawLayout { order: ByteOrder::Big, ..layout }));
        for wrong in ["", "3x2", "3:uint16", "3x2:text", "3x2:int24", "-3x2:uint16"] {
            assert_eq!(RawLayout::parse(wrong), None, "{wrong}");
        }
    }
}
