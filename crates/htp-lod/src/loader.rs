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
use crate::window::Sheet;

/// A sheet that was read, or could not be.
pub(crate) struct Arrival {
    pub sheet: Sheet,
    pub content: Result<Cell, CellsError>,
}

pub(crate) enum Loader {
    Live(Worker),
    Blocking { file: Box<CellFile>, wanted: VecDeque<Sheet> },
}

impl Loader {
    /// So many sheets may wait to be taken.
    pub fn new(file: CellFile, loading: Loading, waiting: usize) -> std::io::Result<Self> {
        match loading {
            Loading::Live => Ok(Self::Live(Worker::start(file, waiting)?)),
            Loading::Blocking => Ok(Self::Blocking { file: Box::new(file), wanted: VecDeque::new() }),
        }
    }

    /// Whether a plan waits for its cells.
    pub fn is_blocking(&self) -> bool {
        matches!(self, Self::Blocking { .. })
    }

    /// What is to be read from now on, in this order.
    pub fn want(&mut self, sheets: Vec<Sheet>) {
        match self {
            Self::Live(worker) => worker.want(sheets),
            Self::Blocking { wanted, .. } => *wanted = sheets.into(),
        }
    }

    /// The next sheet that was read; without a thread, that is read now.
    pub fn take(&mut self) -> Option<Arrival> {
        match self {
            Self::Live(worker) => worker.take(),
            Self::Blocking { file, wanted } => {
                let sheet = wanted.pop_front()?;
                Some(Arrival { sheet, content: file.read(sheet.level, sheet.cell) })
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
    wanted: VecDeque<Sheet>,
    /// Taken off a list, and not arrived yet.
    on_the_way: Vec<Sheet>,
    end: bool,
}

impl Worker {
    fn start(file: CellFile, waiting: usize) -> std::io::Result<Self> {
        let inbox = Arc::new(Inbox::default());
        let (sender, arrivals) = sync_channel(waiting);
        let theirs = inbox.clone();
        let work = move || read_all(&file, &theirs, &sender);
        let thread = std::thread::Builder::new().name("htp-lod cells".into()).spawn(work)?;
        Ok(Self { inbox, arrivals, thread: Some(thread) })
    }

    fn want(&self, sheets: Vec<Sheet>) {
        let mut list = self.inbox.lock();
        list.wanted = sheets.into();
        let List { wanted, on_the_way, .. } = &mut *list;
        wanted.retain(|sheet| !on_the_way.contains(sheet));
        self.inbox.changed.notify_one();
    }

    /// Panics where the thread has: without it nothing would ever arrive.
    fn take(&self) -> Option<Arrival> {
        let arrival = match self.arrivals.try_recv() {
            Ok(arrival) => arrival,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => panic!("the thread that reads cells has panicked"),
        };
        self.inbox.lock().on_the_way.retain(|sheet| *sheet != arrival.sheet);
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
    fn next(&self) -> Option<Sheet> {
        let mut list = self.lock();
        loop {
            if list.end {
                return None;
            }
            if let Some(sheet) = list.wanted.pop_front() {
                list.on_the_way.push(sheet);
                return Some(sheet);
            }
            list = self.changed.wait(list).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

fn read_all(file: &CellFile, inbox: &Inbox, arrivals: &SyncSender<Arrival>) {
    while let Some(sheet) = inbox.next() {
        if arrivals.send(Arrival { sheet, content: file.read(sheet.level, sheet.cell) }).is_err() {
            return; // nobody listens any more
        }
    }
}
