//! The signs that families of depth nets are told by, read from the graph without running it.

use std::collections::{BTreeSet, HashMap};

use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::tensor_shape_proto::dimension;
use tract_onnx::pb::{GraphProto, ModelProto, NodeProto, TensorProto, ValueInfoProto};

use super::{externals, floats, tensor_type};

/// What a net says of itself without being run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signs {
    /// Inputs that are no weights.
    pub inputs: Vec<Port>,
    /// Outputs.
    pub outputs: Vec<Port>,
    /// Names of all operations.
    pub operators: BTreeSet<String>,
    /// Side of the patches that the first convolution cuts the picture into, and how many numbers each becomes: a
    /// vision transformer's.
    pub patch: Option<[usize; 2]>,
    /// The normalisation of colours that the net does by itself.
    pub normalises: Option<Scale>,
    /// Operations before the first output, last first, with the number that each takes where it is one.
    pub end: Vec<(String, Option<f32>)>,
    /// Names of further files with weights, beside the net's.
    pub files: Vec<String>,
}

/// An input or an output.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// Lengths of its axes; none where any length goes.
    pub dims: Vec<Option<usize>>,
    /// Whether it holds fractions (and no whole numbers).
    pub is_float: bool,
}

/// The numbers that black and white are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// 0 and 1.
    Unit,
    /// 0 and 255.
    Bytes,
}

/// How far back from an output the operations are told.
const END: usize = 8;

impl Signs {
    pub(super) fn of(model: &ModelProto, graph: &GraphProto) -> Self {
        let known = Known::of(graph);
        let is_weight = |port: &&ValueInfoProto| !known.weights.contains_key(port.name.as_str());
        let inputs: Vec<Port> = graph.input.iter().filter(is_weight).map(Port::of).collect();
        let picture = inputs.iter().find(|port| port.is_picture()).map_or("", |port| port.name.as_str());
        Self {
            operators: graph.node.iter().map(|node| node.op_type.clone()).collect(),
            patch: patch(graph, &known),
            normalises: normalises(graph, &known, picture),
            end: graph.output.first().map(|output| known.end(&output.name)).unwrap_or_default(),
            files: externals(model).into_iter().map(str::to_owned).collect(),
            outputs: graph.output.iter().map(Port::of).collect(),
            inputs,
        }
    }

    /// Inputs that can take a picture.
    pub fn pictures(&self) -> impl Iterator<Item = &Port> {
        self.inputs.iter().filter(|port| port.is_picture())
    }

    /// Whether there is an output of this name.
    pub fn answers(&self, name: &str) -> bool {
        self.outputs.iter().any(|port| port.name == name)
    }
}

impl Port {
    fn of(info: &ValueInfoProto) -> Self {
        let tensor = tensor_type(info);
        let length = |dim: &Option<dimension::Value>| match dim {
            Some(dimension::Value::DimValue(n)) => usize::try_from(*n).ok().filter(|n| *n > 0),
            _ => None,
        };
        let floats = [DataType::Float, DataType::Float16, DataType::Double].map(|kind| kind as i32);
        Self {
            name: info.name.clone(),
            dims: tensor
                .and_then(|t| t.shape.as_ref())
                .map_or(Vec::new(), |shape| shape.dim.iter().map(|dim| length(&dim.value)).collect()),
            is_float: tensor.is_some_and(|tensor| floats.contains(&tensor.elem_type)),
        }
    }

    /// Whether it is `[1, 3, H, W]`, `[1, H, W, 3]` or `[1, views, 3, H, W]`, as far as its axes are known.
    pub fn is_picture(&self) -> bool {
        let may_be = |at: usize, length: usize| self.dims[at].is_none_or(|n| n == length);
        self.is_float
            && match self.dims.len() {
                4 => may_be(0, 1) && (may_be(1, 3) || may_be(3, 3)),
                5 => may_be(0, 1) && may_be(1, 1) && may_be(2, 3),
                _ => false,
            }
    }
}

