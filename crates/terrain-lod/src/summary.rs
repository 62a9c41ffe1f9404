//! The summary: a row for each run and tolerance.

mod row;

use terrain_core::popping::Popping;

use crate::error_pass::{ErrorFlight, ErrorFrame};
use crate::frame_times::{RepeatTimes, percentile, sorted};
use crate::live_pass::{LiveFlight, LiveFrame};
use crate::methods::Run;
use crate::output::tidy;
use crate::pictures::PictureRow;
use crate::speed_pass::SpeedFrame;
use crate::suite::Bench;

pub use row::SummaryRow;

/// What the rows say of the machine.
#[derive(Clone, Debug, Default)]
pub struct Surroundings {
    pub adapter: String,
    pub adapter_type: String,
    pub submission: String,
    pub load_average: f64,
}

/// The rows of one run before anything is measured, one for each of its tolerances.
pub fn rows(bench: &Bench, run: &Run, surroundings: &Surroundings) -> Vec<SummaryRow> {
    let tolerances = bench.suite.tolerances_of(run);
    tolerances.iter().map(|tolerance_px| identity(bench, run, surroundings, *tolerance_px)).collect()
}

fn identity(bench: &Bench, run: &Run, surroundings: &Surroundings, tolerance_px: f64) -> SummaryRow {
    SummaryRow {
        method: run.method.as_str().into(),
        setting: run.setting(),
        run: run.file_stem(),
        dem: bench.dem.name.clone(),
        width: bench.suite.size_px[0],
        height: bench.suite.size_px[1],
        tolerance_px,
        patch: run.patch(),
        frames: bench.path.len(),
        adapter: surroundings.adapter.clone(),
        adapter_type: surroundings.adapter_type.clone(),
        flight: bench.flight_name.clone(),
        fov_y_deg: tidy(bench.path.fov_y().to_degrees()),
        dem_columns: bench.dem.heightmap.columns(),
        dem_rows: bench.dem.heightmap.rows(),
        threads: run.settings.threads,
        submission: surroundings.submission.clone(),
        load_average: surroundings.load_average,
        ..Default::default()
    }
}

/// What the error pass found, over the run's `tolerance`-th tolerance.
pub fn fill_errors(row: &mut SummaryRow, flight: &ErrorFlight, tolerance: usize) {
    let ErrorFlight { frames, errors, popping, index_bytes_reserved } = flight;
    let later = frames.get(1..).unwrap_or_default();
    row.triangles_mean = mean(frames, |f| f.triangles);
    row.triangles_max = frames.iter().map(|f| f.triangles).max();
    row.draws_mean = mean(frames, |f| f.draws);
    row.first_upload_bytes = frames.first().map(|f| f.upload_bytes);
    row.upload_bytes_mean = mean(later, |f| f.upload_bytes);
    row.updated_patches_mean = mean(later, |f| f.updated_patches);
    row.index_bytes_reserved = Some(*index_bytes_reserved);
    row.index_bytes_used = frames.iter().map(|f| f.index_bytes_used).max();
    row.samples_mean = mean(frames, |f| f.samples);
    row.void_samples_mean = mean(frames, |f| f.void_samples);
    row.frames_without_samples = Some(frames.iter().filter(|f| f.samples == 0).count() as u64);
    let measured = |value: f64| (errors.samples() > 0).then(|| tidy(value));
    row.error_px_max = measured(errors.max_px().into());
    row.error_px_p999 = measured(errors.percentile_px(0.999).into());
    row.error_px_p99 = measured(errors.percentile_px(0.99).into());
    row.error_px_p95 = measured(errors.percentile_px(0.95).into());
    row.error_px_rms = measured(errors.rms_px());
    row.over_tolerance_share = measured(errors.over_share(tolerance));
    row.error_m_max = measured(errors.max_m().into());
    row.cracks = Some(frames.iter().map(|f| f.cracks).sum());
    row.displacement_px_max = measured(errors.displacements().max_px().into());
    row.displacement_px_p99 = measured(errors.displacements().percentile_px(0.99).into());
    fill_popping(row, popping);
    row.triangles_by_level_mean = mean_by_level(frames);
    row.popping_samples_mean = mean(later, |f| f.popping_samples);
    row.changed_triangles_mean = mean(later, |f| f.changed_triangles);
    row.resident_bytes = frames.iter().map(|f| f.resident_bytes).max().filter(|bytes| *bytes > 0);
    if row.resident_bytes.is_some() {
        row.stand_in_frames_share = mean(frames, |f| (f.stand_ins > 0) as u64);
        let unheld_px = frames.iter().map(|f| f.unheld_px);
        (row.unheld_px_max, row.unbounded_frames) = (largest_finite(unheld_px.clone()), Some(infinite(unheld_px)));
        row.cells_loaded = frames.last().map(|f| f.cells_loaded);
        row.reads_failed = frames.last().map(|f| f.reads_failed);
        row.read_retries = frames.last().map(|f| f.read_retries);
    }
}

