//! The paper's asynchronous thread (section 4): it updates the mesh for the newest view that it was shown, and hands
//! finished updates over.
//!
//! ```text
//!   plan()                                  worker "tin-lod updates"
//!     show(view) ---- newest view ------->  outdated patches in view, nearest first, a few at a time
//!     finished() <--- bounded channel ----  one Update for each few, watertight with all before it
//! ```
//!
//! Neither waits for the other, but for the worker when the channel is full. A view that is newer than the one that is
//! being worked on makes the rest of that work void. A plan takes so many updates and no more: a frame that was long, or
//! a camera that jumped, does not make the next plan long.

use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

use terrain_core::{Heightmap, View};

use crate::cull::PatchTree;
use crate::mesh::{Mesh, Update};
use crate::options::{EdgePolicy, Options};

/// Outdated patches in one update: small enough that the nearest are soon drawn, large enough to keep all threads busy.
const PATCHES_AN_UPDATE: usize = 16;

/// Updates that may wait to be drawn.
const UPDATES_WAITING: usize = 64;

/// A plan takes no further update once it has taken so many triangles: 1.5 MB of indices, copied in less than a
/// millisecond. At 60 frames a second that is more than two threads can make.
const TRIANGLES_A_PLAN: u64 = 1 << 17;

/// The main thread's end.
pub(crate) struct Worker {
    /// What was shown last: an unchanged view is not shown again.
    shown: Option<Box<Asked>>,
    inbox: Arc<Inbox>,
    finished: Receiver<Finished>,
    thread: Option<JoinHandle<()>>,
}

/// An update, and when the view was asked for that it is made for.
struct Finished {
    update: Update,
    asked: Instant,
}

/// The newest view, or the end.
#[derive(Default)]
struct Inbox {
    request: Mutex<Request>,
    changed: Condvar,
}

/// A view to follow.
#[derive(Clone)]
struct Asked {
    view: View,
    culling: bool,
    at: Instant,
}

#[derive(Default)]
struct Request {
    asked: Option<Asked>,
    end: bool,
}

/// What the worker works with.
pub(crate) struct Workshop {
    pub heightmap: Arc<Heightmap>,
    pub options: Options,
    pub pool: rayon::ThreadPool,
    pub tree: Arc<PatchTree>,
    pub mesh: Mesh,
    pub hand_over: HandOver,
}

/// Passes an update on to be drawn: as it is, and at once. Tests delay it, or take it apart.
pub(crate) type HandOver = fn(Update, &mut dyn FnMut(Update));

impl Worker {
    pub fn start(workshop: Workshop) -> std::io::Result<Self> {
        let inbox = Arc::new(Inbox::default());
        let (sender, finished) = sync_channel(UPDATES_WAITING);
        let theirs = inbox.clone();
        let work = move || workshop.work(&theirs, &sender);
        let thread = std::thread::Builder::new().name("tin-lod updates".into()).spawn(work)?;
        Ok(Self { shown: None, inbox, finished, thread: Some(thread) })
    }

    /// Shows the worker a view, unless it has seen it. Takes a lock that is only ever held to exchange views.
    pub fn show(&mut self, view: &View, culling: bool) {
        let is_same = |shown: &Asked| shown.view == *view && shown.culling == culling;
        if !self.shown.as_deref().is_some_and(is_same) {
            let asked = Asked { view: view.clone(), culling, at: Instant::now() };
            self.shown = Some(Box::new(asked.clone()));
            self.inbox.put(|request| request.asked = Some(asked));
        }
    }

    /// Updates that have finished, in order, each whole. What is beyond [`TRIANGLES_A_PLAN`] waits for the next plan.
    /// Panics where the worker has: without it every frame would be whole, and none up to date.
    pub fn finished(&self) -> Vec<Update> {
        let (now, mut updates, mut triangles) = (Instant::now(), Vec::new(), 0);
        while triangles < TRIANGLES_A_PLAN {
            let Finished { mut update, asked } = match self.finished.try_recv() {
                Ok(finished) => finished,
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => panic!("the thread of the updates has panicked"),
            };
            update.report.latency = now - asked;
            triangles += update.report.triangles;
            updates.push(update);
        }
        updates
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.inbox.put(|request| request.end = true);
        // A worker that waits for room in the channel must find it closed.
        self.finished = sync_channel(0).1;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Inbox {
    fn put(&self, change: impl FnOnce(&mut Request)) {
        change(&mut self.request.lock().unwrap_or_else(PoisonError::into_inner));
        self.changed.notify_one();
    }

    /// Waits for a view; `None` at the end.
    fn take(&self) -> Option<Asked> {
        let mut request = self.request.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if request.end {
                return None;
            }
            if let Some(asked) = request.asked.take() {
                return Some(asked);
            }
            request = self.changed.wait(request).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Whether there is something newer to do.
    fn is_waiting(&self) -> bool {
        let request = self.request.lock().unwrap_or_else(PoisonError::into_inner);
        request.end || request.asked.is_some()
    }
}

impl Workshop {
    fn work(mut self, inbox: &Inbox, finished: &SyncSender<Finished>) {
        while let Some(asked) = inbox.take() {
            if self.follow(&asked, inbox, finished).is_none() {
                return;
            }
        }
    }

    /// Brings the patches in view up to date until that is done or a newer view waits; `None` when nobody listens.
    fn follow(&mut self, asked: &Asked, inbox: &Inbox, finished: &SyncSender<Finished>) -> Option<()> {
        let Self { heightmap, options, pool, tree, mesh, hand_over } = self;
        let mut visible = Vec::new();
        tree.visible(&asked.view, asked.culling, &mut visible);
        let outdated = mesh.outdated(options, &asked.view, &visible);
        // The paper's edges follow where both patches are updated for one request, so a request stays whole.
        let few = match options.edge_policy {
            EdgePolicy::Matched => PATCHES_AN_UPDATE / (options.group() * options.group()) as usize,
            EdgePolicy::Paper => outdated.len().max(1),
        };
        for patches in outdated.chunks(few) {
            let update = pool.install(|| mesh.update(heightmap, options, &asked.view, patches));
            let mut sent = Ok(());
            hand_over(update, &mut |update| sent = finished.send(Finished { update, asked: asked.at }));
            sent.ok()?;
            if inbox.is_waiting() {
                break;
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::WorkReport;

    /// After a long frame there is a queue: it must not become one long plan.
    #[test]
    fn a_plan_takes_a_bounded_number_of_triangles_and_the_next_ones_take_the_rest_in_order() {
        let (sender, finished) = sync_channel(UPDATES_WAITING);
        let worker = Worker { shown: None, inbox: Arc::default(), finished, thread: None };
        let half = TRIANGLES_A_PLAN / 2;
        for triangles in [half, half - 1, 3, half, 5 * half, 7] {
            let report = WorkReport { triangles, ..Default::default() };
            let update = Update { report, ..Default::default() };
            sender.try_send(Finished { update, asked: Instant::now() }).unwrap();
        }
        let take = || worker.finished().iter().map(|update| update.report.triangles).collect::<Vec<_>>();
        assert_eq!([take(), take(), take(), take()], [vec![half, half - 1, 3], vec![half, 5 * half], vec![7], vec![]]);
    }
}
