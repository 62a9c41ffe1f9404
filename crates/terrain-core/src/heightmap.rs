//! The DEM in memory: a regular grid of samples.

use std::sync::Arc;

use crate::{Sample, VoidMask};

/// A grid of height samples in metres, row by row, the northern row first.
///
/// World axes: x east, y up, z south, in metres; the first sample stands at x = 0, z = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Heightmap {
    columns: u32,
    rows: u32,
    spacing_m: [f64; 2],
    heights_m: Vec<f32>,
    voids: Option<Arc<VoidMask>>,
}

/// Why a grid of numbers is no heightmap.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HeightmapError {
    /// Fewer than 2 or more than [`Heightmap::MAX_SIDE`] samples along one side.
    #[error("{columns} x {rows} samples: expected 2 to {} along each side", Heightmap::MAX_SIDE)]
    Size {
        /// Samples along x.
        columns: u32,
        /// Samples along z.
        rows: u32,
    },
    /// The number of heights is not `columns * rows`.
    #[error("{found} heights for a grid that needs {expected}")]
    Count {
        /// Heights given.
        found: usize,
        /// Heights needed.
        expected: usize,
    },
    /// A spacing that is not a positive finite number.
    #[error("spacing {0} x {1} m: expected two positive, finite numbers")]
    Spacing(f64, f64),
    /// A height that is NaN or infinite.
    #[error("height {height_m} at column {column}, row {row}: expected a finite number")]
    Height {
        /// Its column.
        column: u32,
        /// Its row.
        row: u32,
        /// The offending value.
        height_m: f32,
    },
    /// A void mask of another grid.
    #[error("a void mask of {} x {} samples for a grid of {} x {}", .mask[0], .mask[1], .grid[0], .grid[1])]
    Voids {
        /// Columns and rows of the mask.
        mask: [u32; 2],
        /// Columns and rows of the grid.
        grid: [u32; 2],
    },
}

/// Heights that are looked at without asking in between.
const BLOCK: usize = 4096;
/// Heights that are looked at side by side, as vector instructions can.
const LANES: usize = 16;

impl Heightmap {
    /// The longest side in samples: sample coordinates travel to the GPU as 16-bit integers.
    pub const MAX_SIDE: u32 = 65_535;

    /// Checks and takes a grid; `spacing_m` is the distance between neighbouring samples in x and z.
    pub fn new(columns: u32, rows: u32, spacing_m: [f64; 2], heights_m: Vec<f32>) -> Result<Self, HeightmapError> {
        let map = Self::of_any([columns, rows], spacing_m, heights_m)?;
        if let Some(i) = first_not_finite(&map.heights_m) {
            let (column, row) = (i as u32 % columns, i as u32 / columns);
            return Err(HeightmapError::Height { column, row, height_m: map.heights_m[i] });
        }
        Ok(map)
    }

    /// As [`Self::new`], of heights that are known to be finite: to look at all of a large grid takes longer than to read it.
    pub fn of_finite(size: [u32; 2], spacing_m: [f64; 2], heights_m: Vec<f32>) -> Result<Self, HeightmapError> {
        debug_assert!(are_finite(&heights_m));
        Self::of_any(size, spacing_m, heights_m)
    }

    fn of_any([columns, rows]: [u32; 2], spacing_m: [f64; 2], heights_m: Vec<f32>) -> Result<Self, HeightmapError> {
        let side = 2..=Self::MAX_SIDE;
        if !side.contains(&columns) || !side.contains(&rows) {
            return Err(HeightmapError::Size { columns, rows });
        }
        let expected = columns as usize * rows as usize;
        if heights_m.len() != expected {
            return Err(HeightmapError::Count { found: heights_m.len(), expected });
        }
        if !spacing_m.iter().all(|s| s.is_finite() && *s > 0.0) {
            return Err(HeightmapError::Spacing(spacing_m[0], spacing_m[1]));
        }
        Ok(Self { columns, rows, spacing_m, heights_m, voids: None })
    }

    /// Declares samples to be voids: nobody measured the heights that they hold. Meshes are built on these heights as on
    /// any others; what is drawn, measured or exported leaves the voids out. A mask without voids is none.
    pub fn with_voids(self, voids: Arc<VoidMask>) -> Result<Self, HeightmapError> {
        let (mask, grid) = ([voids.columns(), voids.rows()], [self.columns, self.rows]);
        if mask != grid {
            return Err(HeightmapError::Voids { mask, grid });
        }
        Ok(Self { voids: Some(voids).filter(|voids| voids.count() > 0), ..self })
    }

    /// Samples along x (west to east).
    pub fn columns(&self) -> u32 {
        self.columns
    }

