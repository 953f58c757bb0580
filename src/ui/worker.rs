//! Threads that compute, and how they talk to the window: requests in, events out, neither side ever waits for a lock
//! that is held while something is computed.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::event::Event;
use super::words::{Message, message};
use crate::job::Cancel;

/// Tells the results of one request from those of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct JobId(u64);

impl JobId {
    fn next() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Frames that only show how far a job is: each costs the job time where the processor draws.
const PROGRESS_FRAMES: Duration = Duration::from_millis(200);
/// Frames in which views appear one after the other.
const VIEW_FRAMES: Duration = Duration::from_millis(60);

/// The way from a thread to the window.
#[derive(Clone)]
pub struct Outbox {
    sender: SyncSender<(JobId, Event)>,
    ctx: egui::Context,
}

impl Outbox {
    /// An outbox that wakes a window.
    pub fn new(sender: SyncSender<(JobId, Event)>, ctx: egui::Context) -> Self {
        Self { sender, ctx }
    }

    /// Tells the window; waits while its letter box is full, so that a slow window slows the thread and memory stays
    /// flat. Progress is not worth waiting for: the next letter tells it too. False once the window is gone.
    pub fn send(&self, job: JobId, event: Event) -> bool {
        let delay = match event {
            Event::Progress(_) => PROGRESS_FRAMES,
            Event::View(..) => VIEW_FRAMES,
            _ => Duration::ZERO,
        };
        let sent = match event {
            Event::Progress(_) => !matches!(self.sender.try_send((job, event)), Err(TrySendError::Disconnected(_))),
            _ => self.sender.send((job, event)).is_ok(),
        };
        self.ctx.request_repaint_after(delay);
        sent
    }
}

/// What a thread does with a request.
pub trait Work<R>: FnMut(JobId, R, &Cancel, &Outbox) + Send + 'static {}
impl<R, F: FnMut(JobId, R, &Cancel, &Outbox) + Send + 'static> Work<R> for F {}

struct Inner<R> {
    waiting: VecDeque<(JobId, R, Cancel)>,
    running: Option<Running>,
    is_closed: bool,
}

/// What a thread is doing.
struct Running {
    job: JobId,
    cancel: Cancel,
    /// When it was asked to stop.
    asked: Option<Instant>,
}

impl Running {
    fn stop(&mut self) {
        self.cancel.cancel();
        self.asked.get_or_insert_with(Instant::now);
    }
}

struct Shared<R> {
    inner: Mutex<Inner<R>>,
    wake: Condvar,
}

impl<R> Shared<R> {
    fn lock(&self) -> MutexGuard<'_, Inner<R>> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A named thread that does one request after the other. Dropping it stops it.
pub struct Worker<R> {
    shared: Arc<Shared<R>>,
}

impl<R: Send + 'static> Worker<R> {
    /// Starts the thread. Without one (the system has none left) requests wait for ever, and the log says so.
    pub fn spawn(name: &'static str, outbox: Outbox, mut work: impl Work<R>) -> Self {
        let inner = Inner { waiting: VecDeque::new(), running: None, is_closed: false };
        let shared = Arc::new(Shared { inner: Mutex::new(inner), wake: Condvar::new() });
        let theirs = Arc::clone(&shared);
        let started = std::thread::Builder::new().name(name.to_owned()).spawn(move || {
            crate::kernel::background::step_back();
            while let Some((job, request, cancel)) = next(&theirs) {
                // A bug in one job must not take the window down.
                let done = catch_unwind(AssertUnwindSafe(|| work(job, request, &cancel, &outbox)));
                if let Some(asked) = theirs.lock().running.take().and_then(|running| running.asked) {
                    log::debug!("{name}: stopped {:.3} s after it was asked to", asked.elapsed().as_secs_f64());
                }
                if let Err(panic) = done {
                    outbox.send(job, Event::Failed(panic_text(panic.as_ref())));
                }
            }
        });
        if let Err(error) = started {
            log::error!("the thread {name} did not start: {error}");
        }
        Self { shared }
    }

    /// Puts a request behind those that wait; all are done.
    pub fn push(&self, request: R) -> JobId {
        self.add(request, false)
    }

    /// Latest wins: stops what runs, forgets what waits, and does this.
    pub fn replace(&self, request: R) -> JobId {
        self.add(request, true)
    }

