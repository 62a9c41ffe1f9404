//! What the system says of a thread, and how one is put behind the others. On Linux alone: elsewhere nothing is said, and all
//! threads are equal.

use std::time::{Duration, Instant};

/// How far those that work behind the frames step back, as `nice` counts it. They inherit it from the thread that starts them, so
/// a method needs to know nothing of it: who builds it steps back first.
pub const BEHIND_THE_FRAMES: i32 = 10;

/// Lets threads of this process that want the same core go first: this one, and all that it starts from now on.
pub fn step_back() {
    #[cfg(target_os = "linux")]
    {
        // On Linux a "process" without a number is the calling thread. One that was put back already stays there, and where
        // the system refuses, all are equal.
        let nice = rustix::process::getpriority_process(None).unwrap_or(0);
        let _ = rustix::process::setpriority_process(None, nice.max(BEHIND_THE_FRAMES));
    }
}

/// Time on the clock, and of it the time that this thread was on a core.
#[derive(Clone, Copy)]
pub struct Stopwatch {
    wall: Instant,
    cpu: Option<Duration>,
}

/// Milliseconds by a [`Stopwatch`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    pub wall_ms: f64,
    /// `None` where the system does not say.
    pub cpu_ms: Option<f64>,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu: cpu_time() }
    }

    pub fn spent(&self) -> Spent {
        let cpu = cpu_time().zip(self.cpu).map(|(now, start)| now.saturating_sub(start));
        Spent { wall_ms: 1e3 * self.wall.elapsed().as_secs_f64(), cpu_ms: cpu.map(|cpu| 1e3 * cpu.as_secs_f64()) }
    }
}

impl std::ops::Add for Spent {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let cpu_ms = self.cpu_ms.zip(other.cpu_ms).map(|(a, b)| a + b);
        Self { wall_ms: self.wall_ms + other.wall_ms, cpu_ms }
    }
}

/// Of the calling thread.
fn cpu_time() -> Option<Duration> {
    #[cfg(target_os = "linux")]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        Duration::try_from(time).ok()
    }
    #[cfg(not(target_os = "linux"))]
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_sleeps_spends_no_time_on_a_core() {
        let watch = Stopwatch::start();
        std::thread::sleep(Duration::from_millis(20));
        let spent = watch.spent();
        assert!(spent.wall_ms >= 20.0, "{spent:?}");
        if cfg!(target_os = "linux") {
            assert!(spent.cpu_ms.unwrap() < spent.wall_ms, "{spent:?}");
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn who_steps_back_takes_along_those_that_it_starts_and_nobody_else() {
        let nice = || rustix::process::getpriority_process(None).unwrap();
        let before = nice();
        let started = std::thread::spawn(move || {
            step_back();
            std::thread::spawn(nice).join().unwrap()
        });
        assert_eq!(started.join().unwrap(), before.max(BEHIND_THE_FRAMES));
        assert_eq!(nice(), before);
    }
}
