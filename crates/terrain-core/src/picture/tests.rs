//! The measures against known distortions: in closed form where there is one, and against the definition written out.

use std::f64::consts::TAU;

use super::*;
use crate::SplitMix64;

const SIZE_PX: [u32; 2] = [64, 48];
/// Of 8-bit pictures.
const RANGE: f64 = 255.0;
const C1: f64 = (0.01 * RANGE) * (0.01 * RANGE);
const C2: f64 = (0.03 * RANGE) * (0.03 * RANGE);

/// Something with structure: two waves and a ramp.
fn scene(column: u32, row: u32) -> f32 {
    let (x, y) = (f64::from(column), f64::from(row));
    (110.0 + 40.0 * (0.7 * x + 0.2 * y).sin() + 25.0 * (0.31 * y).cos() + 0.5 * x) as f32
}

/// Waves along x, 4 periods over the picture.
fn wave(amplitude: f64, phase: f64) -> Raster {
    let at = |column: u32, _| (128.0 + amplitude * (TAU * f64::from(column) / 16.0 + phase).sin()) as f32;
    Raster::from_fn(SIZE_PX, at)
}

fn flat(value: f32) -> Raster {
    Raster::from_fn(SIZE_PX, |_, _| value)
}

fn map(raster: &Raster, mut change: impl FnMut(f32) -> f32) -> Raster {
    Raster { size_px: raster.size_px, values: raster.values.iter().map(|value| change(*value)).collect() }
}

/// Plus or minus `amount`, each as often: noise of variance `amount` squared.
fn noise(amount: f32, seed: u64) -> impl FnMut(f32) -> f32 {
    let mut random = SplitMix64::new(seed);
    move |value| value + if random.below(2) == 0 { amount } else { -amount }
}

/// The definition, window by window in two dimensions, with variances as mean squared differences from the mean.
fn mssim_written_out(a: &Raster, b: &Raster) -> f64 {
    let [width, height] = a.size_px.map(|side| side as i64);
    let bell = |i: i64, j: i64| (-((i * i + j * j) as f64) / (2.0 * 1.5 * 1.5)).exp();
    let places = || (-5..=5_i64).flat_map(|i| (-5..=5_i64).map(move |j| (i, j)));
    let total: f64 = places().map(|(i, j)| bell(i, j)).sum();
    let (mut sum, mut windows) = (0.0, 0);
    for y in 5..height - 5 {
        for x in 5..width - 5 {
            let at = |raster: &Raster, (i, j): (i64, i64)| f64::from(raster.values[((y + j) * width + x + i) as usize]);
            let mean = |value: &dyn Fn((i64, i64)) -> f64| {
                places().map(|(i, j)| bell(i, j) / total * value((i, j))).sum::<f64>()
            };
            let (a_mean, b_mean) = (mean(&|p| at(a, p)), mean(&|p| at(b, p)));
            let a_variance = mean(&|p| (at(a, p) - a_mean).powi(2));
            let b_variance = mean(&|p| (at(b, p) - b_mean).powi(2));
            let covariance = mean(&|p| (at(a, p) - a_mean) * (at(b, p) - b_mean));
            let light = (2.0 * a_mean * b_mean + C1) / (a_mean * a_mean + b_mean * b_mean + C1);
            sum += light * (2.0 * covariance + C2) / (a_variance + b_variance + C2);
            windows += 1;
        }
    }
    sum / f64::from(windows)
}

/// MSSIM, which must be that of the definition.
fn similarity(a: &Raster, b: &Raster) -> f64 {
    let [found, expected] = [mssim(a, b, RANGE).unwrap(), mssim_written_out(a, b)];
    assert!((found - expected).abs() < 1e-9, "{found}, written out {expected}");
    assert_eq!(mssim(b, a, RANGE), Some(found), "which of the two comes first is no matter");
    found
}

#[test]
fn equal_pictures_are_0_apart_and_1_alike() {
    for picture in [Raster::from_fn(SIZE_PX, scene), flat(0.0), wave(90.0, 0.3)] {
        assert_eq!((rmse(&picture, &picture), similarity(&picture, &picture)), (0.0, 1.0));
    }
}

#[test]
fn an_offset_changes_the_light_alone() {
    let (a, b) = (flat(100.0), flat(130.0));
    assert_eq!(rmse(&a, &b), 30.0);
    let light = (2.0 * 100.0 * 130.0 + C1) / (100.0 * 100.0 + 130.0 * 130.0 + C1);
    assert!((similarity(&a, &b) - light).abs() < 1e-9);
    // With structure the offset is still all that differs, so the loss is as small.
    let textured = Raster::from_fn(SIZE_PX, scene);
    let brighter = map(&textured, |value| value + 30.0);
    assert!((rmse(&textured, &brighter) - 30.0).abs() < 1e-5);
    let alike = similarity(&textured, &brighter);
    assert!(alike > 0.9 && alike < 1.0, "{alike}");
}

