//! The person's own depth nets: a folder a net, each whole or not there.

use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

use directories::ProjectDirs;
use serde::{Deserialize, Serialize};

use super::error::AdoptError;
use super::trial::Adopted;
use crate::aside::{NewFile, NewFolder};
use crate::job::{Job, Stage};
use crate::synth::{Manifest, ModelError, ModelSource, ModelTag, Task};
use crate::within;

/// A folder of added depth nets.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Shelf {
    folder: PathBuf,
}

/// A net on the shelf.
#[derive(Debug)]
pub struct Shelved {
    /// Its name, as `--source` takes it.
    pub name: String,
    /// What it says of itself, or what is wrong with it.
    pub manifest: Result<Manifest, ModelError>,
    /// Bytes of its files.
    pub bytes: u64,
    /// Whether it is used for all photos for which nothing else is asked.
    pub is_preferred: bool,
}

/// Which net is used where nothing else is asked.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Preferred {
    depth: String,
}

/// Names that mean something else to `--source`.
const TAKEN: [&str; 5] = ["auto", "network", "phone", "fused", "map"];
/// The file that names the preferred net.
const PREFERRED: &str = "preferred.toml";
/// The most that the file with its name may hold.
const MOST_TEXT_BYTES: u64 = 64 << 10;
/// Bytes that are copied between two looks at the cancel flag.
const PIECE_BYTES: usize = 4 << 20;

impl Shelf {
    /// The user's own; none where the system has no such place.
    pub fn user() -> Option<Self> {
        ProjectDirs::from("", "", "plenoscope").map(|dirs| Self::new(&dirs.data_dir().join("models")))
    }

    /// A folder of one's own. It need not be there yet.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_owned() }
    }

    /// Where the nets lie.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The same as a source of models.
    pub fn source(&self) -> ModelSource {
        ModelSource::Folder(self.folder.clone())
    }

    /// All nets by name, broken ones too.
    pub fn nets(&self) -> Vec<Shelved> {
        let preferred = self.preferred();
        let names = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let names = names.filter(|entry| entry.path().is_dir()).map(|entry| entry.file_name().to_string_lossy().into());
        let mut names: Vec<String> = names.filter(|name: &String| !name.starts_with('.')).collect();
        names.sort();
        let source = self.source();
        let shelved = |name: String| Shelved {
            manifest: source.depth_manifest(&name),
            bytes: bytes_of(&self.folder.join(&name)),
            is_preferred: preferred.as_deref() == Some(name.as_str()),
            name,
        };
        names.into_iter().map(shelved).collect()
    }

    /// The net that is used where nothing else is asked.
    pub fn preferred(&self) -> Option<String> {
        let text = within::text(&self.folder.join(PREFERRED), MOST_TEXT_BYTES).ok()?;
        let Preferred { depth } = toml::from_str(&text).ok()?;
        Some(depth).filter(|name| within::is_plain_name(name) && self.folder.join(name).is_dir())
    }

    /// Uses a net where nothing else is asked; none is the program's own.
    ///
    /// # Errors
    /// No net of this name; what is wrong with it; a folder that cannot be written to.
    pub fn prefer(&self, name: Option<&str>) -> Result<(), AdoptError> {
        let path = self.folder.join(PREFERRED);
        let Some(name) = name else {
            return match fs::remove_file(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(AdoptError::write(&path)(error)),
                _ => Ok(()),
            };
        };
        self.known(name)?.manifest?;
        let text = toml::to_string(&Preferred { depth: name.to_owned() }).unwrap_or_default();
        let write = || {
            let mut file = NewFile::new(&path)?;
            file.file().write_all(text.as_bytes())?;
            file.put()
        };
        write().map_err(AdoptError::write(&path))
    }

    /// The name and checksum of a net.
    pub fn tag(&self, name: &str) -> Option<ModelTag> {
        self.source().depth_manifest(name).ok().map(|manifest| manifest.tag())
    }

    /// Whether a net can be put here under a name.
    ///
    /// # Errors
    /// A name that cannot be one; one of this name, unless it is to be replaced.
    pub fn check(&self, name: &str, replace: bool) -> Result<(), AdoptError> {
        check_name(name)?;
        if self.folder.join(name).exists() && !replace {
            return Err(AdoptError::Exists { name: name.to_owned() });
        }
        Ok(())
    }

    /// Copies a net that was tried, and its further files, under the name in its manifest.
    ///
    /// # Errors
    /// Those of [`check`](Self::check); a file or folder that fails.
    pub fn put(&self, file: &Path, net: &Adopted, replace: bool, job: &Job) -> Result<(), AdoptError> {
        let Adopted { manifest, .. } = net;
        self.check(&manifest.id, replace)?;
        let target = self.folder.join(&manifest.id);
        fs::create_dir_all(&self.folder).map_err(AdoptError::write(&self.folder))?;
        let folder = NewFolder::new(&target).map_err(AdoptError::write(&target))?;
        let mut copied = Copied { bytes: 0, of: net.bytes };
        for part in std::iter::once(&manifest.file).chain(manifest.data_files.keys()) {
            copied.copy(&file.with_file_name(part), &folder.path().join(part), job)?;
        }
        let text = manifest.to_toml();
        fs::write(folder.path().join("manifest.toml"), text).map_err(AdoptError::write(&target))?;
        folder.put(|_| true).map_err(AdoptError::write(&target))
    }

    /// Takes a net away, with its files.
    ///
    /// # Errors
    /// No net of this name; files that cannot be deleted.
    pub fn remove(&self, name: &str) -> Result<(), AdoptError> {
        let shelved = self.known(name)?;
        if shelved.is_preferred {
            self.prefer(None)?;
        }
        let path = self.folder.join(name);
        fs::remove_dir_all(&path).map_err(|source| AdoptError::Io {
            what: "the net was not removed",
            source,
            advice: "check that its folder can be written to",
            path,
        })
    }

    fn known(&self, name: &str) -> Result<Shelved, AdoptError> {
        let nets = self.nets();
        let names: Vec<_> = nets.iter().map(|net| net.name.clone()).collect();
        let known =
            if names.is_empty() { "none was added".to_owned() } else { format!("known are {}", names.join(", ")) };
        let unknown = || AdoptError::Unknown { name: name.to_owned(), known };
        nets.into_iter().find(|net| net.name == name).ok_or_else(unknown)
    }
}

