//! Small random nets as ONNX files with manifests, written for tests.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]
#![allow(dead_code, reason = "each test file uses its own part")]

use std::path::Path;

use prost::Message as _;
use sha2::{Digest, Sha256};
use tract_onnx::pb::{
    AttributeProto, GraphProto, ModelProto, NodeProto, OperatorSetIdProto, TensorProto, TensorShapeProto, TypeProto,
    ValueInfoProto, attribute_proto::AttributeType, tensor_proto::DataType, tensor_shape_proto, type_proto,
};

/// One convolution of 3×3 or 3×3×3 with edge padding, then ELU (all but the last layer) or tanh (the last).
#[derive(Clone)]
pub struct Layer {
    axes: usize,
    from: usize,
    to: usize,
    dilation: i64,
    nan: bool,
}

impl Layer {
    /// 3×3.
    pub fn conv2(from: usize, to: usize) -> Self {
        Self { axes: 2, from, to, dilation: 1, nan: false }
    }

    /// 3×3×3.
    pub fn conv3(from: usize, to: usize) -> Self {
        Self { axes: 3, ..Self::conv2(from, to) }
    }

    /// With this dilation.
    pub fn dilated(self, dilation: i64) -> Self {
        Self { dilation, ..self }
    }

    /// With one weight that is not a number.
    pub fn with_nan(self) -> Self {
        Self { nan: true, ..self }
    }

    fn weights(&self, seed: u64) -> Vec<f32> {
        let n = self.from * self.to * 3usize.pow(self.axes as u32);
        let scale = 1.5 / ((self.from * 3usize.pow(self.axes as u32)) as f32).sqrt();
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 40) as f32 / (1u64 << 23) as f32 - 1.0) * scale
        };
        let mut weights: Vec<f32> = (0..n).map(|_| next()).collect();
        weights[0] = if self.nan { f32::NAN } else { weights[0] };
        weights
    }
}

fn tensor(name: String, dims: &[usize], data_type: DataType, raw_data: Vec<u8>) -> TensorProto {
    let dims = dims.iter().map(|n| *n as i64).collect();
    TensorProto { name, dims, data_type: data_type as i32, raw_data, ..Default::default() }
}