/// Constants and makers of a graph's values, by name.
struct Known<'a> {
    weights: HashMap<&'a str, &'a TensorProto>,
    makers: HashMap<&'a str, &'a NodeProto>,
}

impl<'a> Known<'a> {
    fn of(graph: &'a GraphProto) -> Self {
        let constants = graph.node.iter().filter(|node| node.op_type == "Constant");
        let constants = constants.filter_map(|node| {
            let value = node.attribute.iter().find(|attribute| attribute.name == "value")?;
            Some((node.output.first()?.as_str(), value.t.as_ref()?))
        });
        let makers = graph.node.iter().flat_map(|node| node.output.iter().map(move |name| (name.as_str(), node)));
        let weights = graph.initializer.iter().map(|tensor| (tensor.name.as_str(), tensor)).chain(constants);
        Self { weights: weights.collect(), makers: makers.collect() }
    }

    /// The few numbers of a small constant.
    fn numbers(&self, name: &str) -> Option<Vec<f32>> {
        let tensor = self.weights.get(name)?;
        let count: i64 = tensor.dims.iter().product();
        if count > 16 { None } else { Some(floats(tensor)?.collect()) }
    }

    /// The constant that an operation takes beside a value that is made.
    fn constant(&self, node: &NodeProto) -> Option<Vec<f32>> {
        node.input.iter().find_map(|name| self.numbers(name))
    }

    /// Operations before a value, last first, along the first input that is made.
    fn end(&self, name: &str) -> Vec<(String, Option<f32>)> {
        let mut operations = Vec::new();
        let mut at = name;
        while let Some(node) = self.makers.get(at).filter(|_| operations.len() < END) {
            let number = self.constant(node).filter(|numbers| numbers.len() == 1);
            operations.push((node.op_type.clone(), number.map(|numbers| numbers[0])));
            match node.input.iter().find(|input| self.makers.contains_key(input.as_str())) {
                Some(input) => at = input,
                None => break,
            }
        }
        operations
    }
}

/// Side and width of the patches of the first convolution that does not overlap itself.
fn patch(graph: &GraphProto, known: &Known) -> Option<[usize; 2]> {
    let conv = graph.node.iter().find(|node| node.op_type.starts_with("Conv"))?;
    let ints = |name: &str| conv.attribute.iter().find(|a| a.name == name).map(|a| a.ints.clone());
    let (kernel, strides) = (ints("kernel_shape")?, ints("strides")?);
    let weights = conv.input.get(1).and_then(|name| known.weights.get(name.as_str()));
    let width = weights.and_then(|tensor| tensor.dims.first()).copied().unwrap_or(0);
    let is_patch = kernel.len() == 2 && kernel == strides && kernel[0] >= 8;
    is_patch.then_some([kernel[0] as usize, width as usize])
}

/// Whether mean and deviation are taken off straight after the input, and of which numbers.
fn normalises(graph: &GraphProto, known: &Known, input: &str) -> Option<Scale> {
    let mut at = input;
    let mut scale = Scale::Unit;
    for _ in 0..4 {
        let node = graph.node.iter().find(|node| node.input.iter().any(|name| name == at))?;
        let constant = known.constant(node);
        match (node.op_type.as_str(), constant.as_deref()) {
            ("Sub" | "Add", Some(mean)) => {
                let is_bytes = mean.iter().any(|m| m.abs() > 1.5);
                return Some(if is_bytes { Scale::Bytes } else { scale });
            }
            ("Div", Some([by])) if *by > 100.0 => scale = Scale::Bytes,
            ("Mul", Some([by])) if *by < 0.01 => scale = Scale::Bytes,
            ("Cast" | "Transpose" | "Identity" | "Unsqueeze", _) => {}
            _ => return None,
        }
        at = node.output.first()?;
    }
    None
}
