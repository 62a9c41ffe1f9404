//! `dem shade`: a DEM seen from above, coloured by height, under a sun in the north-west.

use std::path::Path;

use terrain_core::Heightmap;
use terrain_dem::{Dem, write_png_rgb_rows};

use crate::dem;
use crate::dem_args::ShadeArgs;
use crate::fault::Fault;
use crate::output::print;
use crate::results::probe_parent;

/// Voids: no ground has this colour.
const VOID: [u8; 3] = [200, 0, 200];

/// Colours from the lowest sample to the highest, evenly apart: green valleys, brown slopes, white summits.
const RAMP: [[f32; 3]; 6] = [
    [70.0, 120.0, 85.0],
    [130.0, 165.0, 100.0],
    [205.0, 200.0, 140.0],
    [175.0, 135.0, 95.0],
    [150.0, 120.0, 110.0],
    [250.0, 250.0, 250.0],
];

/// Light from the north-west, 45 degrees above the horizon: east, up and south of a vector of length 1.
const TO_SUN: [f64; 3] = [-0.5, std::f64::consts::FRAC_1_SQRT_2, -0.5];

/// What slopes that face away from the sun are left with.
const AMBIENT: f64 = 0.25;

pub fn run(args: &ShadeArgs) -> Result<(), Fault> {
    let out = &args.out;
    if out.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("png")) {
        return Err(Fault::usage(format_args!("{}: expected a name that ends in .png", out.display())));
    }
    if Path::new(&args.dem).canonicalize().is_ok_and(|path| out.canonicalize().is_ok_and(|out| out == path)) {
        return Err(Fault::write(out, "it is the file that is read; expected another name"));
    }
    probe_parent(out)?;
    let dem = dem::open(&args.dem, &args.read.options())?;
    let map = &dem.heightmap;
    let (columns, rows) = (map.columns(), map.rows());
    let shade = Shade::of(&dem, args.exaggerate);
    let mut row = 0..rows;
    write_png_rgb_rows(out, columns, rows, &mut |colours| {
        shade.fill(row.next().expect("a row of the DEM"), colours);
        Ok(())
    })?;
    let [low, high] = shade.range_m;
    print(&format!("{}: {columns} x {rows} pixels, {low} to {high} m\n", out.display()))
}

struct Shade<'a> {
    dem: &'a Dem,
    exaggerate: f64,
    /// Of the samples that are no voids.
    range_m: [f32; 2],
}

impl<'a> Shade<'a> {
    fn of(dem: &'a Dem, exaggerate: f64) -> Self {
        let mut shade = Self { dem, exaggerate, range_m: [f32::INFINITY, f32::NEG_INFINITY] };
        shade.range_m =
            shade.heights_m().fold(shade.range_m, |[low, high], height_m| [low.min(height_m), high.max(height_m)]);
        shade
    }

    /// Of the samples that are no voids.
    fn heights_m(&self) -> impl Iterator<Item = f32> {
        let map = &self.dem.heightmap;
        let rows = (0..).zip(map.heights_m().chunks(map.columns() as usize));
        let samples =
            rows.flat_map(|(row, row_m)| (0..).zip(row_m).map(move |(column, height_m)| (column, row, *height_m)));
        samples.filter(|(column, row, _)| !self.is_void(*column, *row)).map(|(_, _, height_m)| height_m)
    }

    fn is_void(&self, column: u32, row: u32) -> bool {
        self.dem.voids.as_ref().is_some_and(|voids| voids.is_void(column, row))
    }

    fn fill(&self, row: u32, colours: &mut [[u8; 3]]) {
        for (column, colour) in (0..).zip(colours) {
            *colour = if self.is_void(column, row) { VOID } else { self.colour(column, row) };
        }
    }

