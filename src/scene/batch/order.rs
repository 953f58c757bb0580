//! What a batch is asked to do, and what became of it.

use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::field::Strength;
use crate::io::formats::depth_map::GivenDepth;
use crate::scene::{DepthFrom, Making, Recipe};
use crate::shard::Shard;
use crate::synth::Task;

/// What to do with every photo.
#[derive(Clone, Debug)]
pub struct Order {
    /// The edit.
    pub recipe: Recipe,
    /// The folder that the pictures go to; it is made if it is not there.
    pub out: PathBuf,
    /// How much memory the photos that are worked on together may take.
    pub memory_bytes: u64,
    /// How many photos are worked on together at most; 0 is one for each core.
    pub jobs: usize,
    /// What becomes of pictures that are there already.
    pub earlier: Earlier,
    /// Which of the photos are this worker's.
    pub shard: Shard,
    /// How depth is made.
    pub making: Making,
    /// A map to use instead of any other depth.
    pub own_map: Option<GivenDepth>,
}

/// What becomes of pictures that are there already.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Earlier {
    /// They stay, whoever made them.
    #[default]
    Keep,
    /// Those stay that are whole, of this recipe, and of the photo as it is now; others are made again.
    Resume,
    /// All are made again.
    Replace,
}

/// How it went.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Pictures that were made.
    pub done: Vec<PathBuf>,
    /// Pictures that were there already.
    pub skipped: Vec<PathBuf>,
    /// How many of those came there while this worker made the same.
    pub met: usize,
    /// Photos that failed, each with a sentence that says why.
    pub failed: Vec<(PathBuf, String)>,
    /// Whether it was stopped before the end.
    pub stopped: bool,
}

/// What became of a photo, as a line of a report has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// The photo.
    pub path: String,
    /// Its picture; none where it failed.
    pub output: Option<String>,
    /// What became of it.
    pub state: State,
    /// Seconds that this took.
    pub secs: f64,
    /// Why it failed.
    pub error: Option<String>,
}

/// What became of a photo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// Its picture was made.
    Made,
    /// Its picture was there already.
    Skipped,
    /// Its picture came there while this worker made the same.
    Met,
    /// It failed.
    Failed,
}

/// Why a batch could not be started, or had to end.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// The folder for the pictures cannot be made.
    #[error("the folder for the pictures cannot be made — {why} — choose another: {}", .path.display())]
    NoFolder {
        /// The system's words.
        why: String,
        /// The folder.
        path: PathBuf,
    },
    /// A folder was there at the start and is not any more.
    #[error("the work had to end — a folder has gone away — bring it back and run the same again with --resume: {}", .0.display())]
    Gone(PathBuf),
    /// The report cannot be written.
    #[error(
        "the work had to end — the report cannot be written ({0}) — make room for it and run the same again with --resume"
    )]
    Report(std::io::Error),
}

impl Order {
    /// What its pictures are known by: recipe, nets, and how depth is made.
    pub(super) fn key(&self) -> String {
        // Repairs come with the recipe.
        let Making { long_side, occlusion, source, scale, models, shelf, strength, threads: _, repairs: _ } =
            &self.making;
        let mut hash = Sha256::new();
        hash.update(self.recipe.to_json());
        hash.update(format!("{long_side} {occlusion} {source:?} {scale:?} {:?}", self.own_map));
        if let Some(Strength(strength)) = strength {
            hash.update(format!("{strength}"));
        }
        let index = models.index().ok();
        let depth = index.as_ref().and_then(|pair| models.manifest(&pair.depth, Task::RayDepth).ok());
        let occlusion =
            index.as_ref().and_then(|pair| models.manifest(pair.occlusion.as_deref()?, Task::Occlusion).ok());
        hash.update(format!("{depth:?} {occlusion:?}"));
        let named = match source {
            DepthFrom::Model(name) => Some(name.clone()),
            DepthFrom::Auto => shelf.as_ref().and_then(|shelf| shelf.preferred()),
            _ => None,
        };
        let tag = named.as_ref().and_then(|name| shelf.as_ref()?.tag(name));
        hash.update(format!("{named:?} {tag:?}"));
        hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
    }
}

/// A folder as it was at the start: after an unmount there is another of the same name.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) path: PathBuf,
    id: Option<(u64, u64)>,
}

impl Place {
    /// A folder that is there; none where it is not.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        path.is_dir().then(|| Self { path: path.to_owned(), id: id(path) })
    }

    /// Whether the same folder is still there.
    pub(super) fn is_there(&self) -> bool {
        self.path.is_dir() && id(&self.path) == self.id
    }
}

#[cfg(unix)]
fn id(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    path.metadata().ok().map(|facts| (facts.dev(), facts.ino()))
}

#[cfg(not(unix))]
fn id(_: &Path) -> Option<(u64, u64)> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::FNumber;
    use crate::scene::{Edit, recipe::PictureSettings};

    fn order(f: f32, making: Making) -> Order {
        let recipe = Recipe::new(Edit { f_number: FNumber(f), ..Edit::default() }, PictureSettings::default());
        let out = PathBuf::from("out");
        let (earlier, shard) = (Earlier::Keep, Shard::default());
        Order { recipe, out, memory_bytes: 1, jobs: 0, earlier, shard, making, own_map: None }
    }

    #[test]
    fn the_key_hangs_on_what_a_picture_hangs_on() {
        let key = |f, making| order(f, making).key();
        let making = Making::default;
        assert_eq!(key(2.0, making()), key(2.0, Making { threads: 3, ..making() }));
        let others = [
            key(2.8, making()),
            key(2.0, Making { long_side: 360, ..making() }),
            key(2.0, Making { source: DepthFrom::Network, ..making() }),
            key(2.0, Making { scale: crate::synth::Scale::Lytro, ..making() }),
            key(2.0, Making { strength: Some(Strength(2.0)), ..making() }),
            key(2.0, Making { models: crate::synth::ModelSource::Folder("none".into()), ..making() }),
        ];
        assert!(others.iter().all(|other| *other != key(2.0, making())), "{others:?}");
    }

    #[cfg(unix)]
    #[test]
    fn another_folder_of_the_same_name_is_not_the_same() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out");
        std::fs::create_dir(&path).unwrap();
        let place = Place::of(&path).unwrap();
        assert!(place.is_there());
        std::fs::rename(&path, dir.path().join("away")).unwrap();
        assert!(!place.is_there());
        std::fs::create_dir(&path).unwrap();
        assert!(!place.is_there());
    }
}
