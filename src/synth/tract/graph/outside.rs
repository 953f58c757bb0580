//! Weights that lie in files, read for tract one tensor at a time.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

use tract_onnx::data_resolver::ModelDataResolver;
use tract_onnx::pb::TensorProto;
use tract_onnx::prelude::*;
use tract_onnx::tract_core::internal::{bail, ensure};

use super::location;
use crate::synth::tract::op;

/// Reads weights; those that are narrower than f32 are widened on the way.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::synth::tract) struct Outside {
    /// How tensors are kept that are no f32, by file name and offset.
    narrow: BTreeMap<(String, usize), Narrow>,
}

/// How weights are kept that are narrower than f32.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Narrow {
    /// In half precision.
    Halves,
    /// In bytes; so many follow each other with the same step.
    Bytes { steps: Vec<f32>, each: usize },
}

impl Narrow {
    /// How many bytes stand for one number.
    fn width(&self) -> usize {
        match self {
            Self::Halves => 2,
            Self::Bytes { .. } => 1,
        }
    }

    /// The same numbers as f32, little-endian.
    pub(super) fn widened(&self, kept: &[u8]) -> Vec<u8> {
        let mut wide = Vec::with_capacity(kept.len() / self.width() * size_of::<f32>());
        let mut put = |value: f32| wide.extend(value.to_le_bytes());
        match self {
            Self::Halves => kept.as_chunks().0.iter().for_each(|half| put(f16::from_le_bytes(*half).to_f32())),
            Self::Bytes { steps, each } => {
                for (of_step, step) in kept.chunks_exact((*each).max(1)).zip(steps.iter().cycle()) {
                    of_step.iter().for_each(|&byte| put(f32::from(byte as i8) * step));
                }
            }
        }
        wide
    }
}

impl Outside {
    /// Notes how a tensor in a file is kept; whether it lies in one.
    pub(super) fn notes(&mut self, tensor: &TensorProto, narrow: &Narrow) -> bool {
        let Some(name) = location(tensor) else { return false };
        self.narrow.insert((name.to_owned(), number(tensor, "offset").unwrap_or(0)), narrow.clone());
        true
    }
}

/// A number that says where in a file a tensor lies.
pub(super) fn number(tensor: &TensorProto, key: &str) -> Option<usize> {
    tensor.external_data.iter().find(|entry| entry.key == key)?.value.parse().ok()
}

impl ModelDataResolver for Outside {
    fn read_bytes_from_path(
        &self,
        to: &mut Vec<u8>,
        path: &Path,
        offset: usize,
        length: Option<usize>,
    ) -> TractResult<()> {
        op::stop()?;
        let mut file = File::open(path)?;
        let whole = usize::try_from(file.metadata()?.len())?;
        let length = length.unwrap_or_else(|| whole.saturating_sub(offset));
        ensure!(offset.checked_add(length).is_some_and(|end| end <= whole), "weights beyond the end of {path:?}");
        file.seek(SeekFrom::Start(offset as u64))?;
        let Some(name) = path.file_name() else { bail!("no file: {path:?}") };
        let mut kept = vec![0; length];
        file.read_exact(&mut kept)?;
        *to = match self.narrow.get(&(name.to_string_lossy().into_owned(), offset)) {
            Some(narrow) => narrow.widened(&kept),
            None => kept,
        };
        Ok(())
    }
}
