//! What a long computation needs from its caller: a way to be stopped and someone to tell.

mod alone;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::field::{RayDepths, View, ViewIndex};

/// Asks a running job to stop. Clones share one flag.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Asks the job to stop at its next check.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the job has been asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// `Err(Cancelled)` once the job has been asked to stop.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// The flag itself, for code that cannot see this type (the convolution kernel).
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }
}

/// The job was asked to stop. Not an error: nobody is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped")]
pub struct Cancelled;

/// What a job is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reading and decoding a file.
    Open,
    /// The depth net, and its ray depths brought to the light field's size.
    Depth,
    /// Lambertian rendering of the views.
    Warp,
    /// The occlusion net.
    Occlusion,
    /// Plane sweep over the views of a light field that came without ray depths.
    Sweep,
    /// Finding the same things in several photos.
    Match,
    /// Finding where several photos were taken.
    Poses,
    /// The mean of several photos.
    Mean,
    /// Repairs of the depth.
    Mend,
    /// The lens renderer.
    Refocus,
    /// Encoding and writing files.
    Save,
}

impl Stage {
    /// What a person reads while it runs.
    pub fn label(self) -> &'static str {
        match self {
            Self::Open => "Opening",
            Self::Depth => "Estimating ray depths",
            Self::Warp => "Rendering views",
            Self::Occlusion => "Correcting occlusions",
            Self::Sweep => "Measuring ray depths",
            Self::Match => "Matching the photos",
            Self::Poses => "Finding the cameras",
            Self::Mean => "Taking the photos' mean",
            Self::Mend => "Mending the depth",
            Self::Refocus => "Refocusing",
            Self::Save => "Saving",
        }
    }
}

/// How far a stage is: `done` of `total` units of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The stage that is running.
    pub stage: Stage,
    /// Units done.
    pub done: u32,
    /// Units in all; never 0.
    pub total: u32,
}

/// Listens to a job. Called from the job's threads, so it must be quick.
pub trait Sink: Sync {
    /// The job went on a little.
    fn progress(&self, _progress: Progress) {}
    /// Ray depths are there, before the views.
    fn depths(&self, _depths: &Arc<RayDepths>) {}
    /// A view is there; it comes again when the occlusion net has corrected it.
    fn view(&self, _at: ViewIndex, _view: &Arc<View>) {}
    /// Something went wrong that does not stop the job.
    fn warning(&self, _text: String) {}
}

/// Nobody listens.
impl Sink for () {}

/// Keeps what a person is told.
#[cfg(test)]
#[derive(Default)]
pub(crate) struct Told(std::sync::Mutex<Vec<String>>);

#[cfg(test)]
impl Sink for Told {
    fn warning(&self, text: String) {
        self.0.lock().unwrap().push(text);
    }
}

#[cfg(test)]
impl Told {
    /// What was said since the last time.
    pub(crate) fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.0.lock().unwrap())
    }
}

/// What is handed to every long computation.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// Looked at between units of work.
    pub cancel: &'a Cancel,
    /// Told of progress and results.
    pub sink: &'a dyn Sink,
}

impl Job<'_> {
    /// `Err(Cancelled)` once the job has been asked to stop.
    pub fn check(&self) -> Result<(), Cancelled> {
        self.cancel.check()
    }

    /// Tells the sink how far `stage` is, and checks for cancel.
    pub fn advance(&self, stage: Stage, done: u32, total: u32) -> Result<(), Cancelled> {
        self.sink.progress(Progress { stage, done, total: total.max(1) });
        self.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cancelled_job_stops_at_its_next_check() {
        let cancel = Cancel::default();
        let job = Job { cancel: &cancel, sink: &() };
        assert_eq!(job.check(), Ok(()));
        cancel.clone().cancel();
        assert_eq!(job.advance(Stage::Warp, 1, 2), Err(Cancelled));
    }
}
