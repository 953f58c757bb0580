//! Files and folders are there whole or not at all: written aside in the same place, then put there in one step.
//!
//! Aside is a private place: a file without a name, or a folder that its owner alone may look into. What is put there is
//! brought to the disk first. A symbolic link at the target is replaced, never followed. What a killed program leaves
//! goes as soon as another writes into that folder ([`sweep`]).

mod place;

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use place::Place;
pub use place::sweep;
#[cfg(target_os = "linux")]
use place::{PREFIX, SUFFIX, hold, sweep_once};

/// A folder cannot be put where a symbolic link is: following it would write somewhere else.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("there is a symbolic link of that name")]
pub struct IsLink;

/// A file on its way to a path. Until [`put`](Self::put) an older one stays as it was; dropped, it leaves nothing.
pub struct NewFile {
    path: PathBuf,
    aside: Aside,
}

/// Without a name where the system can do that, so that even a kill leaves nothing.
enum Aside {
    #[cfg(target_os = "linux")]
    Nameless(File),
    // The file before its folder: this is the order in which they go.
    Named(tempfile::NamedTempFile, Place),
}

impl NewFile {
    /// An empty file beside its target.
    ///
    /// # Errors
    /// The system's.
    pub fn new(path: &Path) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        if let Ok(file) = nameless(parent(path)) {
            sweep_once(parent(path));
            return Ok(Self { path: path.to_owned(), aside: Aside::Nameless(file) });
        }
        Self::named(path)
    }

    fn named(path: &Path) -> io::Result<Self> {
        let place = Place::within(parent(path))?;
        let mut builder = tempfile::Builder::new();
        // Its folder keeps others out until it has its name.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(place.path())?;
        Ok(Self { path: path.to_owned(), aside: Aside::Named(file, place) })
    }

    /// What is written to.
    pub fn file(&mut self) -> &mut File {
        match &mut self.aside {
            #[cfg(target_os = "linux")]
            Aside::Nameless(file) => file,
            Aside::Named(file, _) => file.as_file_mut(),
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
            Aside::Nameless(file) => link(&file, &self.path)?,
            Aside::Named(file, _place) => {
                file.persist_noclobber(&self.path).map(drop).map_err(|failed| failed.error)?;
            }
        }
        sync_names(&self.path);
        Ok(())
    }

    /// Brings it to the disk and gives it its name. It takes over the rights of an older file.
    ///
    /// # Errors
    /// The system's; then an older file is as it was.
    pub fn put(mut self) -> io::Result<()> {
        #[cfg(unix)]
        if let Some(old) = fs::symlink_metadata(&self.path).ok().filter(fs::Metadata::is_file) {
            self.file().set_permissions(rights(&old))?;
        }
        self.file().sync_all()?;
        match self.aside {
            #[cfg(target_os = "linux")]
            Aside::Nameless(file) => link(&file, &self.path)
                .or_else(|error| if is_taken(&self.path) { replace(&file, &self.path) } else { Err(error) })?,
            Aside::Named(file, _place) => file.persist(&self.path).map(drop).map_err(|failed| failed.error)?,
        }
        sync_names(&self.path);
        Ok(())
    }
}

/// A folder on its way to a path.
pub struct NewFolder {
    target: PathBuf,
    new: PathBuf,
    place: Place,
}

impl NewFolder {
    /// An empty folder beside its target.
    ///
    /// # Errors
    /// The system's; `AlreadyExists` where the target is a file, [`IsLink`] where it is a link.
    pub fn new(path: &Path) -> io::Result<Self> {
        match fs::symlink_metadata(path) {
            Ok(facts) if facts.is_symlink() => return Err(io::Error::other(IsLink)),
            Ok(facts) if !facts.is_dir() => return Err(io::ErrorKind::AlreadyExists.into()),
            _ => {}
        }
        let place = Place::within(parent(path))?;
        let new = place.path().join("new");
        fs::create_dir(&new)?;
        Ok(Self { target: path.to_owned(), new, place })
    }

    /// Where its files are written.
    pub fn path(&self) -> &Path {
        &self.new
    }

