//! The photos before and after the open one: looked for on a thread, and opened ahead, so that going on is instant.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use super::ask::Picked;
use super::document::Document;
use super::event::Event;
use super::tiles::TileSet;
use super::words::message;
use super::worker::{JobId, Outbox, Work};
use crate::io::folder;
use crate::job::{Cancel, Job};
use crate::scene::Recipe;

/// Photos that are held ahead: one before, one after.
const HELD: usize = 2;
/// Larger files are not opened ahead: they would take memory from what is being looked at.
const LARGEST_BYTES: u64 = 48 << 20;

/// A photo that was opened ahead, ready for the screen.
#[derive(Clone)]
pub struct Ready {
    /// What was read.
    pub document: Document,
    /// The photo for the screen.
    pub tiles: Arc<TileSet>,
}

/// When a photo was changed, and the edit beside it, where there is one.
type Changed = (SystemTime, Option<SystemTime>);

/// What has been opened ahead. The lock is held for a look only, never while a file is read.
#[derive(Clone, Default)]
pub struct Ahead(Arc<Mutex<Vec<(PathBuf, Changed, Ready)>>>);

impl Ahead {
    /// Takes a photo out, if it is there and its file and its edit are still the same.
    pub fn take(&self, path: &Path) -> Option<Ready> {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = held.iter().position(|(held, ..)| held == path)?;
        let (_, before, ready) = held.swap_remove(at);
        (changed(path)? == before).then_some(ready)
    }

    fn holds(&self, path: &Path) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).iter().any(|(held, ..)| held == path)
    }

    fn keep_only(&self, paths: &[PathBuf]) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).retain(|(held, ..)| paths.contains(held));
    }

    fn put(&self, path: PathBuf, changed: Changed, ready: Ready) {
        let mut held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        held.push((path, changed, ready));
        let over = held.len().saturating_sub(HELD);
        held.drain(..over);
    }
}

fn changed(path: &Path) -> Option<Changed> {
    let of = |path: &Path| path.metadata().and_then(|meta| meta.modified()).ok();
    Some((of(path)?, of(&Recipe::sidecar(path))))
}

/// What is wanted of a file's folder.
pub enum Request {
    /// Go to the next photo (`true`) or the previous one.
    Step(PathBuf, bool),
    /// Open the photos on both sides ahead.
    Prefetch(PathBuf),
}

/// The thread's work.
pub fn worker(ahead: Ahead) -> impl Work<Request> {
    move |job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox| match request {
        Request::Step(path, is_next) => step(job, &path, is_next, outbox),
        Request::Prefetch(path) => prefetch(&path, &ahead, cancel),
    }
}

fn step(job: JobId, path: &Path, is_next: bool, outbox: &Outbox) {
    let event = match folder::neighbours(path) {
        Ok((before, after)) => {
            let found = if is_next { after } else { before };
            found.map_or_else(
                || Event::Warning(if is_next { message!("photo-last") } else { message!("photo-first") }),
                |path| Event::Picked(Picked::Open(path)),
            )
        }
        Err(error) => {
            let folder = path.parent().unwrap_or(path);
            Event::Failed(message!("folder-unreadable", why = error.to_string(), folder = folder))
        }
    };
    outbox.send(job, event);
}

/// Opens both neighbours. Nothing is told: what cannot be opened is told when a person goes there.
fn prefetch(path: &Path, ahead: &Ahead, cancel: &Cancel) {
    let Ok((before, after)) = folder::neighbours(path) else { return };
    let wanted: Vec<PathBuf> = after.into_iter().chain(before).collect();
    ahead.keep_only(&wanted);
    for path in wanted {
        let is_small = path.metadata().is_ok_and(|meta| meta.len() <= LARGEST_BYTES);
        if cancel.is_cancelled() || !is_small || ahead.holds(&path) {
            continue;
        }
        let Some(changed) = changed(&path) else { continue };
        let Ok(document) = Document::read(&path, &Job { cancel, sink: &() }) else { continue };
        if let Some(photo) = document.subject.photo() {
            let tiles = Arc::new(TileSet::new(photo.size(), photo.srgb8()));
            ahead.put(path, changed, Ready { document, tiles });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn photo(path: &Path) {
        image::RgbImage::from_pixel(8, 6, image::Rgb([10, 20, 30])).save(path).unwrap();
    }

    #[test]
    fn neighbours_are_opened_ahead_once_and_a_changed_file_is_read_anew() {
        let dir = tempfile::tempdir().unwrap();
        let paths: Vec<_> = (1..=4).map(|n| dir.path().join(format!("p{n}.png"))).collect();
        paths.iter().for_each(|path| photo(path));
        let ahead = Ahead::default();
        prefetch(&paths[1], &ahead, &Cancel::default());
        assert!(ahead.holds(&paths[0]) && ahead.holds(&paths[2]) && !ahead.holds(&paths[3]));
        prefetch(&paths[2], &ahead, &Cancel::default());
        assert!(!ahead.holds(&paths[0]), "what is farther away goes");
        let ready = ahead.take(&paths[3]).unwrap();
        assert_eq!(ready.document.subject.name, "p4.png");
        assert!(ahead.take(&paths[3]).is_none(), "it was taken");
        prefetch(&paths[2], &ahead, &Cancel::default());
        std::fs::write(Recipe::sidecar(&paths[3]), "{}").unwrap();
        assert!(ahead.take(&paths[3]).is_none(), "its edit has changed since");
        let file = std::fs::File::options().append(true).open(&paths[1]).unwrap();
        file.set_modified(SystemTime::UNIX_EPOCH).unwrap();
        assert!(ahead.take(&paths[1]).is_none(), "the file has changed since");
    }
}
