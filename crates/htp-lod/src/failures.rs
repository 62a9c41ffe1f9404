//! Reads that failed: counted, told of once, and tried again.

use std::collections::{BTreeMap, BTreeSet};

use crate::cells::CellsError;

/// Reads of cells that failed, from the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FailedReads {
    /// The source failed: missing, cut short, denied.
    pub io: u64,
    /// The bytes were not those with the checksum.
    pub damaged: u64,
    /// The bytes were those of another cell.
    pub wrong_cell: u64,
    /// Anything else.
    pub other: u64,
}

impl FailedReads {
    /// All of them.
    pub fn sum(&self) -> u64 {
        self.io + self.damaged + self.wrong_cell + self.other
    }

    fn count_of(&mut self, kind: Kind) -> &mut u64 {
        match kind {
            Kind::Io => &mut self.io,
            Kind::Damaged => &mut self.damaged,
            Kind::WrongCell => &mut self.wrong_cell,
            Kind::Other => &mut self.other,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Io,
    Damaged,
    WrongCell,
    Other,
}

impl Kind {
    fn of(error: &CellsError) -> Self {
        match error {
            CellsError::Io(_) => Self::Io,
            CellsError::Damaged { .. } => Self::Damaged,
            CellsError::WrongCell { .. } => Self::WrongCell,
            _ => Self::Other,
        }
    }
}

/// Plans before the first new attempt; twice as many before each next one.
const PLANS_BEFORE_RETRY: u64 = 8;
/// Plans before a new attempt at most: 17 seconds at 60 frames a second.
const MOST_PLANS_BEFORE_RETRY: u64 = 1 << 10;

/// What has failed and is to be tried again. Time is counted in plans: no clock decides.
#[derive(Default)]
pub(crate) struct Failures {
    pub reads: FailedReads,
    /// Reads of cells that had failed before.
    pub retries: u64,
    failed: BTreeMap<[u32; 2], Failed>,
    /// Cells and kinds that were told of.
    told: BTreeSet<([u32; 2], Kind)>,
    messages: Vec<String>,
}

struct Failed {
    attempts: u32,
    /// Number of the plan that tries again.
    due: u64,
}

impl Failures {
    /// Takes note of a read, and of why it has failed if it has.
    pub fn note(&mut self, cell: [u32; 2], error: Option<&CellsError>, plan: u64) {
        self.retries += self.failed.contains_key(&cell) as u64;
        let Some(error) = error else {
            self.failed.remove(&cell);
            return;
        };
        *self.reads.count_of(Kind::of(error)) += 1;
        let failed = self.failed.entry(cell).or_insert(Failed { attempts: 0, due: 0 });
        failed.due = plan + (PLANS_BEFORE_RETRY << failed.attempts.min(32)).min(MOST_PLANS_BEFORE_RETRY);
        failed.attempts += 1;
        self.tell(cell, error);
    }

    /// Whether a cell may be read in a plan.
    pub fn may_read(&self, cell: [u32; 2], plan: u64) -> bool {
        self.failed.get(&cell).is_none_or(|failed| failed.due <= plan)
    }

    /// Whether any cell is to be tried again from this plan on.
    pub fn is_due(&self, plan: u64) -> bool {
        self.failed.values().any(|failed| failed.due == plan)
    }

    /// One message a cell and kind of failure.
    fn tell(&mut self, cell: [u32; 2], error: &CellsError) {
        let [column, row] = cell;
        if self.told.insert((cell, Kind::of(error))) {
            self.messages.push(format!("cell ({column}, {row}): {error}; its coarse levels stand in for it"));
        }
    }

    /// What is to be told since the last time.
    pub fn take_messages(&mut self) -> Vec<String> {
        std::mem::take(&mut self.messages)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_is_read_again_ever_later_until_it_can_be_and_told_of_once_a_kind() {
        let (mut failures, mut plan, mut waits) = (Failures::default(), 0, Vec::new());
        let damaged = || CellsError::Damaged { part: "cell".to_owned() };
        for attempt in 0..10 {
            let io = CellsError::from(std::io::Error::from(std::io::ErrorKind::NotFound));
            let error = if attempt == 3 { damaged() } else { io };
            failures.note([4, 5], Some(&error), plan);
            let due = (plan + 1..).find(|plan| failures.may_read([4, 5], *plan)).unwrap();
            assert!(failures.is_due(due) && !failures.is_due(due - 1) && failures.may_read([5, 4], plan));
            waits.push(due - plan);
            plan = due;
        }
        assert_eq!(waits, [8, 16, 32, 64, 128, 256, 512, 1024, 1024, 1024]);
        assert_eq!(failures.reads, FailedReads { io: 9, damaged: 1, ..FailedReads::default() });
        assert_eq!((failures.reads.sum(), failures.retries), (10, 9));
        let expected = "cell (4, 5): cannot read cells: entity not found; its coarse levels stand in for it";
        let messages = failures.take_messages();
        assert_eq!((messages.len(), messages[0].as_str()), (2, expected));

        failures.note([4, 5], None, plan);
        assert_eq!((failures.retries, failures.may_read([4, 5], plan)), (10, true));
        failures.note([4, 5], Some(&damaged()), plan);
        assert!(failures.may_read([4, 5], plan + 8), "the next failure is a first one");
        assert!(failures.take_messages().is_empty());
    }
}
