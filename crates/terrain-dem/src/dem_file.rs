//! DEMs out: 16-bit PNG, float32 TIFF, and samples without a header; the sidecar that says what their numbers mean.

mod tiff;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::formats::png::write_png16_rows;
use crate::sidecar::whereabouts;
use crate::{Dem, DemError, write_atomically};

/// How a DEM is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DemFormat {
    /// Greyscale of 16 bits; voids are 0.
    Png16,
    /// GeoTIFF of one band in metres, where the DEM lies, or else in coordinates from its south-western sample on; voids are
    /// NaN.
    Tiff32,
    /// `u16`, the low byte first, and nothing else; voids are 0.
    Raw16,
    /// `f32` in metres, the low byte first, and nothing else; voids are NaN.
    Raw32,
}

impl DemFormat {
    /// By the ending of the name.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_lowercase();
        match ending.as_str() {
            "png" => Some(Self::Png16),
            "tif" | "tiff" => Some(Self::Tiff32),
            "r16" => Some(Self::Raw16),
            "r32" => Some(Self::Raw32),
            _ => None,
        }
    }

    fn is_16_bits(self) -> bool {
        matches!(self, Self::Png16 | Self::Raw16)
    }
}

/// What 16-bit values mean: `height_m = value * scale + offset_m`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steps {
    /// Metres a step.
    pub scale: f64,
    /// Metres at the value 0.
    pub offset_m: f64,
    /// Whether every height comes back as the very same number.
    pub is_exact: bool,
}

/// Writes a DEM, and beside it the sidecar that it is read back by; the steps of 16-bit values.
pub fn write_dem(path: &Path, dem: &Dem, format: DemFormat) -> Result<Option<Steps>, DemError> {
    let steps = format.is_16_bits().then(|| Steps::of(dem));
    let map = &dem.heightmap;
    let (columns, rows) = (map.columns(), map.rows());
    match (format, steps) {
        (DemFormat::Png16, Some(steps)) => {
            let mut row = 0..rows;
            write_png16_rows(path, columns, rows, &mut |values| {
                steps.fill(dem, row.next().expect("a row of the DEM"), values);
                Ok(())
            })?;
        }
        (DemFormat::Raw16, Some(steps)) => write(path, |out| {
            let mut values = vec![0; columns as usize];
            (0..rows).try_for_each(|row| {
                steps.fill(dem, row, &mut values);
                out.write_all(&bytes(values.iter().map(|value| value.to_le_bytes())))
            })
        })?,
        (DemFormat::Tiff32, _) => write(path, |out| tiff::write(out, dem))?,
        _ => write(path, |out| (0..rows).try_for_each(|row| out.write_all(&row_f32(dem, row))))?,
    }
    let sidecar = sidecar(dem, format, steps);
    write(&sidecar_of(path), |out| out.write_all(sidecar.as_bytes()))?;
    Ok(steps)
}

/// The sidecar of a file of a DEM.
pub fn sidecar_of(path: &Path) -> PathBuf {
    path.with_extension("toml")
}

fn write(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), DemError> {
    write_atomically(path, write).map_err(|e| DemError::io("write", path, e))
}

fn bytes<const N: usize>(values: impl Iterator<Item = [u8; N]>) -> Vec<u8> {
    values.flatten().collect()
}

/// A row in metres, NaN at voids.
fn row_f32(dem: &Dem, row: u32) -> Vec<u8> {
    bytes(heights_m(dem, row).map(|height_m| height_m.unwrap_or(f32::NAN).to_le_bytes()))
}

fn heights_m(dem: &Dem, row: u32) -> impl Iterator<Item = Option<f32>> {
    let columns = dem.heightmap.columns();
    let start = row as usize * columns as usize;
    let row_m = &dem.heightmap.heights_m()[start..start + columns as usize];
    let is_void = move |column| dem.voids.as_ref().is_some_and(|voids| voids.is_void(column, row));
    row_m.iter().zip(0..).map(move |(height_m, column)| (!is_void(column)).then_some(*height_m))
}

/// The value of a void.
const VOID: u16 = 0;

