//! The columns of the summary.

use serde::{Deserialize, Serialize};

/// One row of `summary.csv`. What was not measured is empty; `err` says why a run failed.
///
/// `width` and `height` are the picture's. `tolerance_px` is a setting of the methods that take one, and the yardstick
/// of `over_tolerance_share` for all. Means of uploads leave out the first frame, which has a column of its own.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct SummaryRow {
    pub method: String,
    pub setting: String,
    /// The name that the run's files begin with.
    pub run: String,
    pub dem: String,
    pub width: u32,
    pub height: u32,
    pub tolerance_px: f64,
    pub patch: Option<u32>,
    pub frames: u32,
    pub adapter: String,
    pub adapter_type: String,
    pub fps_mean: Option<f64>,
    pub frame_ms_p50: Option<f64>,
    pub frame_ms_p95: Option<f64>,
    pub frame_ms_p99: Option<f64>,
    pub frame_ms_max: Option<f64>,
    pub plan_ms_p50: Option<f64>,
    pub encode_ms_p50: Option<f64>,
    pub gpu_ms_p50: Option<f64>,
    pub cpu_ms_mean: Option<f64>,
    pub triangles_mean: Option<f64>,
    pub triangles_max: Option<u64>,
    pub draws_mean: Option<f64>,
    pub draw_calls_mean: Option<f64>,
    pub upload_bytes_mean: Option<f64>,
    pub index_bytes_reserved: Option<u64>,
    /// Largest of all frames.
    pub index_bytes_used: Option<u64>,
    pub error_px_max: Option<f64>,
    pub error_px_p99: Option<f64>,
    pub error_px_rms: Option<f64>,
    pub over_tolerance_share: Option<f64>,
    pub error_m_max: Option<f64>,
    pub cracks: Option<u64>,
    pub err: String,
    pub flight: String,
    /// Vertical field of view.
    pub fov_y_deg: f64,
    pub dem_columns: u32,
    pub dem_rows: u32,
    pub error_px_p999: Option<f64>,
    pub error_px_p95: Option<f64>,
    pub plan_ms_p99: Option<f64>,
    /// DEM samples in view that have a height.
    pub samples_mean: Option<f64>,
    /// Frames that see no sample: they have no error and cost nothing.
    pub frames_without_samples: Option<u64>,
    pub first_upload_bytes: Option<u64>,
    pub updated_patches_mean: Option<f64>,
    /// The errors as displacements on the screen.
    pub displacement_px_max: Option<f64>,
    pub displacement_px_p99: Option<f64>,
    /// From here to `changed_triangles_mean`: what changes of the mesh alone do. Samples in view that they move, a frame,
    /// and over all moved samples of the flight how far, by the usual formula and on the screen.
    pub popping_samples_mean: Option<f64>,
    pub popping_px_max: Option<f64>,
    pub popping_px_p99: Option<f64>,
    pub popping_displacement_px_max: Option<f64>,
    pub popping_displacement_px_p99: Option<f64>,
    pub changed_triangles_mean: Option<f64>,
    /// From here to `late_frames`: the live pass, over all frames of all its flights. Frames a second that it is paced at.
    pub live_fps: Option<f64>,
    /// Share of the frames that draw a stale patch, and how many of them.
    pub stale_frames_share: Option<f64>,
    pub stale_patches_mean: Option<f64>,
    pub stale_patches_max: Option<u32>,
    /// How long updates are on their way: the longest of each frame that draws one.
    pub latency_ms_p50: Option<f64>,
    pub latency_ms_p99: Option<f64>,
    pub live_plan_ms_p50: Option<f64>,
    pub live_plan_ms_p99: Option<f64>,
    pub live_plan_ms_max: Option<f64>,
    /// CPU time of the same on its own thread.
    pub live_plan_cpu_ms_p99: Option<f64>,
    pub live_plan_cpu_ms_max: Option<f64>,
    pub live_error_px_max: Option<f64>,
    pub live_error_px_p99: Option<f64>,
    pub live_error_px_rms: Option<f64>,
    pub live_over_tolerance_share: Option<f64>,
    pub live_cracks: Option<u64>,
    /// Frames whose plan was not there when the next one was due.
    pub late_frames: Option<u64>,
    /// From here to `plan_ms_p99_high`: the speed pass. The 99.9th percentile is the longest frame below 1,000 timed ones.
    pub frame_ms_p999: Option<f64>,
    /// Frames a second of the slowest percent.
    pub fps_low_1pct: Option<f64>,
    /// What frames take above twice the median, summed over a flight.
    pub jank_ms: Option<f64>,
    /// Ends of 95 % intervals, from two repeats on.
    pub fps_mean_low: Option<f64>,
    pub fps_mean_high: Option<f64>,
    pub frame_ms_p50_low: Option<f64>,
    pub frame_ms_p50_high: Option<f64>,
    pub frame_ms_p99_low: Option<f64>,
    pub frame_ms_p99_high: Option<f64>,
    pub plan_ms_p50_low: Option<f64>,
    pub plan_ms_p50_high: Option<f64>,
    pub plan_ms_p99_low: Option<f64>,
    pub plan_ms_p99_high: Option<f64>,
    /// Of a method that loads cells: share of the frames with stand-ins in view, by how many pixels the bound is not held
    /// at worst, and the frames in which no number of pixels is a bound, which the column before leaves out: infinity is
    /// no number in JSON. Of plans that wait for their cells, and live.
    pub stand_in_frames_share: Option<f64>,
    pub unheld_px_max: Option<f64>,
    pub unbounded_frames: Option<u64>,
    pub live_stand_in_frames_share: Option<f64>,
    pub live_unheld_px_max: Option<f64>,
    pub live_unbounded_frames: Option<u64>,
    /// The DEM in memory, the GPU's heights included.
    pub resident_bytes: Option<u64>,
    /// Cells loaded, reads that failed and reads after a failure, from the beginning; of all live flights together. And
    /// how many cells a live frame waited for at most.
    pub cells_loaded: Option<u64>,
    pub reads_failed: Option<u64>,
    pub read_retries: Option<u64>,
    pub live_cells_due_max: Option<u64>,
    pub live_cells_loaded: Option<u64>,
    pub live_reads_failed: Option<u64>,
    pub live_read_retries: Option<u64>,
    /// Of the timed frames of the speed pass that have updates: how long these take in one frame (Bertilsson and Goswami
    /// 2016, Table 2).
    pub update_ms_max: Option<f64>,
    pub update_ms_min: Option<f64>,
    pub update_ms_mean: Option<f64>,
    /// From level 0 on, with spaces between them.
    #[serde(default)]
    pub triangles_by_level_mean: String,
    /// Finding out what is in view, of methods where that is a step of its own.
    #[serde(default)]
    pub cull_ms_p50: Option<f64>,
    /// Writing the plan's uploads into the buffers.
    #[serde(default)]
    pub upload_ms_p50: Option<f64>,
    /// From here to `picture_ridge_share`: the pictures against those of the full grid, means over their moments.
    #[serde(default)]
    pub picture_flat_rmse: Option<f64>,
    #[serde(default)]
    pub picture_flat_mssim: Option<f64>,
    /// FLIP is empty in a build without the feature `flip`.
    #[serde(default)]
    pub picture_flat_flip: Option<f64>,
    #[serde(default)]
    pub picture_shaded_rmse: Option<f64>,
    #[serde(default)]
    pub picture_shaded_mssim: Option<f64>,
    #[serde(default)]
    pub picture_shaded_flip: Option<f64>,
    #[serde(default)]
    pub picture_depth_rmse_m: Option<f64>,
    #[serde(default)]
    pub picture_outline_share: Option<f64>,
    #[serde(default)]
    pub picture_ridge_share: Option<f64>,
    /// Voids in view: they are not drawn, and no error is measured at them.
    #[serde(default)]
    pub void_samples_mean: Option<f64>,
    pub threads: usize,
    pub submission: String,
    /// Flights in the speed pass.
    pub repeats: u32,
    pub load_average: f64,
}
