//! The statistics of the speed pass: each is computed for every flight by itself, and the summary has its median over the
//! repeats. So one flight in a slow spell of the machine moves no number, and the repeats say how sure a number is.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::interval::{Interval, median};
use crate::output::tidy;
use crate::speed_pass::SpeedFrame;

/// A frame that takes longer than this many medians of its flight janks by what is above.
const JANK: f64 = 2.0;
/// Times are kept in microseconds. One below this is read as this, so that a tick of the clock makes no difference.
pub const SHORTEST_MS: f64 = 0.01;

/// The timed frames of one flight: its numbers in order. What was not measured is empty.
struct Flight {
    frame_ms: Vec<f64>,
    plan_ms: Vec<f64>,
    encode_ms: Vec<f64>,
    gpu_ms: Vec<f64>,
    cull_ms: Vec<f64>,
    upload_ms: Vec<f64>,
    cpu_ms: Vec<f64>,
}

/// A name, and how it is computed.
type Statistic = (&'static str, fn(&Flight) -> Option<f64>);

/// The statistics by their columns.
const STATISTICS: [Statistic; 15] = [
    ("fps_mean", |f| mean(&f.frame_ms).map(fps)),
    ("fps_low_1pct", |f| mean(slowest_percent(&f.frame_ms)).map(fps)),
    ("frame_ms_p50", |f| percentile(&f.frame_ms, 0.5)),
    ("frame_ms_p95", |f| percentile(&f.frame_ms, 0.95)),
    ("frame_ms_p99", |f| percentile(&f.frame_ms, 0.99)),
    ("frame_ms_p999", |f| percentile(&f.frame_ms, 0.999)),
    ("frame_ms_max", |f| f.frame_ms.last().copied()),
    ("jank_ms", |f| jank(&f.frame_ms)),
    ("plan_ms_p50", |f| percentile(&f.plan_ms, 0.5)),
    ("plan_ms_p99", |f| percentile(&f.plan_ms, 0.99)),
    ("encode_ms_p50", |f| percentile(&f.encode_ms, 0.5)),
    ("gpu_ms_p50", |f| percentile(&f.gpu_ms, 0.5)),
    ("cull_ms_p50", |f| percentile(&f.cull_ms, 0.5)),
    ("upload_ms_p50", |f| percentile(&f.upload_ms, 0.5)),
    ("cpu_ms_mean", |f| mean(&f.cpu_ms)),
];

/// Each statistic by its column: one value a repeat, in the order that they were flown.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RepeatTimes(BTreeMap<String, Vec<f64>>);

impl RepeatTimes {
    /// Of the frames of all repeats of one run. Warm-up frames are left out.
    pub fn of(frames: &[SpeedFrame]) -> Self {
        let flights: Vec<Flight> = frames.chunk_by(|a, b| a.repeat == b.repeat).map(Flight::of).collect();
        let values = |statistic: &Statistic| flights.iter().filter_map(statistic.1).map(tidy).collect::<Vec<_>>();
        let measured = STATISTICS.iter().map(|statistic| (statistic.0.to_string(), values(statistic)));
        Self(measured.filter(|(_, values)| !values.is_empty()).collect())
    }

    /// One value a repeat; none where it was not measured.
    pub fn get(&self, statistic: &str) -> &[f64] {
        self.0.get(statistic).map_or(&[], Vec::as_slice)
    }

    /// Median over the repeats.
    pub fn median(&self, statistic: &str) -> Option<f64> {
        median(self.get(statistic)).map(tidy)
    }

    /// The same with its interval, where there are repeats enough.
    pub fn interval(&self, statistic: &str) -> Option<Interval> {
        Interval::of_median(self.get(statistic))
    }

    /// Width of the interval of the [headline](Self::headline) as a share of its median; `None` without an interval.
    pub fn headline_width(&self) -> Option<f64> {
        let Interval { estimate, low, high } = self.interval(self.headline())?;
        Some((high - low) / estimate.max(SHORTEST_MS))
    }

    /// The statistic that stands for a run's speed: its median frame time, or plan time where nothing was drawn.
    pub fn headline(&self) -> &'static str {
        if self.get("frame_ms_p50").is_empty() { "plan_ms_p50" } else { "frame_ms_p50" }
    }
}

