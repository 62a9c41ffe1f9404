//! `dem info`, and the opening of DEMs with their warnings.

use serde::Serialize;
use terrain_dem::{Dem, HeightUnit, ReadOptions};

use crate::dem_args::{DemCommand, DemToolArgs, FormatName, InfoArgs};
use crate::fault::Fault;
use crate::output::{print, tidy};

/// Opens a DEM, and says on stderr what the user should know about it, one line each.
pub fn open(spec: &str, options: &ReadOptions) -> Result<Dem, Fault> {
    let dem = terrain_dem::open(spec, options)?;
    for warning in &dem.reading.warnings {
        eprintln!("warning: {spec}: {warning}");
    }
    Ok(dem)
}

pub fn run(args: &DemToolArgs) -> Result<(), Fault> {
    match &args.command {
        DemCommand::Info(args) => info(args),
    }
}

fn info(args: &InfoArgs) -> Result<(), Fault> {
    let dem = terrain_dem::open(&args.dem, &args.read.options())?;
    let described = Description::of(&args.dem, &dem);
    print(&match args.format {
        FormatName::Text => described.text(),
        FormatName::Json => serde_json::to_string_pretty(&described).expect("numbers become JSON") + "\n",
    })
}

/// What a file holds, and what was loaded of it.
#[derive(Serialize)]
struct Description<'a> {
    dem: &'a str,
    format: &'a str,
    sample_type: &'a str,
    bands: u32,
    crs: Option<&'a str>,
    columns: u32,
    rows: u32,
    /// In x and z.
    spacing_m: [f64; 2],
    /// Who said the spacing.
    spacing_from: &'a str,
    /// In x and z.
    extent_m: [f64; 2],
    lowest_m: f32,
    highest_m: f32,
    /// `None` where neither the file nor the user says it.
    unit: Option<&'static str>,
    /// Metres a step of the file's values.
    scale: f64,
    offset_m: f64,
    nodata: Option<f64>,
    /// Samples without a height, which hold one from their rim.
    voids: u64,
    source: Option<&'a str>,
    licence: Option<&'a str>,
    warnings: &'a [String],
}

impl<'a> Description<'a> {
    fn of(spec: &'a str, dem: &'a Dem) -> Self {
        let (map, reading) = (&dem.heightmap, &dem.reading);
        let wider = |[low, high]: [f32; 2], height_m: &f32| [low.min(*height_m), high.max(*height_m)];
        let [lowest_m, highest_m] = map.heights_m().iter().fold([f32::INFINITY, f32::NEG_INFINITY], wider);
        Self {
            dem: spec,
            format: &reading.format,
            sample_type: reading.samples,
            bands: reading.bands,
            crs: reading.crs.as_deref(),
            columns: map.columns(),
            rows: map.rows(),
            spacing_m: map.spacing_m().map(tidy),
            spacing_from: &reading.spacing_from,
            extent_m: map.extent_m().map(tidy),
            lowest_m,
            highest_m,
            unit: reading.unit.map(HeightUnit::name),
            scale: reading.scale,
            offset_m: reading.offset_m,
            nodata: reading.nodata,
            voids: dem.voids.as_ref().map_or(0, |voids| voids.count()),
            source: dem.source.as_deref(),
            licence: dem.licence.as_deref(),
            warnings: &reading.warnings,
        }
    }

    fn text(&self) -> String {
        let Self { columns, rows, lowest_m, highest_m, scale, offset_m, .. } = self;
        let ([x, z], [width_km, depth_km]) = (self.spacing_m, self.extent_m.map(|metres| metres / 1e3));
        let bands = if self.bands == 1 { String::new() } else { format!(", {} bands", self.bands) };
        let unit = self.unit.unwrap_or("not said, taken as metres");
        let declared = self.nodata.map_or("none declared".to_owned(), |nodata| format!("declared: {nodata}"));
        let mut text = format!(
            "{}\n  \
             format   {}, {}{bands}\n  \
             CRS      {}\n  \
             size     {columns} x {rows} samples, {width_km:.1} x {depth_km:.1} km\n  \
             spacing  {x} x {z} m (by {})\n  \
             heights  {lowest_m} to {highest_m} m (unit {unit}; {scale} m a step, {offset_m} m at 0)\n  \
             voids    {} ({declared})\n",
            self.dem,
            self.format,
            self.sample_type,
            self.crs.unwrap_or("not said"),
            self.spacing_from,
            self.voids,
        );
        for (name, line) in [("source", self.source), ("licence", self.licence)] {
            text += &line.map_or(String::new(), |line| format!("  {name:<8} {line}\n"));
        }
        for warning in self.warnings {
            text += &format!("  warning  {warning}\n");
        }
        text
    }
}
