//! `dem convert`: a DEM of any format into one of ours, or one that others read.

use std::path::Path;

use terrain_dem::{Dem, DemFormat, Steps, write_dem};

use crate::dem_args::{CellsArgs, ConvertArgs, VoidsName};
use crate::fault::Fault;
use crate::output::{print, tidy};
use crate::results::probe_parent;
use crate::{cut, dem, sidecar_file};

const EXPECTED: &str = "expected a name that ends in .png, .tif, .r16, .r32 or .cells";

pub fn run(args: &ConvertArgs) -> Result<(), Fault> {
    let out = &args.out;
    if out.extension().is_some_and(|ending| ending == "cells") {
        return cut::run(&CellsArgs::plain(args.dem.clone(), out.clone(), args.read.clone()));
    }
    let Some(format) = DemFormat::of(out) else {
        return Err(Fault::usage(format_args!("{}: {EXPECTED}", out.display())));
    };
    sidecar_file::check_place(Path::new(&args.dem), out)?;
    probe_parent(out)?;
    let mut dem = dem::open(&args.dem, &args.read.options())?;
    if args.read.voids == Some(VoidsName::Fill) {
        dem.voids = None;
    }
    let steps = write_dem(out, &dem, format)?;
    print(&line(out, &dem, format, steps))
}

fn line(out: &Path, dem: &Dem, format: DemFormat, steps: Option<Steps>) -> String {
    let map = &dem.heightmap;
    let [x, z] = map.spacing_m().map(tidy);
    let voids = match (&dem.voids, steps) {
        (None, _) => String::new(),
        (Some(voids), None) => format!("; {} voids as NaN", voids.count()),
        (Some(voids), Some(_)) => format!("; {} voids as 0", voids.count()),
    };
    let kind = match format {
        DemFormat::Png16 => "16-bit PNG",
        DemFormat::Tiff32 => "float32 GeoTIFF",
        DemFormat::Raw16 => "uint16",
        DemFormat::Raw32 => "float32",
    };
    let steps = steps.map_or(String::new(), |Steps { scale, is_exact, .. }| match is_exact {
        true => format!(" in steps of {scale} m, all heights exact"),
        false => format!(" rounded to steps of {scale:.6} m"),
    });
    let (columns, rows) = (map.columns(), map.rows());
    format!("{}: {columns} x {rows} samples, {x} x {z} m apart, {kind}{steps}{voids}\n", out.display())
}