    fn add(&self, request: R, is_latest: bool) -> JobId {
        let job = JobId::next();
        let mut inner = self.shared.lock();
        if is_latest {
            inner.stop();
        }
        inner.waiting.push_back((job, request, Cancel::default()));
        self.shared.wake.notify_one();
        job
    }

    /// Stops what runs and forgets what waits.
    pub fn stop(&self) {
        self.shared.lock().stop();
    }

    /// Stops one request. True if it had not begun: then no event will come of it.
    pub fn cancel(&self, job: JobId) -> bool {
        let mut inner = self.shared.lock();
        let before = inner.waiting.len();
        inner.waiting.retain(|(waiting, ..)| *waiting != job);
        if let Some(running) = inner.running.as_mut().filter(|running| running.job == job) {
            running.stop();
        }
        inner.waiting.len() < before
    }
}

impl<R> Inner<R> {
    fn stop(&mut self) {
        self.waiting.clear();
        if let Some(running) = &mut self.running {
            running.stop();
        }
    }
}

impl<R> Drop for Worker<R> {
    fn drop(&mut self) {
        let mut inner = self.shared.lock();
        inner.stop();
        inner.is_closed = true;
        self.shared.wake.notify_one();
    }
}

/// The next request; `None` when the window is gone.
fn next<R>(shared: &Shared<R>) -> Option<(JobId, R, Cancel)> {
    let mut inner = shared.lock();
    loop {
        if inner.is_closed {
            return None;
        }
        if let Some((job, request, cancel)) = inner.waiting.pop_front() {
            inner.running = Some(Running { job, cancel: cancel.clone(), asked: None });
            return Some((job, request, cancel));
        }
        inner = shared.wake.wait(inner).unwrap_or_else(PoisonError::into_inner);
    }
}

fn panic_text(panic: &(dyn std::any::Any + Send)) -> Message {
    let what = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let what = what.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    message!("job-broke", what = what)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::{Receiver, sync_channel};

    fn outbox() -> (Outbox, Receiver<(JobId, Event)>) {
        let (sender, receiver) = sync_channel(8);
        (Outbox::new(sender, egui::Context::default()), receiver)
    }

    /// Work whose first request tells that it has begun, and ends only when it is stopped.
    fn slow_first(started: SyncSender<()>) -> impl Work<&'static str> {
        move |job: JobId, name: &'static str, cancel: &Cancel, out: &Outbox| {
            if name == "first" {
                started.send(()).unwrap();
                while !cancel.is_cancelled() {
                    std::thread::yield_now();
                }
            }
            out.send(job, Event::Warning(Message::heard(name)));
        }
    }

    #[test]
    fn the_latest_request_stops_the_running_one_and_replaces_the_waiting() {
        let (outbox, events) = outbox();
        let (started, has_started) = sync_channel(1);
        let worker = Worker::spawn("latest", outbox, slow_first(started));
        let first = worker.replace("first");
        has_started.recv().unwrap();
        worker.replace("second");
        let third = worker.replace("third");
        let name = |event| if let Event::Warning(name) = event { name.text() } else { String::new() };
        let got: Vec<_> = events.iter().take(2).map(|(job, event)| (job, name(event))).collect();
        assert_eq!(got, [(first, "first".to_owned()), (third, "third".to_owned())]);
    }

    #[test]
    fn one_request_is_stopped_and_the_others_go_on() {
        let (outbox, events) = outbox();
        let (started, has_started) = sync_channel(1);
        let worker = Worker::spawn("queue", outbox, slow_first(started));
        let first = worker.push("first");
        let second = worker.push("second");
        let third = worker.push("third");
        has_started.recv().unwrap();
        assert!(worker.cancel(second), "it had not begun");
        assert!(!worker.cancel(first), "it had");
        let got: Vec<_> = events.iter().take(2).map(|(job, _)| job).collect();
        assert_eq!(got, [first, third]);
    }

    #[test]
    fn a_panic_is_told_and_the_thread_goes_on() {
        let (outbox, events) = outbox();
        let worker = Worker::spawn("fragile", outbox, |job, broken: bool, _: &Cancel, out: &Outbox| {
            assert!(!broken, "on purpose");
            out.send(job, Event::Stopped);
        });
        worker.push(true);
        worker.push(false);
        assert!(matches!(events.recv().unwrap().1, Event::Failed(text) if text.text().contains("on purpose")));
        assert!(matches!(events.recv().unwrap().1, Event::Stopped));
    }
}
