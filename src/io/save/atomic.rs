//! A file is there whole or not at all: written aside in the same folder, brought to the disk, then put in place.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::SaveError;

/// Writes a file through `write`: aside in the same folder, then in one step to `path`. Whatever goes wrong on the
/// way, an older file at `path` stays as it was, and nothing half-written is left.
pub fn atomic(path: &Path, write: impl FnOnce(&mut File) -> Result<(), SaveError>) -> Result<(), SaveError> {
    let folder = folder_of(path)?;
    let fail = |error: io::Error| SaveError::from_io(&error, path);
    let mut aside = Aside::new(folder).map_err(fail)?;
    write(aside.file()).map_err(|error| error.at(path))?;
    aside.file().sync_all().map_err(fail)?;
    aside.put(path).map_err(fail)
}

/// The folder that a file will be in; a sentence where it cannot be.
fn folder_of(path: &Path) -> Result<&Path, SaveError> {
    if path.is_dir() || path.file_name().is_none() {
        return Err(SaveError::IsFolder(path.to_owned()));
    }
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if folder.is_dir() { Ok(folder) } else { Err(SaveError::NoFolder(folder.to_owned())) }
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

/// A file beside its target. Without a name where the system can do that, so that even a kill leaves nothing.
enum Aside {
    #[cfg(target_os = "linux")]
    Nameless {
        file: File,
        folder: PathBuf,
    },
    Named(tempfile::NamedTempFile),
}

impl Aside {
    fn new(folder: &Path) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        if let Ok(file) = nameless(folder) {
            return Ok(Self::Nameless { file, folder: folder.to_owned() });
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".plenoscope-").suffix(".part");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        builder.tempfile_in(folder).map(Self::Named)
    }

    fn file(&mut self) -> &mut File {
        match self {
            #[cfg(target_os = "linux")]
            Self::Nameless { file, .. } => file,
            Self::Named(file) => file.as_file_mut(),
        }
    }

    fn put(self, path: &Path) -> io::Result<()> {
        match self {
            #[cfg(target_os = "linux")]
            Self::Nameless { file, folder } => link(&file, path)
                .or_else(|error| if path.exists() { replace(&file, &folder, path) } else { Err(error) }),
            Self::Named(file) => file.persist(path).map(drop).map_err(|failed| failed.error),
        }
    }
}

#[cfg(target_os = "linux")]
fn nameless(folder: &Path) -> io::Result<File> {
    use rustix::fs::{Mode, OFlags};
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    let file = File::from(rustix::fs::open(folder, flags, Mode::from_raw_mode(0o666))?);
    // Where there is no /proc the file could never get a name.
    Path::new("/proc/self/fd").exists().then_some(file).ok_or_else(|| io::ErrorKind::Unsupported.into())
}

#[cfg(target_os = "linux")]
fn link(file: &File, path: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD};
    use std::os::fd::AsRawFd;
    let open = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(rustix::fs::linkat(CWD, open.as_str(), CWD, path, AtFlags::SYMLINK_FOLLOW)?)
}

/// A name can be given, not taken over: link under a name aside, then rename.
#[cfg(target_os = "linux")]
fn replace(file: &File, folder: &Path, path: &Path) -> io::Result<()> {
    let name = format!(".plenoscope-{}-{:?}.part", std::process::id(), std::time::Instant::now());
    let clean: String = name.chars().filter(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '-')).collect();
    let aside = folder.join(clean);
    link(file, &aside)?;
    std::fs::rename(&aside, path).inspect_err(|_| {
        // The rename's error is the one to tell; a name that stays behind is all that this can add.
        let _ = std::fs::remove_file(&aside);
    })
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut all: Vec<_> =
            folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        all.sort();
        all
    }

    fn write(text: &'static str) -> impl FnOnce(&mut File) -> Result<(), SaveError> {
        move |file| file.write_all(text.as_bytes()).map_err(|e| SaveError::from_io(&e, Path::new("")))
    }

    #[test]
    fn a_file_is_made_and_replaced_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        atomic(&path, write("one")).unwrap();
        atomic(&path, write("two")).unwrap();
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
