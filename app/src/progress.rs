//! Tells a person at a terminal how far a job is; silent where nobody looks.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use plenoscope::job::{Progress, Sink, Stage};

/// A progress bar that starts anew at every stage.
pub struct Bar {
    bar: ProgressBar,
    stage: Mutex<Option<Stage>>,
    quiet: bool,
}

impl Bar {
    /// A bar on stderr, drawn only where that is a terminal; `quiet` hides it and warnings too.
    pub fn new(quiet: bool) -> Self {
        let target = if quiet || !std::io::stderr().is_terminal() {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        };
        let bar = ProgressBar::with_draw_target(Some(1), target);
        let style = ProgressStyle::with_template("{msg:24} {bar:32} {percent:>3} %  {elapsed}")
            .map_or_else(|_| ProgressStyle::default_bar(), |style| style.progress_chars("━╸─"));
        bar.set_style(style);
        Self { bar, stage: Mutex::new(None), quiet }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Sink for Bar {
    fn progress(&self, progress: Progress) {
        let mut stage = self.stage.lock().unwrap_or_else(PoisonError::into_inner);
        if *stage != Some(progress.stage) {
            *stage = Some(progress.stage);
            self.bar.reset();
            self.bar.set_message(progress.stage.label());
        }
        self.bar.set_length(progress.total.into());
        self.bar.set_position(progress.done.into());
    }

    fn warning(&self, text: String) {
        if !self.quiet {
            self.bar.suspend(|| eprintln!("warning: {}", plenoscope::errors::one_line(&text)));
        }
    }
}
