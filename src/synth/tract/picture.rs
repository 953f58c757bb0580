//! The shape of the picture that a foreign net takes, read off its graph.

use tract_onnx::pb::{ModelProto, ValueInfoProto, tensor_shape_proto::dimension::Value, type_proto};

use super::{EngineError, OnnxBytes};

/// The shape of the first input, `[1, 3, h, w]` or `[1, h, w, 3]`: fixed sides as the file has them, free ones from
/// `size` (width, height).
///
/// # Errors
/// No ONNX model; no input with the four axes of a picture.
pub fn picture_shape(file: OnnxBytes, size: [usize; 2]) -> Result<Vec<usize>, EngineError> {
    let proto = file.decoded(&tract_onnx::onnx())?;
    let no_picture = || EngineError::Unsupported { detail: "its first input is no picture of four axes".to_owned() };
    let dims = first_input(&proto).map(dims).filter(|dims| dims.len() == 4).ok_or_else(no_picture)?;
    let channels_last = dims[3] == Some(3) && dims[1] != Some(3);
    let [width, height] = size;
    let free = if channels_last { [1, height, width, 3] } else { [1, 3, height, width] };
    Ok(dims.iter().zip(free).map(|(fixed, free)| fixed.unwrap_or(free)).collect())
}

/// The first input that is no weight: old files list their weights among the inputs.
fn first_input(model: &ModelProto) -> Option<&ValueInfoProto> {
    let graph = model.graph.as_ref()?;
    graph.input.iter().find(|input| graph.initializer.iter().all(|weights| weights.name != input.name))
}

/// The axes; `None` is an axis of any length.
fn dims(input: &ValueInfoProto) -> Vec<Option<usize>> {
    let Some(type_proto::Value::TensorType(tensor)) = input.r#type.as_ref().and_then(|kind| kind.value.as_ref()) else {
        return Vec::new();
    };
    let length = |value: &Option<Value>| match value {
        Some(Value::DimValue(n)) => usize::try_from(*n).ok().filter(|n| *n > 0),
        _ => None,
    };
    tensor.shape.iter().flat_map(|shape| &shape.dim).map(|dim| length(&dim.value)).collect()
}
