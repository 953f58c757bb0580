//! Files and folders are there whole or not at all: written aside in the same place, then put there in one step.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// How everything that is not yet there is called.
const PREFIX: &str = ".plenoscope-";
const SUFFIX: &str = ".part";

/// A file on its way to a path. Until [`put`](Self::put) an older one stays as it was; dropped, it leaves nothing.
pub struct NewFile {
    path: PathBuf,
    aside: Aside,
}

/// Without a name where the system can do that, so that even a kill leaves nothing.
enum Aside {
    #[cfg(target_os = "linux")]
    Nameless(File),
    Named(tempfile::NamedTempFile),
}

impl NewFile {
    /// An empty file beside its target.
    ///
    /// # Errors
    /// The system's.
    pub fn new(path: &Path) -> io::Result<Self> {
        let folder = parent(path);
        #[cfg(target_os = "linux")]
        if let Ok(file) = nameless(folder) {
            return Ok(Self { path: path.to_owned(), aside: Aside::Nameless(file) });
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        Ok(Self { path: path.to_owned(), aside: Aside::Named(builder.tempfile_in(folder)?) })
    }

    /// What is written to.
    pub fn file(&mut self) -> &mut File {
        match &mut self.aside {
            #[cfg(target_os = "linux")]
            Aside::Nameless(file) => file,
            Aside::Named(file) => file.as_file_mut(),
        }
    }

    /// Brings it to the disk and gives it its name, unless a file of that name came there meanwhile.
    ///
    /// # Errors
    /// `AlreadyExists` where one did, which stays as it is; else the system's.
    pub fn put_new(mut self) -> io::Result<()> {
        self.file().sync_all()?;
        match self.aside {
            #[cfg(target_os = "linux")]
            Aside::Nameless(file) => link(&file, &self.path),
            Aside::Named(file) => file.persist_noclobber(&self.path).map(drop).map_err(|failed| failed.error),
        }
    }

    /// Brings it to the disk and gives it its name.
    ///
    /// # Errors
    /// The system's; then an older file is as it was.
    pub fn put(mut self) -> io::Result<()> {
        self.file().sync_all()?;
        match self.aside {
            #[cfg(target_os = "linux")]
            Aside::Nameless(file) => link(&file, &self.path)
                .or_else(|error| if self.path.exists() { replace(&file, &self.path) } else { Err(error) }),
            Aside::Named(file) => file.persist(&self.path).map(drop).map_err(|failed| failed.error),
        }
    }
}

/// A folder on its way to a path.
pub struct NewFolder {
    path: PathBuf,
    aside: tempfile::TempDir,
}

impl NewFolder {
    /// An empty folder beside its target.
    ///
    /// # Errors
    /// The system's; `AlreadyExists` where the target is a file.
    pub fn new(path: &Path) -> io::Result<Self> {
        if path.is_file() {
            return Err(io::ErrorKind::AlreadyExists.into());
        }
        let aside = tempfile::Builder::new().prefix(PREFIX).suffix(SUFFIX).tempdir_in(parent(path))?;
        Ok(Self { path: path.to_owned(), aside })
    }

    /// Where its files are written.
    pub fn path(&self) -> &Path {
        self.aside.path()
    }

    /// Gives it its name. Into a folder that is there already go the files alone: of the old ones those are taken away
    /// for which `is_ours` says so, and a person's own stay.
    ///
    /// # Errors
    /// The system's.
    pub fn put(self, is_ours: impl Fn(&str) -> bool) -> io::Result<()> {
        if !self.path.exists() {
            // A temporary folder is its owner's alone; what stays gets the ordinary rights.
            #[cfg(unix)]
            fs::set_permissions(self.aside.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755))?;
            return fs::rename(self.aside.keep(), &self.path);
        }
        for old in fs::read_dir(&self.path)?.filter_map(Result::ok) {
            if is_ours(&old.file_name().to_string_lossy()) {
                fs::remove_file(old.path())?;
            }
        }
        for new in fs::read_dir(self.aside.path())? {
            let new = new?;
            fs::rename(new.path(), self.path.join(new.file_name()))?;
        }
        Ok(())
    }
}

/// The folder that a path lies in.
pub fn parent(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
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
fn replace(file: &File, path: &Path) -> io::Result<()> {
    let name = format!("{PREFIX}{}-{:?}{SUFFIX}", std::process::id(), std::time::Instant::now());
    let clean: String = name.chars().filter(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '-')).collect();
    let aside = parent(path).join(clean);
    link(file, &aside)?;
    fs::rename(&aside, path).inspect_err(|_| {
        // The rename's error is the one to tell; a name that stays behind is all that this can add.
        let _ = fs::remove_file(&aside);
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

    fn write(path: &Path, text: &str) -> NewFile {
        let mut new = NewFile::new(path).unwrap();
        new.file().write_all(text.as_bytes()).unwrap();
        new
    }

    #[test]
    fn a_file_is_made_and_replaced_whole_or_not_at_all() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        write(&path, "one").put().unwrap();
        write(&path, "two").put().unwrap();
        drop(write(&path, "half"));
        assert_eq!(write(&path, "late").put_new().unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        assert_eq!(fs::read_to_string(&path).unwrap(), "two");
        write(&dir.path().join("b.txt"), "new").put_new().unwrap();
        fs::remove_file(dir.path().join("b.txt")).unwrap();
        assert!(write(dir.path(), "a folder's name").put().is_err());
        assert_eq!(names(dir.path()), ["a.txt"]);
    }

    #[test]
    fn a_folder_is_made_whole_and_shared_with_a_persons_own_files() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out");
        let made = |name: &str| {
            let new = NewFolder::new(&path).unwrap();
            fs::write(new.path().join(name), name).unwrap();
            new
        };
        made("frame_1").put(|_| false).unwrap();
        fs::write(path.join("letter"), "dear").unwrap();
        made("frame_2").put(|name| name.starts_with("frame")).unwrap();
        drop(made("frame_3"));
        assert_eq!(names(&path), ["frame_2", "letter"]);
        assert_eq!(names(dir.path()), ["out"]);
        assert_eq!(NewFolder::new(&path.join("letter")).err().unwrap().kind(), io::ErrorKind::AlreadyExists);
    }
}
