//! The photo before or after the open one, looked for on a thread.

use std::path::PathBuf;

use super::dialogs::Picked;
use super::worker::{Event, JobId, Outbox};
use crate::io::folder;
use crate::job::Cancel;

/// Finds the next (`true`) or previous photo of a file's folder.
pub fn work(job: JobId, (path, is_next): (PathBuf, bool), _: &Cancel, outbox: &Outbox) {
    let event = match folder::neighbours(&path) {
        Ok((before, after)) => {
            let found = if is_next { after } else { before };
            Event::Picked(found.map_or(Picked::Nothing, Picked::Open))
        }
        Err(error) => {
            let folder = path.parent().unwrap_or(&path).display();
            Event::Failed(format!("could not look into the folder — {error} — check that you may read it: {folder}"))
        }
    };
    outbox.send(job, event);
}