impl Steps {
    /// The file's own steps, if 65,536 of them, or one less where there are voids, reach from the lowest sample to the
    /// highest and give every height back; or else as many as there are.
    fn of(dem: &Dem) -> Self {
        let all = || (0..dem.heightmap.rows()).flat_map(|row| heights_m(dem, row)).flatten();
        let wider = |[low, high]: [f32; 2], height_m: f32| [low.min(height_m), high.max(height_m)];
        let [low, high] = all().fold([f32::INFINITY, f32::NEG_INFINITY], wider).map(f64::from);
        let first = if dem.voids.is_some() { VOID + 1 } else { 0 };
        let mut own = Self { scale: dem.reading.scale, offset_m: dem.reading.offset_m, is_exact: true };
        // A whole number of steps down, so that values and heights keep their meaning as long as they can.
        let lowest = ((low - own.offset_m) / own.scale).round();
        if lowest < f64::from(first) || (high - own.offset_m) / own.scale > f64::from(u16::MAX) + 0.5 {
            own.offset_m += (lowest - f64::from(first)) * own.scale;
        }
        if own.scale > 0.0 && all().all(|height_m| own.gives_back(height_m)) {
            return own;
        }
        let steps = f64::from(u16::MAX - first);
        let scale = if high > low { (high - low) / steps } else { 1.0 };
        let mut fitted = Self { scale, offset_m: low - f64::from(first) * scale, is_exact: true };
        fitted.is_exact = all().all(|height_m| fitted.gives_back(height_m));
        fitted
    }

    /// Saturates.
    fn value(self, height_m: f32) -> u16 {
        ((f64::from(height_m) - self.offset_m) / self.scale).round() as u16
    }

    /// As the reader computes it.
    fn gives_back(self, height_m: f32) -> bool {
        (f64::from(self.value(height_m)) * self.scale + self.offset_m) as f32 == height_m
    }

    fn fill(self, dem: &Dem, row: u32, values: &mut [u16]) {
        for (value, height_m) in values.iter_mut().zip(heights_m(dem, row)) {
            *value = height_m.map_or(VOID, |height_m| self.value(height_m));
        }
    }
}

fn sidecar(dem: &Dem, format: DemFormat, steps: Option<Steps>) -> String {
    let map = &dem.heightmap;
    let mut text = format!("{SIDECAR_MARK}\nspacing_m = {:?}\n", map.spacing_m());
    if let Some(Steps { scale, offset_m, .. }) = steps {
        text += &format!("scale = {scale:?}\noffset_m = {offset_m:?}\n");
    }
    if steps.is_some() && dem.voids.is_some() {
        text += &format!("nodata = {VOID}\n");
    }
    let raw = match format {
        DemFormat::Raw16 => Some("uint16"),
        DemFormat::Raw32 => Some("float32"),
        DemFormat::Png16 | DemFormat::Tiff32 => None,
    };
    text += &raw.map_or(String::new(), |kind| format!("raw = \"{}x{}:{kind}\"\n", map.columns(), map.rows()));
    // A GeoTIFF says it itself.
    if format != DemFormat::Tiff32 {
        text += &whereabouts(dem.reading.crs.as_deref(), dem.georeference.as_ref());
    }
    for (key, words) in [("source", &dem.source), ("licence", &dem.licence), ("notice", &dem.notice)] {
        let words = words.as_ref().map(|words| toml::Value::from(words.as_str()));
        text += &words.map_or(String::new(), |words| format!("{key} = {words}\n"));
    }
    text
}

