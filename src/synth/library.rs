//! Where models come from: the ones in the program, or a folder. Every file is checked against its manifest.

use std::borrow::Cow;
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use sha2::{Digest, Sha256};

use super::{Manifest, ModelError, Task};
use crate::field::ViewGrid;

/// The models that were embedded when the program was built: path below `models/`, content.
static EMBEDDED: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/embedded_models.rs"));

/// Where models come from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub enum ModelSource {
    /// The ones that came with the program.
    #[default]
    Embedded,
    /// A folder laid out like `models/`: `models.toml` and one folder a model (`--models DIR`).
    Folder(PathBuf),
}

/// A model's name and checksum: what a light field says it was made with.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, Deserialize)]
pub struct ModelTag {
    /// Name of the model.
    pub id: String,
    /// Checksum of its ONNX file.
    pub sha256: String,
}

/// `models.toml`: the pair of nets that is used. What else it names is built into the program beside them.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct ModelIndex {
    /// The depth net.
    pub depth: String,
    /// The occlusion net; none means Lambertian views are final.
    pub occlusion: Option<String>,
}

/// A model as it was read: its manifest and its ONNX file, checked against each other.
#[derive(Clone, Debug)]
pub struct ModelFile {
    /// What it says about itself.
    pub manifest: Manifest,
    /// The ONNX file.
    pub onnx: Cow<'static, [u8]>,
    /// The folder that its further files lie in, where it has some.
    pub folder: Option<PathBuf>,
    /// Where it came from, for errors.
    pub place: String,
}

impl ModelFile {
    /// Checks that its views are those of the depth net in use.
    pub(super) fn check_grid(&self, wanted: ViewGrid) -> Result<(), ModelError> {
        let own = self.manifest.grid()?;
        if own == wanted {
            return Ok(());
        }
        let [have, want] = [own, wanted].map(|grid| format!("{} × {}", grid.rows(), grid.cols()));
        let why = format!("its views are {have} where the depth net in use makes {want}");
        Err(ModelError::Manifest { place: self.place.clone(), why })
    }
}

impl ModelSource {
    /// The pair of nets that this source uses.
    pub fn index(&self) -> Result<ModelIndex, ModelError> {
        let text = self.text("models.toml")?;
        let place = self.place("models.toml");
        toml::from_str(&text).map_err(|error| ModelError::Manifest { place, why: error.message().to_owned() })
    }

    /// Reads one model and checks its task and checksum.
    pub fn model(&self, id: &str, task: Task) -> Result<ModelFile, ModelError> {
        let manifest = self.manifest(id, task)?;
        let file = format!("{id}/{}", manifest.file);
        let onnx = self.bytes(&file)?;
        if sha256(&onnx) != manifest.sha256.to_lowercase() {
            return Err(ModelError::Tampered { id: manifest.id, place: self.place(&file) });
        }
        let folder = self.data_folder(id, &manifest)?;
        Ok(ModelFile { manifest, onnx, folder, place: self.place(&file) })
    }

    /// Reads what a model says of itself and checks its task; its files are not looked at.
    pub fn manifest(&self, id: &str, task: Task) -> Result<Manifest, ModelError> {
        let path = format!("{id}/manifest.toml");
        let place = self.place(&path);
        let manifest = Manifest::parse(&self.text(&path)?, &place)?;
        if manifest.id != id {
            let why = format!("its id is {:?}, and its folder is {id:?}", manifest.id);
            return Err(ModelError::Manifest { place, why });
        }
        if manifest.task != task {
            let why = format!("its task is {:?} where {task:?} is needed", manifest.task);
            return Err(ModelError::Manifest { place, why });
        }
        Ok(manifest)
    }

