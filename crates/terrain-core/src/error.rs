//! The error oracle: how far the drawn mesh is from *every* DEM sample in view.
//!
//! The error of a sample is vertical: |mesh - DEM| in metres at the sample, and the same projected to pixels by
//! [`View::pixels`] at the sample's distance from the eye. What hides behind a ridge counts as well.

use glam::DVec3;

use crate::{Heightmap, Sample, Triangle, View};

/// Measures meshes over one DEM; keeps its memory from frame to frame.
pub struct ErrorOracle<'a> {
    heightmap: &'a Heightmap,
    /// |mesh - DEM| in metres, one a sample; NaN where no triangle covers the sample.
    deviations_m: Vec<f32>,
}

impl<'a> ErrorOracle<'a> {
    /// Starts without a mesh: all samples are uncovered.
    pub fn new(heightmap: &'a Heightmap) -> Self {
        Self { heightmap, deviations_m: vec![f32::NAN; heightmap.heights_m().len()] }
    }

    /// Takes a mesh: interpolates each triangle at each sample that it covers.
    pub fn set_mesh(&mut self, triangles: &[Triangle]) {
        self.deviations_m.fill(f32::NAN);
        for triangle in triangles {
            self.cover(triangle);
        }
    }

    /// |mesh - DEM| in metres, one a sample, row by row; NaN where no triangle covers the sample.
    pub fn deviations_m(&self) -> &[f32] {
        &self.deviations_m
    }

    /// Adds the errors of all samples inside the view's frustum to `errors`.
    pub fn measure(&self, view: &View, errors: &mut ErrorDistribution) {
        let eye = view.eye_world;
        for row in 0..self.heightmap.rows() {
            for column in 0..self.heightmap.columns() {
                let sample = Sample { column, row };
                let world = DVec3::from(self.heightmap.world(sample));
                if !view.sees_point(world) {
                    continue;
                }
                let deviation_m = self.deviations_m[self.heightmap.index(sample) as usize];
                if deviation_m.is_nan() {
                    errors.uncovered += 1;
                } else {
                    errors.add(deviation_m, view.pixels(deviation_m as f64, world.distance(eye)) as f32);
                }
            }
        }
    }

    /// Writes the deviations of the samples inside one triangle or on its border. Barycentric weights are exact
    /// integers, so two triangles agree on a shared edge to the rounding of one f64 division.
    fn cover(&mut self, triangle: &Triangle) {
        let [a, b, c] = triangle.samples.map(|s| [s.column as i64, s.row as i64]);
        let heights = triangle.heights_m.map(f64::from);
        let doubled_area = triangle.doubled_area();
        let orientation = doubled_area.signum();
        let low = [0, 1].map(|i| a[i].min(b[i]).min(c[i]));
        let high = [0, 1].map(|i| a[i].max(b[i]).max(c[i]));
        for row in low[1]..=high[1] {
            for column in low[0]..=high[0] {
                let p = [column, row];
                let weights = [doubled_area_of(b, c, p), doubled_area_of(c, a, p), doubled_area_of(a, b, p)];
                if weights.iter().any(|w| w * orientation < 0) {
                    continue;
                }
                let sum: f64 = weights.iter().zip(heights).map(|(w, h)| *w as f64 * h).sum();
                let index = self.heightmap.index(Sample { column: column as u32, row: row as u32 }) as usize;
                let mesh_m = sum / doubled_area as f64;
                self.deviations_m[index] = (mesh_m - self.heightmap.heights_m()[index] as f64).abs() as f32;
            }
        }
    }
}

/// As [`Triangle::doubled_area`].
fn doubled_area_of(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1])
}

/// Errors of many samples: of one frame, or of all frames of a flight.
///
/// Maximum and RMS are exact. Percentiles come from a histogram over the leading bits of the floats and are rounded
/// up by at most 0.1 %, so a flight of any length needs the same memory and the result does not depend on order.
#[derive(Clone)]
pub struct ErrorDistribution {
    samples: u64,
    uncovered: u64,
    max_px: f32,
    max_m: f32,
    sum_of_squares_px: f64,
    /// Tolerances in pixels, and how many samples are above each.
    over: Vec<(f32, u64)>,
    histogram: Vec<u64>,
}

/// Bits of an f32 that are left out of the histogram's key: 10 bits of the mantissa stay.
const DROPPED_BITS: u32 = 13;
/// Keys of positive, finite floats.
const BINS: usize = (f32::INFINITY.to_bits() >> DROPPED_BITS) as usize + 1;