fn ints(name: &str, ints: Vec<i64>) -> AttributeProto {
    AttributeProto { name: name.to_owned(), ints, r#type: AttributeType::Ints as i32, ..Default::default() }
}

fn node(op: &str, input: &[&str], output: &str, attribute: Vec<AttributeProto>) -> NodeProto {
    let input = input.iter().map(|name| (*name).to_owned()).collect();
    let (name, op_type) = (output.to_owned(), op.to_owned());
    NodeProto { output: vec![name.clone()], name, op_type, input, attribute, ..Default::default() }
}

fn value(name: &str, channels: usize, axes: usize) -> ValueInfoProto {
    use tensor_shape_proto::{Dimension, dimension::Value};
    let named = |axis: usize| Value::DimParam(format!("{name}_axis_{axis}"));
    let fixed = [Value::DimValue(1), Value::DimValue(channels as i64)].into_iter().chain((0..axes).map(named));
    let dim = fixed.map(|value| Dimension { value: Some(value), ..Default::default() }).collect();
    let tensor = type_proto::Tensor { elem_type: DataType::Float as i32, shape: Some(TensorShapeProto { dim }) };
    let r#type = TypeProto { value: Some(type_proto::Value::TensorType(tensor)), ..Default::default() };
    ValueInfoProto { name: name.to_owned(), r#type: Some(r#type), ..Default::default() }
}

/// The ONNX file of a chain of layers.
pub fn onnx(layers: &[Layer], seed: u64) -> Vec<u8> {
    let (mut nodes, mut tensors, mut at) = (Vec::new(), Vec::new(), "x".to_owned());
    for (i, layer) in layers.iter().enumerate() {
        let (pads, weights, conv) = (format!("p{i}"), format!("w{i}"), format!("conv{i}"));
        let side = |outer: i64| [0, 0].into_iter().chain((0..layer.axes).map(move |_| outer));
        let raw = side(layer.dilation).chain(side(layer.dilation)).flat_map(i64::to_le_bytes).collect();
        tensors.push(tensor(pads.clone(), &[2 * (layer.axes + 2)], DataType::Int64, raw));
        let shape: Vec<usize> = [layer.to, layer.from].into_iter().chain((0..layer.axes).map(|_| 3)).collect();
        let raw = layer.weights(seed + i as u64).iter().flat_map(|w| w.to_le_bytes()).collect();
        tensors.push(tensor(weights.clone(), &shape, DataType::Float, raw));
        let edge = AttributeProto {
            name: "mode".to_owned(),
            s: b"edge".to_vec(),
            r#type: AttributeType::String as i32,
            ..Default::default()
        };
        let padded = format!("padded{i}");
        nodes.push(node("Pad", &[&at, &pads], &padded, vec![edge]));
        let attributes =
            vec![ints("kernel_shape", vec![3; layer.axes]), ints("dilations", vec![layer.dilation; layer.axes])];
        nodes.push(node("Conv", &[&padded, &weights], &conv, attributes));
        let last = i + 1 == layers.len();
        at = if last { "y".to_owned() } else { format!("elu{i}") };
        nodes.push(node(if last { "Tanh" } else { "Elu" }, &[&conv], &at, vec![]));
    }
    let (first, last) = (&layers[0], &layers[layers.len() - 1]);
    model(nodes, tensors, value("x", first.from, first.axes), value("y", last.to, last.axes))
}

/// The ONNX file of a net that adds the mean of some numbers to one colour of the picture: so many zeros beside a one and a two,
/// which are made while it is read.
pub fn with_a_constant_of(zeros: i64) -> Vec<u8> {
    let raw = |numbers: &[i64]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    let tensors = vec![
        tensor("two".to_owned(), &[2], DataType::Float, [1.0_f32, 2.0].map(f32::to_le_bytes).concat()),
        tensor("zeros".to_owned(), &[2], DataType::Int64, raw(&[0, zeros])),
        tensor("w".to_owned(), &[1, 3, 1, 1], DataType::Float, [0.1_f32, -0.2, 0.1].map(f32::to_le_bytes).concat()),
    ];
    let nodes = vec![
        node("Pad", &["two", "zeros"], "numbers", vec![]),
        node("ReduceMean", &["numbers"], "mean", vec![ints("axes", vec![0])]),
        node("Conv", &["x", "w"], "colour", vec![ints("kernel_shape", vec![1, 1])]),
        node("Add", &["colour", "mean"], "y", vec![]),
    ];
    model(nodes, tensors, value("x", 3, 2), value("y", 1, 2))
}

/// The ONNX file of a graph with one input and one output.
fn model(node: Vec<NodeProto>, tensors: Vec<TensorProto>, input: ValueInfoProto, output: ValueInfoProto) -> Vec<u8> {
    let graph = GraphProto {
        name: "net".to_owned(),
        node,
        initializer: tensors,
        input: vec![input],
        output: vec![output],
        ..Default::default()
    };
    let opset = OperatorSetIdProto { version: 17, ..Default::default() };
    ModelProto { ir_version: 8, opset_import: vec![opset], graph: Some(graph), ..Default::default() }.encode_to_vec()
}

/// Writes a small model of a ray-depth or an occlusion net and its manifest into `folder/id`.
pub fn write_model(folder: &Path, id: &str, onnx: &[u8], task: &str) {
    let rest = "views = [8, 8]\ninputs = [\"rgb\"]\nworking_long_side = 32\nmultiple_of = 8\n";
    write_with_manifest(folder, id, onnx, task, rest);
}

/// Writes a model into `folder/id`, with a manifest that goes on with `rest`.
pub fn write_with_manifest(folder: &Path, id: &str, onnx: &[u8], task: &str, rest: &str) {
    let sha256: String = Sha256::digest(onnx).iter().map(|byte| format!("{byte:02x}")).collect();
    std::fs::create_dir_all(folder.join(id)).unwrap();
    std::fs::write(folder.join(id).join("model.onnx"), onnx).unwrap();
    let head = format!("id = \"{id}\"\ntask = \"{task}\"\nfile = \"model.onnx\"\nsha256 = \"{sha256}\"\n");
    std::fs::write(folder.join(id).join("manifest.toml"), head + rest).unwrap();
}

/// Writes a depth net of these layers as the model `depth`.
pub fn write_depth(folder: &Path, layers: &[Layer], seed: u64) {
    write_model(folder, "depth", &onnx(layers, seed), "ray-depth");
}

/// Writes a small depth net, a small occlusion net and the index that names them.
pub fn write_pair(folder: &Path, seed: u64) {
    write_depth(folder, &[Layer::conv2(3, 8), Layer::conv2(8, 64).dilated(2)], seed);
    let occlusion = onnx(&[Layer::conv3(4, 8), Layer::conv3(8, 3)], seed + 7);
    write_model(folder, "occlusion", &occlusion, "occlusion");
    std::fs::write(folder.join("models.toml"), "depth = \"depth\"\nocclusion = \"occlusion\"\n").unwrap();
}

fn floats(name: &str, dims: &[usize], values: &[f32]) -> TensorProto {
    tensor(name.to_owned(), dims, DataType::Float, values.iter().flat_map(|w| w.to_le_bytes()).collect())
}

/// Writes a relative-depth net as people export them today: colours normalised as for ImageNet, `[1, 3, H, W]` in
/// patches of 14×14, the answer `[1, H / 14, W / 14]`. Its nearness is what red has above one half.
pub fn write_patches(folder: &Path, id: &str) {
    const PATCH: usize = 14;
    let (mean, std) = (0.485, 0.229);
    let red = [std / (PATCH * PATCH) as f32; PATCH * PATCH];
    let weights = [&red[..], &[0.0; 2 * PATCH * PATCH]].concat();
    let tensors = vec![
        floats("weights", &[1, 3, PATCH, PATCH], &weights),
        floats("bias", &[1], &[mean - 0.5]),
        tensor("axis".to_owned(), &[1], DataType::Int64, 1i64.to_le_bytes().to_vec()),
    ];
    let steps = vec![ints("kernel_shape", vec![PATCH as i64; 2]), ints("strides", vec![PATCH as i64; 2])];
    let nodes = vec![
        node("Conv", &["x", "weights", "bias"], "patches", steps),
        node("Relu", &["patches"], "above", vec![]),
        node("Squeeze", &["above", "axis"], "y", vec![]),
    ];
    let onnx = model(nodes, tensors, value("x", 3, 2), value("y", 1, 2));
    let rules = "working_long_side = 224\nmultiple_of = 14\n\n[relative]\n\
        mean = [0.485, 0.456, 0.406]\nstd = [0.229, 0.224, 0.225]\n";
    write_with_manifest(folder, id, &onnx, "relative-depth", rules);
}

/// Writes a relative-depth net as others do: a fixed size, `[1, 32, 48, 3]`, blue first, the answer `[1, 32, 48, 1]` a
/// distance. It takes blue for far: 2 + 4 · blue metres.
pub fn write_metres(folder: &Path, id: &str) {
    let tensors = vec![floats("weights", &[1, 3, 1, 1], &[4.0, 0.0, 0.0]), floats("bias", &[1], &[2.0])];
    let nodes = vec![
        node("Transpose", &["x"], "planes", vec![ints("perm", vec![0, 3, 1, 2])]),
        node("Conv", &["planes", "weights", "bias"], "metres", vec![ints("kernel_shape", vec![1, 1])]),
        node("Transpose", &["metres"], "y", vec![ints("perm", vec![0, 2, 3, 1])]),
    ];
    let onnx = model(nodes, tensors, value("x", 32, 2), value("y", 32, 2));
    let rules = "[relative]\ninput_size = [48, 32]\norder = \"bgr\"\nlayout = \"nhwc\"\noutput = \"distance\"\n";
    write_with_manifest(folder, id, &onnx, "relative-depth", rules);
}