    /// The folder of a model's further files, each checked; none where the model is one file.
    fn data_folder(&self, id: &str, manifest: &Manifest) -> Result<Option<PathBuf>, ModelError> {
        let Self::Folder(folder) = self else { return Ok(None) };
        for (name, sha256) in &manifest.data_files {
            let path = folder.join(id).join(name);
            let found = checksum(&path).map_err(|source| ModelError::Unreadable { path: path.clone(), source })?;
            if found != sha256.to_lowercase() {
                return Err(ModelError::Tampered { id: id.to_owned(), place: path.display().to_string() });
            }
        }
        Ok((!manifest.data_files.is_empty()).then(|| folder.join(id)))
    }

    /// Where the pair of nets comes from: a folder of `relative-depth` models alone leaves those in the program in use.
    pub(super) fn for_pair(&self) -> Self {
        let relative = |id: &String| self.depth_task(id) == Some(Task::RelativeDepth);
        match self {
            Self::Folder(folder)
                if !folder.join("models.toml").exists() && self.further_models().iter().any(relative) =>
            {
                Self::Embedded
            }
            source => source.clone(),
        }
    }

    /// A depth net other than the pair's own, by its name; none where there is none.
    pub(super) fn further_model(&self, id: &str) -> Option<Result<ModelFile, ModelError>> {
        let is_here = self.folders().iter().any(|folder| folder == id);
        is_here.then(|| self.model(id, self.depth_task(id).unwrap_or(Task::RelativeDepth)))
    }

    /// Names of the depth nets that lie here beside the pair's own: further sources of ray depth. Broken ones are left
    /// out.
    pub fn further_models(&self) -> Vec<String> {
        let own = self.index().map(|index| index.depth).unwrap_or_default();
        let mut ids: Vec<_> = self.folders().into_iter().filter(|id| *id != own).collect();
        ids.retain(|id| self.depth_task(id).is_some());
        ids.sort();
        ids
    }

    /// What a model is for, where that is depth.
    fn depth_task(&self, id: &str) -> Option<Task> {
        let path = format!("{id}/manifest.toml");
        let manifest = self.text(&path).and_then(|text| Manifest::parse(&text, &path)).ok()?;
        (manifest.task != Task::Occlusion).then_some(manifest.task)
    }

    fn folders(&self) -> Vec<String> {
        match self {
            Self::Embedded => {
                EMBEDDED.iter().filter_map(|(path, _)| path.strip_suffix("/manifest.toml")).map(str::to_owned).collect()
            }
            Self::Folder(folder) => {
                let entries = fs::read_dir(folder).into_iter().flatten().flatten();
                entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
            }
        }
    }

    fn text(&self, path: &str) -> Result<String, ModelError> {
        let bytes = self.bytes(path)?.into_owned();
        let not_text = |_| ModelError::Manifest { place: self.place(path), why: "it is not text".to_owned() };
        String::from_utf8(bytes).map_err(not_text)
    }

    fn bytes(&self, path: &str) -> Result<Cow<'static, [u8]>, ModelError> {
        match self {
            Self::Embedded => EMBEDDED
                .iter()
                .find(|(name, _)| *name == path)
                .map(|(_, content)| Cow::Borrowed(*content))
                .ok_or_else(|| ModelError::NotEmbedded { path: path.to_owned() }),
            Self::Folder(folder) => {
                let path = folder.join(path);
                fs::read(&path).map(Cow::Owned).map_err(|source| ModelError::Unreadable { path, source })
            }
        }
    }

    fn place(&self, path: &str) -> String {
        match self {
            Self::Embedded => format!("the program's own {path}"),
            Self::Folder(folder) => folder.join(path).display().to_string(),
        }
    }
}

/// Checksum of a file, read a piece at a time: weights can be larger than the memory that is free.
pub(super) fn checksum(path: &Path) -> std::io::Result<String> {
    let mut file = fs::File::open(path)?;
    let mut sum = Sha256::new();
    let mut piece = vec![0; 1 << 20];
    loop {
        match file.read(&mut piece)? {
            0 => return Ok(hex(&sum.finalize())),
            n => sum.update(&piece[..n]),
        }
    }
}

/// Checksum of bytes.
pub(super) fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Lower-case hexadecimal digits.
pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