/// How much of a net has been copied.
struct Copied {
    bytes: u64,
    of: u64,
}

impl Copied {
    fn copy(&mut self, from: &Path, to: &Path, job: &Job) -> Result<(), AdoptError> {
        let mut source = within::open(from).map_err(AdoptError::read(from))?;
        let mut target = File::create(to).map_err(AdoptError::write(to))?;
        let mut piece = vec![0; PIECE_BYTES];
        loop {
            let percent = self.bytes * 100 / self.of.max(1);
            job.advance(Stage::Save, percent.min(100) as u32, 100)?;
            match source.read(&mut piece).map_err(AdoptError::read(from))? {
                0 => return target.sync_all().map_err(AdoptError::write(to)),
                n => {
                    target.write_all(&piece[..n]).map_err(AdoptError::write(to))?;
                    self.bytes += n as u64;
                }
            }
        }
    }
}

/// A name is a folder's, and one word on the command line.
fn check_name(name: &str) -> Result<(), AdoptError> {
    let is_ours = || ModelSource::Embedded.manifest(name, Task::RayDepth).is_ok();
    let fault = match name {
        "" => Some("it is empty"),
        _ if name.len() > 100 => Some("it is longer than 100 letters"),
        _ if name.starts_with(['.', '-']) => Some("it begins with a dot or a dash"),
        _ if !within::is_plain_name(name) => Some("it is no plain folder name"),
        _ if TAKEN.contains(&name) || is_ours() => Some("that is another source's name"),
        _ => None,
    };
    match fault {
        Some(why) => Err(AdoptError::Name { name: name.to_owned(), why }),
        None => Ok(()),
    }
}

fn bytes_of(folder: &Path) -> u64 {
    let files = fs::read_dir(folder).into_iter().flatten().flatten();
    files.filter_map(|file| file.metadata().ok()).map(|data| data.len()).sum()
}
