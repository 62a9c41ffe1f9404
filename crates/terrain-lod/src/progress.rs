//! Progress with the time left, on stderr, where that is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// The bar of one pass. It shows nothing where stderr is no terminal.
pub struct Progress(ProgressBar);

impl Progress {
    pub fn new(pass: &'static str, steps: u64) -> Self {
        let style = ProgressStyle::with_template("{msg:14} {wide_bar} {pos}/{len}  {eta} left");
        let bar = ProgressBar::new(steps).with_message(pass);
        bar.set_style(style.expect("a template that indicatif understands"));
        Self(bar)
    }

    /// There is more to do than was known.
    pub fn extend(&self, steps: u64) {
        self.0.inc_length(steps);
    }

    pub fn step(&self) {
        self.0.inc(1);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
