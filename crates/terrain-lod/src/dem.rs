//! `dem info`, and the opening of DEMs with their warnings: files of cells are DEMs too.

use std::ops::ControlFlow;
use std::path::Path;

use htp_lod::Provenance;
use serde::Serialize;
use terrain_dem::{Dem, DemRows, HeightUnit, ReadOptions, Reading, VoidMask, VoidPolicy, whereabouts};

use crate::cells_dem::CellsDem;
use crate::dem_args::{DemCommand, DemToolArgs, FormatName, InfoArgs};
use crate::fault::Fault;
use crate::output::{print, tidy};
use crate::{cells_file, convert, cut, shade, synth};

/// Opens a DEM, and says on stderr what the user should know about it, one line each.
pub fn open(spec: &str, options: &ReadOptions) -> Result<Dem, Fault> {
    if cells_file::is_one(Path::new(spec)) {
        let cells = CellsDem::open(Path::new(spec), options)?;
        warn(spec, &cells.reading);
        return cells.load();
    }
    let dem = terrain_dem::open(spec, options)?;
    warn(spec, &dem.reading);
    Ok(dem)
}

fn warn(spec: &str, reading: &Reading) {
    for warning in &reading.warnings {
        eprintln!("warning: {spec}: {warning}");
    }
}

/// A DEM of which a few rows are in memory.
pub enum Rows {
    File(DemRows),
    Cells(CellsDem),
}

impl Rows {
    /// As [`open`], without loading it if that can be helped.
    pub fn open(spec: &str, options: &ReadOptions) -> Result<Self, Fault> {
        if cells_file::is_one(Path::new(spec)) {
            let cells = CellsDem::open(Path::new(spec), options)?;
            warn(spec, &cells.reading);
            return Ok(Self::Cells(cells));
        }
        let rows = terrain_dem::open_rows(spec, options)?;
        warn(spec, &rows.reading);
        Ok(Self::File(rows))
    }

    pub fn samples(&self) -> [u32; 2] {
        match self {
            Self::File(rows) => rows.samples,
            Self::Cells(cells) => cells.header().samples,
        }
    }

    pub fn spacing_m(&self) -> [f64; 2] {
        match self {
            Self::File(rows) => rows.spacing_m,
            Self::Cells(cells) => cells.header().spacing_m,
        }
    }

    /// Where the DEM comes from.
    pub fn provenance(&self) -> Provenance {
        match self {
            Self::File(rows) => {
                let place = whereabouts(rows.reading.crs.as_deref(), rows.georeference.as_ref());
                Provenance {
                    source: rows.source.clone(),
                    licence: rows.licence.clone(),
                    notice: rows.notice.clone(),
                    place: Some(place).filter(|place| !place.is_empty()),
                }
            }
            Self::Cells(cells) => cells.header().provenance.clone(),
        }
    }

    /// Where the rows hold the fill of voids that stay open.
    pub fn voids(&self) -> Option<&VoidMask> {
        match self {
            Self::File(rows) => rows.voids.as_deref(),
            Self::Cells(cells) => cells.open_voids().map(|voids| &**voids),
        }
    }

    /// Metres a step of the file's values, and at the value 0.
    pub fn steps(&self) -> [f64; 2] {
        let reading = match self {
            Self::File(rows) => &rows.reading,
            Self::Cells(cells) => &cells.reading,
        };
        [reading.scale, reading.offset_m]
    }

    /// Calls with each row in metres, from the northern one on, until that breaks.
    pub fn for_each(&self, on_row: &mut dyn FnMut(&[f32]) -> ControlFlow<()>) -> Result<(), Fault> {
        match self {
            Self::File(rows) => Ok(rows.for_each(on_row).map(drop)?),
            Self::Cells(cells) => cells.for_each(on_row),
        }
    }
}

pub fn run(args: &DemToolArgs) -> Result<(), Fault> {
    match &args.command {
        DemCommand::Info(args) => info(args),
        DemCommand::Cells(args) => cut::run(args),
        DemCommand::Convert(args) => convert::run(args),
        DemCommand::Shade(args) => shade::run(args),
        DemCommand::Synth(args) => synth::run(args),
    }
}

