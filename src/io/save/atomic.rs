//! Files and folders written aside, with our words for what can go wrong.

use std::fs::File;
use std::path::{Path, PathBuf};

use super::SaveError;
use crate::aside::{NewFile, NewFolder, parent};

/// Writes a file through `write`: aside in the same folder, then in one step to `path`. Whatever goes wrong on the
/// way, an older file at `path` stays as it was, and nothing half-written is left.
pub fn atomic(path: &Path, write: impl FnOnce(&mut File) -> Result<(), SaveError>) -> Result<(), SaveError> {
    aside(path, write)?.put().map_err(|error| SaveError::from_io(&error, path))
}

/// The same, but a file that came to `path` meanwhile stays: [`SaveError::Exists`].
pub fn atomic_new(path: &Path, write: impl FnOnce(&mut File) -> Result<(), SaveError>) -> Result<(), SaveError> {
    aside(path, write)?.put_new().map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => SaveError::Exists(path.to_owned()),
        _ => SaveError::from_io(&error, path),
    })
}

/// A file that is written and has no name yet.
fn aside(path: &Path, write: impl FnOnce(&mut File) -> Result<(), SaveError>) -> Result<NewFile, SaveError> {
    if path.is_dir() || path.file_name().is_none() {
        return Err(SaveError::IsFolder(path.to_owned()));
    }
    check_parent(path)?;
    let fail = |error| SaveError::from_io(&error, path);
    let mut new = NewFile::new(path).map_err(fail)?;
    write(new.file()).map_err(|error| error.at(path))?;
    Ok(new)
}

/// Writes a folder through `write`, which gets another path to write to: aside, then in one step to `path`. Into a
/// folder that is there already go the files alone. Of its old files those are taken away for which `is_ours` says so;
/// a person's own stay.
pub fn folder<E: From<SaveError>>(
    path: &Path,
    is_ours: impl Fn(&str) -> bool,
    write: impl FnOnce(&Path) -> Result<(), E>,
) -> Result<(), E> {
    check_parent(path)?;
    let fail = |error| SaveError::from_io(&error, path);
    let new = NewFolder::new(path).map_err(fail)?;
    write(new.path())?;
    Ok(new.put(is_ours).map_err(fail)?)
}

/// A sentence where the folder is missing that a path is to lie in.
fn check_parent(path: &Path) -> Result<(), SaveError> {
    let folder = parent(path);
    if folder.is_dir() { Ok(()) } else { Err(SaveError::NoFolder(folder.to_owned())) }
}

/// Whether two paths are one file, by whatever names.
pub fn same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b || same_inode(&a, &b),
        _ => false,
    }
}

#[cfg(unix)]
fn same_inode(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |path: &Path| path.metadata().ok().map(|m| (m.dev(), m.ino()));
    id(a).is_some() && id(a) == id(b)
}

#[cfg(not(unix))]
fn same_inode(_: &Path, _: &Path) -> bool {
    false
}

/// A path like this one that is still free: `name-2.png`, `name-3.png` …
pub fn free_path(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let with = |n: u32| match path.extension() {
        Some(ext) => path.with_file_name(format!("{stem}-{n}.{}", ext.to_string_lossy())),
        None => path.with_file_name(format!("{stem}-{n}")),
    };
    if !path.exists() {
        return path.to_owned();
    }
    (2..).map(with).find(|free| !free.exists()).unwrap_or_else(|| path.to_owned())
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;
    use crate::aside::names;

    fn write(text: &'static str) -> impl FnOnce(&mut File) -> Result<(), SaveError> {
        move |file| file.write_all(text.as_bytes()).map_err(|e| SaveError::from_io(&e, Path::new("")))
    }

    #[test]
    fn a_file_is_made_and_replaced_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        atomic(&path, write("one")).unwrap();
        atomic(&path, write("two")).unwrap();
        assert!(matches!(atomic_new(&path, write("three")), Err(SaveError::Exists(at)) if at == path));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(names(dir.path()), ["a.txt"]);
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_beside_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        atomic(&path, write("old")).unwrap();
        let failed = atomic(&path, |file| {
            write("half")(file)?;
            Err(SaveError::Cancelled)
        });
        assert!(matches!(failed, Err(SaveError::Cancelled)));
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(dir.path()), ["a.txt"]);
    }

    #[test]
    fn a_folder_as_target_and_a_folder_that_is_not_there_are_told_apart() {
        let dir = tempfile::tempdir().unwrap();
        assert!(matches!(atomic(dir.path(), write("x")), Err(SaveError::IsFolder(_))));
        assert!(matches!(atomic(&dir.path().join("no/a.txt"), write("x")), Err(SaveError::NoFolder(_))));
    }

    #[test]
    fn a_free_name_counts_up() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        assert_eq!(free_path(&path), path);
        atomic(&path, write("x")).unwrap();
        assert_eq!(free_path(&path), dir.path().join("a-2.png"));
    }

    #[cfg(unix)]
    #[test]
    fn one_file_by_two_names_is_found_out() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        atomic(&path, write("x")).unwrap();
        let other = dir.path().join("b.png");
        std::fs::hard_link(&path, &other).unwrap();
        assert!(same_file(&path, &other));
        assert!(!same_file(&path, &dir.path().join("c.png")));
    }
}
