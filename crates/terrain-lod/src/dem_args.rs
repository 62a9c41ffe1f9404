//! The part of the command line that is about elevation files.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use serde::{Deserialize, Serialize};
use terrain_core::Heightmap;
use terrain_dem::synthetic::Kind;
use terrain_dem::{ColourCode, Crop, HeightUnit, RawLayout, ReadOptions, VoidPolicy};

use crate::parse::{parse_finite, parse_positive, parse_spacing};

/// Where the heights come from.
#[derive(Clone, Debug, Args)]
pub struct DemArgs {
    /// An elevation file (GeoTIFF, PNG, .hgt, .asc, .bil, .flt, DTED, PGM, .npy, or .cells by `dem cells`), tiles of one
    /// DEM as a folder or a quoted pattern such as 'N4*W12*.hgt', a built-in DEM (jacksboro), or
    /// synthetic:COLUMNSxROWS:SEED
    #[arg(long, value_name = "FILE")]
    pub dem: Option<String>,
    #[command(flatten)]
    pub read: ReadArgs,
}

/// What the user says about a file; it wins over the sidecar, and that over the file itself.
#[derive(Clone, Debug, Args)]
pub struct ReadArgs {
    /// Metres between samples: one number, or x and z apart
    #[arg(long, value_name = "M[,M]", value_parser = parse_spacing)]
    pub spacing: Option<[f64; 2]>,
    /// Metres for one step of the file's values
    #[arg(long, value_name = "M", value_parser = parse_finite, allow_hyphen_values = true)]
    pub scale: Option<f64>,
    /// Height in metres of the value 0
    #[arg(long, value_name = "M", value_parser = parse_finite, allow_hyphen_values = true)]
    pub offset: Option<f64>,
    /// Accept 8-bit PNGs and PGMs, whose steps are coarse
    #[arg(long)]
    pub allow_8_bit: bool,
    /// The file's value that stands for no height
    #[arg(long, value_name = "VALUE", allow_hyphen_values = true)]
    pub nodata: Option<f64>,
    /// The unit of the file's heights
    #[arg(long, value_name = "UNIT")]
    pub unit: Option<UnitName>,
    /// Which band to read, from 1 [default: the first]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub band: Option<u32>,
    /// What becomes of samples without a height [default: hole]
    #[arg(long)]
    pub voids: Option<VoidsName>,
    /// The most samples to load [default and most: 536870912]
    #[arg(long, value_name = "N")]
    pub max_samples: Option<u64>,
    /// The part of the DEM to take: 513x513 in its middle, or 513x513+COLUMN+ROW
    #[arg(long, value_name = "WxH[+C+R]", value_parser = parse_crop)]
    pub crop: Option<Crop>,
    /// Take every n-th column and row
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=65_535))]
    pub thin: Option<u32>,
    /// Bring the samples of what is taken to this distance in metres: one number, or x and z apart
    #[arg(long, value_name = "M[,M]", value_parser = parse_spacing)]
    pub resample: Option<[f64; 2]>,
    /// Which overview of a TIFF to read, from 1, the finest one [default: the picture itself]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub overview: Option<u32>,
    /// How a colour PNG packs its heights
    #[arg(long, value_name = "CODE")]
    pub png_colours: Option<ColoursName>,
    /// The layout of a file without a header, such as 513x513:uint16 or 100x80:float32be
    #[arg(long, value_name = "WxH:TYPE", value_parser = parse_raw)]
    pub raw: Option<RawLayout>,
}

impl DemArgs {
    pub fn read_options(&self) -> ReadOptions {
        self.read.options()
    }
}

impl ReadArgs {
    /// The same for the reader.
    pub fn options(&self) -> ReadOptions {
        ReadOptions {
            spacing_m: self.spacing,
            scale: self.scale,
            offset_m: self.offset,
            allow_8_bit: self.allow_8_bit,
            nodata: self.nodata,
            unit: self.unit.map(HeightUnit::from),
            band: self.band,
            voids: self.voids.map(VoidPolicy::from).unwrap_or_default(),
            max_samples: self.max_samples,
            crop: self.crop,
            thin: self.thin,
            resample_m: self.resample,
            overview: self.overview,
            colours: self.png_colours.map(ColourCode::from),
            raw: self.raw,
        }
    }
}

/// Units of height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UnitName {
    /// 1 m
    Metre,
    /// International, 0.3048 m
    Foot,
    /// US survey foot, 1200/3937 m
    UsFoot,
    /// 0.1 m
    Decimetre,
    /// 0.01 m
    Centimetre,
}

impl From<UnitName> for HeightUnit {
    fn from(name: UnitName) -> Self {
        match name {
            UnitName::Metre => Self::Metre,
            UnitName::Foot => Self::Foot,
            UnitName::UsFoot => Self::UsFoot,
            UnitName::Decimetre => Self::Decimetre,
            UnitName::Centimetre => Self::Centimetre,
        }
    }
}

/// What becomes of voids.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VoidsName {
    /// Left open: not drawn, measured or exported
    Hole,
    /// Smooth heights from their rim, which count as any others
    Fill,
    /// Refuse the file
    Error,
}

impl From<VoidsName> for VoidPolicy {
    fn from(name: VoidsName) -> Self {
        match name {
            VoidsName::Hole => Self::Hole,
            VoidsName::Fill => Self::Fill,
            VoidsName::Error => Self::Error,
        }
    }
}

/// How colours make a height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ColoursName {
    /// Terrarium tiles
    Terrarium,
    /// Mapbox terrain-RGB
    Mapbox,
}

impl From<ColoursName> for ColourCode {
    fn from(name: ColoursName) -> Self {
        match name {
            ColoursName::Terrarium => Self::Terrarium,
            ColoursName::Mapbox => Self::Mapbox,
        }
    }
}