fn info(args: &InfoArgs) -> Result<(), Fault> {
    let (path, options) = (Path::new(&args.dem), args.read.options());
    if cells_file::is_one(path) {
        let cells = CellsDem::open(path, &options)?;
        return say(args, &Description::of_cells(&args.dem, &cells, options.voids));
    }
    let dem = terrain_dem::open(&args.dem, &options)?;
    say(args, &Description::of(&args.dem, &dem, options.voids))
}

fn say(args: &InfoArgs, described: &Description) -> Result<(), Fault> {
    print(&match args.format {
        FormatName::Text => described.text(),
        FormatName::Json => serde_json::to_string_pretty(described).expect("numbers become JSON") + "\n",
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
    /// Samples without a height.
    voids: u64,
    /// What becomes of them.
    void_policy: &'static str,
    source: Option<&'a str>,
    licence: Option<&'a str>,
    notice: Option<&'a str>,
    warnings: &'a [String],
}

impl<'a> Description<'a> {
    fn of(spec: &'a str, dem: &'a Dem, policy: VoidPolicy) -> Self {
        let map = &dem.heightmap;
        let wider = |[low, high]: [f32; 2], height_m: &f32| [low.min(*height_m), high.max(*height_m)];
        let range_m = map.heights_m().iter().fold([f32::INFINITY, f32::NEG_INFINITY], wider);
        Self {
            voids: dem.voids.as_ref().map_or(0, |voids| voids.count()),
            source: dem.source.as_deref(),
            licence: dem.licence.as_deref(),
            notice: dem.notice.as_deref(),
            ..Self::new(spec, [map.columns(), map.rows()], map.spacing_m(), range_m, policy, &dem.reading)
        }
    }

    /// By the header: the heights are not read.
    fn of_cells(spec: &'a str, cells: &'a CellsDem, policy: VoidPolicy) -> Self {
        let header = cells.header();
        let Provenance { source, licence, notice, .. } = &header.provenance;
        Self {
            voids: header.voids.map_or(0, |voids| voids.count),
            source: source.as_deref(),
            licence: licence.as_deref(),
            notice: notice.as_deref(),
            ..Self::new(spec, header.samples, header.spacing_m, header.height_range_m, policy, &cells.reading)
        }
    }

    fn new(
        spec: &'a str,
        [columns, rows]: [u32; 2],
        spacing_m: [f64; 2],
        [lowest_m, highest_m]: [f32; 2],
        policy: VoidPolicy,
        reading: &'a Reading,
    ) -> Self {
        let extent_m = [(columns - 1) as f64 * spacing_m[0], (rows - 1) as f64 * spacing_m[1]];
        Self {
            dem: spec,
            format: &reading.format,
            sample_type: reading.samples,
            bands: reading.bands,
            crs: reading.crs.as_deref(),
            columns,
            rows,
            spacing_m: spacing_m.map(tidy),
            spacing_from: &reading.spacing_from,
            extent_m: extent_m.map(tidy),
            lowest_m,
            highest_m,
            unit: reading.unit.map(HeightUnit::name),
            scale: reading.scale,
            offset_m: reading.offset_m,
            nodata: reading.nodata,
            voids: 0,
            void_policy: policy.name(),
            source: None,
            licence: None,
            notice: None,
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
             voids    {} ({declared}; policy: {})\n",
            self.dem,
            self.format,
            self.sample_type,
            self.crs.unwrap_or("not said"),
            self.spacing_from,
            self.voids,
            self.void_policy,
        );
        for (name, line) in [("source", self.source), ("licence", self.licence), ("notice", self.notice)] {
            text += &line.map_or(String::new(), |line| format!("  {name:<8} {line}\n"));
        }
        for warning in self.warnings {
            text += &format!("  warning  {warning}\n");
        }
        text
    }
}
