//! The memory of this process, looked at once a second.

use std::time::{Duration, Instant};

use sysinfo::{Pid, ProcessRefreshKind, ProcessesToUpdate, System};

const PERIOD: Duration = Duration::from_secs(1);

pub struct Memory {
    /// None where the system says nothing.
    system: Option<System>,
    looked: Option<Instant>,
    bytes: Option<u64>,
}

impl Default for Memory {
    fn default() -> Self {
        Self { system: System::new().ok(), looked: None, bytes: None }
    }
}

impl Memory {
    /// Resident bytes; `None` where the system does not say.
    pub fn bytes(&self) -> Option<u64> {
        self.bytes
    }

    /// Looks again if it is time to.
    pub fn refresh(&mut self) {
        if self.looked.is_some_and(|looked| looked.elapsed() < PERIOD) {
            return;
        }
        let pid = Pid::from_u32(std::process::id());
        let what = ProcessRefreshKind::nothing().with_memory();
        if let Some(system) = &mut self.system {
            system.refresh_processes_specifics(ProcessesToUpdate::Some(&[pid]), false, what);
            self.bytes = system.process(pid).map(sysinfo::Process::memory);
        }
        self.looked = Some(Instant::now());
    }
}