#[derive(Debug, Args)]
pub struct DemToolArgs {
    #[command(subcommand)]
    pub command: DemCommand,
}

#[derive(Debug, Subcommand)]
pub enum DemCommand {
    /// Say what a file holds, and what would be loaded of it
    Info(InfoArgs),
    /// Cut a DEM into cells that htp loads one by one; goes on where it was ended
    Cells(CellsArgs),
    /// Write a DEM in another format, with a sidecar that says what its numbers mean
    Convert(ConvertArgs),
    /// Draw a DEM from above: coloured by height, shaded by slope, voids in magenta
    Shade(ShadeArgs),
    /// Write synthetic ground of any size: 16-bit PNG or .r16, and a sidecar
    Synth(SynthArgs),
}

/// Cells of 243 intervals.
const DEFAULT_K: u32 = 3;
const DEFAULT_LAYERS: u32 = 5;

#[derive(Debug, Args)]
pub struct CellsArgs {
    /// The file, a folder or a quoted pattern of tiles, a built-in DEM (jacksboro), or synthetic:COLUMNSxROWS:SEED
    #[arg(value_name = "IN")]
    pub dem: String,
    /// The file to write; .cells is added to a name without an ending
    #[arg(value_name = "OUT")]
    pub out: PathBuf,
    /// Small triangles along a patch
    #[arg(long, value_name = "N", default_value_t = DEFAULT_K)]
    pub k: u32,
    /// Levels of detail: a cell is k^N sample intervals wide, at most 1024
    #[arg(long, value_name = "N", default_value_t = DEFAULT_LAYERS)]
    pub layers: u32,
    /// What the DEM's owner wants to be shown with it; kept in the file, as are source and licence [default: the sidecar's]
    #[arg(long, value_name = "TEXT")]
    pub notice: Option<String>,
    #[command(flatten)]
    pub read: ReadArgs,
}

impl CellsArgs {
    /// With the defaults of `dem cells`.
    pub fn plain(dem: String, out: PathBuf, read: ReadArgs) -> Self {
        Self { dem, out, k: DEFAULT_K, layers: DEFAULT_LAYERS, notice: None, read }
    }
}

#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// The file, a folder or a quoted pattern of tiles, a built-in DEM (jacksboro), or synthetic:COLUMNSxROWS:SEED
    #[arg(value_name = "IN")]
    pub dem: String,
    /// The file to write: .png (16 bits), .tif (float32), .r16, .r32 or .cells
    ///
    /// Voids are 0 in .png and .r16, NaN in .tif and .r32; with --voids fill they are heights.
    #[arg(value_name = "OUT", verbatim_doc_comment)]
    pub out: PathBuf,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Debug, Args)]
pub struct ShadeArgs {
    /// The file, a folder or a quoted pattern of tiles, a built-in DEM (jacksboro), or synthetic:COLUMNSxROWS:SEED
    #[arg(value_name = "FILE")]
    pub dem: String,
    /// The PNG to write: a pixel a sample; --thin makes it smaller
    #[arg(value_name = "OUT.png")]
    pub out: PathBuf,
    /// Metres that a metre of height counts for in the shade
    #[arg(long, value_name = "TIMES", default_value = "1", value_parser = parse_positive)]
    pub exaggerate: f64,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Debug, Args)]
pub struct SynthArgs {
    /// The file to write, .png or .r16; a sidecar of the same name says what its numbers mean
    #[arg(value_name = "OUT")]
    pub out: PathBuf,
    /// Columns and rows of samples
    #[arg(long, value_name = "WxH", value_parser = parse_samples)]
    pub size: [u32; 2],
    /// Another seed, another ground
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// What the ground is like
    #[arg(long, value_name = "KIND", default_value = "ridged")]
    pub kind: KindName,
}

/// Kinds of synthetic ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum KindName {
    /// Mountains, valleys, and lakes
    Ridged,
    /// Smooth hills
    Hills,
    /// Hills and mountains in a flat sea
    Coast,
    /// A plain with single samples that stand out
    Spikes,
}

impl From<KindName> for Kind {
    fn from(name: KindName) -> Self {
        match name {
            KindName::Ridged => Self::Ridged,
            KindName::Hills => Self::Hills,
            KindName::Coast => Self::Coast,
            KindName::Spikes => Self::Spikes,
        }
    }
}

#[derive(Debug, Args)]
pub struct InfoArgs {
    /// The file, a folder or a quoted pattern of tiles, a built-in DEM (jacksboro), or synthetic:COLUMNSxROWS:SEED
    #[arg(value_name = "FILE")]
    pub dem: String,
    #[command(flatten)]
    pub read: ReadArgs,
    /// For a person or for a program
    #[arg(long, default_value = "text")]
    pub format: FormatName,
}

/// How a command answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FormatName {
    /// Lines
    Text,
    /// One object
    Json,
}

fn parse_samples(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(x, z)| Some([x.parse().ok()?, z.parse().ok()?]));
    let max = Heightmap::MAX_SIDE;
    sides
        .filter(|sides| sides.iter().all(|side| (2..=max).contains(side)))
        .ok_or_else(|| format!("expected columns and rows of 2 to {max} samples, such as 4097x4097"))
}

fn parse_raw(text: &str) -> Result<RawLayout, String> {
    let expected =
        "expected COLUMNSxROWS:TYPE with a type such as uint16, int16, float32, and `be` at its end for big-endian";
    RawLayout::parse(text).ok_or_else(|| expected.into())
}

pub fn parse_crop(text: &str) -> Result<Crop, String> {
    Crop::parse(text).ok_or_else(|| "expected COLUMNSxROWS or COLUMNSxROWS+COLUMN+ROW, such as 513x513+100+0".into())
}
