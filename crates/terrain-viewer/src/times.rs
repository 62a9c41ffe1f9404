//! How long the last frames took, by the bench's statistics.

use std::collections::VecDeque;

use terrain_lod::{percentile, sorted};

use crate::thread::Spent;

/// Frames that the graph shows and the percentiles are of.
const KEPT: usize = 240;

/// Milliseconds of the last frames.
#[derive(Default)]
pub struct Times {
    /// From one frame to the next.
    frame_ms: VecDeque<f64>,
    /// What the render thread did for a frame: planning, the interface, recording, submitting. Not the GPU's part.
    work_ms: VecDeque<f64>,
    /// The same without the time in which others had the core: those of a software adapter, for one.
    own_ms: VecDeque<f64>,
}

impl Times {
    pub fn add(&mut self, frame_ms: f64, work: Spent) {
        push(&mut self.frame_ms, frame_ms);
        push(&mut self.work_ms, work.wall_ms);
        if let Some(own_ms) = work.own_ms {
            push(&mut self.own_ms, own_ms);
        }
    }

    pub fn frames_ms(&self) -> impl ExactSizeIterator<Item = f64> {
        self.frame_ms.iter().copied()
    }

    /// P50 and P99 of the frames; 0 before the first.
    pub fn frame_ms(&self) -> [f64; 2] {
        p50_p99(&self.frame_ms)
    }

    pub fn work_ms(&self) -> [f64; 2] {
        p50_p99(&self.work_ms)
    }

    /// `None` where the system does not say.
    pub fn own_ms(&self) -> Option<[f64; 2]> {
        (!self.own_ms.is_empty()).then(|| p50_p99(&self.own_ms))
    }
}

fn push(list: &mut VecDeque<f64>, ms: f64) {
    if list.len() == KEPT {
        list.pop_front();
    }
    list.push_back(ms);
}

fn p50_p99(list: &VecDeque<f64>) -> [f64; 2] {
    let sorted = sorted(list.iter().copied());
    [0.5, 0.99].map(|share| percentile(&sorted, share).unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn old_frames_are_forgotten() {
        let mut times = Times::default();
        assert_eq!(times.frame_ms(), [0.0; 2]);
        let work = |wall_ms| Spent { wall_ms, own_ms: None };
        times.add(1e6, work(1e6));
        (0..KEPT).for_each(|i| times.add(i as f64, work(1.0)));
        assert_eq!((times.frames_ms().len(), times.frame_ms()[1], times.work_ms()), (KEPT, 237.0, [1.0; 2]));
        assert_eq!(times.own_ms(), None);
    }
}
