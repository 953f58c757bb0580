//! How far a job is, and how long it will take.

use super::words::{self, heard, t};
use super::worker::JobId;
use crate::job::{Progress, Stage};

/// A stage that has run shorter than this says nothing about its end.
const TELLS_AFTER_SECS: f64 = 0.8;

/// A job that runs.
#[derive(Clone, Debug)]
pub struct Running {
    /// Which.
    pub job: JobId,
    /// How far its present stage is.
    pub progress: Option<Progress>,
    /// When it began.
    pub since_secs: f64,
    /// When its present stage began.
    stage_since_secs: f64,
}

impl Running {
    /// A job that begins now.
    pub fn new(job: JobId) -> Self {
        let now = now();
        Self { job, progress: None, since_secs: now, stage_since_secs: now }
    }

    /// Takes in how far it is.
    pub fn tell(&mut self, progress: Progress) {
        let stage = |progress: &Progress| progress.stage;
        if self.progress.as_ref().map(stage) != Some(progress.stage) {
            self.stage_since_secs = now();
        }
        self.progress = Some(progress);
    }

    /// What it does, in a few words.
    pub fn label(&self) -> String {
        match self.progress {
            None => heard(Stage::Open.label()).into_owned(),
            Some(progress) if progress.total > 1 => {
                let stage = heard(progress.stage.label());
                t!("progress-of", stage = &*stage, done = progress.done, total = progress.total)
            }
            Some(progress) => heard(progress.stage.label()).into_owned(),
        }
    }

    /// What its present stage is called.
    pub fn stage(&self) -> String {
        heard(self.progress.map_or(Stage::Open, |progress| progress.stage).label()).into_owned()
    }

    /// How much of the present stage is done, 0 to 1.
    pub fn share(&self) -> f32 {
        self.progress.map_or(0.0, |p| (p.done as f32 / p.total.max(1) as f32).clamp(0.0, 1.0))
    }

    /// "3.2 s · 5 s left".
    pub fn time(&self) -> String {
        let now = now();
        let elapsed = t!("seconds", secs = words::fixed(now - self.since_secs, 1));
        match left_secs(now - self.stage_since_secs, f64::from(self.share())) {
            Some(left) if left >= 1.0 => t!("time-left", elapsed = elapsed, left = span(left)),
            _ => elapsed,
        }
    }
}

/// What the thread that opens and synthesizes does for the window.
#[derive(Clone, Debug, Default)]
pub enum Loading {
    /// Nothing.
    #[default]
    Idle,
    /// It reads a file; what was open before is still shown.
    Opening(Running),
    /// It makes the light field of what is open, whose ray depths and views come one after the other.
    Streaming(Running),
    /// It makes a light field anew; the old one is shown until the new one is complete.
    Again(Running),
}

impl Loading {
    /// What runs.
    pub fn running(&self) -> Option<&Running> {
        match self {
            Self::Idle => None,
            Self::Opening(running) | Self::Streaming(running) | Self::Again(running) => Some(running),
        }
    }

    /// Takes in how far it is.
    pub fn tell(&mut self, progress: Progress) {
        if let Self::Opening(running) | Self::Streaming(running) | Self::Again(running) = self {
            running.tell(progress);
        }
    }

    /// The file has been read and is shown.
    pub fn opened(&mut self) {
        if let Self::Opening(running) = self {
            *self = Self::Streaming(running.clone());
        }
    }
}

/// Time that is left when a share took so long; none while that is a guess.
fn left_secs(elapsed: f64, share: f64) -> Option<f64> {
    (elapsed >= TELLS_AFTER_SECS && share > 0.02).then(|| elapsed / share * (1.0 - share))
}

/// "40 s", "3 min".
fn span(secs: f64) -> String {
    if secs < 90.0 {
        t!("seconds", secs = words::fixed(secs.ceil(), 0))
    } else {
        t!("minutes", minutes = words::fixed((secs / 60.0).ceil(), 0))
    }
}

/// Seconds since the program began, for what is shown of time.
pub fn now() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_follows_from_what_is_done() {
        assert_eq!(left_secs(10.0, 0.25), Some(30.0));
        assert_eq!(left_secs(0.1, 0.5), None, "too early to tell");
        assert_eq!(left_secs(10.0, 0.0), None);
        assert_eq!((span(30.2), span(100.0)), ("31 s".to_owned(), "2 min".to_owned()));
    }
}
