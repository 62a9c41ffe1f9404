//! Other distances between samples than the file's: bilinear, over the same ground.

use std::sync::Arc;

use terrain_core::Heightmap;

use crate::Dem;
use crate::voids::VoidMask;

/// A DEM with samples `spacing_m` apart in x and z, from the same north-western sample on. A new sample is a void where one
/// of those that it is made of is.
pub(crate) fn resample(dem: Dem, spacing_m: Option<[f64; 2]>) -> Result<Dem, String> {
    let Some(spacing_m) = spacing_m.filter(|spacing_m| *spacing_m != dem.heightmap.spacing_m()) else { return Ok(dem) };
    let map = &dem.heightmap;
    let (columns, rows) = (
        Axis::of(map.columns(), map.spacing_m()[0], spacing_m[0])?,
        Axis::of(map.rows(), map.spacing_m()[1], spacing_m[1])?,
    );
    let count = u64::from(columns.count) * u64::from(rows.count);
    if count > crate::MAX_SAMPLES {
        let expected = format!("expected at most {} in all", crate::MAX_SAMPLES);
        return Err(format!("{} x {} samples at that spacing; {expected}", columns.count, rows.count));
    }
    let (mut heights_m, mut is_void) = (Vec::with_capacity(count as usize), Vec::new());
    let mask = dem.voids.as_deref();
    for row in rows.places() {
        for column in columns.places() {
            heights_m.push(height_m(map, column, row));
            is_void.extend(mask.map(|mask| corners(column, row).any(|(at, _)| mask.is_void(at[0], at[1]))));
        }
    }
    let heightmap = Heightmap::new(columns.count, rows.count, spacing_m, heights_m).map_err(|e| e.to_string())?;
    let voids = mask.map(|_| VoidMask::of_flags(columns.count, &is_void)).filter(|mask| mask.count() > 0).map(Arc::new);
    let name = format!("{}-{}m", dem.name, spacing_m[0]);
    let coarser = |axis: usize, step: f64| step * spacing_m[axis] / map.spacing_m()[axis];
    let georeference = dem.georeference.map(|mut there| {
        there.place.step = [0, 1].map(|axis| coarser(axis, there.place.step[axis]));
        there
    });
    Ok(Dem { name, heightmap: Arc::new(heightmap), voids, georeference, ..dem })
}

/// Places along one axis of a grid.
struct Axis {
    /// New samples.
    count: u32,
    /// Old intervals a new one.
    step: f64,
    /// The last old sample.
    last: u32,
}

/// An old sample, and how far to the next one.
type Place = (u32, f64);

impl Axis {
    fn of(samples: u32, spacing_m: f64, new_spacing_m: f64) -> Result<Self, String> {
        let step = new_spacing_m / spacing_m;
        let last = samples - 1;
        // Rounding must not lose the last sample where the new spacing divides the extent.
        let intervals = (f64::from(last) / step + 1e-9).floor();
        if !(1.0..f64::from(Heightmap::MAX_SIDE)).contains(&intervals) {
            let (least, most) =
                (f64::from(last) * spacing_m / f64::from(Heightmap::MAX_SIDE - 1), f64::from(last) * spacing_m);
            return Err(format!("a spacing of {new_spacing_m} m; expected {least:.3} to {most:.3} for this DEM"));
        }
        Ok(Self { count: intervals as u32 + 1, step, last })
    }

    fn places(&self) -> impl Iterator<Item = Place> {
        (0..self.count).map(|i| {
            let exact = (f64::from(i) * self.step).min(f64::from(self.last));
            let first = (exact as u32).min(self.last - 1);
            (first, exact - f64::from(first))
        })
    }
}

/// The samples around a place that count there, with their weights.
fn corners((column, x): Place, (row, z): Place) -> impl Iterator<Item = ([u32; 2], f64)> {
    let all = [([0, 0], (1.0 - x) * (1.0 - z)), ([1, 0], x * (1.0 - z)), ([0, 1], (1.0 - x) * z), ([1, 1], x * z)];
    let counts = all.into_iter().filter(|(_, weight)| *weight > 0.0);
    counts.map(move |([dx, dz], weight)| ([column + dx, row + dz], weight))
}

fn height_m(map: &Heightmap, column: Place, row: Place) -> f32 {
    let at = |[column, row]: [u32; 2]| map.heights_m()[row as usize * map.columns() as usize + column as usize];
    corners(column, row).map(|(sample, weight)| f64::from(at(sample)) * weight).sum::<f64>() as f32
}

#[cfg(test)]
mod tests {
    use crate::{ReadOptions, read_bytes};

    const ASC: &str = "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -1\n";

    fn resampled(heights: &str, spacing_m: [f64; 2]) -> Result<crate::Dem, crate::DemError> {
        let options = ReadOptions { resample_m: Some(spacing_m), ..ReadOptions::default() };
        read_bytes("a.asc", format!("{ASC}{heights}\n").into_bytes(), &options)
    }

    #[test]
    fn a_plane_stays_a_plane() {
        let dem = resampled("0 10 20 30\n5 15 25 35\n10 20 30 40", [2.5, 4.0]).unwrap();
        let map = &dem.heightmap;
        assert_eq!((map.columns(), map.rows(), map.spacing_m(), dem.name.as_str()), (13, 6, [2.5, 4.0], "a-2.5m"));
        for (i, height_m) in map.heights_m().iter().enumerate() {
            let expected = (i % 13) as f32 * 2.5 + (i / 13) as f32 * 2.0;
            assert!((height_m - expected).abs() < 1e-4, "{i}: {height_m} {expected}");
        }
    }

    #[test]
    fn a_spacing_that_divides_the_old_one_keeps_all_samples_and_voids() {
        let dem = resampled("1 2 3 4\n5 -1 7 8\n9 9 9 9", [5.0, 10.0]).unwrap();
        let map = &dem.heightmap;
        assert_eq!((map.columns(), map.rows()), (7, 3));
        assert_eq!(map.heights_m()[..7], [1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0]);
        let voids = dem.voids.unwrap();
        let found: Vec<u32> = (0..7).filter(|column| voids.is_void(*column, 1)).collect();
        assert_eq!((found, voids.count()), (vec![1, 2, 3], 3));
    }

    #[test]
    fn a_spacing_beyond_the_dem_is_refused() {
        for wrong in [31.0, 0.0001] {
            let error = resampled("1 2 3 4\n5 6 7 8\n9 9 9 9", [wrong, 10.0]).unwrap_err().to_string();
            assert!(error.contains("m; expected 0.000 to 30.000 for this DEM"), "{error}");
        }
    }
}
