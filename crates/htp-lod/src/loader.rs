//! Reads cells: on a thread of its own, or when a plan waits for them.
//!
//! ```text
//!   plan()                                    thread "htp-lod cells"
//!     want(nearest, next, ...) -- list -----> the first one that is left
//!     take() <-------- bounded channel ------ as read, or why it could not be
//! ```
//!
//! A newer list takes the place of the last one. What has been taken off a list comes, wanted or not, exactly once.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use crate::cells::{Cell, CellFile, CellsError};
use crate::options::Loading;

/// Cells that may wait to be taken.
pub(crate) const CELLS_WAITING: usize = 16;

/// A cell that was read, or could not be.
pub(crate) struct Arrival {
    /// Column and row.
    pub cell: [u32; 2],
    pub content: Result<Cell, CellsError>,
}

pub(crate) enum Loader {
    Live(Worker),
    Blocking { file: CellFile, wanted: VecDeque<[u32; 2]> },
}

impl Loader {
    pub fn new(file: CellFile, loading: Loading) -> std::io::Result<Self> {
        match loading {
            Loading::Live => Ok(Self::Live(Worker::start(file)?)),
            Loading::Blocking => Ok(Self::Blocking { file, wanted: VecDeque::new() }),
        }
    }

    /// Whether a plan waits for its cells.
    pub fn is_blocking(&self) -> bool {
        matches!(self, Self::Blocking { .. })
    }

    /// What is to be read from now on, in this order.
    pub fn want(&mut self, cells: Vec<[u32; 2]>) {
        match self {
            Self::Live(worker) => worker.want(cells),
            Self::Blocking { wanted, .. } => *wanted = cells.into(),
        }
    }

    /// The next cell that was read; without a thread, that is read now.
    pub fn take(&mut self) -> Option<Arrival> {
        match self {
            Self::Live(worker) => worker.take(),
            Self::Blocking { file, wanted } => {
                let cell = wanted.pop_front()?;
                Some(Arrival { cell, content: file.read(cell) })
            }
        }
    }
}

/// The plans' end of the thread.
pub(crate) struct Worker {
    inbox: Arc<Inbox>,
    arrivals: Receiver<Arrival>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Inbox {
    list: Mutex<List>,
    changed: Condvar,
}

#[derive(Default)]
struct List {
    wanted: VecDeque<[u32; 2]>,
    /// Taken off a list, and not arrived yet.
    on_the_way: Vec<[u32; 2]>,
    end: bool,
}

impl Worker {
    fn start(file: CellFile) -> std::io::Result<Self> {
        let inbox = Arc::new(Inbox::default());
        let (sender, arrivals) = sync_channel(CELLS_WAITING);
        let theirs = inbox.clone();
        let work = move || read_all(&file, &theirs, &sender);
        let thread = std::thread::Builder::new().name("htp-lod cells".into()).spawn(work)?;
        Ok(Self { inbox, arrivals, thread: Some(thread) })
    }

    fn want(&self, cells: Vec<[u32; 2]>) {
        let mut list = self.inbox.lock();
        list.wanted = cells.into();
        let List { wanted, on_the_way, .. } = &mut *list;
        wanted.retain(|cell| !on_the_way.contains(cell));
        self.inbox.changed.notify_one();
    }

    /// Panics where the thread has: without it nothing would ever arrive.
    fn take(&self) -> Option<Arrival> {
        let arrival = match self.arrivals.try_recv() {
            Ok(arrival) => arrival,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => panic!("the thread that reads cells has panicked"),
        };
        self.inbox.lock().on_the_way.retain(|cell| *cell != arrival.cell);
        Some(arrival)
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.inbox.lock().end = true;
        self.inbox.changed.notify_one();
        // A thread that waits for room in the channel must find it closed.
        self.arrivals = sync_channel(0).1;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Inbox {
    fn lock(&self) -> MutexGuard<'_, List> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits for something to be wanted; `None` at the end.
    fn next(&self) -> Option<[u32; 2]> {
        let mut list = self.lock();
        loop {
            if list.end {
                return None;
            }
            if let Some(cell) = list.wanted.pop_front() {
                list.on_the_way.push(cell);
                return Some(cell);
            }
            list = self.changed.wait(list).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

fn read_all(file: &CellFile, inbox: &Inbox, arrivals: &SyncSender<Arrival>) {
    while let Some(cell) = inbox.next() {
        if arrivals.send(Arrival { cell, content: file.read(cell) }).is_err() {
            return; // nobody listens any more
        }
    }
}
