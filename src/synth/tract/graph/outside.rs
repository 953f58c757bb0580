//! Weights that lie in files, read for tract one tensor at a time.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

use tract_onnx::data_resolver::ModelDataResolver;
use tract_onnx::pb::TensorProto;
use tract_onnx::prelude::*;
use tract_onnx::tract_core::internal::{bail, ensure};

use super::location;
use crate::synth::tract::op;

/// Reads weights; those in half precision are widened on the way.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(in crate::synth::tract) struct Outside {
    /// File names and offsets of the tensors in half precision.
    halves: BTreeSet<(String, usize)>,
}

impl Outside {
    /// Notes that a tensor in a file is in half precision; whether it lies in one.
    pub(super) fn is_half(&mut self, tensor: &TensorProto) -> bool {
        let Some(name) = location(tensor) else { return false };
        self.halves.insert((name.to_owned(), number(tensor, "offset").unwrap_or(0)));
        true
    }
}

/// A number that says where in a file a tensor lies.
fn number(tensor: &TensorProto, key: &str) -> Option<usize> {
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
        if !self.halves.contains(&(name.to_string_lossy().into_owned(), offset)) {
            to.resize(length, 0);
            file.read_exact(to)?;
            return Ok(());
        }
        let mut halves = vec![0; length];
        file.read_exact(&mut halves)?;
        to.reserve_exact(2 * length);
        to.extend(halves.as_chunks::<2>().0.iter().flat_map(|half| f16::from_le_bytes(*half).to_f32().to_le_bytes()));
        Ok(())
    }
}
