//! Cells that could not be read, on stderr: a line the first time that one fails, as the method words it, and at the end of
//! a flight how many reads there were.

use terrain_core::{FramePlan, LodMethod};

use crate::methods::Run;

/// Lines a flight: a disk that is gone fails for every cell.
const LINES: usize = 8;

/// The failures of one flight.
pub struct ReadFailures {
    /// The flight's run.
    name: String,
    told: usize,
}

impl ReadFailures {
    pub fn of(run: &Run) -> Self {
        Self { name: run.file_stem(), told: 0 }
    }

    /// Tells what has failed since the last time.
    pub fn tell(&mut self, method: &mut dyn LodMethod) {
        for message in method.take_messages() {
            if let Some(line) = self.line(&message) {
                eprintln!("{line}");
            }
        }
    }

    /// `None` once there were enough.
    fn line(&mut self, message: &str) -> Option<String> {
        self.told += 1;
        match self.told {
            ..=LINES => Some(format!("warning: {}: {message}", self.name)),
            _ => None,
        }
    }

    /// The sum, by the flight's last plan.
    pub fn finish(mut self, method: &mut dyn LodMethod, last: &FramePlan) {
        self.tell(method);
        if let Some(line) = self.sum(last) {
            eprintln!("{line}");
        }
    }

    fn sum(&self, last: &FramePlan) -> Option<String> {
        let (failed, retries) = (last.streaming.reads_failed, last.streaming.retries);
        let untold = self.told.saturating_sub(LINES);
        let more = if untold > 0 { format!(" ({untold} more lines like those above)") } else { String::new() };
        (failed > 0).then(|| {
            format!(
                "warning: {}: {failed} reads of cells failed, {retries} reads were retries; coarser levels stood in{more}",
                self.name
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::Streaming;

    #[test]
    fn failures_are_told_a_few_times_and_counted_at_the_end() {
        let mut failures = ReadFailures { name: "run".to_owned(), told: 0 };
        let plan = |reads_failed, retries| FramePlan {
            streaming: Streaming { reads_failed, retries, ..Streaming::default() },
            ..FramePlan::default()
        };
        assert_eq!(failures.sum(&plan(0, 0)), None);
        let lines: Vec<_> = (0..11).filter_map(|cell| failures.line(&format!("cell {cell}: gone"))).collect();
        assert_eq!((lines.len(), lines[7].as_str()), (LINES, "warning: run: cell 7: gone"));
        let expected = "warning: run: 30 reads of cells failed, 19 reads were retries; coarser levels stood in (3 more lines \
                        like those above)";
        assert_eq!(failures.sum(&plan(30, 19)).unwrap(), expected);
    }
}