#[test]
fn noise_has_the_rmse_of_its_deviation_and_takes_a_flat_pictures_structure() {
    let sum_of_squared_weights: f64 = window_weights().iter().map(|weight| weight * weight).sum::<f64>().powi(2);
    for (amount, seed) in [(2.0_f32, 1), (10.0, 2), (40.0, 3)] {
        let even = flat(128.0);
        let noisy = map(&even, noise(amount, seed));
        assert_eq!(rmse(&even, &noisy), f64::from(amount));
        // Covariance 0; the window's own mean takes its share of the variance.
        let variance = f64::from(amount).powi(2) * (1.0 - sum_of_squared_weights);
        let (expected, found) = (C2 / (variance + C2), similarity(&even, &noisy));
        assert!((found / expected - 1.0).abs() < 0.08, "noise of {amount}: {found}, expected {expected}");
    }
    let textured = Raster::from_fn(SIZE_PX, scene);
    let alike = [5.0, 10.0, 20.0].map(|amount| similarity(&textured, &map(&textured, noise(amount, 4))));
    assert!(alike.is_sorted_by(|a, b| a > b), "more noise, less alike: {alike:?}");
}

#[test]
fn a_shift_of_a_ramp_and_of_a_wave_in_closed_form() {
    let ramp = |shift: f32| Raster::from_fn(SIZE_PX, |column, row| 3.0 * (column as f32 + shift) + row as f32);
    assert!((rmse(&ramp(0.0), &ramp(2.0)) - 6.0).abs() < 1e-5);
    // Over whole periods: mean of A^2 (sin a - sin(a + p))^2 = A^2 (1 - cos p).
    for phase in [0.1, 1.0, TAU / 2.0] {
        let (a, b) = (wave(50.0, 0.0), wave(50.0, phase));
        assert!((rmse(&a, &b) - 50.0 * (1.0 - phase.cos()).sqrt()).abs() < 1e-3, "phase {phase}");
        similarity(&a, &b);
    }
    assert!(similarity(&wave(50.0, 0.0), &wave(50.0, TAU / 2.0)) < -0.5, "the opposite is less than nothing alike");
}

#[test]
fn a_blurred_wave_is_a_lower_wave() {
    // A mean over 3 columns takes (1 + 2 cos(2 pi / 16)) / 3 of the amplitude.
    let factor = (1.0 + 2.0 * (TAU / 16.0).cos()) / 3.0;
    let sharp = wave(60.0, 0.4);
    let at = |column: u32, row: u32| sharp.values[(row * SIZE_PX[0] + column % SIZE_PX[0]) as usize];
    let blurred = Raster::from_fn(SIZE_PX, |column, row| {
        (at(column + SIZE_PX[0] - 1, row) + at(column, row) + at(column + 1, row)) / 3.0
    });
    assert!((rmse(&sharp, &blurred) - 60.0 * (1.0 - factor) / 2.0_f64.sqrt()).abs() < 1e-3);
    // Structure and light stay, contrast alone is lost: close to, and never better than, 2 f / (1 + f^2).
    let (alike, bound) = (similarity(&sharp, &blurred), 2.0 * factor / (1.0 + factor * factor));
    assert!((alike - bound).abs() < 0.003, "{alike} of about {bound}");
}

#[test]
fn a_picture_smaller_than_a_window_has_no_similarity() {
    let small = Raster::from_fn([10, 99], scene);
    assert_eq!(mssim(&small, &small, RANGE), None);
    let one = Raster::from_fn([11, 11], scene);
    assert_eq!(mssim(&one, &one, RANGE), Some(1.0));
}

#[test]
fn depths_tell_ridges_from_outlines() {
    let near_m = 0.5;
    let depth = |m: f64| (near_m / m) as f32;
    let a = [depth(100.0), depth(1000.0), 0.0, 0.0, depth(50.0)];
    assert_eq!(compare_depths(&a, &a, near_m), DepthDifference { rmse_m: 0.0, outline_share: 0.0, ridge_share: 0.0 });
    // 3 m farther; another ridge 4 km behind; terrain in place of sky; sky; sky in place of terrain.
    let b = [depth(103.0), depth(5000.0), depth(70.0), 0.0, 0.0];
    let found = compare_depths(&a, &b, near_m);
    assert_eq!((found.outline_share, found.ridge_share), (0.4, 0.2));
    let expected = ((3.0_f64.powi(2) + 4000.0_f64.powi(2)) / 2.0).sqrt();
    assert!((found.rmse_m / expected - 1.0).abs() < 1e-5, "{found:?}");
    assert_eq!(compare_depths(&[], &[], near_m).rmse_m, 0.0);
}
