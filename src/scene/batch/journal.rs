//! Which pictures of a folder were made, of which photos and by which recipe: a line each, a file each worker.
//!
//! Nobody writes into another's file and nothing is locked, so that several workers on several machines can keep it,
//! over NFS too. A line that was torn by a crash is no line; then the picture is made once more.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::UNIX_EPOCH;

use serde::{Deserialize, Serialize};

use crate::aside::IsLink;
use crate::within;

/// The folder in the folder of the pictures.
const FOLDER: &str = ".plenoscope-batch";
const ENDING: &str = ".jsonl";

/// The record of one recipe's pictures in one folder.
pub(super) struct Journal {
    folder: PathBuf,
    own: Mutex<Option<File>>,
    known: Mutex<Known>,
}

/// What was read so far: the last line of each picture, and how far each file was read.
#[derive(Default)]
struct Known {
    made: HashMap<String, Made>,
    read: HashMap<PathBuf, u64>,
}

/// A picture that was there whole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Made {
    picture: String,
    bytes: u64,
    photo: Stamp,
}

/// By what a changed photo is known: its bytes, and when it was last written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Stamp {
    bytes: u64,
    written_ms: u64,
}

impl Journal {
    /// The record of the recipe with this key; nothing is read or written yet.
    pub(super) fn new(pictures: &Path, key: &str) -> Self {
        let folder = pictures.join(FOLDER).join(key);
        Self { folder, own: Mutex::default(), known: Mutex::default() }
    }

    /// Whether a picture is there, whole, of this recipe and of the photo as it is now.
    pub(super) fn is_finished(&self, picture: &Path, photo: &Path) -> bool {
        let Some(now) = Made::of(picture, photo) else { return false };
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.made.get(&now.picture) != Some(&now) {
            // Another worker may have made it since; a record that cannot be read is none.
            let _ = known.read_on(&self.folder);
        }
        known.made.get(&now.picture) == Some(&now)
    }

    /// Writes down that a picture was made.
    pub(super) fn add(&self, picture: &Path, photo: &Path) -> io::Result<()> {
        let Some(made) = Made::of(picture, photo) else { return Ok(()) };
        let line = format!("{}\n", serde_json::to_string(&made)?);
        let mut own = self.own.lock().unwrap_or_else(PoisonError::into_inner);
        if own.is_none() {
            fs::create_dir_all(&self.folder)?;
            // A link that somebody laid there would lead elsewhere.
            let ours = self.folder.ancestors().take(2);
            if ours.map(fs::symlink_metadata).any(|facts| facts.is_ok_and(|facts| facts.is_symlink())) {
                return Err(io::Error::other(IsLink));
            }
            *own = Some(new_file(&self.folder)?);
        }
        own.as_mut().map_or(Ok(()), |file| file.write_all(line.as_bytes()))
    }
}

/// A file that no other worker has, which all may read.
fn new_file(folder: &Path) -> io::Result<File> {
    let mut builder = tempfile::Builder::new();
    builder.prefix("").suffix(ENDING);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    Ok(builder.tempfile_in(folder)?.keep().map_err(|failed| failed.error)?.0)
}

impl Known {
    /// Reads what was added to any worker's file since the last time.
    fn read_on(&mut self, folder: &Path) -> io::Result<()> {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if path.to_string_lossy().ends_with(ENDING) {
                let from = self.read.get(&path).copied().unwrap_or(0);
                let read = self.read_file(&path, from)?;
                self.read.insert(path, from + read);
            }
        }
        Ok(())
    }

    /// Reads whole lines from a place on, and says how many bytes they were.
    fn read_file(&mut self, path: &Path, from: u64) -> io::Result<u64> {
        let mut file = within::open(path)?;
        if file.metadata()?.len() <= from {
            return Ok(0);
        }
        let mut bytes = Vec::new();
        file.seek(SeekFrom::Start(from))?;
        file.read_to_end(&mut bytes)?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        for line in bytes[..whole].split(|byte| *byte == b'\n') {
            if let Ok(made) = serde_json::from_slice::<Made>(line) {
                self.made.insert(made.picture.clone(), made);
            }
        }
        Ok(whole as u64)
    }
}

impl Made {
    /// What a line says of a picture and its photo as they are; none where one of them is not there.
    fn of(picture: &Path, photo: &Path) -> Option<Self> {
        let name = picture.file_name()?.to_string_lossy().into_owned();
        Some(Self { picture: name, bytes: fs::metadata(picture).ok()?.len(), photo: Stamp::of(photo)? })
    }
}

impl Stamp {
    fn of(path: &Path) -> Option<Self> {
        let facts = fs::metadata(path).ok()?;
        let written = facts.modified().ok()?.duration_since(UNIX_EPOCH).unwrap_or_default();
        Some(Self { bytes: facts.len(), written_ms: written.as_millis() as u64 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_finished_while_it_its_photo_and_the_recipe_are_what_they_were() {
        let dir = tempfile::tempdir().unwrap();
        let [photo, picture] = ["p.jpg", "p-f2.jpg"].map(|name| dir.path().join(name));
        fs::write(&photo, "photo").unwrap();
        let (one, other) = (Journal::new(dir.path(), "one"), Journal::new(dir.path(), "one"));
        assert!(!one.is_finished(&picture, &photo), "it is not there");
        fs::write(&picture, "picture").unwrap();
        assert!(!one.is_finished(&picture, &photo), "nobody says who made it");
        one.add(&picture, &photo).unwrap();
        assert!(other.is_finished(&picture, &photo), "another worker's lines count");
        assert!(!Journal::new(dir.path(), "two").is_finished(&picture, &photo), "another recipe's do not");
        fs::write(&picture, "pict").unwrap();
        assert!(!other.is_finished(&picture, &photo), "it is cut off");
        fs::write(&picture, "picture").unwrap();
        fs::write(&photo, "another photo").unwrap();
        assert!(!other.is_finished(&picture, &photo), "the photo is another");
    }

    #[test]
    fn torn_lines_are_none_and_are_read_when_they_are_whole() {
        let dir = tempfile::tempdir().unwrap();
        let [photo, picture] = ["p.jpg", "p-f2.jpg"].map(|name| dir.path().join(name));
        fs::write(&photo, "x").unwrap();
        fs::write(&picture, "x").unwrap();
        let journal = Journal::new(dir.path(), "key");
        let folder = dir.path().join(FOLDER).join("key");
        fs::create_dir_all(&folder).unwrap();
        let line = serde_json::to_string(&Made::of(&picture, &photo).unwrap()).unwrap();
        fs::write(folder.join("a.jsonl"), format!("no JSON\n{line}")).unwrap();
        assert!(!journal.is_finished(&picture, &photo));
        fs::write(folder.join("a.jsonl"), format!("no JSON\n{line}\n")).unwrap();
        assert!(journal.is_finished(&picture, &photo));
    }
}
