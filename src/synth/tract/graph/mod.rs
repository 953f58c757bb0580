//! The ONNX graph as it stands in the file, before tract sees it: what of it is used, and what older exporters wrote.

mod bytes;
mod halves;
mod lean;
mod mend;
mod outside;
mod signs;
mod wiring;

#[cfg(test)]
pub mod tests;

use std::ffi::OsStr;
use std::path::{Component, Path};

use tract_onnx::pb::tensor_proto::{DataLocation, DataType};
use tract_onnx::pb::{GraphProto, ModelProto, TensorProto, ValueInfoProto, type_proto, type_proto::Value};
use tract_onnx::prelude::Framework;

use outside::Outside;
pub use signs::{Port, Scale, Signs};
pub use wiring::Wiring;

use super::error::EngineError;

/// Where an ONNX file is.
#[derive(Clone, Copy, Debug)]
pub enum OnnxBytes<'a> {
    /// In memory.
    Memory(&'a [u8]),
    /// On the disk: its weights are read when they are packed, a tensor at a time.
    File(&'a Path),
}

/// An ONNX file: where it is, where its further files lie, and what of it is used.
#[derive(Clone, Copy, Debug)]
pub struct OnnxFile<'a> {
    /// The file.
    pub bytes: OnnxBytes<'a>,
    /// The folder of the files that hold weights of their own; none where there must be none.
    pub folder: Option<&'a Path>,
    /// Which outputs are wanted, and what stands for inputs other than the picture.
    pub wiring: &'a Wiring,
}

impl<'a> OnnxFile<'a> {
    /// A file in memory whose first input and output are used, and whose weights are all in it.
    pub fn plain(bytes: &'a [u8]) -> Self {
        Self { bytes: OnnxBytes::Memory(bytes), folder: None, wiring: const { &Wiring::FIRST } }
    }

    /// A file on the disk whose first input and output are used; weights may lie in files beside it.
    pub fn on_disk(path: &'a Path) -> Self {
        Self { bytes: OnnxBytes::File(path), folder: path.parent(), wiring: const { &Wiring::FIRST } }
    }

    /// The folder of all files that weights lie in, as tract takes it.
    pub(super) fn weights_folder(&self) -> Option<String> {
        let folder = match self.bytes {
            OnnxBytes::File(path) => path.parent(),
            OnnxBytes::Memory(_) => self.folder,
        };
        folder.map(|folder| folder.to_string_lossy().into_owned())
    }
}

impl OnnxBytes<'_> {
    /// The graph; weights of a file on the disk stay there.
    pub(super) fn decoded(&self, onnx: &tract_onnx::Onnx) -> Result<ModelProto, EngineError> {
        let model = match self {
            Self::Memory(bytes) => onnx.proto_model_for_read(&mut &bytes[..]).map_err(EngineError::parse)?,
            Self::File(path) => lean::decode(path)?,
        };
        if model.graph.as_ref().is_none_or(|graph| graph.node.is_empty()) {
            return Err(EngineError::Parse { detail: "it holds no net".to_owned() });
        }
        Ok(model)
    }

    /// The name that weights have which lie in the file itself.
    fn own_name(&self) -> Option<&OsStr> {
        match self {
            Self::Memory(_) => None,
            Self::File(path) => path.file_name(),
        }
    }
}

/// Reads a file, checks what can be checked without running it, and brings it into the form that tract knows; answers
/// also what reads its weights.
pub(super) fn read(onnx: &tract_onnx::Onnx, file: &OnnxFile) -> Result<(ModelProto, Outside), EngineError> {
    let mut model = file.bytes.decoded(onnx)?;
    check_externals(&model, file)?;
    check_weights(&model)?;
    mend::all(&mut model);
    check_operators(onnx, &model)?;
    let mut outside = Outside::default();
    if let Some(graph) = &mut model.graph {
        halves::widen(graph, &mut outside);
        bytes::widen(graph, &mut outside);
        wiring::connect(graph, file.wiring)?;
    }
    Ok((model, outside))
}

/// Refuses a model with a weight that is NaN or infinite.
fn check_weights(model: &ModelProto) -> Result<(), EngineError> {
    let is_finite = |tensor: &&TensorProto| floats(tensor).is_none_or(|mut values| values.all(f32::is_finite));
    let weights = model.graph.iter().flat_map(|graph| &graph.initializer);
    match weights.into_iter().find(|tensor| !is_finite(tensor)) {
        Some(tensor) => Err(EngineError::NotFinite { name: tensor.name.clone() }),
        None => Ok(()),
    }
}

/// The values of a tensor of f32, in whichever of the two ways the file keeps them; none of one of another type.
fn floats(tensor: &TensorProto) -> Option<impl Iterator<Item = f32> + '_> {
    let raw = tensor.raw_data.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
    (tensor.data_type == DataType::Float as i32).then(|| tensor.float_data.iter().copied().chain(raw))
}

/// What a file says of itself: inputs, outputs and the signs that families of nets are told by.
///
/// # Errors
/// No ONNX file.
pub fn signs(bytes: OnnxBytes) -> Result<Signs, EngineError> {
    let model = bytes.decoded(&tract_onnx::onnx())?;
    let mut signs = Signs::of(&model, model.graph.as_ref().unwrap_or(&GraphProto::default()));
    signs.files.retain(|name| Some(OsStr::new(name)) != bytes.own_name());
    Ok(signs)
}

/// Names of the files beside this one in which weights lie.
fn externals(model: &ModelProto) -> Vec<&str> {
    let tensors = model.graph.iter().flat_map(|graph| &graph.initializer);
    let mut files: Vec<_> = tensors.filter_map(location).collect();
    files.sort_unstable();
    files.dedup();
    files
}

/// The file in which a tensor lies, where that is not this one.
fn location(tensor: &TensorProto) -> Option<&str> {
    let is_outside = tensor.data_location == Some(DataLocation::External as i32);
    let entry = || tensor.external_data.iter().find(|entry| entry.key == "location");
    is_outside.then(|| entry().map_or("", |entry| &entry.value))
}

/// A net may only name files that lie right beside it.
fn check_externals(model: &ModelProto, file: &OnnxFile) -> Result<(), EngineError> {
    for name in externals(model).into_iter().filter(|name| Some(OsStr::new(name)) != file.bytes.own_name()) {
        let mut parts = Path::new(name).components();
        let is_plain = matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None));
        let is_there = is_plain && file.folder.is_some_and(|folder| folder.join(name).is_file());
        if !is_there {
            return Err(EngineError::External { name: name.to_owned() });
        }
    }
    Ok(())
}

/// Names the operation that cannot be run, before tract gives up in the middle.
fn check_operators(onnx: &tract_onnx::Onnx, model: &ModelProto) -> Result<(), EngineError> {
    let nodes = model.graph.iter().flat_map(|graph| &graph.node);
    let unknown = nodes.into_iter().find(|node| !onnx.op_register.0.contains_key(&node.op_type));
    match unknown {
        Some(node) => Err(EngineError::Operator { name: full_name(&node.domain, &node.op_type) }),
        None => Ok(()),
    }
}

fn full_name(domain: &str, operator: &str) -> String {
    if domain.is_empty() { operator.to_owned() } else { format!("{domain}.{operator}") }
}

fn tensor_type(port: &ValueInfoProto) -> Option<&type_proto::Tensor> {
    match port.r#type.as_ref()?.value.as_ref()? {
        Value::TensorType(tensor) => Some(tensor),
    }
}