    fn colour(&self, column: u32, row: u32) -> [u8; 3] {
        let map = &self.dem.heightmap;
        let [low, high] = self.range_m;
        let height_m = height_m(map, column as i64, row as i64);
        let share = if high > low { (height_m as f32 - low) / (high - low) } else { 0.0 };
        let light = light(slope(map, column, row).map(|metres| metres * self.exaggerate)) as f32;
        // Level ground keeps its colour.
        let level = light_of_level() as f32;
        ramp(share).map(|channel| (channel * light / level).min(255.0) as u8)
    }
}

/// The rim's height beyond the rim.
fn height_m(map: &Heightmap, column: i64, row: i64) -> f64 {
    let column = column.clamp(0, map.columns() as i64 - 1) as usize;
    let row = row.clamp(0, map.rows() as i64 - 1) as usize;
    f64::from(map.heights_m()[row * map.columns() as usize + column])
}

/// Metres up a metre to the east and to the south, over the eight neighbours (Horn, "Hill shading and the reflectance
/// map", Proceedings of the IEEE 69, 1981).
fn slope(map: &Heightmap, column: u32, row: u32) -> [f64; 2] {
    let [x, z] = map.spacing_m();
    let at = |dx: i64, dz: i64| height_m(map, column as i64 + dx, row as i64 + dz);
    let across = |from: [f64; 3], to: [f64; 3]| to[0] + 2.0 * to[1] + to[2] - from[0] - 2.0 * from[1] - from[2];
    let east = across([at(-1, -1), at(-1, 0), at(-1, 1)], [at(1, -1), at(1, 0), at(1, 1)]);
    let south = across([at(-1, -1), at(0, -1), at(1, -1)], [at(-1, 1), at(0, 1), at(1, 1)]);
    // At the rim one of the two samples is the middle itself, which halves the slope: not worth a case of its own.
    [east / (8.0 * x), south / (8.0 * z)]
}

/// By the cosine between the ground's normal and the sun.
fn light([east, south]: [f64; 2]) -> f64 {
    let length = (east * east + south * south + 1.0).sqrt();
    let cosine = (TO_SUN[1] - TO_SUN[0] * east - TO_SUN[2] * south) / length;
    AMBIENT + (1.0 - AMBIENT) * cosine.max(0.0)
}

fn light_of_level() -> f64 {
    light([0.0, 0.0])
}

/// The colour at a share of the way from the lowest to the highest sample.
fn ramp(share: f32) -> [f32; 3] {
    let last = RAMP.len() - 1;
    let place = share.clamp(0.0, 1.0) * last as f32;
    let first = (place as usize).min(last - 1);
    let [low, high] = [RAMP[first], RAMP[first + 1]];
    [0, 1, 2].map(|channel| low[channel] + (high[channel] - low[channel]) * (place - first as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_that_face_the_sun_are_lighter() {
        let hill = |east: f32, south: f32| {
            let heights_m = (0..9).map(|i| (i % 3) as f32 * east * 30.0 + (i / 3) as f32 * south * 20.0).collect();
            Heightmap::new(3, 3, [30.0, 20.0], heights_m).unwrap()
        };
        // A plane's slope is exact.
        let [east, south] = slope(&hill(0.5, -0.25), 1, 1);
        assert!((east - 0.5).abs() < 1e-6 && (south + 0.25).abs() < 1e-6, "{east} {south}");
        // Ground that rises to the south-east faces the north-west.
        let [facing, level, averted] = [[0.5, 0.5], [0.0, 0.0], [-0.5, -0.5]].map(light);
        assert!(facing > level && level > averted && averted >= AMBIENT, "{facing} {level} {averted}");
        assert!((light([1.0, 1.0]) - light([f64::sqrt(0.5), f64::sqrt(0.5)])).abs() < 0.1, "nearly towards the sun");
    }

    #[test]
    fn colours_go_from_the_lowest_to_the_highest() {
        assert_eq!((ramp(0.0), ramp(1.0), ramp(-1.0)), (RAMP[0], RAMP[5], RAMP[0]));
        assert_eq!(ramp(0.2), RAMP[1]);
    }
}