    /// Samples along z (north to south).
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Metres between neighbouring samples in x and in z.
    pub fn spacing_m(&self) -> [f64; 2] {
        self.spacing_m
    }

    /// All heights in metres, row by row.
    pub fn heights_m(&self) -> &[f32] {
        &self.heights_m
    }

    /// The samples that are voids, if any.
    pub fn voids(&self) -> Option<&VoidMask> {
        self.voids.as_deref()
    }

    /// Extent in x and z in metres: first sample to last.
    pub fn extent_m(&self) -> [f64; 2] {
        [(self.columns - 1) as f64 * self.spacing_m[0], (self.rows - 1) as f64 * self.spacing_m[1]]
    }

    /// Position of a sample in [`Self::heights_m`], and its index in every baked vertex buffer laid out like it.
    pub fn index(&self, sample: Sample) -> u32 {
        sample.row * self.columns + sample.column
    }

    /// Height of one sample in metres.
    pub fn height_m(&self, sample: Sample) -> f32 {
        self.heights_m[self.index(sample) as usize]
    }

    /// World position of one sample.
    pub fn world(&self, sample: Sample) -> [f64; 3] {
        [sample.column as f64 * self.spacing_m[0], self.height_m(sample) as f64, sample.row as f64 * self.spacing_m[1]]
    }

    /// Height of the ground at a world position, bilinear between samples, clamped to the DEM's rim.
    pub fn ground_m(&self, x_m: f64, z_m: f64) -> f64 {
        let x = (x_m / self.spacing_m[0]).clamp(0.0, (self.columns - 1) as f64);
        let z = (z_m / self.spacing_m[1]).clamp(0.0, (self.rows - 1) as f64);
        let (column, row) = ((x as u32).min(self.columns - 2), (z as u32).min(self.rows - 2));
        let (u, v) = (x - column as f64, z - row as f64);
        let at = |c, r| self.height_m(Sample { column: column + c, row: row + r }) as f64;
        (at(0, 0) * (1.0 - u) + at(1, 0) * u) * (1.0 - v) + (at(0, 1) * (1.0 - u) + at(1, 1) * u) * v
    }

    /// Lowest and highest sample, in metres, in a rectangle of samples (both ends included, clamped to the DEM).
    pub fn height_range_m(&self, first: Sample, last: Sample) -> [f32; 2] {
        let (last_column, last_row) = (last.column.min(self.columns - 1), last.row.min(self.rows - 1));
        let mut range = [f32::INFINITY, f32::NEG_INFINITY];
        for row in first.row..=last_row {
            let start = self.index(Sample { column: first.column, row }) as usize;
            for &h in &self.heights_m[start..=start + (last_column - first.column) as usize] {
                range = [range[0].min(h), range[1].max(h)];
            }
        }
        range
    }

    /// The world box of a rectangle of samples (both ends included, clamped to the DEM).
    pub fn bounds_world(&self, first: Sample, last: Sample) -> crate::Aabb {
        let [low, high] = self.height_range_m(first, last);
        let x = |c: u32| c.min(self.columns - 1) as f64 * self.spacing_m[0];
        let z = |r: u32| r.min(self.rows - 1) as f64 * self.spacing_m[1];
        crate::Aabb {
            min: [x(first.column), low as f64, z(first.row)],
            max: [x(last.column), high as f64, z(last.row)],
        }
    }

    /// Unit normals (x, y, z), one a sample, from central differences of the DEM (one-sided at the rim).
    ///
    /// Computed once from the DEM, so that shading does not change with the mesh
    /// (Bertilsson and Goswami 2016, section 4 and Figure 4).
    pub fn normals(&self) -> Vec<[f32; 3]> {
        let mut normals = Vec::with_capacity(self.heights_m.len());
        for row in 0..self.rows {
            for column in 0..self.columns {
                normals.push(self.normal(Sample { column, row }));
            }
        }
        normals
    }

    /// The unit normal at one sample; see [`Self::normals`].
    pub fn normal(&self, at: Sample) -> [f32; 3] {
        let (west, east) = (at.column.saturating_sub(1), (at.column + 1).min(self.columns - 1));
        let (north, south) = (at.row.saturating_sub(1), (at.row + 1).min(self.rows - 1));
        let rise = |a: Sample, b: Sample| (self.height_m(b) - self.height_m(a)) as f64;
        let slope_x = rise(Sample { column: west, ..at }, Sample { column: east, ..at })
            / ((east - west) as f64 * self.spacing_m[0]);
        let slope_z = rise(Sample { row: north, ..at }, Sample { row: south, ..at })
            / ((south - north) as f64 * self.spacing_m[1]);
        let length = (slope_x * slope_x + 1.0 + slope_z * slope_z).sqrt();
        [(-slope_x / length) as f32, (1.0 / length) as f32, (-slope_z / length) as f32]
    }
}