impl ErrorDistribution {
    /// An empty distribution that counts the samples above each of these tolerances (in pixels).
    pub fn new(tolerances_px: &[f32]) -> Self {
        Self {
            samples: 0,
            uncovered: 0,
            max_px: 0.0,
            max_m: 0.0,
            sum_of_squares_px: 0.0,
            over: tolerances_px.iter().map(|tolerance| (*tolerance, 0)).collect(),
            histogram: vec![0; BINS],
        }
    }

    /// Adds one sample's error.
    pub fn add(&mut self, error_m: f32, error_px: f32) {
        self.samples += 1;
        self.max_m = self.max_m.max(error_m);
        self.max_px = self.max_px.max(error_px);
        self.sum_of_squares_px += error_px as f64 * error_px as f64;
        for (tolerance_px, count) in &mut self.over {
            *count += (error_px > *tolerance_px) as u64;
        }
        self.histogram[(error_px.to_bits() >> DROPPED_BITS) as usize] += 1;
    }

    /// Adds another distribution over the same tolerances.
    pub fn merge(&mut self, other: &Self) {
        self.samples += other.samples;
        self.uncovered += other.uncovered;
        self.max_px = self.max_px.max(other.max_px);
        self.max_m = self.max_m.max(other.max_m);
        self.sum_of_squares_px += other.sum_of_squares_px;
        for (ours, theirs) in self.over.iter_mut().zip(&other.over) {
            debug_assert_eq!(ours.0, theirs.0, "distributions over different tolerances");
            ours.1 += theirs.1;
        }
        for (ours, theirs) in self.histogram.iter_mut().zip(&other.histogram) {
            *ours += theirs;
        }
    }

    /// Forgets all samples, keeps the tolerances and the memory.
    pub fn clear(&mut self) {
        (self.samples, self.uncovered) = (0, 0);
        (self.max_px, self.max_m, self.sum_of_squares_px) = (0.0, 0.0, 0.0);
        self.over.iter_mut().for_each(|(_, count)| *count = 0);
        self.histogram.fill(0);
    }

    /// Samples that were measured.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Samples in view that no triangle covers.
    pub fn uncovered(&self) -> u64 {
        self.uncovered
    }

    /// Largest error in pixels.
    pub fn max_px(&self) -> f32 {
        self.max_px
    }

    /// Largest error in metres.
    pub fn max_m(&self) -> f32 {
        self.max_m
    }

    /// Root of the mean squared error in pixels; 0 without samples.
    pub fn rms_px(&self) -> f64 {
        (self.sum_of_squares_px / self.samples.max(1) as f64).sqrt()
    }

    /// Share of the samples above the `i`-th tolerance, 0 to 1.
    pub fn over_share(&self, i: usize) -> f64 {
        self.over[i].1 as f64 / self.samples.max(1) as f64
    }

    /// The error in pixels that a `share` of the samples (0 to 1) does not exceed.
    pub fn percentile_px(&self, share: f64) -> f32 {
        let wanted = (share * self.samples as f64).ceil() as u64;
        let mut seen = 0;
        for (key, count) in self.histogram.iter().enumerate() {
            seen += *count;
            if seen >= wanted.max(1) {
                let upper = f32::from_bits((key as u32) << DROPPED_BITS | ((1 << DROPPED_BITS) - 1));
                return if key == 0 { 0.0 } else { upper.min(self.max_px) };
            }
        }
        self.max_px
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Camera, Lens, SplitMix64};

    fn rough_dem(seed: u64) -> Heightmap {
        let mut random = SplitMix64::new(seed);
        let heights = (0..9 * 7).map(|_| random.range(0.0, 50.0) as f32).collect();
        Heightmap::new(9, 7, [10.0, 12.0], heights).unwrap()
    }

    /// The whole DEM as fans around one inner sample.
    fn fan(dem: &Heightmap, column: u32, row: u32) -> Vec<Triangle> {
        let corner = |c, r| Sample { column: c, row: r };
        let rim = [corner(0, 0), corner(0, 6), corner(8, 6), corner(8, 0)];
        let triangle = |i: usize| {
            let samples = [corner(column, row), rim[i], rim[(i + 1) % 4]];
            Triangle { samples, heights_m: samples.map(|s| dem.height_m(s)) }
        };
        (0..4).map(triangle).filter(|t| t.doubled_area() != 0).collect()
    }

    /// Height of the mesh at a sample by solving each triangle's plane in floats: nothing shared with the oracle.
    fn brute_force_m(dem: &Heightmap, mesh: &[Triangle], at: Sample) -> Option<f64> {
        mesh.iter().find_map(|t| {
            let [a, b, c] = t.samples.map(|s| DVec3::from(dem.world(s)));
            let p = DVec3::from(dem.world(at));
            let normal = (b - a).cross(c - a);
            let flat = |v: DVec3| DVec3::new(v.x, 0.0, v.z);
            let inside = [(a, b), (b, c), (c, a)].iter().all(|(s, e)| flat(*e - *s).cross(flat(p - *s)).y >= -1e-6);
            inside.then(|| a.y - (normal.x * (p.x - a.x) + normal.z * (p.z - a.z)) / normal.y)
        })
    }