/// The first line of each sidecar that a program of ours wrote, and may write anew.
pub const SIDECAR_MARK: &str = "# Written by terrain-lod.";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ReadOptions, read, read_bytes};

    const ASC: &str = "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 10\nNODATA_value -1\n";

    fn dem(heights: &str, options: &ReadOptions) -> Dem {
        read_bytes("a.asc", format!("{ASC}{heights}\n").into_bytes(), options).unwrap()
    }

    /// What is read back of each format.
    fn back(dem: &Dem) -> Vec<(Option<Steps>, Dem)> {
        let folder = tempfile::tempdir().unwrap();
        let one = |name: &str| {
            let path = folder.path().join(name);
            let steps = write_dem(&path, dem, DemFormat::of(&path).unwrap()).unwrap();
            (steps, read(&path, &ReadOptions::default()).unwrap())
        };
        ["a.png", "b.tif", "c.r16", "d.r32"].map(one).into()
    }

    #[test]
    fn every_format_gives_heights_voids_and_spacing_back() {
        let options = ReadOptions { scale: Some(0.1), spacing_m: Some([30.0, 20.5]), ..ReadOptions::default() };
        let written = Dem {
            source: Some("\"quoted\"\nand wrapped".to_owned()),
            ..dem("10 20 30 -25\n5 -1 70 60010\n9 9 9 9", &options)
        };
        for (steps, read) in back(&written) {
            let format = &read.reading.format;
            assert_eq!((&read.heightmap, &read.voids), (&written.heightmap, &written.voids), "{format}");
            assert_eq!(read.source, written.source, "{format}");
            assert!(steps.is_none_or(|steps| steps.is_exact && steps.scale == 0.1), "{format}: {steps:?}");
        }
    }

    fn tiff_of(dem: &Dem) -> Dem {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.tif");
        write_dem(&path, dem, DemFormat::Tiff32).unwrap();
        read(&path, &ReadOptions::default()).unwrap()
    }

    #[test]
    fn a_tiff_keeps_the_place_of_a_part_and_its_system() {
        let tile = [0; 50];
        let part = |name: &str| {
            let options = ReadOptions { crop: crate::Crop::parse("4x3+1+2"), thin: Some(2), ..ReadOptions::default() };
            read_bytes(name, tile.into(), &options).unwrap()
        };
        let written = tiff_of(&part("N44W122.hgt"));
        let there = written.georeference.as_ref().unwrap();
        // Samples of a quarter of a degree from the corner at 45 N 122 W, every second of them.
        assert_eq!((there.place.west, there.place.north, there.place.step), (-121.75, 44.5, [0.5; 2]));
        assert_eq!(written.reading.crs.as_deref(), Some("EPSG:4326"));
        assert_eq!(tiff_of(&written).georeference, written.georeference, "and again");
        // Nobody knows where that is.
        assert_eq!(part_of_nowhere(&tile).georeference.unwrap().place.west, 0.0);
    }

    #[test]
    fn a_sidecar_keeps_the_place_and_the_system() {
        let tile = read_bytes("N44W122.hgt", vec![0; 50], &ReadOptions::default()).unwrap();
        let tile = tiff_of(&tile);
        assert!(tile.georeference.is_some() && tile.reading.crs.is_some());
        for (_, read) in back(&tile) {
            assert_eq!((&read.georeference, &read.reading.crs), (&tile.georeference, &tile.reading.crs));
            assert_eq!(tiff_of(&read).georeference, tile.georeference, "and on into a GeoTIFF");
        }
        let mut nowhere = tile.clone();
        nowhere.georeference.as_mut().unwrap().keys.doubles.push(f64::NAN);
        assert!(
            back(&nowhere).iter().all(|(_, read)| read.heightmap == tile.heightmap),
            "what is not sound is not written"
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        write_dem(&path, &tile, DemFormat::Png16).unwrap();
        let part = read(&path, &ReadOptions { crop: crate::Crop::parse("3x2+1+2"), ..ReadOptions::default() }).unwrap();
        let there = part.georeference.unwrap().place;
        assert_eq!((there.west, there.north), (-121.75, 44.5), "a part lies where the part lies");
        let moved = read(&path, &ReadOptions { spacing_m: Some([1.0; 2]), ..ReadOptions::default() }).unwrap();
        assert_eq!(moved.georeference, None, "whoever says another spacing does not trust the place");
    }

    fn part_of_nowhere(tile: &[u8]) -> Dem {
        let options = ReadOptions { spacing_m: Some([30.0; 2]), ..ReadOptions::default() };
        tiff_of(&read_bytes("a.hgt", tile.into(), &options).unwrap())
    }

    #[test]
    fn a_place_goes_with_the_files_own_spacing_alone() {
        let rows = "1 2 3 4\n5 6 7 8\n9 9 9 9";
        let at = |options: &ReadOptions| tiff_of(&dem(rows, options)).georeference.unwrap().place;
        // The corner of the cells is at 0, 0.
        assert_eq!((at(&ReadOptions::default()).west, at(&ReadOptions::default()).north), (5.0, 25.0));
        let told = at(&ReadOptions { spacing_m: Some([30.0; 2]), ..ReadOptions::default() });
        assert_eq!((told.west, told.north, told.step), (0.0, 60.0, [30.0; 2]));
    }

    #[test]
    fn heights_beyond_16_bits_are_rounded_to_the_finest_steps() {
        let written = dem("0.25 1 2 3\n4 5 6 7.5\n8 9 -1 90000.125", &ReadOptions::default());
        for (steps, read) in back(&written) {
            let Some(steps) = steps else {
                assert_eq!(read.heightmap, written.heightmap);
                continue;
            };
            assert!(!steps.is_exact && steps.scale < 1.374, "{steps:?}");
            assert_eq!(read.voids.as_ref().map(|voids| voids.count()), Some(1));
            for (found, expected) in read.heightmap.heights_m().iter().zip(written.heightmap.heights_m()) {
                assert!((found - expected).abs() as f64 <= steps.scale * 0.51, "{found} {expected}");
            }
        }
    }

    #[test]
    fn flat_ground_has_steps_too() {
        for (steps, read) in back(&dem("7.3 7.3 7.3 7.3\n7.3 7.3 7.3 7.3\n7.3 7.3 7.3 7.3", &ReadOptions::default())) {
            assert!(steps.is_none_or(|steps| steps.scale == 1.0));
            assert_eq!(read.heightmap.heights_m(), [7.3; 12]);
        }
    }
}