/// A mesh that never changes moves nothing: 0, where a frame's columns are empty.
fn fill_popping(row: &mut SummaryRow, popping: &Popping) {
    let (pixels, displacements) = (popping.pixels(), popping.displacements());
    row.popping_px_max = Some(tidy(pixels.max_px().into()));
    row.popping_px_p99 = Some(tidy(pixels.percentile_px(0.99).into()));
    row.popping_displacement_px_max = Some(tidy(displacements.max_px().into()));
    row.popping_displacement_px_p99 = Some(tidy(displacements.percentile_px(0.99).into()));
}

/// What the live pass found, over the run's `tolerance`-th tolerance.
pub fn fill_live(row: &mut SummaryRow, bench: &Bench, flight: &LiveFlight, tolerance: usize) {
    let LiveFlight { frames, errors } = flight;
    let all = |number: fn(&LiveFrame) -> Option<f64>| sorted(frames.iter().filter_map(number));
    row.live_fps = Some(tidy(1.0 / bench.path.step_s()));
    row.stale_frames_share = mean_of(&all(|f| Some((f.stale_patches > 0).into())));
    row.stale_patches_mean = mean_of(&all(|f| Some(f.stale_patches.into())));
    row.stale_patches_max = frames.iter().map(|f| f.stale_patches).max();
    let (latency_ms, plan_ms) = (all(|f| f.latency_ms), all(|f| Some(f.plan_ms)));
    row.latency_ms_p50 = percentile(&latency_ms, 0.5);
    row.latency_ms_p99 = percentile(&latency_ms, 0.99);
    row.live_plan_ms_p50 = percentile(&plan_ms, 0.5);
    row.live_plan_ms_p99 = percentile(&plan_ms, 0.99);
    row.live_plan_ms_max = plan_ms.last().copied();
    let plan_cpu_ms = all(|f| Some(f.plan_cpu_ms));
    row.live_plan_cpu_ms_p99 = percentile(&plan_cpu_ms, 0.99);
    row.live_plan_cpu_ms_max = plan_cpu_ms.last().copied();
    let measured = |value: f64| (errors.samples() > 0).then(|| tidy(value));
    row.live_error_px_max = measured(errors.max_px().into());
    row.live_error_px_p99 = measured(errors.percentile_px(0.99).into());
    row.live_error_px_rms = measured(errors.rms_px());
    row.live_over_tolerance_share = measured(errors.over_share(tolerance));
    row.live_cracks = Some(frames.iter().map(|f| f.cracks).sum());
    row.late_frames = Some(frames.iter().filter(|f| f.late).count() as u64);
    if row.resident_bytes.is_some() {
        row.live_stand_in_frames_share = mean_of(&all(|f| Some((f.stand_ins > 0).into())));
        let unheld_px = frames.iter().map(|f| f.unheld_px);
        row.live_unheld_px_max = largest_finite(unheld_px.clone());
        row.live_unbounded_frames = Some(infinite(unheld_px));
        // Each flight counts from its own beginning.
        let last_of_each = frames.chunk_by(|a, b| a.repeat == b.repeat).filter_map(<[LiveFrame]>::last);
        let sum = |count: fn(&LiveFrame) -> u64| Some(last_of_each.clone().map(count).sum());
        row.live_cells_due_max = frames.iter().map(|f| f.cells_due).max();
        row.live_cells_loaded = sum(|f| f.cells_loaded);
        row.live_reads_failed = sum(|f| f.reads_failed);
        row.live_read_retries = sum(|f| f.read_retries);
    }
}

