//! Parts of a DEM: a rectangle of its samples, or every n-th of them.

use std::sync::Arc;

use terrain_core::{Heightmap, Sample};

use crate::Dem;
use crate::georef::Georeference;
use crate::voids::VoidMask;

/// A rectangle of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Samples along x and along z.
    pub size: [u32; 2],
    /// Its first column and row; in the middle of the DEM without.
    pub first: Option<[u32; 2]>,
}

/// A crop in a grid that it lies in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Column and row of its first sample.
    pub first: [u32; 2],
    /// Samples along x and along z.
    pub size: [u32; 2],
}

impl Crop {
    /// `COLUMNSxROWS` in the middle, or `COLUMNSxROWS+COLUMN+ROW`: `513x513`, `513x257+100+0`.
    pub fn parse(text: &str) -> Option<Self> {
        let mut parts = text.split('+');
        let (columns, rows) = parts.next()?.split_once('x')?;
        let size = [columns.parse().ok()?, rows.parse().ok()?];
        let first = match (parts.next(), parts.next(), parts.next()) {
            (None, ..) => None,
            (Some(column), Some(row), None) => Some([column.parse().ok()?, row.parse().ok()?]),
            _ => return None,
        };
        Some(Self { size, first })
    }

    /// Its samples in a DEM, if it lies in it.
    pub(crate) fn window_in(&self, samples: [u32; 2]) -> Result<Window, String> {
        let middle = [0, 1].map(|axis| samples[axis].saturating_sub(self.size[axis]) / 2);
        let first = self.first.unwrap_or(middle);
        let fits = |axis: usize| first[axis].checked_add(self.size[axis]).is_some_and(|end| end <= samples[axis]);
        if fits(0) && fits(1) {
            return Ok(Window { first, size: self.size });
        }
        let ([columns, rows], [column, row], [has_columns, has_rows]) = (self.size, first, samples);
        Err(format!(
            "it has {has_columns} x {has_rows} samples; expected a crop within, not {columns}x{rows}+{column}+{row}"
        ))
    }
}

/// The samples of `crop`, and of those every `thin`-th column and row from the first on.
pub(crate) fn part(dem: Dem, crop: Option<Crop>, thin: u32) -> Result<Dem, String> {
    if crop.is_none() && thin == 1 {
        return Ok(dem);
    }
    let whole = &dem.heightmap;
    let samples = [whole.columns(), whole.rows()];
    let crop = crop.unwrap_or(Crop { size: samples, first: Some([0, 0]) });
    let window = crop.window_in(samples)?;
    let [column, row] = window.first;
    let [columns, rows] = window.size.map(|side| side.div_ceil(thin));
    let places = (0..rows).flat_map(|z| (0..columns).map(move |x| [x, z]));
    let places = places.map(|[x, z]| Sample { column: column + x * thin, row: row + z * thin });
    let heights_m = places.clone().map(|sample| whole.height_m(sample)).collect();
    let spacing_m = whole.spacing_m().map(|metres| metres * f64::from(thin));
    let heightmap = Heightmap::new(columns, rows, spacing_m, heights_m).map_err(|e| e.to_string())?;
    let is_void = |mask: &VoidMask| places.map(|at| mask.is_void(at.column, at.row)).collect::<Vec<_>>();
    let voids = dem.voids.as_deref().map(|mask| VoidMask::of_flags(columns, &is_void(mask)));
    let voids = voids.filter(|mask| mask.count() > 0).map(Arc::new);
    let name = name(&dem.name, window, samples, thin);
    let georeference =
        dem.georeference.map(|whole| Georeference { place: whole.place.part([column, row], thin), ..whole });
    Ok(Dem { name, heightmap: Arc::new(heightmap), voids, georeference, ..dem })
}