/// The place of the first height that is NaN or infinite. Looks at many at a time: searched one by one, all heights of a
/// sound DEM would take as long as copying them.
fn first_not_finite(heights_m: &[f32]) -> Option<usize> {
    let block = heights_m.chunks(BLOCK).position(|block| !are_finite(block))?;
    let within = heights_m[block * BLOCK..].iter().position(|height_m| !height_m.is_finite())?;
    Some(block * BLOCK + within)
}

/// Nothing is left of finite numbers times 0, and NaN of all others.
fn are_finite(heights_m: &[f32]) -> bool {
    let (lanes, rest) = heights_m.as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for lane in lanes {
        (0..LANES).for_each(|i| sums[i] += lane[i] * 0.0);
    }
    !sums.iter().chain(rest).fold(0.0, |sum, height_m| sum + height_m * 0.0).is_nan()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Heightmap {
        // Rises 2 m a column and falls 3 m a row.
        let heights = (0..4).flat_map(|r| (0..5).map(move |c| 2.0 * c as f32 - 3.0 * r as f32)).collect();
        Heightmap::new(5, 4, [10.0, 20.0], heights).unwrap()
    }

    #[test]
    fn broken_grids_are_refused() {
        let refuse = |c, r, s, h| Heightmap::new(c, r, s, h).unwrap_err().to_string();
        assert_eq!(refuse(1, 9, [1.0; 2], vec![0.0; 9]), "1 x 9 samples: expected 2 to 65535 along each side");
        assert_eq!(refuse(2, 2, [1.0; 2], vec![0.0; 3]), "3 heights for a grid that needs 4");
        assert_eq!(refuse(2, 2, [0.0, 1.0], vec![0.0; 4]), "spacing 0 x 1 m: expected two positive, finite numbers");
        let nan = vec![0.0, 0.0, f32::NAN, 0.0];
        assert_eq!(refuse(2, 2, [1.0; 2], nan), "height NaN at column 0, row 1: expected a finite number");
    }

    #[test]
    fn a_broken_height_is_found_wherever_it_is() {
        for at in [0, 4095, 4096, 9_999] {
            let mut heights_m = vec![1.0; 100 * 100];
            (heights_m[at], heights_m[9_999]) = (f32::INFINITY, f32::INFINITY);
            let expected =
                HeightmapError::Height { column: at as u32 % 100, row: at as u32 / 100, height_m: f32::INFINITY };
            assert_eq!(Heightmap::new(100, 100, [1.0; 2], heights_m), Err(expected));
        }
    }

    #[test]
    fn voids_are_those_of_the_grid() {
        let mask = |columns, flags: &[bool]| Arc::new(VoidMask::of_flags(columns, flags));
        let mut flags = [false; 20];
        assert_eq!(ramp().with_voids(mask(5, &flags)).unwrap(), ramp(), "no voids, no mask");
        flags[7] = true;
        let refused = ramp().with_voids(mask(4, &flags)).unwrap_err().to_string();
        assert_eq!(refused, "a void mask of 4 x 5 samples for a grid of 5 x 4");
        let marked = ramp().with_voids(mask(5, &flags)).unwrap();
        assert!(marked.voids().is_some_and(|voids| voids.is_void(2, 1)) && marked.heights_m() == ramp().heights_m());
    }

    #[test]
    fn ground_between_samples_and_beyond_the_rim() {
        let ramp = ramp();
        assert_eq!(ramp.ground_m(15.0, 30.0), 2.0 * 1.5 - 3.0 * 1.5);
        assert_eq!(ramp.ground_m(-5.0, 0.0), 0.0);
        assert_eq!(ramp.ground_m(1e9, 1e9), 2.0 * 4.0 - 3.0 * 3.0);
    }

    #[test]
    fn normals_of_a_plane_are_the_planes_normal() {
        let (sx, sz): (f64, f64) = (2.0 / 10.0, -3.0 / 20.0);
        let length = (sx * sx + 1.0 + sz * sz).sqrt();
        for n in ramp().normals() {
            let expected = [-sx / length, 1.0 / length, -sz / length];
            assert!(n.iter().zip(expected).all(|(a, b)| (*a as f64 - b).abs() < 1e-6), "{n:?}");
        }
    }

    #[test]
    fn bounds_are_clamped_to_the_dem() {
        let bounds = ramp().bounds_world(Sample { column: 3, row: 2 }, Sample { column: 9, row: 9 });
        assert_eq!(bounds.min, [30.0, 6.0 - 9.0, 40.0]);
        assert_eq!(bounds.max, [40.0, 8.0 - 6.0, 60.0]);
    }
}