/// What the speed pass found: medians over its repeats, and the largest of all timed frames.
pub fn fill_speed(row: &mut SummaryRow, frames: &[SpeedFrame], times: &RepeatTimes) {
    let ends = |statistic| times.interval(statistic).map_or((None, None), |i| (Some(tidy(i.low)), Some(tidy(i.high))));
    row.repeats = frames.last().map_or(0, |last| last.repeat + 1);
    row.fps_mean = times.median("fps_mean");
    row.frame_ms_p50 = times.median("frame_ms_p50");
    row.frame_ms_p95 = times.median("frame_ms_p95");
    row.frame_ms_p99 = times.median("frame_ms_p99");
    row.frame_ms_max = times.get("frame_ms_max").iter().copied().reduce(f64::max);
    row.plan_ms_p50 = times.median("plan_ms_p50");
    row.plan_ms_p99 = times.median("plan_ms_p99");
    row.encode_ms_p50 = times.median("encode_ms_p50");
    row.gpu_ms_p50 = times.median("gpu_ms_p50");
    row.cull_ms_p50 = times.median("cull_ms_p50");
    row.upload_ms_p50 = times.median("upload_ms_p50");
    row.cpu_ms_mean = times.median("cpu_ms_mean");
    row.frame_ms_p999 = times.median("frame_ms_p999");
    row.fps_low_1pct = times.median("fps_low_1pct");
    row.jank_ms = times.median("jank_ms");
    (row.fps_mean_low, row.fps_mean_high) = ends("fps_mean");
    (row.frame_ms_p50_low, row.frame_ms_p50_high) = ends("frame_ms_p50");
    (row.frame_ms_p99_low, row.frame_ms_p99_high) = ends("frame_ms_p99");
    (row.plan_ms_p50_low, row.plan_ms_p50_high) = ends("plan_ms_p50");
    (row.plan_ms_p99_low, row.plan_ms_p99_high) = ends("plan_ms_p99");
    let updates = sorted(frames.iter().filter(|f| !f.warm_up && f.update_ms > 0.0).map(|f| f.update_ms));
    (row.update_ms_min, row.update_ms_max) = (updates.first().copied(), updates.last().copied());
    row.update_ms_mean = mean_of(&updates);
    // Counts are counts, also while warming up: so they compare with the plan's draws.
    row.draw_calls_mean = mean_of(&frames.iter().filter_map(|f| f.draw_calls.map(f64::from)).collect::<Vec<_>>());
}

/// What the pictures are worth.
pub fn fill_pictures(row: &mut SummaryRow, pictures: &[PictureRow]) {
    let all = |number: fn(&PictureRow) -> Option<f64>| mean_of(&pictures.iter().filter_map(number).collect::<Vec<_>>());
    row.picture_flat_rmse = all(|picture| Some(picture.flat_rmse));
    row.picture_flat_mssim = all(|picture| picture.flat_mssim);
    row.picture_flat_flip = all(|picture| picture.flat_flip);
    row.picture_shaded_rmse = all(|picture| Some(picture.shaded_rmse));
    row.picture_shaded_mssim = all(|picture| picture.shaded_mssim);
    row.picture_shaded_flip = all(|picture| picture.shaded_flip);
    row.picture_depth_rmse_m = all(|picture| picture.depth_rmse_m);
    row.picture_outline_share = all(|picture| picture.outline_share);
    row.picture_ridge_share = all(|picture| picture.ridge_share);
}

