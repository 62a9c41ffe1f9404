//! Reads that failed: counted, told of once, and tried again.

use std::collections::{BTreeMap, BTreeSet};

use crate::cells::CellsError;
use crate::window::Sheet;

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
    /// Reads of sheets that had failed before.
    pub retries: u64,
    failed: BTreeMap<Sheet, Failed>,
    /// Plans from which on sheets are to be tried again, those that were asked about left out.
    due: BTreeSet<u64>,
    /// Sheets and kinds that were told of.
    told: BTreeSet<(Sheet, Kind)>,
    messages: Vec<String>,
}

struct Failed {
    attempts: u32,
    /// Number of the plan that tries again.
    due: u64,
}

impl Failures {
    /// Takes note of a read, and of why it has failed if it has.
    pub fn note(&mut self, sheet: Sheet, error: Option<&CellsError>, plan: u64) {
        self.retries += self.failed.contains_key(&sheet) as u64;
        let Some(error) = error else {
            self.failed.remove(&sheet);
            return;
        };
        *self.reads.count_of(Kind::of(error)) += 1;
        let failed = self.failed.entry(sheet).or_insert(Failed { attempts: 0, due: 0 });
        let wait = (PLANS_BEFORE_RETRY << failed.attempts.min(32)).min(MOST_PLANS_BEFORE_RETRY);
        failed.due = plan + wait;
        failed.attempts += 1;
        self.due.insert(plan + wait);
        self.tell(sheet, error);
    }

    /// Whether a sheet may be read in a plan.
    pub fn may_read(&self, sheet: Sheet, plan: u64) -> bool {
        self.failed.get(&sheet).is_none_or(|failed| failed.due <= plan)
    }

    /// Whether any sheet is to be tried again that was not when this was last asked.
    pub fn take_due(&mut self, plan: u64) -> bool {
        let later = self.due.split_off(&(plan + 1));
        !std::mem::replace(&mut self.due, later).is_empty()
    }

    /// One message a sheet and kind of failure.
    fn tell(&mut self, sheet: Sheet, error: &CellsError) {
        let Sheet { level, cell: [column, row] } = sheet;
        if self.told.insert((sheet, Kind::of(error))) {
            self.messages.push(format!(
                "cell ({column}, {row}), level {level}: {error}; coarser levels stand in for it, and it is read again after \
                 {PLANS_BEFORE_RETRY} to {MOST_PLANS_BEFORE_RETRY} plans, ever later"
            ));
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
        let [sheet, other] = [[4, 5], [5, 4]].map(|cell| Sheet { level: 1, cell });
        let damaged = || CellsError::Damaged { part: "cell".to_owned() };
        for attempt in 0..10 {
            let io = CellsError::from(std::io::Error::from(std::io::ErrorKind::NotFound));
            let error = if attempt == 3 { damaged() } else { io };
            failures.note(sheet, Some(&error), plan);
            let due = (plan + 1..).find(|plan| failures.may_read(sheet, *plan)).unwrap();
            assert!(!failures.take_due(due - 1) && failures.take_due(due) && failures.may_read(other, plan));
            assert!(!failures.take_due(due), "asked for once");
            waits.push(due - plan);
            plan = due;
        }
        assert_eq!(waits, [8, 16, 32, 64, 128, 256, 512, 1024, 1024, 1024]);
        assert_eq!(failures.reads, FailedReads { io: 9, damaged: 1, ..FailedReads::default() });
        assert_eq!((failures.reads.sum(), failures.retries), (10, 9));
        let expected = "cell (4, 5), level 1: cannot read cells: entity not found; coarser levels stand in for it, and it is \
                        read again after 8 to 1024 plans, ever later";
        let messages = failures.take_messages();
        assert_eq!((messages.len(), messages[0].as_str()), (2, expected));

        failures.note(sheet, None, plan);
        assert_eq!((failures.retries, failures.may_read(sheet, plan)), (10, true));
        failures.note(sheet, Some(&damaged()), plan);
        assert!(failures.may_read(sheet, plan + 8), "the next failure is a first one");
        assert!(failures.take_messages().is_empty());
    }
}