impl Flight {
    fn of(frames: &[SpeedFrame]) -> Self {
        let sorted =
            |time: fn(&SpeedFrame) -> Option<f64>| sorted(frames.iter().filter(|f| !f.warm_up).filter_map(time));
        Self {
            frame_ms: sorted(|f| f.frame_ms),
            plan_ms: sorted(|f| Some(f.plan_ms)),
            encode_ms: sorted(|f| f.encode_ms),
            gpu_ms: sorted(|f| f.gpu_ms),
            // A method that has no such step says 0.
            cull_ms: sorted(|f| (f.cull_ms > 0.0).then_some(f.cull_ms)),
            upload_ms: sorted(|f| f.upload_ms),
            // Of frames that were drawn: CPU time of the plan alone would be another number.
            cpu_ms: sorted(|f| f.frame_ms.map(|_| f.cpu_ms)),
        }
    }
}

fn fps(frame_ms: f64) -> f64 {
    1e3 / frame_ms
}

/// The last percent of sorted times, at least one.
fn slowest_percent(sorted: &[f64]) -> &[f64] {
    &sorted[sorted.len() - sorted.len().div_ceil(100)..]
}

/// Milliseconds above [`JANK`] medians, summed over the flight.
fn jank(sorted: &[f64]) -> Option<f64> {
    let limit = JANK * percentile(sorted, 0.5)?;
    Some(sorted.iter().map(|time| (time - limit).max(0.0)).sum())
}

fn mean(numbers: &[f64]) -> Option<f64> {
    (!numbers.is_empty()).then(|| numbers.iter().sum::<f64>() / numbers.len() as f64)
}

/// The numbers in order.
pub fn sorted(numbers: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut numbers: Vec<f64> = numbers.collect();
    numbers.sort_by(f64::total_cmp);
    numbers
}

/// The smallest number that a `share` of the sorted ones do not exceed.
pub fn percentile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.max(1) - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(repeat: u32, frame_ms: f64, warm_up: bool) -> SpeedFrame {
        let plan_ms = frame_ms / 10.0;
        SpeedFrame { repeat, frame_ms: Some(frame_ms), plan_ms, warm_up, cpu_ms: 2.0, ..SpeedFrame::default() }
    }

    #[test]
    fn percentiles_are_members_of_the_list() {
        let ten: Vec<f64> = (1..=10).map(f64::from).collect();
        assert_eq!([0.5, 0.95, 0.99, 0.0].map(|s| percentile(&ten, s).unwrap()), [5.0, 10.0, 10.0, 1.0]);
        assert_eq!(percentile(&[], 0.5), None);
    }

    #[test]
    fn every_statistic_is_a_column() {
        let row = serde_json::to_value(crate::summary::SummaryRow::default()).unwrap();
        STATISTICS.iter().for_each(|(name, _)| assert!(row.get(name).is_some(), "{name}"));
    }

    #[test]
    fn warm_up_frames_are_not_timed() {
        let times = RepeatTimes::of(&[frame(0, 1e6, true), frame(0, 10.0, false), frame(0, 30.0, false)]);
        assert_eq!((times.get("fps_mean"), times.get("frame_ms_max")), (&[50.0][..], &[30.0][..]));
        assert!(times.get("gpu_ms_p50").is_empty(), "not measured is empty, not zero");
    }

    #[test]
    fn a_slow_repeat_is_one_value_and_moves_no_median() {
        let flight = |repeat: u32, ms: f64| (0..100).map(move |i| frame(repeat, ms + f64::from(i) / 100.0, false));
        let frames: Vec<SpeedFrame> = flight(0, 10.0).chain(flight(1, 50.0)).chain(flight(2, 10.0)).collect();
        let times = RepeatTimes::of(&frames);
        assert_eq!(times.get("frame_ms_p99"), [10.98, 50.98, 10.98]);
        assert_eq!(times.median("frame_ms_p99"), Some(10.98));
        assert_eq!((times.headline(), times.get("plan_ms_p50").len()), ("frame_ms_p50", 3));
    }

    #[test]
    fn jank_is_what_exceeds_two_medians_and_the_slowest_percent_has_at_least_one_frame() {
        let frames: Vec<SpeedFrame> = [10.0, 10.0, 10.0, 20.0, 26.0].map(|ms| frame(0, ms, false)).into();
        let times = RepeatTimes::of(&frames);
        assert_eq!((times.median("jank_ms"), times.median("fps_low_1pct")), (Some(6.0), Some(tidy(1e3 / 26.0))));
        assert_eq!(slowest_percent(&[1.0; 250]).len(), 3);
        assert!(slowest_percent(&[]).is_empty());
    }
}
