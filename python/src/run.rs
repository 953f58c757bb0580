//! Long work: on a thread of its own, without the interpreter's lock, while this one listens for Ctrl-C and tells how far
//! it is.

use std::process;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use plenoscope::errors::one_line;
use plenoscope::job::{Cancel, Job, Progress, Sink};
use plenoscope::scene::SceneError;
use pyo3::prelude::*;

use crate::errors::raised;

/// How often Ctrl-C is looked for and progress told.
const LISTEN: Duration = Duration::from_millis(50);

/// What a job said since it was last asked.
#[derive(Default)]
struct Heard {
    latest: Mutex<Option<Progress>>,
    warnings: Mutex<Vec<String>>,
}

impl Sink for Heard {
    fn progress(&self, progress: Progress) {
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(progress);
    }

    fn warning(&self, text: String) {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(text);
    }
}

impl Heard {
    /// Hands on what was said, and looks for Ctrl-C. What a signal or a callback raises is the error.
    fn tell(&self, py: Python<'_>, callback: Option<&Py<PyAny>>) -> PyResult<()> {
        py.check_signals()?;
        let warnings = std::mem::take(&mut *self.warnings.lock().unwrap_or_else(PoisonError::into_inner));
        for text in warnings {
            let class = py.import("plenoscope._errors")?.getattr("PlenoscopeWarning")?;
            py.import("warnings")?.call_method1("warn", (one_line(&text), class))?;
        }
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let (Some(callback), Some(Progress { stage, done, total })) = (callback, latest) {
            callback.call1(py, (stage.label(), done, total))?;
        }
        Ok(())
    }
}

/// Does the work, tells `progress(stage, done, total)`, and stops it where that or Ctrl-C raises.
///
/// # Errors
/// The library's, or what was raised.
pub fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Job) -> Result<T, SceneError> + Send,
) -> PyResult<T> {
    check_process(py)?;
    let (cancel, heard) = (Cancel::default(), Heard::default());
    let (outcome, raised_meanwhile) = py.detach(|| {
        thread::scope(|scope| {
            let (ends, end) = sync_channel::<()>(1);
            let (cancel, heard) = (&cancel, &heard);
            let worker = thread::Builder::new().name("plenoscope".to_owned()).spawn_scoped(scope, move || {
                let _ends_with_it = ends;
                work(&Job { cancel, sink: heard })
            });
            let mut stopped_by = None;
            while matches!(end.recv_timeout(LISTEN), Err(RecvTimeoutError::Timeout)) {
                if stopped_by.is_none() {
                    stopped_by = Python::attach(|py| heard.tell(py, progress)).err();
                    stopped_by.iter().for_each(|_| cancel.cancel());
                }
            }
            (worker.map(thread::ScopedJoinHandle::join), stopped_by)
        })
    });
    match (outcome, raised_meanwhile) {
        (_, Some(error)) => Err(error),
        (Ok(Ok(done)), None) => {
            heard.tell(py, progress)?;
            done.map_err(|error| raised(py, error))
        }
        (Ok(Err(panic)), None) => std::panic::resume_unwind(panic),
        (Err(no_thread), None) => {
            let text = format!("the work cannot be begun — {no_thread} — end something else that runs, and try again");
            Err(raised(py, SceneError::Refused(text)))
        }
    }
}

/// The process that has our threads.
static HOME: AtomicU32 = AtomicU32::new(0);

/// A fork takes no threads along: what waits for them would wait for ever.
fn check_process(py: Python<'_>) -> PyResult<()> {
    let here = process::id();
    match HOME.compare_exchange(0, here, Ordering::Relaxed, Ordering::Relaxed) {
        Err(home) if home != here => {
            let text = "this process was forked from one that had used plenoscope — its threads stayed there — start \
                        processes with multiprocessing.get_context(\"spawn\")";
            Err(raised(py, SceneError::Refused(text.to_owned())))
        }
        _ => Ok(()),
    }
}