fn mean(frames: &[ErrorFrame], count: fn(&ErrorFrame) -> u64) -> Option<f64> {
    let counts: Vec<f64> = frames.iter().map(|f| count(f) as f64).collect();
    mean_of(&counts)
}

/// Whole triangles, level by level.
fn mean_by_level(frames: &[ErrorFrame]) -> String {
    let mut sums: Vec<u64> = Vec::new();
    for frame in frames {
        for (level, triangles) in frame.triangles_by_level.split(' ').filter_map(|text| text.parse().ok()).enumerate() {
            let triangles: u64 = triangles;
            sums.resize(sums.len().max(level + 1), 0);
            sums[level] += triangles;
        }
    }
    let mean = |sum: &u64| ((*sum as f64 / frames.len() as f64).round() as u64).to_string();
    sums.iter().map(mean).collect::<Vec<_>>().join(" ")
}

fn mean_of(numbers: &[f64]) -> Option<f64> {
    (!numbers.is_empty()).then(|| tidy(numbers.iter().sum::<f64>() / numbers.len() as f64))
}

fn largest_finite(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    numbers.filter(|number| number.is_finite()).max_by(f64::total_cmp)
}

fn infinite(numbers: impl Iterator<Item = f64>) -> u64 {
    numbers.filter(|number| number.is_infinite()).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::error::ErrorDistribution;

    /// Found by a review: JSON has no infinity, so a resumed bench had an empty cell where another one has `inf`.
    #[test]
    fn an_infinite_unheld_px_was_lost_in_a_part() {
        let frame = |unheld_px| ErrorFrame { unheld_px, resident_bytes: 1, ..ErrorFrame::default() };
        let filled = |unheld_px: &[f64]| {
            let frames = unheld_px.iter().copied().map(frame).collect();
            let flight = ErrorFlight {
                frames,
                errors: ErrorDistribution::new(&[1.0]),
                popping: Popping::default(),
                index_bytes_reserved: 0,
            };
            let mut row = SummaryRow::default();
            fill_errors(&mut row, &flight, 0);
            row
        };
        let row = filled(&[0.0, f64::INFINITY, 2.5, f64::INFINITY]);
        assert_eq!((row.unheld_px_max, row.unbounded_frames), (Some(2.5), Some(2)));
        let resumed: SummaryRow = serde_json::from_str(&serde_json::to_string(&row).unwrap()).unwrap();
        assert_eq!(format!("{resumed:?}"), format!("{row:?}"));
        let row = filled(&[f64::INFINITY]);
        assert_eq!((row.unheld_px_max, row.unbounded_frames), (None, Some(1)), "0 would say that the bound is held");
    }

    #[test]
    fn the_largest_frame_is_that_of_all_repeats_and_the_rest_are_medians() {
        let frame = |repeat, frame_ms| SpeedFrame {
            repeat,
            frame_ms: Some(frame_ms),
            draw_calls: Some(7),
            // One flight has none.
            update_ms: frame_ms - 10.0,
            ..SpeedFrame::default()
        };
        let frames = [frame(0, 10.0), frame(1, 30.0), frame(2, 11.0)];
        let mut row = SummaryRow::default();
        fill_speed(&mut row, &frames, &RepeatTimes::of(&frames));
        assert_eq!((row.frame_ms_p50, row.frame_ms_max, row.repeats), (Some(11.0), Some(30.0), 3));
        assert!(row.frame_ms_p50_low < Some(11.0) && row.frame_ms_p50_high > Some(11.0), "{row:?}");
        let updates = [row.update_ms_min, row.update_ms_mean, row.update_ms_max];
        assert_eq!(updates, [Some(1.0), Some(10.5), Some(20.0)], "of the frames that have any");
        assert_eq!((row.draw_calls_mean, row.gpu_ms_p50), (Some(7.0), None), "not measured is empty, not zero");
    }
}