    /// Brings it to the disk and gives it its name. Into a folder that is there already go the files alone: of the old
    /// ones those are taken away for which `is_ours` says so, and a person's own stay. On Linux that is one step too,
    /// unless the old folder holds folders.
    ///
    /// # Errors
    /// The system's; [`IsLink`].
    pub fn put(self, is_ours: impl Fn(&str) -> bool) -> io::Result<()> {
        sync_within(&self.new)?;
        match fs::symlink_metadata(&self.target) {
            Err(_) => fs::rename(&self.new, &self.target)?,
            Ok(facts) if facts.is_symlink() => return Err(io::Error::other(IsLink)),
            Ok(_) => {
                if !self.exchange(&is_ours)? {
                    self.move_files(&is_ours)?;
                }
            }
        }
        sync_names(&self.target);
        drop(self.place);
        Ok(())
    }

    /// Puts the new folder, with a person's own files in it, in the place of the old one, in one step. Says no where that
    /// cannot be done; then nothing has changed.
    #[cfg(target_os = "linux")]
    fn exchange(&self, is_ours: &impl Fn(&str) -> bool) -> io::Result<bool> {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        let mut linked = Vec::new();
        for old in fs::read_dir(&self.target)? {
            let old = old?;
            let name = old.file_name();
            let at = self.new.join(&name);
            if is_ours(&name.to_string_lossy()) || is_taken(&at) {
                continue;
            }
            if old.file_type()?.is_dir() || fs::hard_link(old.path(), &at).is_err() {
                return linked.iter().try_for_each(fs::remove_file).map(|()| false);
            }
            linked.push(at);
        }
        fs::set_permissions(&self.new, rights(&fs::metadata(&self.target)?))?;
        if renameat_with(CWD, &self.new, CWD, &self.target, RenameFlags::EXCHANGE).is_err() {
            return linked.iter().try_for_each(fs::remove_file).map(|()| false);
        }
        // What somebody put there meanwhile comes along.
        for late in fs::read_dir(&self.new)?.filter_map(Result::ok) {
            let at = self.target.join(late.file_name());
            if !is_ours(&late.file_name().to_string_lossy()) && !is_taken(&at) {
                fs::rename(late.path(), at)?;
            }
        }
        Ok(true)
    }

    #[cfg(not(target_os = "linux"))]
    fn exchange(&self, _: &impl Fn(&str) -> bool) -> io::Result<bool> {
        Ok(false)
    }

    /// The same file by file.
    fn move_files(&self, is_ours: &impl Fn(&str) -> bool) -> io::Result<()> {
        for old in fs::read_dir(&self.target)?.filter_map(Result::ok) {
            if is_ours(&old.file_name().to_string_lossy()) {
                fs::remove_file(old.path())?;
            }
        }
        for new in fs::read_dir(&self.new)? {
            let new = new?;
            fs::rename(new.path(), self.target.join(new.file_name()))?;
        }
        Ok(())
    }
}

/// The folder that a path lies in.
pub fn parent(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Bytes that may still be written to the disk of a folder; none where the system does not say.
pub fn free_bytes(folder: &Path) -> Option<u64> {
    #[cfg(target_os = "linux")]
    return rustix::fs::statvfs(folder).ok().map(|disk| disk.f_bavail.saturating_mul(disk.f_frsize));
    #[cfg(not(target_os = "linux"))]
    return Some(folder).and(None);
}

/// Whether there is something of a name, a link that leads nowhere too.
#[cfg(target_os = "linux")]
fn is_taken(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok()
}

/// Who may read and write it, without what lets a program run as somebody else.
#[cfg(unix)]
fn rights(facts: &fs::Metadata) -> fs::Permissions {
    use std::os::unix::fs::PermissionsExt;
    fs::Permissions::from_mode(facts.permissions().mode() & 0o777)
}

/// Brings all files of a folder to the disk.
fn sync_within(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            sync_within(&entry.path())?;
        } else {
            File::options().read(true).write(true).open(entry.path())?.sync_all()?;
        }
    }
    Ok(())
}

