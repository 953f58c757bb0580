//! Where models come from: the ones in the program, or a folder. Every file is checked against its manifest.

use std::borrow::Cow;
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use sha2::{Digest, Sha256};

use super::tract::{OnnxBytes, OnnxFile, Wiring};
use super::{Manifest, ModelError, Task};
use crate::field::ViewGrid;
use crate::within;

/// The models that were embedded when the program was built: path below `models/`, content.
static EMBEDDED: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/embedded_models.rs"));

/// The most that a manifest or an index may hold.
const MOST_TEXT_BYTES: u64 = 1 << 20;

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

/// A model: its manifest and its ONNX file, checked against each other.
#[derive(Clone, Debug)]
pub struct ModelFile {
    /// What it says about itself.
    pub manifest: Manifest,
    /// The ONNX file.
    pub onnx: ModelBytes,
    /// Bytes of the ONNX file and of those beside it.
    pub bytes: u64,
    /// The folder that its further files lie in, where it has some.
    pub folder: Option<PathBuf>,
    /// Where it came from, for errors.
    pub place: String,
}

/// Where the ONNX file of a model is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ModelBytes {
    /// In the program.
    Embedded(&'static [u8]),
    /// On the disk, from where it is read each time it is made ready.
    File(PathBuf),
}

impl ModelBytes {
    /// As the engine takes it.
    pub fn as_onnx(&self) -> OnnxBytes<'_> {
        match self {
            Self::Embedded(bytes) => OnnxBytes::Memory(bytes),
            Self::File(path) => OnnxBytes::File(path),
        }
    }

    /// The whole file.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn read(&self) -> std::io::Result<Cow<'static, [u8]>> {
        match self {
            Self::Embedded(bytes) => Ok(Cow::Borrowed(bytes)),
            Self::File(path) => fs::read(path).map(Cow::Owned),
        }
    }
}

impl ModelFile {
    /// As the engine takes it.
    pub fn onnx<'a>(&'a self, wiring: &'a Wiring) -> OnnxFile<'a> {
        OnnxFile { bytes: self.onnx.as_onnx(), folder: self.folder.as_deref(), wiring }
    }

    /// Whether it is part of the program.
    pub(super) fn is_built_in(&self) -> bool {
        matches!(self.onnx, ModelBytes::Embedded(_))
    }

    /// Checks that the ONNX file still is the one that the manifest describes.
    pub(super) fn check(&self) -> Result<(), ModelError> {
        let sum = match &self.onnx {
            ModelBytes::Embedded(bytes) => sha256(bytes),
            ModelBytes::File(path) => {
                checksum(path).map_err(|source| ModelError::Unreadable { path: path.clone(), source })?
            }
        };
        if sum == self.manifest.sha256.to_lowercase() {
            return Ok(());
        }
        Err(ModelError::Tampered { id: self.manifest.id.clone(), place: self.place.clone() })
    }

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
        let bad = |why: &str| ModelError::Manifest { place: place.clone(), why: why.to_owned() };
        let index: ModelIndex = toml::from_str(&text).map_err(|error| bad(error.message()))?;
        let is_here = |name: &String| within::is_plain_name(name);
        if !is_here(&index.depth) || !index.occlusion.iter().all(is_here) {
            return Err(bad("a model must be a folder beside it"));
        }
        Ok(index)
    }

    /// Reads one model and checks its task and checksum.
    pub fn model(&self, id: &str, task: Task) -> Result<ModelFile, ModelError> {
        let manifest = self.manifest(id, task)?;
        let name = format!("{id}/{}", manifest.file);
        let (onnx, own_bytes) = match self {
            Self::Embedded => embedded(&name).map(|bytes| (ModelBytes::Embedded(bytes), bytes.len() as u64))?,
            Self::Folder(folder) => {
                let path = folder.join(&name);
                let bytes = fs::metadata(&path).map(|about| about.len());
                (ModelBytes::File(path.clone()), bytes.map_err(|source| ModelError::Unreadable { path, source })?)
            }
        };
        let (folder, further_bytes) = self.data_folder(id, &manifest)?;
        let bytes = own_bytes + further_bytes;
        let file = ModelFile { manifest, onnx, bytes, folder, place: self.place(&name) };
        file.check()?;
        Ok(file)
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

    /// The same of a depth net, of ray depths or of relative depth.
    pub fn depth_manifest(&self, id: &str) -> Result<Manifest, ModelError> {
        self.manifest(id, self.depth_task(id).unwrap_or(Task::RelativeDepth))
    }

    /// The folder of a model's further files, each checked, and their bytes; none where the model is one file.
    fn data_folder(&self, id: &str, manifest: &Manifest) -> Result<(Option<PathBuf>, u64), ModelError> {
        let Self::Folder(folder) = self else { return Ok((None, 0)) };
        let mut bytes = 0;
        for (name, sha256) in &manifest.data_files {
            let path = folder.join(id).join(name);
            let read = || Ok((checksum(&path)?, fs::metadata(&path)?.len()));
            let (found, len) = read().map_err(|source| ModelError::Unreadable { path: path.clone(), source })?;
            bytes += len;
            if found != sha256.to_lowercase() {
                return Err(ModelError::Tampered { id: id.to_owned(), place: path.display().to_string() });
            }
        }
        Ok(((!manifest.data_files.is_empty()).then(|| folder.join(id)), bytes))
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

    /// Names and checksums of [`further_models`](Self::further_models).
    pub fn further_tags(&self) -> Vec<ModelTag> {
        let tag = |id: String| Some(self.manifest(&id, self.depth_task(&id)?).ok()?.tag());
        self.further_models().into_iter().filter_map(tag).collect()
    }

    /// Names of the nets of four corners that lie here.
    pub(super) fn corner_models(&self) -> Vec<String> {
        let mut ids = self.folders();
        ids.retain(|id| self.task(id) == Some(Task::Corners));
        ids.sort();
        ids
    }

    /// What a model is for, where that is the depth of a photo.
    fn depth_task(&self, id: &str) -> Option<Task> {
        self.task(id).filter(|task| matches!(task, Task::RayDepth | Task::RelativeDepth))
    }

    /// What a model is for; none where it does not say so.
    fn task(&self, id: &str) -> Option<Task> {
        let path = format!("{id}/manifest.toml");
        let manifest = self.text(&path).and_then(|text| Manifest::parse(&text, &path));
        manifest.ok().map(|manifest| manifest.task)
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
            Self::Embedded => embedded(path).map(Cow::Borrowed),
            Self::Folder(folder) => {
                let path = folder.join(path);
                let read = within::bytes(&path, MOST_TEXT_BYTES).map(Cow::Owned);
                read.map_err(|source| ModelError::Unreadable { path, source })
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

/// A file in the program.
fn embedded(path: &str) -> Result<&'static [u8], ModelError> {
    let found = EMBEDDED.iter().find(|(name, _)| *name == path).map(|(_, content)| *content);
    found.ok_or_else(|| ModelError::NotEmbedded { path: path.to_owned() })
}

/// Checksum of a file, read a piece at a time: weights can be larger than the memory that is free.
pub(super) fn checksum(path: &Path) -> std::io::Result<String> {
    let mut file = within::open(path)?;
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
