//! Which outputs of a graph are wanted, and the numbers that stand for inputs other than the picture.

use std::collections::BTreeMap;

use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::tensor_shape_proto::dimension;
use tract_onnx::pb::{GraphProto, TensorProto, ValueInfoProto};

use super::super::error::EngineError;
use super::tensor_type;

/// What of a graph is connected.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wiring {
    /// Names of the wanted outputs, in the order in which they are answered; empty for the first alone.
    pub outputs: Vec<String>,
    /// Inputs other than the picture, and the number that each is given.
    pub numbers: BTreeMap<String, f64>,
}

impl Wiring {
    /// The first output, and no input but the picture.
    pub const FIRST: Self = Self { outputs: Vec::new(), numbers: BTreeMap::new() };
}

/// Leaves the picture as the only input, and the wanted outputs alone.
pub(super) fn connect(graph: &mut GraphProto, wiring: &Wiring) -> Result<(), EngineError> {
    // Older files list their weights among the inputs.
    let weights: Vec<String> = graph.initializer.iter().map(|tensor| tensor.name.clone()).collect();
    graph.input.retain(|input| !weights.contains(&input.name));
    for (name, number) in &wiring.numbers {
        let Some(at) = graph.input.iter().position(|input| input.name == *name) else {
            return Err(EngineError::NoPort { what: "input", name: name.clone(), known: names(&graph.input) });
        };
        let input = graph.input.remove(at);
        graph.initializer.push(constant(&input, *number)?);
    }
    if graph.input.len() != 1 {
        return Err(EngineError::Inputs { names: names(&graph.input) });
    }
    let wanted = match &wiring.outputs[..] {
        [] => graph.output.iter().take(1).map(|output| output.name.clone()).collect(),
        names => names.to_vec(),
    };
    let find = |name: &String| {
        let found = graph.output.iter().find(|output| output.name == *name).cloned();
        found.ok_or_else(|| EngineError::NoPort { what: "output", name: name.clone(), known: names(&graph.output) })
    };
    graph.output = wanted.iter().map(find).collect::<Result<_, _>>()?;
    Ok(())
}

fn names(ports: &[ValueInfoProto]) -> String {
    ports.iter().map(|port| port.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// One number in the type and the shape of an input; axes of unknown length have one element.
fn constant(input: &ValueInfoProto, number: f64) -> Result<TensorProto, EngineError> {
    let odd = |why: &str| EngineError::Input { name: input.name.clone(), why: why.to_owned() };
    let tensor = tensor_type(input).ok_or_else(|| odd("it is no tensor"))?;
    let dims: Vec<i64> = tensor.shape.iter().flat_map(|shape| &shape.dim).map(|dim| length(&dim.value)).collect();
    let raw_data = match DataType::try_from(tensor.elem_type) {
        Ok(DataType::Int64) => (number as i64).to_le_bytes().to_vec(),
        Ok(DataType::Int32) => (number as i32).to_le_bytes().to_vec(),
        Ok(DataType::Float) => (number as f32).to_le_bytes().to_vec(),
        Ok(DataType::Double) => number.to_le_bytes().to_vec(),
        Ok(DataType::Bool) => vec![u8::from(number != 0.0)],
        _ => return Err(odd("its type is no number")),
    };
    if dims.iter().product::<i64>() != 1 {
        return Err(odd("it is more than one number"));
    }
    Ok(TensorProto { name: input.name.clone(), data_type: tensor.elem_type, dims, raw_data, ..TensorProto::default() })
}

fn length(value: &Option<dimension::Value>) -> i64 {
    match value {
        Some(dimension::Value::DimValue(length)) => *length,
        _ => 1,
    }
}
