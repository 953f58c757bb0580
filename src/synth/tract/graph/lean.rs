//! An ONNX file without its weights: they stay in the file until tract asks for them, one tensor at a time.
//!
//! Read whole, weights would be in memory three times at once: as the file, as its decoded graph and as tract's tensors.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use prost::Message as _;
use tract_onnx::pb::tensor_proto::{DataLocation, DataType};
use tract_onnx::pb::{ModelProto, StringStringEntryProto, TensorProto};

use crate::synth::tract::EngineError;

/// Weights of fewer bytes stay in the graph.
const LARGE_BYTES: u64 = 64 << 10;
/// Bytes of weights that are looked at together; whole numbers of every type.
const PIECE_BYTES: usize = 1 << 20;

/// Decodes a file; its large weights are marked as lying in an external file, which is this one.
///
/// # Errors
/// [`EngineError::Parse`]; [`EngineError::NotFinite`] for a large weight that is NaN or infinite.
pub(super) fn decode(path: &Path) -> Result<ModelProto, EngineError> {
    let damaged = |detail: String| EngineError::Parse { detail };
    let open = || {
        let file = File::open(path)?;
        let end = file.metadata()?.len();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        io::Result::Ok(Lean { from: BufReader::new(file), at: 0, end, name, odd: None })
    };
    let mut lean = open().map_err(|error| damaged(error.to_string()))?;
    let mut bytes = Vec::new();
    lean.message(lean.end, Level::Model, &mut bytes).map_err(|error| damaged(error.to_string()))?;
    if let Some(name) = lean.odd {
        return Err(EngineError::NotFinite { name });
    }
    ModelProto::decode(&bytes[..]).map_err(|error| damaged(error.to_string()))
}

/// The field of a tensor that says whether its values lie in another file.
const DATA_LOCATION: u64 = 14;

/// A message that weights may lie in.
#[derive(Clone, Copy, PartialEq)]
enum Level {
    Model,
    Graph,
    Tensor,
    /// The bytes of a tensor.
    Values,
}

impl Level {
    /// What a field of this message holds; none where it is copied as it is.
    fn inside(self, field: u64) -> Option<Self> {
        match (self, field) {
            (Self::Model, 7) => Some(Self::Graph),
            (Self::Graph, 5) => Some(Self::Tensor),
            (Self::Tensor, 9) => Some(Self::Values),
            _ => None,
        }
    }
}

/// A file in the form of protocol buffers that is copied without its weights.
struct Lean {
    from: BufReader<File>,
    /// Bytes that were read.
    at: u64,
    end: u64,
    /// The file's name.
    name: String,
    /// The first weights with values that are no numbers.
    odd: Option<String>,
}

impl Lean {
    /// Copies a message of `len` bytes.
    fn message(&mut self, len: u64, level: Level, to: &mut Vec<u8>) -> io::Result<()> {
        let end = self.at + len;
        while self.at < end {
            let key = self.varint()?;
            match (key & 7, level.inside(key >> 3)) {
                (0, _) => {
                    let value = self.varint()?;
                    // "Here", said behind weights that were left in the file, would take back where they are.
                    if level != Level::Tensor || key >> 3 != DATA_LOCATION || value != DataLocation::Default as u64 {
                        put(to, key, value);
                    }
                }
                (1, _) => {
                    varint(to, key);
                    self.copy(8, to)?;
                }
                (5, _) => {
                    varint(to, key);
                    self.copy(4, to)?;
                }
                (2, inside) => {
                    let len = self.varint()?;
                    if len > end.saturating_sub(self.at) {
                        return Err(io::ErrorKind::UnexpectedEof.into());
                    }
                    self.bytes(key, len, inside, to)?;
                }
                _ => return Err(io::ErrorKind::InvalidData.into()),
            }
        }
        if self.at == end { Ok(()) } else { Err(io::ErrorKind::InvalidData.into()) }
    }

    /// Copies a field of `len` bytes.
    fn bytes(&mut self, key: u64, len: u64, inside: Option<Level>, to: &mut Vec<u8>) -> io::Result<()> {
        match inside {
            Some(Level::Values) if len >= LARGE_BYTES => self.leave(len, to),
            Some(level) if level != Level::Values => {
                let mut message = Vec::new();
                self.message(len, level, &mut message)?;
                put(to, key, message.len() as u64);
                to.extend(message);
                Ok(())
            }
            _ => {
                put(to, key, len);
                self.copy(len, to)
            }
        }
    }

    /// Leaves the values of a tensor in the file; `tensor` is what of it came before.
    fn leave(&mut self, len: u64, tensor: &mut Vec<u8>) -> io::Result<()> {
        let entry = |key: &str, value: String| StringStringEntryProto { key: key.to_owned(), value };
        let before = TensorProto::decode(&tensor[..]).map_err(io::Error::other)?;
        let external_data = vec![
            entry("location", self.name.clone()),
            entry("offset", self.at.to_string()),
            entry("length", len.to_string()),
        ];
        let data_location = Some(DataLocation::External as i32);
        TensorProto { external_data, data_location, ..TensorProto::default() }.encode(tensor)?;
        let is_float = before.data_type == DataType::Float as i32;
        if !self.are_finite(len, is_float)? && self.odd.is_none() {
            self.odd = Some(before.name);
        }
        Ok(())
    }

    /// Goes past `len` bytes; whether they are finite numbers.
    fn are_finite(&mut self, len: u64, is_float: bool) -> io::Result<bool> {
        let mut piece = vec![0; PIECE_BYTES];
        let (mut left, mut finite) = (len, true);
        while left > 0 {
            let piece = &mut piece[..usize::try_from(left).unwrap_or(PIECE_BYTES).min(PIECE_BYTES)];
            self.from.read_exact(piece)?;
            let floats = piece.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
            finite &= !is_float || floats.fold(true, |all, value| all & value.is_finite());
            left -= piece.len() as u64;
        }
        self.at += len;
        Ok(finite)
    }

    fn copy(&mut self, len: u64, to: &mut Vec<u8>) -> io::Result<()> {
        if len > self.end.saturating_sub(self.at) || self.from.by_ref().take(len).read_to_end(to)? as u64 != len {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        self.at += len;
        Ok(())
    }

    fn varint(&mut self) -> io::Result<u64> {
        let mut value = 0u64;
        for shift in (0..64).step_by(7) {
            let mut byte = [0];
            self.from.read_exact(&mut byte)?;
            self.at += 1;
            value |= u64::from(byte[0] & 127) << shift;
            if byte[0] < 128 {
                return Ok(value);
            }
        }
        Err(io::ErrorKind::InvalidData.into())
    }
}

/// A key, and a number or a length.
fn put(to: &mut Vec<u8>, key: u64, value: u64) {
    varint(to, key);
    varint(to, value);
}

fn varint(to: &mut Vec<u8>, mut value: u64) {
    while value >= 128 {
        to.push(value as u8 | 128);
        value >>= 7;
    }
    to.push(value as u8);
}
