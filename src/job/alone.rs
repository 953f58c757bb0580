//! Work that looks at no flag, as decoders do: who stops waits for it no longer, and it ends alone.

use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::thread::Builder;
use std::time::Duration;

use super::{Cancelled, Job, Progress, Sink};
use crate::field::{RayDepths, View, ViewIndex};

/// Time between two looks at the flag.
const LOOK: Duration = Duration::from_millis(10);
/// What can be said before whoever waits has heard it.
const LETTERS: usize = 64;
/// Stack of the thread: as much as a program's first one has.
const STACK_BYTES: usize = 8 << 20;

/// What the work says to whoever waits for it.
enum Told {
    Progress(Progress),
    Depths(Arc<RayDepths>),
    View(ViewIndex, Arc<View>),
    Warning(String),
}

/// Sends it. Where nobody waits any more, nobody hears it.
struct Post(SyncSender<Told>);

impl Sink for Post {
    fn progress(&self, progress: Progress) {
        drop(self.0.send(Told::Progress(progress)));
    }
    fn depths(&self, depths: &Arc<RayDepths>) {
        drop(self.0.send(Told::Depths(Arc::clone(depths))));
    }
    fn view(&self, at: ViewIndex, view: &Arc<View>) {
        drop(self.0.send(Told::View(at, Arc::clone(view))));
    }
    fn warning(&self, text: String) {
        drop(self.0.send(Told::Warning(text)));
    }
}

impl Told {
    fn tell(self, sink: &dyn Sink) {
        match self {
            Self::Progress(progress) => sink.progress(progress),
            Self::Depths(depths) => sink.depths(&depths),
            Self::View(at, view) => sink.view(at, &view),
            Self::Warning(text) => sink.warning(text),
        }
    }
}

impl Job<'_> {
    /// Waits for work on a thread of its own, and for no longer than until the job is asked to stop: then the work ends alone,
    /// and what it makes is dropped. On a thread of a pool it is done right there, for it may need that very thread.
    ///
    /// # Errors
    /// Stopped.
    pub fn alone<T: Send + 'static>(&self, work: impl FnOnce(&Job) -> T + Send + 'static) -> Result<T, Cancelled> {
        if rayon::current_thread_index().is_some() {
            return Ok(work(self));
        }
        let (sender, told) = sync_channel(LETTERS);
        let cancel = self.cancel.clone();
        let run = move || work(&Job { cancel: &cancel, sink: &Post(sender) });
        let thread = Builder::new().name("alone".into()).stack_size(STACK_BYTES).spawn(run);
        let thread = thread.expect("a thread can be started");
        loop {
            match told.recv_timeout(LOOK) {
                Ok(said) => said.tell(self.sink),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            self.check()?;
        }
        thread.join().map_err(|panic| resume_unwind(panic))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::{Cancel, Stage, Told as Heard};

    #[test]
    fn who_stops_does_not_wait_for_work_that_looks_at_no_flag() {
        let cancel = Cancel::default();
        let (end, ended) = sync_channel::<()>(1);
        let (begun, begins) = sync_channel::<()>(1);
        let stopper = cancel.clone();
        let stop = move || {
            begins.recv().unwrap();
            stopper.cancel();
        };
        let stop = Builder::new().name("stop".into()).spawn(stop).unwrap();
        let job = Job { cancel: &cancel, sink: &() };
        let done = job.alone(move |_| {
            begun.send(()).unwrap();
            // Until the test is over.
            ended.recv().unwrap_err();
        });
        assert_eq!(done, Err(Cancelled));
        stop.join().unwrap();
        drop(end);
    }

    #[test]
    fn what_it_says_is_heard_and_what_it_makes_comes_back() {
        let (cancel, heard) = (Cancel::default(), Heard::default());
        let job = Job { cancel: &cancel, sink: &heard };
        let made = job.alone(|job| {
            job.sink.warning("a little odd".to_owned());
            job.advance(Stage::Open, 1, 1).map(|()| 7)
        });
        assert_eq!(made, Ok(Ok(7)));
        assert_eq!(heard.take(), ["a little odd"]);
        // A pool of one thread would wait for itself.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let within = pool.install(|| job.alone(|_| rayon::join(|| 1, || 2)));
        assert_eq!(within, Ok((1, 2)));
    }

    #[test]
    fn its_panic_is_ours() {
        let cancel = Cancel::default();
        let caught = std::panic::catch_unwind(|| {
            Job { cancel: &cancel, sink: &() }.alone(|_| panic!("as it should")).unwrap_or(())
        });
        assert!(caught.is_err());
    }
}
