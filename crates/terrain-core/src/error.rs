//! The error oracle: how far the drawn mesh is from *every* DEM sample in view, and from the mesh drawn before.
//!
//! The error of a sample is vertical: |mesh - DEM| in metres at the sample, and the same in pixels twice: projected by
//! [`View::pixels`] at the sample's distance from the eye, and as the [displacement](View::displacement_px) of the mesh's
//! point from the sample on the screen. What hides behind a ridge counts as well. A [void](Heightmap::voids) has no height
//! to be wrong about: such samples are counted and not measured. What the change of the mesh does to the picture is in
//! [`popping`](crate::popping).

mod distribution;

use glam::DVec3;

use crate::popping::Popping;
use crate::{Aabb, Heightmap, Sample, Triangle, View};

pub use distribution::ErrorDistribution;

/// Measures meshes over one DEM; keeps its memory from frame to frame.
pub struct ErrorOracle<'a> {
    heightmap: &'a Heightmap,
    /// mesh - DEM in metres, one a sample; NaN where no triangle covers the sample. Two meshes over one DEM differ by as
    /// much as their deviations do, which f32 resolves better than heights.
    signed_m: Vec<f32>,
    /// The same of the mesh before.
    signed_before_m: Vec<f32>,
    /// Runs of samples of one row, in the order of the samples: where they are in the world.
    runs: Vec<Aabb>,
}

/// Samples of a run: what is out of view is passed over in such steps.
const RUN: u32 = 32;

impl<'a> ErrorOracle<'a> {
    /// Starts without a mesh: all samples are uncovered.
    pub fn new(heightmap: &'a Heightmap) -> Self {
        let uncovered = vec![f32::NAN; heightmap.heights_m().len()];
        Self { heightmap, signed_before_m: uncovered.clone(), signed_m: uncovered, runs: runs(heightmap).collect() }
    }

    /// Takes a mesh: interpolates each triangle at each sample that it covers.
    pub fn set_mesh(&mut self, triangles: &[Triangle]) {
        std::mem::swap(&mut self.signed_m, &mut self.signed_before_m);
        self.signed_m.fill(f32::NAN);
        for triangle in triangles {
            self.cover(triangle);
        }
    }

    /// |mesh - DEM| in metres, one a sample, voids included, row by row; NaN where no triangle covers the sample.
    pub fn deviations_m(&self) -> impl ExactSizeIterator<Item = f32> {
        self.signed_m.iter().map(|signed_m| signed_m.abs())
    }

    /// |mesh - DEM| in metres at one sample; NaN where no triangle covers it.
    pub fn deviation_m(&self, at: Sample) -> f32 {
        self.signed_m[self.heightmap.index(at) as usize].abs()
    }

    /// The screen-space error at one sample, in view or not; NaN where no triangle covers it.
    pub fn error_px(&self, view: &View, at: Sample) -> f32 {
        let distance_m = DVec3::from(self.heightmap.world(at)).distance(view.eye_world);
        view.pixels(self.deviation_m(at).into(), distance_m) as f32
    }

    /// Whether the mesh before covered a sample.
    pub fn was_covered(&self, at: Sample) -> bool {
        !self.signed_before_m[self.heightmap.index(at) as usize].is_nan()
    }

    /// Adds the errors of all samples inside the view's frustum to `errors`.
    pub fn measure(&self, view: &View, errors: &mut ErrorDistribution) {
        self.for_each_in_view(view, |index, world| {
            let signed_m = self.signed_m[index];
            if signed_m.is_nan() {
                // The mesh is whole, voids or not.
                errors.uncovered += 1;
            } else if self.is_void(index) {
                errors.voids += 1;
            } else if signed_m == 0.0 {
                errors.add(0.0, 0.0, 0.0);
            } else {
                let deviation_m = signed_m.abs();
                let error_px = view.pixels(deviation_m as f64, world.distance(view.eye_world));
                let displacement_px = view.displacement_px(world, signed_m as f64);
                errors.add(deviation_m, error_px as f32, displacement_px as f32);
            }
        });
    }

    /// Adds to `popping` what the last [`Self::set_mesh`] has changed at the samples inside the view's frustum, both
    /// meshes seen in this view. A void does not count, nor does a sample that one of them does not cover.
    pub fn measure_popping(&self, view: &View, popping: &mut Popping) {
        self.for_each_in_view(view, |index, world| {
            let (now_m, before_m) = (self.signed_m[index], self.signed_before_m[index]);
            let change_m = (now_m - before_m).abs();
            // Of NaN that is not true.
            if change_m > 0.0 && !self.is_void(index) {
                let px = view.pixels(change_m as f64, world.distance(view.eye_world));
                let point_before = DVec3 { y: world.y + before_m as f64, ..world };
                let displacement_px = view.displacement_px(point_before, (now_m - before_m) as f64);
                popping.add(px as f32, displacement_px as f32);
            }
        });
    }

    fn is_void(&self, index: usize) -> bool {
        self.heightmap.voids().is_some_and(|voids| voids.has(index))
    }

