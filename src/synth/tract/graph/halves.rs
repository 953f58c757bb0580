//! Nets in float16 as nets in float32: half precision is ten times slower here, and small numbers vanish in it.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;

use tract_onnx::pb::tensor_proto::{DataLocation, DataType};
use tract_onnx::pb::{GraphProto, TensorProto, ValueInfoProto, type_proto::Value};
use tract_onnx::prelude::f16;

use super::location;
use crate::synth::tract::EngineError;

const HALF: i32 = DataType::Float16 as i32;
const FULL: i32 = DataType::Float as i32;

/// Turns weights, casts and the types of inputs and outputs into float32.
pub(super) fn widen(graph: &mut GraphProto, folder: Option<&Path>) -> Result<(), EngineError> {
    graph.initializer.iter_mut().try_for_each(|tensor| widen_tensor(tensor, folder))?;
    for node in &mut graph.node {
        let is_cast = node.op_type == "Cast";
        for attribute in &mut node.attribute {
            if is_cast && attribute.name == "to" && attribute.i == i64::from(HALF) {
                attribute.i = i64::from(FULL);
            }
            attribute.t.iter_mut().chain(&mut attribute.tensors).try_for_each(|t| widen_tensor(t, folder))?;
            attribute.g.iter_mut().chain(&mut attribute.graphs).try_for_each(|graph| widen(graph, folder))?;
        }
    }
    graph.input.iter_mut().chain(&mut graph.output).chain(&mut graph.value_info).for_each(widen_port);
    Ok(())
}

fn widen_port(port: &mut ValueInfoProto) {
    if let Some(Value::TensorType(tensor)) = port.r#type.as_mut().and_then(|kind| kind.value.as_mut())
        && tensor.elem_type == HALF
    {
        tensor.elem_type = FULL;
    }
}

fn widen_tensor(tensor: &mut TensorProto, folder: Option<&Path>) -> Result<(), EngineError> {
    if tensor.data_type != HALF {
        return Ok(());
    }
    if let Some(name) = location(tensor) {
        let missing = || EngineError::External { name: name.to_owned() };
        let path = folder.ok_or_else(missing)?.join(name);
        tensor.raw_data = outside(tensor, &path).map_err(|_unreadable| missing())?;
        tensor.data_location = Some(DataLocation::Default as i32);
        tensor.external_data.clear();
    }
    let halves = tensor.raw_data.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]));
    let packed = tensor.int32_data.iter().map(|bits| f16::from_bits(*bits as u16));
    tensor.raw_data = halves.chain(packed).flat_map(|half| half.to_f32().to_le_bytes()).collect();
    tensor.int32_data.clear();
    tensor.data_type = FULL;
    Ok(())
}

/// The bytes of a tensor that lie in another file.
fn outside(tensor: &TensorProto, path: &Path) -> io::Result<Vec<u8>> {
    let number = |key: &str| tensor.external_data.iter().find(|entry| entry.key == key)?.value.parse::<u64>().ok();
    let mut file = File::open(path)?;
    let whole = file.metadata()?.len();
    let start = number("offset").unwrap_or(0);
    let length = number("length").unwrap_or(whole.saturating_sub(start));
    if start.saturating_add(length) > whole {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    file.seek(SeekFrom::Start(start))?;
    let mut bytes = vec![0; length as usize];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}
