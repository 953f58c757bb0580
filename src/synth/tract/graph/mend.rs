//! What exporters wrote that tract does not know, in the words that it knows.

use tract_onnx::pb::attribute_proto::AttributeType;
use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::{AttributeProto, GraphProto, ModelProto, NodeProto, TensorProto};

/// Rewrites what can be rewritten; what cannot stays as it is.
pub(super) fn all(model: &mut ModelProto) {
    let version = model.opset_import.iter_mut().find(|opset| opset.domain.is_empty() || opset.domain == "ai.onnx");
    let Some(graph) = &mut model.graph else { return };
    if let Some(opset) = version.filter(|opset| opset.version < 10)
        && graph.node.iter().any(|node| node.op_type == "Upsample")
    {
        opset.version = 10;
        upsample_to_resize(graph);
    }
    batch_norm_of_one(graph);
}

/// `Upsample` (opsets 7 to 9) is `Resize` of opset 10; there `Slice` takes its bounds as inputs.
fn upsample_to_resize(graph: &mut GraphProto) {
    let mut constants = Vec::new();
    for (i, node) in graph.node.iter_mut().enumerate() {
        let mut input = |of: &str, tensor: TensorProto, node: &mut NodeProto| {
            let name = format!("plenoscope.{of}.{i}");
            node.input.push(name.clone());
            constants.push(TensorProto { name, ..tensor });
        };
        match node.op_type.as_str() {
            "Upsample" => {
                "Resize".clone_into(&mut node.op_type);
                if let Some(scales) = take(node, "scales") {
                    input("scales", floats(&scales.floats), node);
                }
            }
            "Slice" if node.input.len() == 1 => {
                let [starts, ends, axes] = ["starts", "ends", "axes"].map(|name| take(node, name).map(|a| a.ints));
                let starts = starts.unwrap_or_default();
                // Without axes they are the first ones.
                let axes = axes.unwrap_or_else(|| (0..starts.len() as i64).collect());
                input("starts", integers(&starts), node);
                input("ends", integers(&ends.unwrap_or_default()), node);
                input("axes", integers(&axes), node);
            }
            _ => {}
        }
    }
    graph.initializer.extend(constants);
}

/// Weight standardisation is exported as batch normalisation in training mode over a batch of one: that is what
/// instance normalisation does, by its own numbers and without a memory.
fn batch_norm_of_one(graph: &mut GraphProto) {
    for node in graph.node.iter_mut().filter(|node| node.op_type == "BatchNormalization") {
        let is_training = node.attribute.iter().any(|a| a.name == "training_mode" && a.i == 1);
        if is_training && node.input.len() >= 3 {
            "InstanceNormalization".clone_into(&mut node.op_type);
            node.input.truncate(3);
            node.output.truncate(1);
            node.attribute.retain(|attribute| attribute.name == "epsilon");
            if node.attribute.is_empty() {
                let epsilon = AttributeProto { name: "epsilon".to_owned(), f: 1e-5, ..AttributeProto::default() };
                node.attribute.push(AttributeProto { r#type: AttributeType::Float as i32, ..epsilon });
            }
        }
    }
}

fn take(node: &mut NodeProto, name: &str) -> Option<AttributeProto> {
    let at = node.attribute.iter().position(|attribute| attribute.name == name)?;
    Some(node.attribute.remove(at))
}

fn floats(values: &[f32]) -> TensorProto {
    let (dims, float_data) = (vec![values.len() as i64], values.to_vec());
    TensorProto { dims, float_data, data_type: DataType::Float as i32, ..TensorProto::default() }
}

fn integers(values: &[i64]) -> TensorProto {
    let (dims, int64_data) = (vec![values.len() as i64], values.to_vec());
    TensorProto { dims, int64_data, data_type: DataType::Int64 as i32, ..TensorProto::default() }
}