    /// Calls `visit` with the index and the position of every sample inside the view's frustum, row by row.
    fn for_each_in_view(&self, view: &View, mut visit: impl FnMut(usize, DVec3)) {
        let columns = self.heightmap.columns();
        let starts =
            (0..self.heightmap.rows()).flat_map(|row| (0..columns).step_by(RUN as usize).map(move |c| (c, row)));
        for ((first, row), bounds) in starts.zip(&self.runs) {
            if !view.sees(bounds) {
                continue;
            }
            let all_seen = view.sees_whole(bounds);
            for column in first..columns.min(first + RUN) {
                let sample = Sample { column, row };
                let world = DVec3::from(self.heightmap.world(sample));
                if all_seen || view.sees_point(world) {
                    visit(self.heightmap.index(sample) as usize, world);
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
            let p = [low[0] - 1, row];
            let mut weights = [doubled_area_of(b, c, p), doubled_area_of(c, a, p), doubled_area_of(a, b, p)];
            for column in low[0]..=high[0] {
                // By a column to the east, a weight changes by the rows of the side opposite its corner.
                weights = [weights[0] + c[1] - b[1], weights[1] + a[1] - c[1], weights[2] + b[1] - a[1]];
                if weights.iter().any(|w| w * orientation < 0) {
                    continue;
                }
                let sum: f64 = weights.iter().zip(heights).map(|(w, h)| *w as f64 * h).sum();
                let index = self.heightmap.index(Sample { column: column as u32, row: row as u32 }) as usize;
                let mesh_m = sum / doubled_area as f64;
                self.signed_m[index] = (mesh_m - self.heightmap.heights_m()[index] as f64) as f32;
            }
        }
    }
}

/// The boxes of all runs.
fn runs(heightmap: &Heightmap) -> impl Iterator<Item = Aabb> {
    (0..heightmap.rows()).flat_map(move |row| {
        (0..heightmap.columns()).step_by(RUN as usize).map(move |column| {
            let (first, last) = (Sample { column, row }, Sample { column: column + RUN - 1, row });
            heightmap.bounds_world(first, last)
        })
    })
}

/// As [`Triangle::doubled_area`].
fn doubled_area_of(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (c[0] - a[0]) * (b[1] - a[1]) - (b[0] - a[0]) * (c[1] - a[1])
}

#[cfg(test)]
pub(crate) mod fans;

#[cfg(test)]
mod tests {
    use super::fans::{brute_force_m, fan, is_seen, on_screen_px, rough_dem, samples, view, with_voids};
    use super::*;
    use crate::SplitMix64;

    #[test]
    fn agrees_with_brute_force_over_every_triangle_and_sample() {
        for seed in 0..50 {
            let dem = rough_dem(seed);
            let mut random = SplitMix64::new(seed);
            let mesh = fan(&dem, 1 + random.below(7) as u32, 1 + random.below(5) as u32);
            let mut oracle = ErrorOracle::new(&dem);
            oracle.set_mesh(&mesh);
            for (at, deviation_m) in samples().zip(oracle.deviations_m()) {
                let expected = brute_force_m(&dem, &mesh, at).unwrap() - dem.height_m(at) as f64;
                assert!((deviation_m as f64 - expected.abs()).abs() < 1e-4, "seed {seed}, {at:?}");
                assert_eq!(deviation_m, oracle.deviation_m(at));
                let view = view(seed);
                let distance_m = DVec3::from(dem.world(at)).distance(view.eye_world);
                let error_px = deviation_m as f64 * 200.0 / (2.0 * 0.1f64.tan() * distance_m);
                assert!((oracle.error_px(&view, at) as f64 - error_px).abs() <= 1e-6 * error_px, "seed {seed}, {at:?}");
            }
        }
    }

    /// Error and displacement in pixels of each sample in view, by brute force.
    fn expected_px(dem: &Heightmap, mesh: &[Triangle], view: &View) -> Vec<[f64; 2]> {
        let seen = samples().filter(|at| is_seen(view, dem.world(*at).into()));
        seen.filter_map(|at| {
            let sample = DVec3::from(dem.world(at));
            let point = DVec3 { y: brute_force_m(dem, mesh, at)?, ..sample };
            let error_px = (point.y - sample.y).abs() * 200.0 / (2.0 * 0.1f64.tan() * sample.distance(view.eye_world));
            Some([error_px, on_screen_px(view, sample, point)])
        })
        .collect()
    }

    #[test]
    fn measures_only_samples_in_view_and_counts_holes() {
        for seed in 0..20 {
            let (dem, view) = (rough_dem(seed), view(seed));
            let mut mesh = fan(&dem, 4, 3);
            let mut oracle = ErrorOracle::new(&dem);
            oracle.set_mesh(&mesh);
            let mut errors = ErrorDistribution::new(&[0.0, 5.0, 1e9]);
            oracle.measure(&view, &mut errors);

            let expected = expected_px(&dem, &mesh, &view);
            let max = |i: usize| expected.iter().fold(0.0, |largest: f64, px| largest.max(px[i]));
            let rms = (expected.iter().map(|[error, _]| error * error).sum::<f64>() / expected.len() as f64).sqrt();
            assert!(expected.len() < 63);
            assert_eq!([errors.samples(), errors.displacements().samples()], [expected.len() as u64; 2]);
            assert!((errors.max_px() as f64 / max(0) - 1.0).abs() < 1e-6, "seed {seed}");
            assert!((errors.displacements().max_px() as f64 / max(1) - 1.0).abs() < 1e-4, "seed {seed}");
            assert!((errors.rms_px() / rms - 1.0).abs() < 1e-6, "seed {seed}");
            let over_5 = expected.iter().filter(|px| px[0] > 5.0).count() as f64 / expected.len() as f64;
            assert_eq!((errors.over_share(1), errors.over_share(2)), (over_5, 0.0), "seed {seed}");
            assert_eq!(errors.uncovered(), 0);

            mesh.remove(0);
            oracle.set_mesh(&mesh);
            errors.clear();
            oracle.measure(&view, &mut errors);
            assert_eq!(errors.samples(), expected_px(&dem, &mesh, &view).len() as u64, "seed {seed}");
            assert_eq!(errors.uncovered() + errors.samples(), expected.len() as u64, "seed {seed}");
        }
    }

    #[test]
    fn voids_are_counted_and_not_measured() {
        let mut measured = 0;
        for seed in 0..40 {
            let ((dem, is_void), view) = (with_voids(rough_dem(seed), seed), view(seed));
            let mut mesh = fan(&dem, 4, 3);
            // A sample that nothing covers is a hole in the mesh, void or not.
            mesh.truncate(if seed % 4 == 0 { 3 } else { 4 });
            let mut oracle = ErrorOracle::new(&dem);
            oracle.set_mesh(&mesh);
            let mut errors = ErrorDistribution::new(&[5.0]);
            oracle.measure(&view, &mut errors);

            let (mut expected, mut voids, mut uncovered) = (Vec::new(), 0, 0);
            for (at, is_void) in samples().zip(is_void).filter(|(at, _)| is_seen(&view, dem.world(*at).into())) {
                match brute_force_m(&dem, &mesh, at) {
                    None => uncovered += 1,
                    Some(_) if is_void => voids += 1,
                    Some(mesh_m) => {
                        let sample = DVec3::from(dem.world(at));
                        expected.push(view.pixels((mesh_m - sample.y).abs(), sample.distance(view.eye_world)));
                    }
                }
            }
            let worst_px = expected.iter().copied().fold(0.0, f64::max);
            let over = expected.iter().filter(|px| **px > 5.0).count() as f64 / expected.len() as f64;
            assert_eq!(
                [errors.samples(), errors.voids(), errors.uncovered()],
                [expected.len() as u64, voids, uncovered]
            );
            assert!((errors.max_px() as f64 - worst_px).abs() < 1e-4 && errors.over_share(0) == over, "seed {seed}");
            let mut twice = errors.clone();
            twice.merge(&errors);
            assert_eq!([twice.samples(), twice.voids()], [2 * errors.samples(), 2 * voids]);
            twice.clear();
            assert_eq!(twice.voids(), 0);
            measured += (voids > 0) as u32;
        }
        assert!(measured > 30, "views with voids: {measured}");
    }

    /// The camera is level, so that the vertical is parallel to the picture, and the peak stands at its rim.
    #[test]
    fn a_displacement_at_the_pictures_rim_exceeds_the_usual_formula() {
        let mut heights = vec![0.0; 25];
        heights[12] = 1.0;
        let dem = Heightmap::new(5, 5, [10.0; 2], heights).unwrap();
        let flat = [[[0, 0], [0, 4], [4, 4]], [[0, 0], [4, 4], [4, 0]]].map(|corners| Triangle {
            samples: corners.map(|[column, row]| Sample { column, row }),
            heights_m: [0.0; 3],
        });
        // 30 m to the north and 29 m to the east of the eye, with a field of view of 90 degrees.
        let camera = crate::Camera { eye_world: DVec3::new(-9.0, 1.0, 50.0), heading: 0.0, pitch: 0.0 };
        let lens = crate::Lens { fov_y: std::f64::consts::FRAC_PI_2, size_px: [200, 200], near_m: 1.0 };
        let view = View::new(&camera, &lens).unwrap();
        let mut oracle = ErrorOracle::new(&dem);
        oracle.set_mesh(&flat);
        let mut errors = ErrorDistribution::new(&[]);
        oracle.measure(&view, &mut errors);
        let (error_px, displacement_px) = (errors.max_px() as f64, errors.displacements().max_px() as f64);
        assert!((error_px - 100.0 / 30.0f64.hypot(29.0)).abs() < 1e-5, "{error_px}");
        assert!((displacement_px - 100.0 / 30.0).abs() < 1e-5, "{displacement_px}");
    }

    #[test]
    fn a_perfect_mesh_has_no_error() {
        let mut errors = ErrorDistribution::new(&[0.0]);
        (0..10).for_each(|_| errors.add(0.0, 0.0, 0.0));
        assert_eq!((errors.max_px(), errors.percentile_px(0.99), errors.over_share(0)), (0.0, 0.0, 0.0));
        assert_eq!((errors.displacements().max_px(), errors.displacements().samples()), (0.0, 10));
    }
}
