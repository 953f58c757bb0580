//! Small nets, written here, through the engine.

mod foreign;

use prost::Message as _;
use tract_onnx::pb::*;
use tract_onnx::pb::{attribute_proto::AttributeType, tensor_proto::DataType};

use super::*;
use crate::kernel::numbers;
use crate::kernel::winograd::{Columns, Rows};

fn value(name: &str, shape: &[i64]) -> ValueInfoProto {
    use tensor_shape_proto::{Dimension, dimension::Value};
    let dim = shape
        .iter()
        .map(|&n| Dimension {
            value: Some(if n < 0 { Value::DimParam(format!("d{}", -n)) } else { Value::DimValue(n) }),
            ..Default::default()
        })
        .collect();
    let tensor = type_proto::Tensor { elem_type: DataType::Float as i32, shape: Some(TensorShapeProto { dim }) };
    let r#type = TypeProto { value: Some(type_proto::Value::TensorType(tensor)), ..Default::default() };
    ValueInfoProto { name: name.into(), r#type: Some(r#type), ..Default::default() }
}

fn floats(name: &str, dims: &[i64], values: &[f32]) -> TensorProto {
    let raw_data = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    TensorProto {
        name: name.into(),
        dims: dims.to_vec(),
        data_type: DataType::Float as i32,
        raw_data,
        ..Default::default()
    }
}

fn ints(name: &str, values: &[i64]) -> AttributeProto {
    AttributeProto {
        name: name.into(),
        ints: values.to_vec(),
        r#type: AttributeType::Ints as i32,
        ..Default::default()
    }
}

fn node(op: &str, inputs: &[&str], output: &str, attribute: Vec<AttributeProto>) -> NodeProto {
    let input = inputs.iter().map(|&s| s.into()).collect();
    NodeProto {
        name: output.into(),
        op_type: op.into(),
        input,
        output: vec![output.into()],
        attribute,
        ..Default::default()
    }
}

fn model(node: Vec<NodeProto>, initializer: Vec<TensorProto>, input: &[i64], output: &[i64]) -> Vec<u8> {
    let graph = GraphProto {
        name: "net".into(),
        node,
        initializer,
        input: vec![value("x", input)],
        output: vec![value("y", output)],
        ..Default::default()
    };
    let opset_import = vec![OperatorSetIdProto { domain: String::new(), version: 17 }];
    ModelProto { ir_version: 8, opset_import, graph: Some(graph), ..Default::default() }.encode_to_vec()
}

/// One 3×3 convolution of a one-channel picture by `weights`, zero padding.
fn one_convolution(weights: &[f32]) -> Vec<u8> {
    let conv = node("Conv", &["x", "w"], "y", vec![ints("pads", &[1; 4])]);
    model(vec![conv], vec![floats("w", &[1, 1, 3, 3], weights)], &[1, 1, -1, -2], &[1, 1, -1, -2])
}

fn integers(name: &str, values: &[i64]) -> TensorProto {
    let raw_data = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let dims = vec![values.len() as i64];
    TensorProto { name: name.into(), dims, data_type: DataType::Int64 as i32, raw_data, ..Default::default() }
}

fn text(name: &str, value: &str) -> AttributeProto {
    let r#type = AttributeType::String as i32;
    AttributeProto { name: name.into(), s: value.into(), r#type, ..Default::default() }
}

/// A net that is written down node by node.
#[derive(Clone, Default)]
struct Net {
    nodes: Vec<NodeProto>,
    tensors: Vec<TensorProto>,
    /// Name of the value that the next node reads.
    last: String,
    channels: usize,
    rank: usize,
}

impl Net {
    fn new(channels: usize, rank: usize) -> Self {
        Self { last: "x".into(), channels, rank, ..Self::default() }
    }

    fn then(mut self, op: &str, more_inputs: &[&str], attributes: Vec<AttributeProto>) -> Self {
        let output = format!("{op}{}", self.nodes.len());
        let inputs: Vec<&str> = std::iter::once(self.last.as_str()).chain(more_inputs.iter().copied()).collect();
        self.nodes.push(node(op, &inputs, &output, attributes));
        self.last = output;
        self
    }

    /// Padding by itself, as many on either side as the axis of `amounts` says.
    fn pad(mut self, mode: &str, amounts: &[i64]) -> Self {
        let name = format!("pads{}", self.nodes.len());
        let one_side = [&[0, 0], amounts].concat();
        self.tensors.push(integers(&name, &[one_side.clone(), one_side].concat()));
        self.then("Pad", &[&name], vec![text("mode", mode)])
    }

    fn conv(mut self, channels: usize, dilation: i64, pads: i64, bias: bool) -> Self {
        let (weights, biases) = (format!("w{}", self.nodes.len()), format!("b{}", self.nodes.len()));
        let taps = 3usize.pow(self.rank as u32);
        let mut dims = vec![channels as i64, self.channels as i64];
        dims.resize(2 + self.rank, 3);
        let seed = self.nodes.len() as u64 + 17;
        let scale = (3.0 / (self.channels * taps) as f32).sqrt();
        let values: Vec<f32> = numbers(seed, channels * self.channels * taps).iter().map(|v| v * scale).collect();
        self.tensors.push(floats(&weights, &dims, &values));
        self.tensors.push(floats(&biases, &[channels as i64], &numbers(seed + 1, channels)));
        self.channels = channels;
        let mut dilations = vec![dilation; self.rank];
        let mut pads = vec![pads; self.rank];
        if self.rank == 3 {
            (dilations[0], pads[0]) = (1, pads[0].min(1));
        }
        let attributes = vec![ints("dilations", &dilations), ints("pads", &[pads.clone(), pads].concat())];
        let inputs = [weights.as_str(), biases.as_str()];
        self.then("Conv", if bias { &inputs } else { &inputs[..1] }, attributes)
    }

    fn finish(mut self, inputs: usize) -> Vec<u8> {
        if let Some(last) = self.nodes.last_mut() {
            last.output = vec!["y".into()];
        }
        let shape = |channels: usize| {
            let mut shape = vec![1, channels as i64];
            shape.extend((1..=self.rank as i64).map(|axis| -axis));
            shape
        };
        let (input, output) = (shape(inputs), shape(self.channels));
        model(self.nodes, self.tensors, &input, &output)
    }
}

/// Runs `net` on every path and compares with tract's own; `direct` convolutions are to be the kernel's.
fn assert_paths_agree(net: &[u8], shape: &[usize], direct: usize) {
    let input = numbers(5, shape.iter().product());
    let run = |path, exact| {
        let net = prepare(net, shape, &Options { path, exact, threads: 2, ..Options::default() }).unwrap();
        let answer = net.run(&input, &Cancel::default()).unwrap();
        (net.direct_convolutions(), answer)
    };
    let (_, stock) = run(Path::Stock, true);
    for path in [Path::Auto, Path::Avx512, Path::Avx2, Path::Portable] {
        for (exact, most) in [(true, 1e-5), (false, 5e-5)] {
            let (count, answer) = run(path, exact);
            assert_eq!(count, direct, "{path:?}: convolutions that were replaced");
            assert_eq!(answer.shape(), stock.shape());
            for (i, (a, b)) in answer.iter().zip(&stock[..]).enumerate() {
                assert!((a - b).abs() <= most, "{path:?} {exact} {shape:?}: value {i} is {a}, not {b}");
            }
        }
    }
}

#[test]
fn a_depth_net_with_edge_padding_is_all_direct() {
    let net = Net::new(5, 2).pad("edge", &[1, 1]).conv(16, 1, 0, true).then("Elu", &[], vec![]);
    let net = net.pad("edge", &[4, 4]).conv(21, 4, 0, true).then("Elu", &[], vec![]);
    let mut net = net.pad("edge", &[1, 1]).conv(4, 1, 0, true).then("Tanh", &[], vec![]);
    net.tensors.push(floats("scale", &[], &[4.0]));
    let net = net.then("Mul", &["scale"], vec![]).finish(5);
    for [height, width] in [[1, 1], [3, 2], [17, 53], [12, 16]] {
        assert_paths_agree(&net, &[1, 5, height, width], 3);
    }
}

#[test]
fn an_occlusion_net_over_views_is_all_direct() {
    for padding in ["edge", "constant"] {
        let net = Net::new(4, 3).pad(padding, &[1, 1, 1]).conv(8, 1, 0, true).then("Elu", &[], vec![]);
        let net = net.conv(3, 1, 1, false).then("Tanh", &[], vec![]).finish(4);
        for [views, height, width] in [[1, 1, 1], [6, 5, 9], [9, 8, 33]] {
            assert_paths_agree(&net, &[1, 4, views, height, width], 2);
        }
    }
}

#[test]
fn layers_of_many_channels_become_a_chain() {
    for padding in ["edge", "constant"] {
        let net = Net::new(3, 2).pad(padding, &[1, 1]).conv(16, 1, 0, true).then("Elu", &[], vec![]);
        let net = net.pad(padding, &[2, 2]).conv(64, 2, 0, true).then("Elu", &[], vec![]);
        let net = net.pad(padding, &[8, 8]).conv(64, 8, 0, true).then("Elu", &[], vec![]);
        let net = net.conv(5, 1, 1, false).finish(3);
        let shape = [1, 3, 81, 113];
        assert_paths_agree(&net, &shape, 4);
        let ready = |exact| prepare(&net, &shape, &Options { exact, ..Options::default() }).unwrap();
        let nodes = |exact| ready(exact).plan.model().nodes().len();
        assert!(nodes(false) < nodes(true), "nothing was fused");
        assert_eq!(ready(false).flop(), ready(true).flop());
    }
}

#[test]
fn results_that_are_alike_are_computed_once() {
    let net = Net::new(16, 2).pad("edge", &[1, 1]).conv(16, 1, 0, true).then("Elu", &[], vec![]);
    let mut net = net.pad("edge", &[1, 1]).conv(6, 1, 0, true).then("Tanh", &[], vec![]);
    let last = net.tensors.len() - 2;
    for tensor in &mut net.tensors[last..] {
        let row = tensor.raw_data.len() / 6;
        tensor.raw_data = tensor.raw_data[..row].repeat(6);
    }
    let mut other = net.clone();
    let bias = other.tensors.last_mut().unwrap();
    bias.raw_data[20..].copy_from_slice(&0.25_f32.to_le_bytes());
    for (net, results) in [(net.finish(16), 1), (other.finish(16), 6)] {
        let shape = [1, 16, 12, 19];
        assert_paths_agree(&net, &shape, 2);
        let ready = prepare(&net, &shape, &Options { exact: true, ..Options::default() }).unwrap();
        let layers = ready.plan.model().nodes().iter().filter_map(|node| node.op_as::<op::DirectConv>());
        assert_eq!(layers.map(|layer| layer.channels[1]).collect::<Vec<_>>(), [16, results]);
    }
}

#[test]
fn residual_layers_stay_within_a_chain() {
    let conv = |net: Net| net.pad("edge", &[1, 1]).conv(32, 1, 0, true).then("Elu", &[], vec![]);
    let then_add = |net: Net| {
        let before = net.last.clone();
        conv(net).then("Add", &[&before], vec![])
    };
    let net = then_add(then_add(conv(Net::new(32, 2))));
    // What is added is an older result here, which has to stay.
    let first = net.nodes[2].output[0].clone();
    let net = conv(conv(net).then("Add", &[&first], vec![])).finish(32);
    let shape = [1, 32, 19, 21];
    assert_paths_agree(&net, &shape, 5);
    let ready = prepare(&net, &shape, &Options::default()).unwrap();
    let chains = ready.plan.model().nodes().iter().filter_map(|node| node.op_as::<chain::Chain>());
    assert_eq!(chains.map(|chain| chain.len).collect::<Vec<_>>(), [1, 3, 1]);
}

#[test]
fn a_chain_reads_what_is_joined_and_enlarged_before_it() {
    let elu = |net: Net, channels, pads: i64| net.conv(channels, 1, pads, true).then("Elu", &[], vec![]);
    let mut net = elu(Net::new(16, 2), 32, 1);
    let large = net.last.clone();
    net = net.then("AveragePool", &[], vec![ints("kernel_shape", &[2; 2]), ints("strides", &[2; 2])]);
    net = elu(net, 48, 1);
    net.tensors.push(floats("none", &[0], &[]));
    net.tensors.push(floats("scales", &[4], &[1.0, 1.0, 2.0, 2.0]));
    let nearest = [("mode", "nearest"), ("coordinate_transformation_mode", "asymmetric"), ("nearest_mode", "floor")];
    net = net.then("Resize", &["none", "scales"], nearest.map(|(name, value)| text(name, value)).into());
    let axis = AttributeProto { name: "axis".into(), i: 1, r#type: AttributeType::Int as i32, ..Default::default() };
    net = net.then("Concat", &[&large], vec![axis]);
    net.channels = 80;
    let net = elu(elu(net, 16, 1), 64, 1).finish(16);
    let shape = [1, 16, 38, 42];
    assert_paths_agree(&net, &shape, 4);
    let ready = prepare(&net, &shape, &Options::default()).unwrap();
    let names: Vec<_> = ready.plan.model().nodes().iter().map(|node| node.op.name().into_owned()).collect();
    assert!(!names.iter().any(|name| name.contains("Concat") || name.contains("Upsample")), "{names:?}");
}

#[test]
fn a_chain_over_views_takes_pictures_of_any_size() {
    let net = Net::new(4, 3).pad("edge", &[1, 1, 1]).conv(8, 1, 0, true).then("Elu", &[], vec![]);
    let net = net.pad("edge", &[1, 1, 1]).conv(3, 1, 0, true).then("Tanh", &[], vec![]).finish(4);
    let small = prepare(&net, &[1, 4, 9, 16, 16], &Options::default()).unwrap();
    let chain = small.volume_chain().expect("two convolutions over views are a chain");
    let input = numbers(5, 4 * 9 * 7 * 30);
    let large = prepare(&net, &[1, 4, 9, 7, 30], &Options::default()).unwrap();
    let want = large.run(&input, &Cancel::default()).unwrap();
    let fill = |at: Columns, rows: &mut [f32], step: usize| {
        for c in 0..4 {
            let from = &input[((c * 9 + at.view) * 7 + at.y) * 30..][at.x.clone()];
            rows[c * step..][..from.len()].copy_from_slice(from);
        }
    };
    let mut seen = 0;
    let take = |rows: Rows| {
        for (c, view, y) in (0..27).flat_map(|i| rows.y.clone().map(move |y| (i / 9, i % 9, y))) {
            let want = &want[((c * 9 + view) * 7 + y) * 30..][rows.x.clone()];
            assert_eq!(rows.row(view, c, y), want);
            seen += want.len();
        }
    };
    chain.run([9, 7, 30], fill, take, None).unwrap();
    assert_eq!(seen, want.len());
}

#[test]
fn what_does_not_qualify_stays_with_tract() {
    let valid = Net::new(2, 2).conv(3, 1, 0, true).finish(2);
    assert_paths_agree(&valid, &[1, 2, 7, 8], 0);
    let reflected = Net::new(2, 2).pad("reflect", &[1, 1]).conv(3, 1, 0, true).finish(2);
    assert_paths_agree(&reflected, &[1, 2, 7, 8], 0);
    let wide = Net::new(2, 2).pad("edge", &[2, 2]).conv(3, 1, 0, true).finish(2);
    assert_paths_agree(&wide, &[1, 2, 7, 8], 0);
    let mut strided = Net::new(2, 2).conv(3, 1, 1, true);
    strided.nodes[0].attribute.push(ints("strides", &[2, 2]));
    assert_paths_agree(&strided.finish(2), &[1, 2, 7, 8], 0);
}

#[test]
fn an_elu_without_a_convolution_and_one_of_another_slope_are_right() {
    let alpha =
        AttributeProto { name: "alpha".into(), f: 0.5, r#type: AttributeType::Float as i32, ..Default::default() };
    let net = Net::new(3, 2).then("Elu", &[], vec![]).conv(2, 1, 1, true).then("Elu", &[], vec![alpha]).finish(3);
    assert_paths_agree(&net, &[1, 3, 6, 19], 1);
}

#[test]
fn a_value_that_is_read_twice_is_not_swallowed() {
    let net = Net::new(3, 2).conv(3, 1, 1, true).then("Elu", &[], vec![]).then("Add", &["Conv0"], vec![]).finish(3);
    assert_paths_agree(&net, &[1, 3, 6, 19], 1);
}

#[test]
fn the_identity_kernel_gives_the_picture_back() {
    let net = one_convolution(&[0., 0., 0., 0., 1., 0., 0., 0., 0.]);
    let net = prepare(&net, &[1, 1, 3, 5], &Options::default()).unwrap();
    assert_eq!(net.output_shape(), [1, 1, 3, 5]);
    let picture: Vec<f32> = (0..15).map(|v| v as f32).collect();
    let answer = net.run(&picture, &Cancel::default()).unwrap();
    assert_eq!(answer.shape(), [1, 1, 3, 5]);
    assert_eq!(&answer[..], &picture[..]);
}

#[test]
fn bad_models_are_told_apart() {
    let options = Options::default();
    let error = |bytes: &[u8], shape: &[usize]| prepare(bytes, shape, &options).unwrap_err();
    assert!(matches!(error(b"no ONNX at all", &[1, 1, 3, 5]), EngineError::Parse { .. }));
    assert!(matches!(error(&one_convolution(&[f32::NAN; 9]), &[1, 1, 3, 5]), EngineError::NotFinite { .. }));
    assert!(matches!(error(&one_convolution(&[0.; 9]), &[1, 2, 3, 5]), EngineError::Shape { .. }));
    let unknown = model(vec![node("Frobnicate", &["x"], "y", vec![])], vec![], &[1], &[1]);
    assert!(!matches!(error(&unknown, &[1]), EngineError::Parse { .. } | EngineError::NotFinite { .. }));
}

#[test]
fn a_cancelled_run_says_so() {
    let net = prepare(&one_convolution(&[0.; 9]), &[1, 1, 3, 5], &Options::default()).unwrap();
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(matches!(net.run(&[0.; 15], &cancel), Err(EngineError::Cancelled)));
}

#[test]
fn weights_are_kept_once_for_all_sizes() {
    let weights = numbers(1, 32 * 32 * 9);
    let conv = node("Conv", &["x", "w"], "y", vec![ints("pads", &[1; 4])]);
    let onnx = model(vec![conv], vec![floats("w", &[32, 32, 3, 3], &weights)], &[1, 32, -1, -2], &[1, 32, -1, -2]);
    let options = Options { exact: true, ..Options::default() };
    let of = |shape: &[usize], options: &Options| {
        let net = prepare(&onnx, shape, options).unwrap();
        let weights = net.plan.model().nodes().iter().find_map(|node| node.op_as::<op::DirectConv>()).unwrap();
        Arc::clone(&weights.weights)
    };
    let (first, second) = (of(&[1, 32, 8, 9], &options), of(&[1, 32, 20, 17], &options));
    assert!(Arc::ptr_eq(&first, &second));
    assert!(!Arc::ptr_eq(&first, &of(&[1, 32, 8, 9], &Options { exact: true, ..Options::default() })));
}