/// Tells parts of a DEM from each other and from the whole.
pub(crate) fn name(whole: &str, window: Window, samples: [u32; 2], thin: u32) -> String {
    let Window { first: [column, row], size: [columns, rows] } = window;
    let cropped = if window.size == samples { String::new() } else { format!("-{columns}x{rows}+{column}+{row}") };
    let thinned = if thin == 1 { String::new() } else { format!("-thin{thin}") };
    format!("{whole}{cropped}{thinned}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReadOptions, VoidPolicy, open};

    fn options(crop: &str, thin: Option<u32>) -> ReadOptions {
        ReadOptions { crop: Crop::parse(crop), thin, ..Default::default() }
    }

    #[test]
    fn rectangles_as_users_write_them() {
        assert_eq!(Crop::parse("5x3"), Some(Crop { size: [5, 3], first: None }));
        assert_eq!(Crop::parse("5x3+1+0"), Some(Crop { size: [5, 3], first: Some([1, 0]) }));
        for wrong in ["", "5", "5x", "5x3+1", "5x3+1+2+3", "5x-3", "5x3+a+b"] {
            assert_eq!(Crop::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn a_part_has_the_samples_of_its_place() {
        let whole = open("synthetic:40x31:3", &ReadOptions::default()).unwrap().heightmap;
        let part = open("synthetic:40x31:3", &options("11x9+20+7", Some(3))).unwrap();
        assert_eq!((part.heightmap.columns(), part.heightmap.rows()), (4, 3));
        assert_eq!(part.heightmap.spacing_m(), whole.spacing_m().map(|metres| 3.0 * metres));
        assert_eq!(part.name, "synthetic-40x31-3-11x9+20+7-thin3");
        for (column, row) in (0..3).flat_map(|row| (0..4).map(move |column| (column, row))) {
            let there = Sample { column: 20 + 3 * column, row: 7 + 3 * row };
            assert_eq!(part.heightmap.height_m(Sample { column, row }), whole.height_m(there));
        }
        let middle = open("synthetic:40x31:3", &options("11x9", None)).unwrap();
        assert_eq!(
            middle.heightmap.height_m(Sample { column: 0, row: 0 }),
            whole.height_m(Sample { column: 14, row: 11 })
        );
    }

    #[test]
    fn voids_go_with_their_samples() {
        let text =
            "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -1\n1 2 3 4\n5 -1 7 8\n9 9 9 9\n";
        let read = |crop| crate::read_bytes("a.asc", text.into(), &options(crop, None)).unwrap();
        let part = read("2x2+1+1");
        assert_eq!(part.voids.as_ref().map(|mask| (mask.count(), mask.is_void(0, 0))), Some((1, true)));
        assert_eq!(part.heightmap.voids(), part.voids.as_deref());
        assert_eq!((read("2x2+2+1").voids, read("2x2+2+1").heightmap.voids()), (None, None));
        let fill = ReadOptions { voids: VoidPolicy::Fill, ..options("2x2+1+1", None) };
        let filled = crate::read_bytes("a.asc", text.into(), &fill).unwrap();
        assert!(filled.heightmap.voids().is_none() && filled.voids == part.voids);
        assert_eq!(filled.heightmap.heights_m(), part.heightmap.heights_m());
    }

    /// Tiles and rows beside the part are not even looked at.
    #[test]
    fn a_part_of_a_file_is_read_without_the_rest() {
        let whole: Vec<u8> = (0..40 * 31u16).flat_map(u16::to_le_bytes).collect();
        let raw = crate::RawLayout::parse("40x31:uint16");
        let read = |crop, max_samples| {
            let options = ReadOptions {
                raw,
                max_samples: Some(max_samples),
                spacing_m: Some([10.0; 2]),
                ..options(crop, Some(2))
            };
            crate::read_bytes("a.r16", whole.clone(), &options)
        };
        let part = read("11x9+20+7", 99).unwrap();
        assert_eq!((part.heightmap.columns(), part.heightmap.rows(), &part.name[..]), (6, 5, "a-11x9+20+7-thin2"));
        for (column, row) in (0..5).flat_map(|row| (0..6).map(move |column| (column, row))) {
            let value = (7 + 2 * row) * 40 + 20 + 2 * column;
            assert_eq!(part.heightmap.height_m(Sample { column, row }), value as f32);
        }
        let refused = read("11x9+20+7", 98).unwrap_err().to_string();
        assert!(refused.starts_with("a.r16: 11 x 9 samples; expected"), "{refused}");
        let beyond = read("11x9+30+7", 99).unwrap_err().to_string();
        assert_eq!(beyond, "a.r16: it has 40 x 31 samples; expected a crop within, not 11x9+30+7");
    }

    #[test]
    fn a_part_beyond_the_dem_is_refused() {
        let refused = open("synthetic:40x31:3", &options("11x9+30+7", None)).unwrap_err().to_string();
        let expected = "synthetic:40x31:3: it has 40 x 31 samples; expected a crop within, not 11x9+30+7";
        assert_eq!(refused, expected);
        assert!(open("synthetic:40x31:3", &options("1x9", None)).is_err(), "no DEM has one column");
    }
}
