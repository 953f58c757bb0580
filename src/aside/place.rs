//! The private folder that something is written in until it gets its name, and what becomes of those of killed programs.

use std::collections::HashSet;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::time::Duration;

use tempfile::TempDir;

/// How everything that is not yet there is called.
pub(super) const PREFIX: &str = ".plenoscope-";
pub(super) const SUFFIX: &str = ".part";
/// Held by the program that writes; the system lets it go however that program ends.
const LOCK: &str = "lock";
/// A folder without a lock is one that was just made, or one whose maker was killed then.
const JUST_MADE: Duration = Duration::from_secs(60);

/// A folder beside a target that nobody else may look into. It goes with its owner, or with the next who writes there.
pub(super) struct Place {
    // First, as an open file keeps its folder on Windows.
    _lock: File,
    folder: TempDir,
}

impl Place {
    /// A folder in a folder. What killed programs left there goes first, once a run.
    pub(super) fn within(folder: &Path) -> io::Result<Self> {
        sweep_once(folder);
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
        loop {
            let place = builder.tempdir_in(folder)?;
            let lock = match File::create(place.path().join(LOCK)) {
                // Who sweeps takes a folder for left that is empty.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                lock => lock?,
            };
            // Who sweeps may have been faster. A disk without locks is never swept.
            if !matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) {
                return Ok(Self { _lock: lock, folder: place });
            }
        }
    }

    /// Where things are written.
    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Marks a file that is about to lie beside its target as one whose owner lives.
#[cfg(target_os = "linux")]
pub(super) fn hold(file: &File) {
    // On a disk without locks it is held for ever, as nobody can find out.
    let _ = file.try_lock();
}

/// The same as [`sweep`], where it has not been done in this run.
pub(super) fn sweep_once(folder: &Path) {
    static SWEPT: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);
    if SWEPT.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.to_owned()) {
        sweep(folder);
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        clear(self.path());
    }
}

/// Takes a folder away, its lock last: who is killed here leaves what the next sweep knows. What cannot be deleted is left
/// to the next.
fn clear(folder: &Path) {
    let all = || fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    for path in all().filter(|path| path.file_name().is_some_and(|name| name != LOCK)) {
        let _ = if path.is_dir() && !path.is_symlink() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
    }
    let _ = fs::remove_file(folder.join(LOCK));
    let _ = fs::remove_dir(folder);
}

/// Takes away what killed programs left in a folder. What a living one is writing stays.
pub fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(PREFIX) && name.ends_with(SUFFIX) {
            take_left(&entry.path());
        }
    }
}

/// Takes a file or folder away whose owner does not live.
fn take_left(path: &Path) {
    let Ok(facts) = fs::symlink_metadata(path) else { return };
    let is_old = || facts.modified().ok().and_then(|at| at.elapsed().ok()).is_some_and(|age| age > JUST_MADE);
    let is_free = |held: &Path| File::open(held).is_ok_and(|lock| lock.try_lock().is_ok());
    let lock = path.join(LOCK);
    if facts.is_file() && is_free(path) {
        let _ = fs::remove_file(path);
    } else if facts.is_dir() && (is_free(&lock) || !lock.exists() && is_old()) {
        clear(path);
    } else if facts.is_dir() {
        // Only if it is empty: made just now, then its owner makes another, or nearly taken away.
        let _ = fs::remove_dir(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_program_left_goes_and_what_is_being_written_stays() {
        let dir = tempfile::tempdir().unwrap();
        let alive = Place::within(dir.path()).unwrap();
        let left = dir.path().join(".plenoscope-dead.part");
        fs::create_dir(&left).unwrap();
        fs::write(left.join("half"), "of a file").unwrap();
        sweep(dir.path());
        assert!(left.exists(), "it may have been made just now");
        let empty = dir.path().join(".plenoscope-empty.part");
        fs::create_dir(&empty).unwrap();
        fs::write(left.join(LOCK), "").unwrap();
        fs::write(dir.path().join(".plenoscope-also.part"), "dead").unwrap();
        fs::write(dir.path().join(".plenoscope-batch"), "a person's").unwrap();
        sweep(dir.path());
        let mut names: Vec<_> = dir.path().read_dir().unwrap().map(|entry| entry.unwrap().path()).collect();
        names.sort();
        let mut want = [dir.path().join(".plenoscope-batch"), alive.path().to_owned()];
        want.sort();
        assert_eq!(names, want);
    }

    #[test]
    fn a_place_goes_with_its_owner() {
        let dir = tempfile::tempdir().unwrap();
        let place = Place::within(dir.path()).unwrap();
        let folder = place.path().join("new");
        fs::create_dir(&folder).unwrap();
        fs::write(folder.join("view.png"), "a view").unwrap();
        drop(place);
        assert!(crate::aside::names(dir.path()).is_empty());
    }

    #[cfg(unix)]
    #[test]
    fn nobody_else_may_look_into_it() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let place = Place::within(dir.path()).unwrap();
        assert_eq!(place.path().metadata().unwrap().permissions().mode() & 0o777, 0o700);
    }
}
