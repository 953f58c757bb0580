//! What a file says of itself, and the net in it, ready for one picture.

use std::io::Read as _;
use std::path::Path;

use super::draft::{Draft, draft};
use super::error::AdoptError;
use super::family::{self, Family};
use crate::job::Cancel;
use crate::synth::relative::{input_shape, working_size};
use crate::synth::tract::{EngineError, OnnxBytes, OnnxFile, Options, Runnable, Signs, prepare_file, signs};
use crate::synth::{LongSides, Manifest, Task};

/// No ONNX file is larger: it is a protobuf.
const LARGEST_BYTES: u64 = i32::MAX as u64;
/// First bytes that a model can have: its protobuf's fields, each eight times its number and the kind of its value.
const FIRST: [u8; 9] = [0x08, 0x12, 0x1a, 0x22, 0x28, 0x32, 0x3a, 0x42, 0x72];

/// A net that was read and not yet tried.
pub(super) struct Reading {
    pub signs: Signs,
    pub family: Option<&'static Family>,
    pub draft: Draft,
    /// Without checksums.
    pub manifest: Manifest,
    /// The size that the net sees the picture at.
    pub size: [u32; 2],
    pub net: Runnable,
}

impl Reading {
    /// Reads a file for a picture of this size.
    ///
    /// # Errors
    /// A file that cannot be read, is no depth net, or cannot be run.
    pub(super) fn of(path: &Path, picture: [u32; 2], cancel: &Cancel) -> Result<Self, AdoptError> {
        let engine = AdoptError::engine(path);
        let bytes = std::fs::metadata(path).map_err(AdoptError::read(path))?.len();
        if bytes > LARGEST_BYTES {
            return Err(AdoptError::TooLarge { bytes });
        }
        if !begins_as_onnx(path).map_err(AdoptError::read(path))? {
            return Err(engine(EngineError::Parse { detail: "it does not begin as one".to_owned() }));
        }
        let signs = signs(OnnxBytes::File(path)).map_err(&engine)?;
        let family = family::of(&signs);
        let draft = draft(&signs, family)?;
        let manifest = manifest(path, &draft, family);
        let size = working_size(&manifest, picture);
        let wiring = manifest.relative.wiring();
        let file = OnnxFile { wiring: &wiring, ..OnnxFile::on_disk(path) };
        let options = Options { cancel: cancel.clone(), ..Options::default() };
        let net = prepare_file(&file, &input_shape(&manifest, size), &options).map_err(&engine)?;
        Ok(Self { signs, family, draft, manifest, size, net })
    }
}

/// Whether a file may be ONNX: what is not is never read whole, as it may be large.
fn begins_as_onnx(path: &Path) -> std::io::Result<bool> {
    let mut first = [0];
    let mut file = std::fs::File::open(path)?;
    Ok(file.read(&mut first)? == 1 && FIRST.contains(&first[0]))
}

fn manifest(path: &Path, draft: &Draft, family: Option<&Family>) -> Manifest {
    let text = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    Manifest {
        id: text(path.file_stem()),
        task: Task::RelativeDepth,
        file: text(path.file_name()),
        licence: family.map(|family| family.licence.to_owned()).unwrap_or_default(),
        working_long_side: LongSides::One(draft.long_side),
        multiple_of: draft.multiple_of,
        relative: draft.rules.clone(),
        ..Manifest::default()
    }
}
