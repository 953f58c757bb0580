//! What is being exported, what waits, and how it went.

use std::path::PathBuf;

use super::progress::Running;
use super::words::Message;
use super::worker::JobId;
use crate::job::Progress;

/// How a task stands.
#[derive(Clone, Debug)]
pub enum State {
    /// Others go first.
    Waiting,
    /// It runs.
    Running(Running),
    /// The file was written.
    Done(PathBuf),
    /// The file was there already and was left as it is.
    Skipped,
    /// It failed; the sentence says why.
    Failed(Message),
    /// A person stopped it.
    Stopped,
}

/// One export.
#[derive(Clone, Debug)]
pub struct Task {
    /// Its job.
    pub job: JobId,
    /// What it is, for people.
    pub title: String,
    /// How it stands.
    pub state: State,
}

impl Task {
    /// Whether it waits or runs.
    pub fn is_open(&self) -> bool {
        matches!(self.state, State::Waiting | State::Running(_))
    }
}

/// All exports since the window was opened or the list was cleared, in order.
#[derive(Debug, Default)]
pub struct Queue {
    tasks: Vec<Task>,
    /// Whether its panel is shown.
    pub is_open: bool,
}

impl Queue {
    /// Adds a task that waits.
    pub fn add(&mut self, job: JobId, title: String) {
        self.tasks.push(Task { job, title, state: State::Waiting });
    }

    /// All tasks, the first ones first.
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// Whether a job is one of them.
    pub fn has(&self, job: JobId) -> bool {
        self.tasks.iter().any(|task| task.job == job)
    }

    /// Whether something waits or runs.
    pub fn is_busy(&self) -> bool {
        self.tasks.iter().any(Task::is_open)
    }

    /// Tasks that wait or run.
    pub fn open_count(&self) -> usize {
        self.tasks.iter().filter(|task| task.is_open()).count()
    }

    /// The task that runs, or is the next to run.
    pub fn current(&self) -> Option<&Task> {
        let runs = |task: &&Task| matches!(task.state, State::Running(_));
        self.tasks.iter().find(runs).or_else(|| self.tasks.iter().find(|task| task.is_open()))
    }

    /// A task went on; with the first word of it, it runs.
    pub fn tell(&mut self, job: JobId, progress: Progress) {
        let Some(task) = self.tasks.iter_mut().find(|task| task.job == job) else { return };
        if let State::Waiting = task.state {
            task.state = State::Running(Running::new(job));
        }
        if let State::Running(running) = &mut task.state {
            running.tell(progress);
        }
    }

    /// A task ended.
    pub fn end(&mut self, job: JobId, state: State) {
        if let Some(task) = self.tasks.iter_mut().find(|task| task.job == job) {
            task.state = state;
        }
    }

    /// Takes a task away.
    pub fn forget(&mut self, job: JobId) {
        self.tasks.retain(|task| task.job != job);
    }

    /// Takes away what has ended.
    pub fn clear_ended(&mut self) {
        self.tasks.retain(Task::is_open);
    }
}
