//! An edit beside its photo, which other windows and programs may change meanwhile: theirs is never written over unseen.

use std::collections::HashMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};

use sha2::{Digest, Sha256};

use super::{LARGEST_BYTES, Recipe, RecipeError};
use crate::io::save::{SaveError, atomic, atomic_new, free_path};
use crate::within;

/// What an edit's file held: none where there was no file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found(Option<[u8; 32]>);

/// What this program wrote last, by file.
static WRITTEN: LazyLock<Mutex<HashMap<PathBuf, Found>>> = LazyLock::new(Mutex::default);

impl Found {
    fn of(bytes: Option<&[u8]>) -> Self {
        Self(bytes.map(|bytes| Sha256::digest(bytes).into()))
    }
}

impl Recipe {
    /// The photo's own recipe, if it has one, and what its file held; the latter also where it cannot be used.
    pub fn found_beside(photo: &Path) -> (Result<Option<Self>, RecipeError>, Found) {
        let path = Self::sidecar(photo);
        match within::bytes(&path, LARGEST_BYTES) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => (Ok(None), Found::default()),
            // Read again for the words that tell why.
            read => (Self::read(&path).map(Some), Found::of(read.ok().as_deref())),
        }
    }

    /// Writes it beside its photo, whole or not at all. Where the file there is neither the one that was `found` nor one
    /// of this program's, it stays under another name, which is returned.
    ///
    /// # Errors
    /// [`RecipeError::Save`]; then what was there is as it was.
    pub fn keep_beside(&self, photo: &Path, found: Found) -> Result<Option<PathBuf>, RecipeError> {
        let path = Self::sidecar(photo);
        let text = self.to_json();
        let mut written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
        let known = |now| now == found || written.get(&path) == Some(&now);
        let beside = keep(photo, &path, text.as_bytes(), known)?;
        written.insert(path, Found::of(Some(text.as_bytes())));
        Ok(beside)
    }
}

/// Writes an edit; one that lies there and is not `known` stays under another name.
fn keep(photo: &Path, path: &Path, text: &[u8], known: impl Fn(Found) -> bool) -> Result<Option<PathBuf>, SaveError> {
    // One program at a time: the photo itself is what they have in common.
    let _turn = turn(photo);
    let theirs = within::bytes(path, LARGEST_BYTES).ok().filter(|theirs| !known(Found::of(Some(theirs))));
    let beside = theirs.map(|theirs| put_beside(path, &theirs)).transpose()?;
    atomic(path, |file| write_all(file, text))?;
    Ok(beside)
}

fn write_all(file: &mut File, bytes: &[u8]) -> Result<(), SaveError> {
    file.write_all(bytes).map_err(|error| SaveError::from_io(&error, Path::new("")))
}

/// Keeps somebody else's edit under a name that is free.
fn put_beside(path: &Path, theirs: &[u8]) -> Result<PathBuf, SaveError> {
    loop {
        let free = free_path(path);
        match atomic_new(&free, |file| write_all(file, theirs)) {
            Err(SaveError::Exists(_)) => {}
            put => return put.map(|()| free),
        }
    }
}

/// Waits until no other program keeps an edit of this photo. Where the system has no such locks, nobody waits.
fn turn(photo: &Path) -> Option<File> {
    // On Windows a lock would keep others from reading the photo.
    let photo = if cfg!(unix) { within::open(photo).ok()? } else { return None };
    photo.lock().ok().map(|()| photo)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::FNumber;
    use crate::scene::Edit;
    use crate::scene::recipe::PictureSettings;

    fn at(f_number: f32) -> Recipe {
        Recipe::new(Edit { f_number: FNumber(f_number), ..Edit::default() }, PictureSettings::default())
    }

    fn f_number(path: &Path) -> f32 {
        Recipe::read(path).unwrap().edit(1).f_number.0
    }

    #[test]
    fn an_edit_of_somebody_else_stays_under_another_name() {
        let dir = tempfile::tempdir().unwrap();
        let photo = dir.path().join("p.jpg");
        std::fs::write(&photo, "photo").unwrap();
        let path = Recipe::sidecar(&photo);
        let (none, found) = Recipe::found_beside(&photo);
        assert!(none.unwrap().is_none());
        assert_eq!(at(2.0).keep_beside(&photo, found).unwrap(), None, "there was none");
        assert_eq!(at(2.8).keep_beside(&photo, found).unwrap(), None, "that was ours");

        at(8.0).write(&path).unwrap();
        let theirs = at(4.0).keep_beside(&photo, found).unwrap().unwrap();
        assert_eq!((f_number(&path), f_number(&theirs)), (4.0, 8.0));
        assert_eq!(theirs, dir.path().join("p.jpg.plenoscope-2.json"));

        at(11.0).write(&path).unwrap();
        let (read, found) = Recipe::found_beside(&photo);
        assert_eq!(read.unwrap().unwrap().edit(1).f_number.0, 11.0);
        assert_eq!(at(5.6).keep_beside(&photo, found).unwrap(), None, "we have seen it");

        std::fs::write(&path, "from the future").unwrap();
        let beside = at(1.4).keep_beside(&photo, found).unwrap().unwrap();
        assert_eq!(std::fs::read_to_string(beside).unwrap(), "from the future");
    }

    /// Two windows write in turns as fast as they can: each edit is there, or was seen by who wrote over it.
    #[test]
    fn two_writers_lose_nothing_unseen() {
        let dir = tempfile::tempdir().unwrap();
        let photo = dir.path().join("p.jpg");
        std::fs::write(&photo, "photo").unwrap();
        std::thread::scope(|scope| {
            for writer in 0..2 {
                let photo = &photo;
                scope.spawn(move || {
                    for n in 0..10 {
                        // Nothing of what was there is known: all of it must stay.
                        let text = at(1.0 + n as f32 + 10.0 * writer as f32).to_json();
                        keep(photo, &Recipe::sidecar(photo), text.as_bytes(), |_| false).unwrap();
                    }
                });
            }
        });
        let files = dir.path().read_dir().unwrap().map(|entry| entry.unwrap().path());
        let mut kept: Vec<f32> = files.filter(|path| *path != photo).map(|path| f_number(&path)).collect();
        kept.sort_by(f32::total_cmp);
        kept.dedup();
        let want: Vec<f32> = (0..20).map(|n| 1.0 + n as f32).collect();
        assert_eq!(kept, want);
    }
}
