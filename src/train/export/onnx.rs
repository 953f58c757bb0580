//! Writes a graph as ONNX: opset 17, IR 8, batch normalisation folded, height and width free.
//!
//! Edge padding is a `Pad` of mode `edge` before a valid `Conv`, the pair that the viewer's convolution matches.

use prost::Message as _;
use tract_onnx::pb;
use tract_onnx::prelude::f16;

use crate::TrainError;
use crate::nets::{Bytes, Conv, End, Form, Graph, NORM_EPSILON, Node, VIEWS, Weights};

const OPSET: i64 = 17;
const IR_VERSION: i64 = 8;

/// The bits that a convolution's weights are kept in; it computes in 32 either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bits {
    /// As they were trained.
    #[default]
    ThirtyTwo,
    /// Half the file, behind a `Cast`.
    Sixteen,
    /// A quarter of it: each output channel has a step of its own, behind a `DequantizeLinear`.
    Eight,
}

/// The file's bytes.
pub fn encode(graph: &Graph, weights: &Weights, bits: Bits) -> Result<Vec<u8>, TrainError> {
    let mut writer = Writer { rank: graph.rank, bits, ..Writer::default() };
    let mut names: Vec<String> = Vec::new();
    for (i, node) in graph.nodes.iter().enumerate() {
        let name = match node {
            Node::Input => "input".to_owned(),
            Node::Conv(from, conv) => {
                let said = writer.conv(&names[*from], conv, weights)?;
                match conv.added {
                    Some(to) => writer.node("Add", &[&said, &names[to]], &format!("{}.sum", conv.name), vec![]),
                    None => said,
                }
            }
            Node::Pool(from) => writer.pool(&names[*from], i),
            Node::UpConcat(low, skip) => writer.up_concat(&names[*low], &names[*skip], i),
        };
        names.push(name);
    }
    let last = names.pop().unwrap_or_default();
    writer.node("Identity", &[&last], "output", vec![]);
    let outputs = graph.convs().last().map_or(0, |conv| conv.outputs);
    let proto = pb::GraphProto {
        name: format!("plenoscope {}", graph.arch.name()),
        node: writer.nodes,
        initializer: writer.arrays,
        input: vec![value_info("input", graph.input_channels(), graph.rank)],
        output: vec![value_info("output", outputs, graph.rank)],
        ..Default::default()
    };
    let model = pb::ModelProto {
        ir_version: IR_VERSION,
        producer_name: "plenoscope-train".into(),
        producer_version: env!("CARGO_PKG_VERSION").into(),
        opset_import: vec![pb::OperatorSetIdProto { domain: String::new(), version: OPSET }],
        graph: Some(proto),
        ..Default::default()
    };
    Ok(model.encode_to_vec())
}

