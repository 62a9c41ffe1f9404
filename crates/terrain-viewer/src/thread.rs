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
        let before = rustix::process::getpriority_process(None).unwrap_or(0);
        let _ = rustix::process::setpriority_process(None, before.max(BEHIND_THE_FRAMES));
    }
}

/// Time on the clock, and of it the time in which this thread was ready to run and others had its core.
#[derive(Clone, Copy)]
pub struct Stopwatch {
    wall: Instant,
    queued: Option<Duration>,
}

/// Milliseconds by a [`Stopwatch`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent {
    pub wall_ms: f64,
    /// Without the time in which others had the core: work, and waiting for locks. `None` where the system does not say.
    pub own_ms: Option<f64>,
}

impl Stopwatch {
    pub fn start() -> Self {
        Self { wall: Instant::now(), queued: queued() }
    }

    pub fn spent(&self) -> Spent {
        let wall = self.wall.elapsed();
        let queued = queued().zip(self.queued).map(|(now, start)| now.saturating_sub(start));
        let ms = |time: Duration| 1e3 * time.as_secs_f64();
        Spent { wall_ms: ms(wall), own_ms: queued.map(|queued| ms(wall.saturating_sub(queued))) }
    }
}

impl std::ops::Add for Spent {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let own_ms = self.own_ms.zip(other.own_ms).map(|(a, b)| a + b);
        Self { wall_ms: self.wall_ms + other.wall_ms, own_ms }
    }
}

/// For how long the calling thread has been ready and without a core: the second number of Linux's `schedstat`.
fn queued() -> Option<Duration> {
    let numbers = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    numbers.split_whitespace().nth(1)?.parse().ok().map(Duration::from_nanos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn to_sleep_is_a_threads_own_time() {
        let watch = Stopwatch::start();
        std::thread::sleep(Duration::from_millis(20));
        let Spent { wall_ms, own_ms } = watch.spent();
        assert!(wall_ms >= 20.0 && own_ms.is_none_or(|own_ms| own_ms <= wall_ms), "{wall_ms}, {own_ms:?}");
        let both = Spent { wall_ms: 3.0, own_ms: Some(2.0) } + Spent { wall_ms: 1.0, own_ms: Some(1.0) };
        assert_eq!(both, Spent { wall_ms: 4.0, own_ms: Some(3.0) });
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
