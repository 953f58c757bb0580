//! Nets in float16 as nets in float32: half precision is ten times slower here, and small numbers vanish in it.

use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::{GraphProto, TensorProto, ValueInfoProto, type_proto::Value};
use tract_onnx::prelude::f16;

use super::outside::{Narrow, Outside};

const HALF: i32 = DataType::Float16 as i32;
const FULL: i32 = DataType::Float as i32;

/// Turns weights, casts and the types of inputs and outputs into float32; `outside` hears of the weights in files.
pub(super) fn widen(graph: &mut GraphProto, outside: &mut Outside) {
    graph.initializer.iter_mut().for_each(|tensor| widen_tensor(tensor, outside));
    for node in &mut graph.node {
        let is_cast = node.op_type == "Cast";
        for attribute in &mut node.attribute {
            if is_cast && attribute.name == "to" && attribute.i == i64::from(HALF) {
                attribute.i = i64::from(FULL);
            }
            attribute.t.iter_mut().chain(&mut attribute.tensors).for_each(|tensor| widen_tensor(tensor, outside));
            attribute.g.iter_mut().chain(&mut attribute.graphs).for_each(|graph| widen(graph, outside));
        }
    }
    graph.input.iter_mut().chain(&mut graph.output).chain(&mut graph.value_info).for_each(widen_port);
}

fn widen_port(port: &mut ValueInfoProto) {
    if let Some(Value::TensorType(tensor)) = port.r#type.as_mut().and_then(|kind| kind.value.as_mut())
        && tensor.elem_type == HALF
    {
        tensor.elem_type = FULL;
    }
}

fn widen_tensor(tensor: &mut TensorProto, outside: &mut Outside) {
    if tensor.data_type != HALF {
        return;
    }
    tensor.data_type = FULL;
    if outside.notes(tensor, &Narrow::Halves) {
        return;
    }
    let packed = tensor.int32_data.iter().flat_map(|bits| f16::from_bits(*bits as u16).to_f32().to_le_bytes());
    tensor.raw_data = Narrow::Halves.widened(&tensor.raw_data);
    tensor.raw_data.extend(packed);
    tensor.int32_data.clear();
}