/// Brings a new name to the disk, where the system does that for folders. The file is whole in any case.
fn sync_names(path: &Path) {
    if let Ok(folder) = File::open(parent(path)) {
        let _ = folder.sync_all();
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
fn replace(file: &File, path: &Path) -> io::Result<()> {
    let name = format!("{PREFIX}{}-{:?}{SUFFIX}", std::process::id(), std::time::Instant::now());
    let clean: String = name.chars().filter(|c| c.is_ascii_alphanumeric() || matches!(c, '.' | '-')).collect();
    let aside = parent(path).join(clean);
    hold(file);
    link(file, &aside)?;
    fs::rename(&aside, path).inspect_err(|_| {
        // The rename's error is the one to tell; a name that stays behind is all that this can add.
        let _ = fs::remove_file(&aside);
    })
}

/// What lies in a folder, sorted.
#[cfg(test)]
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let mut all: Vec<_> = folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    all.sort();
    all
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

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
        assert_eq!(fs::read_to_string(path.join("letter")).unwrap(), "dear");
        assert_eq!(names(&path), ["frame_2", "letter"]);
        assert_eq!(names(dir.path()), ["out"]);
        assert_eq!(NewFolder::new(&path.join("letter")).err().unwrap().kind(), io::ErrorKind::AlreadyExists);
    }

    /// The way of systems whose files cannot be without a name.
    #[test]
    fn a_named_file_is_put_in_its_place_too() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        for text in ["one", "two"] {
            let mut new = NewFile::named(&path).unwrap();
            new.file().write_all(text.as_bytes()).unwrap();
            new.put().unwrap();
        }
        assert_eq!(NewFile::named(&path).unwrap().put_new().unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        drop(NewFile::named(&path).unwrap());
        assert_eq!((fs::read_to_string(&path).unwrap().as_str(), names(dir.path())), ("two", vec!["a.txt".to_owned()]));
    }

    #[cfg(unix)]
    #[test]
    fn rights_are_those_of_the_older_file_or_what_is_usual() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let mode = |name: &str| dir.path().join(name).metadata().unwrap().permissions().mode() & 0o777;
        fs::write(dir.path().join("usual"), "").unwrap();
        fs::create_dir(dir.path().join("usual folder")).unwrap();
        for (name, new) in [("a", NewFile::new as fn(&Path) -> io::Result<NewFile>), ("b", NewFile::named)] {
            let path = dir.path().join(name);
            new(&path).unwrap().put().unwrap();
            assert_eq!(mode(name), mode("usual"));
            fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
            new(&path).unwrap().put().unwrap();
            assert_eq!(mode(name), 0o600, "what is private stays private");
        }
        NewFolder::new(&dir.path().join("c")).unwrap().put(|_| false).unwrap();
        assert_eq!(mode("c"), mode("usual folder"));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_not_followed() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::write(at("secret"), "mine").unwrap();
        fs::create_dir(at("home")).unwrap();
        symlink(at("secret"), at("a.json")).unwrap();
        symlink(at("nowhere"), at("b.json")).unwrap();
        symlink(at("home"), at("out")).unwrap();
        write(&at("a.json"), "edit").put().unwrap();
        write(&at("b.json"), "edit").put().unwrap();
        assert_eq!(fs::read_to_string(at("secret")).unwrap(), "mine");
        assert!(["a.json", "b.json"].iter().all(|name| at(name).symlink_metadata().unwrap().is_file()));
        assert!(NewFolder::new(&at("out")).err().unwrap().get_ref().unwrap().is::<IsLink>());
        assert_eq!(names(&at("home")), [""; 0]);
        assert_eq!(names(dir.path()), ["a.json", "b.json", "home", "out", "secret"]);
    }

    /// A person's own folder in the old one cannot go along in one step, and must not be lost.
    #[test]
    fn a_folder_that_holds_folders_keeps_them() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out");
        fs::create_dir_all(path.join("letters")).unwrap();
        fs::write(path.join("letters/one"), "dear").unwrap();
        fs::write(path.join("frame_1"), "old").unwrap();
        let new = NewFolder::new(&path).unwrap();
        fs::write(new.path().join("frame_2"), "new").unwrap();
        new.put(|name| name.starts_with("frame")).unwrap();
        assert_eq!(names(&path), ["frame_2", "letters"]);
        assert_eq!(fs::read_to_string(path.join("letters/one")).unwrap(), "dear");
        assert_eq!(names(dir.path()), ["out"]);
    }
}