/// `[1, channels, (64,) height, width]`.
fn value_info(name: &str, channels: usize, rank: usize) -> pb::ValueInfoProto {
    use pb::tensor_shape_proto::{Dimension, dimension::Value};
    let fixed = |n: usize| Value::DimValue(n as i64);
    let mut sizes = vec![fixed(1), fixed(channels)];
    sizes.extend((rank == 3).then(|| fixed(VIEWS)));
    sizes.extend(["height", "width"].map(|n| Value::DimParam(n.into())));
    let dim = sizes.into_iter().map(|v| Dimension { value: Some(v), ..Default::default() }).collect();
    let tensor = pb::type_proto::Tensor {
        elem_type: pb::tensor_proto::DataType::Float as i32,
        shape: Some(pb::TensorShapeProto { dim }),
    };
    let r#type = pb::TypeProto { value: Some(pb::type_proto::Value::TensorType(tensor)), ..Default::default() };
    pb::ValueInfoProto { name: name.into(), r#type: Some(r#type), ..Default::default() }
}

#[derive(Default)]
struct Writer {
    rank: usize,
    bits: Bits,
    nodes: Vec<pb::NodeProto>,
    arrays: Vec<pb::TensorProto>,
}

impl Writer {
    fn node(&mut self, op: &str, inputs: &[&str], output: &str, attribute: Vec<pb::AttributeProto>) -> String {
        self.nodes.push(pb::NodeProto {
            name: output.into(),
            op_type: op.into(),
            input: inputs.iter().map(|&name| name.into()).collect(),
            output: vec![output.into()],
            attribute,
            ..Default::default()
        });
        output.to_owned()
    }

    fn floats(&mut self, name: &str, dims: &[usize], values: &[f32]) {
        let raw_data = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.array(name, dims, pb::tensor_proto::DataType::Float, raw_data);
    }

    /// Values that a node named so gives, in as many bits as the file keeps.
    fn weights(&mut self, name: &str, dims: &[usize], values: &[f32]) {
        match self.bits {
            Bits::ThirtyTwo => self.floats(name, dims, values),
            Bits::Sixteen => self.halves(name, dims, values),
            Bits::Eight => self.bytes(name, dims, values),
        }
    }

    fn halves(&mut self, name: &str, dims: &[usize], values: &[f32]) {
        let raw_data = values.iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect();
        let kept = format!("{name}.half");
        self.array(&kept, dims, pb::tensor_proto::DataType::Float16, raw_data);
        self.node("Cast", &[&kept], name, vec![int("to", pb::tensor_proto::DataType::Float as i64)]);
    }

    fn bytes(&mut self, name: &str, dims: &[usize], values: &[f32]) {
        let bytes = Bytes::of(values, dims[0]);
        let [kept, scale] = [format!("{name}.bytes"), format!("{name}.steps")];
        let raw_data = bytes.values.iter().map(|v| *v as u8).collect();
        self.array(&kept, dims, pb::tensor_proto::DataType::Int8, raw_data);
        self.floats(&scale, &dims[..1], &bytes.steps);
        self.node("DequantizeLinear", &[&kept, &scale], name, vec![int("axis", 0)]);
    }

    fn array(&mut self, name: &str, dims: &[usize], kind: pb::tensor_proto::DataType, raw_data: Vec<u8>) {
        let dims = dims.iter().map(|&n| n as i64).collect();
        self.arrays.push(pb::TensorProto {
            name: name.into(),
            dims,
            data_type: kind as i32,
            raw_data,
            ..Default::default()
        });
    }

    /// Pad, Conv with folded normalisation, and the activation.
    fn conv(&mut self, from: &str, conv: &Conv, weights: &Weights) -> Result<String, TrainError> {
        let name = &conv.name;
        let (values, bias) = fold(conv, weights)?;
        let (weight_name, bias_name) = (format!("{name}.weight"), format!("{name}.bias"));
        self.weights(&weight_name, &conv.weight_shape(self.rank), &values);
        self.floats(&bias_name, &[conv.outputs], &bias);
        let dilation = conv.dilation as i64;
        let dilations = if self.rank == 3 { vec![1, dilation, dilation] } else { vec![dilation; 2] };
        let (from, attributes) = match conv.form {
            Form::Full => (self.pad(from, name, &dilations), self.full(dilations)),
            Form::Patch { side, stride, each } => {
                let [before, after] = conv.patch().margins().map(|n| n as i64);
                let mut attributes = vec![
                    ints("kernel_shape", vec![side as i64; 2]),
                    ints("dilations", dilations),
                    ints("strides", vec![stride as i64; 2]),
                    ints("pads", vec![before, before, after, after]),
                ];
                attributes.extend(each.then(|| int("group", conv.outputs as i64)));
                (from.to_owned(), attributes)
            }
        };
        let z = self.node("Conv", &[&from, &weight_name, &bias_name], &format!("{name}.conv"), attributes);
        Ok(self.end(&z, conv))
    }

    /// What a convolution of edge-padded maps is told.
    fn full(&self, dilations: Vec<i64>) -> Vec<pb::AttributeProto> {
        vec![
            ints("kernel_shape", vec![3; self.rank]),
            ints("dilations", dilations),
            ints("strides", vec![1; self.rank]),
            ints("pads", vec![0; 2 * self.rank]),
        ]
    }

    /// A convolution's activation.
    fn end(&mut self, z: &str, conv: &Conv) -> String {
        let name = &conv.name;
        match conv.end {
            End::NormElu => self.node("Elu", &[z], &format!("{name}.elu"), vec![float("alpha", 1.0)]),
            End::Settled { clamped: false } => z.to_owned(),
            End::Settled { clamped: true } => {
                let limits = [("low", 0.0), ("high", 6.0)].map(|(what, value)| {
                    let limit = format!("{name}.{what}");
                    self.floats(&limit, &[], &[value]);
                    limit
                });
                self.node("Clip", &[z, &limits[0], &limits[1]], &format!("{name}.clamped"), vec![])
            }
            End::Tanh { scale } => {
                let y = self.node("Tanh", &[z], &format!("{name}.tanh"), vec![]);
                let factor = format!("{name}.scale");
                self.floats(&factor, &[], &[scale]);
                self.node("Mul", &[&y, &factor], &format!("{name}.scaled"), vec![])
            }
        }
    }

    fn pad(&mut self, from: &str, name: &str, margins: &[i64]) -> String {
        let one_side: Vec<i64> = [0, 0].into_iter().chain(margins.iter().copied()).collect();
        let pads: Vec<u8> = one_side.iter().chain(&one_side).flat_map(|v| v.to_le_bytes()).collect();
        let pads_name = format!("{name}.pads");
        self.array(&pads_name, &[2 * one_side.len()], pb::tensor_proto::DataType::Int64, pads);
        self.node("Pad", &[from, &pads_name], &format!("{name}.padded"), vec![text("mode", "edge")])
    }

    fn pool(&mut self, from: &str, index: usize) -> String {
        self.node(
            "AveragePool",
            &[from],
            &format!("pool{index}"),
            vec![ints("kernel_shape", vec![2, 2]), ints("strides", vec![2, 2])],
        )
    }

    fn up_concat(&mut self, low: &str, skip: &str, index: usize) -> String {
        let scales = format!("up{index}.scales");
        self.floats(&scales, &[4], &[1.0, 1.0, 2.0, 2.0]);
        let how = vec![
            text("mode", "nearest"),
            text("coordinate_transformation_mode", "asymmetric"),
            text("nearest_mode", "floor"),
        ];
        let wide = self.node("Resize", &[low, "", &scales], &format!("up{index}"), how);
        self.node("Concat", &[&wide, skip], &format!("joined{index}"), vec![int("axis", 1)])
    }
}

/// Weights and bias of a convolution with its normalisation, or with the 1/scale inside its tanh, folded in.
fn fold(conv: &Conv, weights: &Weights) -> Result<(Vec<f32>, Vec<f32>), TrainError> {
    let array = |what: &str| weights.get(&format!("{}.{what}", conv.name)).map(|t| t.values.as_slice());
    let weight = array("weight")?;
    let (scale, bias): (Vec<f32>, Vec<f32>) = match conv.end {
        End::NormElu | End::Settled { .. } => {
            let (gamma, beta, mean, var) = (array("gamma")?, array("beta")?, array("mean")?, array("var")?);
            let scale: Vec<f32> = gamma.iter().zip(var).map(|(g, v)| g / (v + NORM_EPSILON).sqrt()).collect();
            let bias = (0..scale.len()).map(|c| beta[c] - mean[c] * scale[c]).collect();
            (scale, bias)
        }
        End::Tanh { scale } => {
            let bias = array("bias")?;
            (vec![1.0 / scale; bias.len()], bias.iter().map(|b| b / scale).collect())
        }
    };
    let row = weight.len() / conv.outputs;
    Ok((weight.iter().enumerate().map(|(i, w)| w * scale[i / row]).collect(), bias))
}

fn attribute(name: &str, kind: pb::attribute_proto::AttributeType) -> pb::AttributeProto {
    pb::AttributeProto { name: name.into(), r#type: kind as i32, ..Default::default() }
}

fn ints(name: &str, ints: Vec<i64>) -> pb::AttributeProto {
    pb::AttributeProto { ints, ..attribute(name, pb::attribute_proto::AttributeType::Ints) }
}

fn int(name: &str, i: i64) -> pb::AttributeProto {
    pb::AttributeProto { i, ..attribute(name, pb::attribute_proto::AttributeType::Int) }
}

fn float(name: &str, f: f32) -> pb::AttributeProto {
    pb::AttributeProto { f, ..attribute(name, pb::attribute_proto::AttributeType::Float) }
}

fn text(name: &str, s: &str) -> pb::AttributeProto {
    pb::AttributeProto { s: s.as_bytes().to_vec(), ..attribute(name, pb::attribute_proto::AttributeType::String) }
}