    #[test]
    fn agrees_with_brute_force_over_every_triangle_and_sample() {
        for seed in 0..50 {
            let dem = rough_dem(seed);
            let mut random = SplitMix64::new(seed);
            let mesh = fan(&dem, 1 + random.below(7) as u32, 1 + random.below(5) as u32);
            let mut oracle = ErrorOracle::new(&dem);
            oracle.set_mesh(&mesh);
            for (i, deviation_m) in oracle.deviations_m().iter().enumerate() {
                let at = Sample { column: i as u32 % 9, row: i as u32 / 9 };
                let expected = brute_force_m(&dem, &mesh, at).unwrap() - dem.height_m(at) as f64;
                assert!((*deviation_m as f64 - expected.abs()).abs() < 1e-4, "seed {seed}, {at:?}");
            }
        }
    }

    #[test]
    fn measures_only_samples_in_view_and_counts_holes() {
        let dem = rough_dem(3);
        let mut mesh = fan(&dem, 4, 3);
        let camera = Camera { eye_world: DVec3::new(40.0, 200.0, 60.0), heading: 0.0, pitch: -1.4 };
        let view = View::new(&camera, &Lens { fov_y: 0.2, size_px: [300, 200], near_m: 1.0 }).unwrap();
        let mut oracle = ErrorOracle::new(&dem);
        oracle.set_mesh(&mesh);
        let mut errors = ErrorDistribution::new(&[0.0, 5.0, 1e9]);
        oracle.measure(&view, &mut errors);

        let mut expected = Vec::new();
        for (i, deviation_m) in oracle.deviations_m().iter().enumerate() {
            let p = DVec3::from(dem.world(Sample { column: i as u32 % 9, row: i as u32 / 9 }));
            let c = view.clip_from_world * p.extend(1.0);
            if c.x.abs() <= c.w && c.y.abs() <= c.w && c.z <= c.w {
                expected.push(*deviation_m as f64 * 200.0 / (2.0 * 0.1f64.tan() * p.distance(camera.eye_world)));
            }
        }
        let max = expected.iter().fold(0.0, |a: f64, b| a.max(*b));
        let rms = (expected.iter().map(|e| e * e).sum::<f64>() / expected.len() as f64).sqrt();
        assert!(expected.len() > 5 && expected.len() < 50);
        assert_eq!(errors.samples(), expected.len() as u64);
        assert!((errors.max_px() as f64 / max - 1.0).abs() < 1e-6);
        assert!((errors.rms_px() / rms - 1.0).abs() < 1e-6);
        let over_5 = expected.iter().filter(|e| **e > 5.0).count() as f64 / expected.len() as f64;
        assert_eq!((errors.over_share(1), errors.over_share(2)), (over_5, 0.0));
        assert_eq!(errors.uncovered(), 0);

        mesh.remove(0);
        oracle.set_mesh(&mesh);
        errors.clear();
        oracle.measure(&view, &mut errors);
        assert_eq!(errors.uncovered() + errors.samples(), expected.len() as u64);
        assert!(errors.uncovered() > 0);
    }

    #[test]
    fn percentiles_are_rounded_up_by_a_thousandth_at_most() {
        let mut random = SplitMix64::new(5);
        let mut values: Vec<f32> = (0..9_999).map(|_| random.range(0.0, 1.0).powi(4) as f32 * 30.0).collect();
        let mut whole = ErrorDistribution::new(&[]);
        let mut halves = whole.clone();
        for half in values.chunks(5_000) {
            let mut part = ErrorDistribution::new(&[]);
            half.iter().for_each(|e| part.add(0.0, *e));
            halves.merge(&part);
        }
        values.iter().for_each(|e| whole.add(0.0, *e));
        values.sort_by(f32::total_cmp);
        for share in [0.001, 0.5, 0.95, 0.99, 0.999, 1.0] {
            let exact = values[(share * 9_999.0_f64).ceil() as usize - 1];
            let found = whole.percentile_px(share);
            assert!(found >= exact && found <= exact * 1.001, "{share}: {found} for {exact}");
            assert_eq!(found, halves.percentile_px(share));
        }
    }

    #[test]
    fn a_perfect_mesh_has_no_error() {
        let mut errors = ErrorDistribution::new(&[0.0]);
        (0..10).for_each(|_| errors.add(0.0, 0.0));
        assert_eq!((errors.max_px(), errors.percentile_px(0.99), errors.over_share(0)), (0.0, 0.0, 0.0));
    }
}
