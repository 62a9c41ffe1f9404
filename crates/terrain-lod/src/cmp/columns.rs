//! What the summary's columns mean to a comparison. A column that is not named here is a counter of which less is better,
//! so that a new one is compared without anyone's doing.

/// Times that are compared, by their columns.
pub const TIMES: [&str; 8] = [
    "fps_mean",
    "frame_ms_p50",
    "frame_ms_p99",
    "plan_ms_p50",
    "plan_ms_p99",
    "encode_ms_p50",
    "gpu_ms_p50",
    "cpu_ms_mean",
];

/// What a row and its partner must share to be comparable, beside the facts of `machine.json`.
pub const ROW_FACTS: [&str; 12] = [
    "dem",
    "dem_columns",
    "dem_rows",
    "flight",
    "frames",
    "fov_y_deg",
    "width",
    "height",
    "adapter",
    "adapter_type",
    "threads",
    "submission",
];

/// The facts of `machine.json`, by their JSON pointers.
pub const MACHINE_FACTS: [&str; 10] = [
    "/cpu",
    "/cores",
    "/backend",
    "/driver",
    "/profile",
    "/dem_sha256",
    "/flight_sha256",
    "/options/size_px",
    "/options/warm_up",
    "/look",
];

/// Who the row is, and what says nothing of a method.
const NO_COUNTERS: [&str; 11] = [
    "method",
    "setting",
    "tolerance_px",
    "patch",
    "repeats",
    "load_average",
    "samples_mean",
    "frames_without_samples",
    "void_samples_mean",
    // More is better; the RMSE beside it says the same the other way round.
    "picture_flat_mssim",
    "picture_shaded_mssim",
];

/// What a clock, or a race with the camera, has a hand in.
const TIMED: [&str; 6] = ["fps_", "live_", "stale_", "latency_", "late_", "jank_"];

/// Whether a column is the same in every flight of the same program.
pub fn is_counter(column: &str) -> bool {
    let is_timed = column.contains("_ms_") || TIMED.iter().any(|start| column.starts_with(start));
    !is_timed && !NO_COUNTERS.contains(&column) && !ROW_FACTS.contains(&column)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::SummaryRow;

    #[test]
    fn the_lists_name_columns_of_the_summary() {
        let row = serde_json::to_value(SummaryRow::default()).unwrap();
        for column in TIMES.iter().chain(&ROW_FACTS).chain(&NO_COUNTERS) {
            assert!(row.get(column).is_some(), "{column} is no column");
        }
        assert!(TIMES.iter().all(|time| !is_counter(time)));
        for counter in
            ["triangles_mean", "draw_calls_mean", "error_px_p999", "cracks", "upload_bytes_mean", "popping_px_max"]
        {
            assert!(is_counter(counter), "{counter}");
        }
        for timed in ["frame_ms_p50_low", "live_error_px_max", "late_frames", "stale_patches_max", "jank_ms"] {
            assert!(!is_counter(timed), "{timed}");
        }
    }
}
