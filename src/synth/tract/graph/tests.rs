//! Each mend on a graph of a few nodes, against what the net means, computed by hand.

use prost::Message as _;
use tract_onnx::pb::attribute_proto::AttributeType;
use tract_onnx::pb::tensor_proto::DataLocation;
pub(crate) use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::tensor_shape_proto::{Dimension, dimension};
use tract_onnx::pb::{
    AttributeProto, GraphProto, ModelProto, NodeProto, OperatorSetIdProto, StringStringEntryProto, TensorProto,
    TensorShapeProto, TypeProto, ValueInfoProto, type_proto,
};
use tract_onnx::prelude::f16;

use super::{OnnxBytes, OnnxFile, Scale, Wiring, signs};
use crate::job::Cancel;
use crate::synth::tract::{EngineError, Options, prepare_file};

/// A graph in the making.
#[derive(Clone)]
pub(crate) struct Graph(ModelProto);

impl Graph {
    pub(crate) fn new(opset: i64) -> Self {
        let opset_import = vec![OperatorSetIdProto { domain: String::new(), version: opset }];
        let graph = GraphProto { name: "net".to_owned(), ..GraphProto::default() };
        Self(ModelProto { ir_version: 7, opset_import, graph: Some(graph), ..ModelProto::default() })
    }

    fn graph(&mut self) -> &mut GraphProto {
        self.0.graph.as_mut().unwrap()
    }

    pub(crate) fn input(mut self, name: &str, kind: DataType, dims: &[Option<i64>]) -> Self {
        let input = port(name, kind, dims);
        self.graph().input.push(input);
        self
    }

    pub(crate) fn output(mut self, name: &str) -> Self {
        let output = port(name, DataType::Float, &[None; 4]);
        self.graph().output.push(output);
        self
    }

    pub(crate) fn weights(mut self, name: &str, dims: &[i64], values: &[f32]) -> Self {
        let raw_data = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let tensor = TensorProto { name: name.to_owned(), dims: dims.to_vec(), raw_data, ..TensorProto::default() };
        self.graph().initializer.push(TensorProto { data_type: DataType::Float as i32, ..tensor });
        self
    }

    pub(crate) fn node(mut self, op: &str, inputs: &[&str], outputs: &[&str], attributes: Vec<AttributeProto>) -> Self {
        let own = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let (input, output) = (own(inputs), own(outputs));
        let node = NodeProto { op_type: op.to_owned(), input, output, attribute: attributes, ..NodeProto::default() };
        self.graph().node.push(node);
        self
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.0.encode_to_vec()
    }
}

fn port(name: &str, kind: DataType, dims: &[Option<i64>]) -> ValueInfoProto {
    let dim = |n: &Option<i64>| Dimension {
        value: Some(match n {
            Some(n) => dimension::Value::DimValue(*n),
            None => dimension::Value::DimParam("side".to_owned()),
        }),
        ..Dimension::default()
    };
    let shape = Some(TensorShapeProto { dim: dims.iter().map(dim).collect() });
    let tensor = type_proto::Tensor { elem_type: kind as i32, shape };
    let kind = TypeProto { value: Some(type_proto::Value::TensorType(tensor)), ..TypeProto::default() };
    ValueInfoProto { name: name.to_owned(), r#type: Some(kind), ..ValueInfoProto::default() }
}

pub(crate) fn int(name: &str, i: i64) -> AttributeProto {
    AttributeProto { name: name.to_owned(), i, r#type: AttributeType::Int as i32, ..AttributeProto::default() }
}

fn ints(name: &str, values: &[i64]) -> AttributeProto {
    let plain = AttributeProto { name: name.to_owned(), ints: values.to_vec(), ..AttributeProto::default() };
    AttributeProto { r#type: AttributeType::Ints as i32, ..plain }
}

fn text(name: &str, value: &str) -> AttributeProto {
    let plain = AttributeProto { name: name.to_owned(), s: value.as_bytes().to_vec(), ..AttributeProto::default() };
    AttributeProto { r#type: AttributeType::String as i32, ..plain }
}

fn answers(file: &OnnxFile, shape: &[usize], input: &[f32]) -> Result<Vec<Vec<f32>>, EngineError> {
    let net = prepare_file(file, shape, &Options { threads: 1, ..Options::default() })?;
    Ok(net.run_all(input, &Cancel::default())?.iter().map(|output| output.to_vec()).collect())
}

fn answer(graph: &Graph, shape: &[usize], input: &[f32]) -> Vec<f32> {
    answers(&OnnxFile::plain(&graph.bytes()), shape, input).unwrap().remove(0)
}

pub(crate) const PICTURE: [Option<i64>; 4] = [Some(1), Some(3), None, None];

/// A 1×1 convolution that adds up the colours with weights of 1, 2 and 3.
fn sum() -> Graph {
    Graph::new(13)
        .input("x", DataType::Float, &PICTURE)
        .weights("w", &[1, 3, 1, 1], &[1.0, 2.0, 3.0])
        .node("Conv", &["x", "w"], &["y"], vec![])
        .output("y")
}

#[test]
fn float16_is_computed_in_float32() {
    let mut graph = sum();
    let tensor = &mut graph.graph().initializer[0];
    // The third weight is too small for sums of half precision.
    tensor.raw_data = [1.0, 2.0, 0.000_5].iter().flat_map(|v| f16::from_f32(*v).to_le_bytes()).collect();
    tensor.data_type = DataType::Float16 as i32;
    graph.graph().input[0] = port("x", DataType::Float16, &PICTURE);
    assert_eq!(answer(&graph, &[1, 3, 1, 2], &[1.0, 2.0, 10.0, 20.0, 1.0, 1.0])[..], [21.000_5, 42.000_5]);
}

#[test]
fn weights_beside_the_file_are_read_and_missing_or_foreign_ones_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut graph = sum();
    let tensor = &mut graph.graph().initializer[0];
    let bytes = std::mem::take(&mut tensor.raw_data);
    tensor.data_location = Some(DataLocation::External as i32);
    let entry = |key: &str, value: &str| StringStringEntryProto { key: key.to_owned(), value: value.to_owned() };
    tensor.external_data = vec![entry("location", "net.onnx_data"), entry("length", "12")];
    let (inside, path) = (graph.bytes(), folder.path().join("net.onnx_data"));
    let run = |bytes: &[u8]| {
        let file = OnnxFile { folder: Some(folder.path()), ..OnnxFile::plain(bytes) };
        answers(&file, &[1, 3, 1, 1], &[1.0; 3])
    };
    let said = run(&inside).unwrap_err().to_string();
    assert!(said.contains("net.onnx_data") && said.contains("not beside it"), "{said}");
    std::fs::write(&path, &bytes).unwrap();
    assert_eq!(run(&inside).unwrap(), [[6.0]]);
    std::fs::write(&path, &bytes[..8]).unwrap();
    assert!(run(&inside).is_err(), "it is shorter than the tensor");
    graph.graph().initializer[0].external_data[0].value = "/etc/hostname".to_owned();
    assert!(matches!(run(&graph.bytes()), Err(EngineError::External { .. })));
}

/// A 1×1 convolution whose weights are many enough to stay in the file.
fn wide(kind: DataType, raw_data: Vec<u8>) -> Graph {
    let bytes = match kind {
        DataType::Int8 => 1,
        DataType::Float16 => 2,
        _ => 4,
    };
    let channels = (raw_data.len() / (3 * bytes)) as i64;
    let mut graph = sum();
    let tensor = &mut graph.graph().initializer[0];
    (tensor.dims, tensor.raw_data, tensor.data_type) = (vec![channels, 3, 1, 1], raw_data, kind as i32);
    graph
}

#[test]
fn a_file_on_the_disk_answers_as_one_in_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("net.onnx");
    let values = (0..90_000).map(|i| (i % 97) as f32 / 7.0);
    let whole = wide(DataType::Float, values.clone().flat_map(f32::to_le_bytes).collect());
    let half = wide(DataType::Float16, values.flat_map(|v| f16::from_f32(v).to_le_bytes()).collect());
    let mut bytes = wide(DataType::Int8, (0..90_000).map(|i| (i % 251) as u8).collect())
        .weights("steps", &[3], &[0.02, 0.5, 1.0])
        .node("DequantizeLinear", &["w", "steps"], &["weights"], vec![int("axis", 1)]);
    let nodes = &mut bytes.graph().node;
    nodes[0].input[1] = "weights".to_owned();
    nodes.swap(0, 1);
    // Some exporters say "here" of each tensor, behind its values.
    let mut here = whole.clone();
    here.graph().initializer[0].data_location = Some(DataLocation::Default as i32);
    for graph in [whole, here, half, bytes, sum()] {
        let bytes = graph.bytes();
        std::fs::write(&path, &bytes).unwrap();
        let on_disk = OnnxFile { folder: None, ..OnnxFile::on_disk(&path) };
        let want = answer(&graph, &[1, 3, 1, 1], &[1.0, -2.0, 3.0]);
        assert_eq!(answers(&on_disk, &[1, 3, 1, 1], &[1.0, -2.0, 3.0]).unwrap()[0], want);
        assert!(signs(OnnxBytes::File(&path)).unwrap().files.is_empty());
        // The last four bytes are the version of the operators, which a file may leave out.
        for len in (0..bytes.len() - 4).step_by(bytes.len() / 97 + 1) {
            std::fs::write(&path, &bytes[..len]).unwrap();
            assert!(answers(&on_disk, &[1, 3, 1, 1], &[0.0; 3]).is_err(), "{len} bytes of {}", bytes.len());
        }
    }
    let odd = wide(DataType::Float, [f32::NAN; 30_000].into_iter().flat_map(f32::to_le_bytes).collect());
    std::fs::write(&path, odd.bytes()).unwrap();
    let refused = answers(&OnnxFile::on_disk(&path), &[1, 3, 1, 1], &[0.0; 3]);
    assert!(matches!(refused, Err(EngineError::NotFinite { name }) if name == "w"));
}

#[test]
fn upsample_of_opset_9_enlarges_and_slices_keep_their_bounds() {
    let graph = Graph::new(9)
        .input("x", DataType::Float, &PICTURE)
        .weights("scales", &[4], &[1.0, 1.0, 2.0, 2.0])
        .node("Slice", &["x"], &["first"], vec![ints("axes", &[1]), ints("starts", &[0]), ints("ends", &[1])])
        .node("Upsample", &["first", "scales"], &["y"], vec![text("mode", "nearest")])
        .output("y");
    let got = answer(&graph, &[1, 3, 1, 2], &[1.0, 2.0, 7.0, 7.0, 8.0, 8.0]);
    assert_eq!(got[..], [1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 2.0]);
}

#[test]
fn batch_normalisation_in_training_mode_is_that_of_its_own_numbers() {
    let one = |name: &str| (name.to_owned(), [1.0f32; 3]);
    let mut graph = Graph::new(14).input("x", DataType::Float, &PICTURE);
    for (name, values) in [one("scale"), one("mean"), one("var")] {
        graph = graph.weights(&name, &[3], &values);
    }
    let graph = graph
        .weights("bias", &[3], &[0.0, 5.0, 0.0])
        .node(
            "BatchNormalization",
            &["x", "scale", "bias", "mean", "var"],
            &["y", "m", "v"],
            vec![int("training_mode", 1)],
        )
        .output("y");
    let got = answer(&graph, &[1, 3, 1, 2], &[1.0, 3.0, 10.0, 30.0, 0.0, 8.0]);
    for (got, want) in got.iter().zip([-1.0, 1.0, 4.0, 6.0, -1.0, 1.0]) {
        assert!((got - want).abs() < 1e-4, "{got} where {want} is meant");
    }
}

#[test]
fn further_inputs_are_numbers_and_outputs_come_in_the_order_that_is_asked_for() {
    let graph = sum()
        .input("num_tokens", DataType::Int64, &[])
        .node("Cast", &["num_tokens"], &["n"], vec![int("to", i64::from(DataType::Float as i32))])
        .node("Mul", &["y", "n"], &["z"], vec![])
        .output("z");
    let bytes = graph.bytes();
    let run = |outputs: &[&str], numbers: &[(&str, f64)]| {
        let outputs = outputs.iter().map(|name| (*name).to_owned()).collect();
        let numbers = numbers.iter().map(|(name, number)| ((*name).to_owned(), *number)).collect();
        let wiring = Wiring { outputs, numbers };
        answers(&OnnxFile { wiring: &wiring, ..OnnxFile::plain(&bytes) }, &[1, 3, 1, 1], &[1.0; 3])
    };
    assert_eq!(run(&["z", "y"], &[("num_tokens", 10.0)]).unwrap(), [[60.0], [6.0]]);
    for (wrong, word) in [
        (run(&[], &[]), "num_tokens"),
        (run(&["depth"], &[("num_tokens", 1.0)]), "y, z"),
        (run(&[], &[("tokens", 1.0)]), "tokens"),
    ] {
        let said = wrong.unwrap_err().to_string();
        assert!(said.contains(word), "{said} should name {word}");
    }
}

#[test]
fn an_operation_that_is_not_known_is_named() {
    let graph = Graph::new(17).input("x", DataType::Float, &PICTURE).node("Deform", &["x"], &["y"], vec![]).output("y");
    let said = answers(&OnnxFile::plain(&graph.bytes()), &[1, 3, 2, 2], &[0.0; 12]).unwrap_err().to_string();
    assert!(said.contains("Deform") && said.contains("not supported"), "{said}");
}

#[test]
fn signs_tell_patches_normalisation_and_the_end() {
    let graph = Graph::new(17)
        .input("image", DataType::Float, &PICTURE)
        .weights("mean", &[1, 3, 1, 1], &[123.7, 116.3, 103.5])
        .weights("w", &[4, 3, 14, 14], &[0.0; 4 * 3 * 14 * 14])
        .weights("eighty", &[], &[80.0])
        .node("Sub", &["image", "mean"], &["centred"], vec![])
        .node("Conv", &["centred", "w"], &["patches"], vec![ints("kernel_shape", &[14; 2]), ints("strides", &[14; 2])])
        .node("Sigmoid", &["patches"], &["share"], vec![])
        .node("Mul", &["share", "eighty"], &["depth"], vec![])
        .output("depth");
    let signs = signs(OnnxBytes::Memory(&graph.bytes())).unwrap();
    assert_eq!((signs.patch, signs.normalises), (Some([14, 4]), Some(Scale::Bytes)));
    assert_eq!(signs.end[..2], [("Mul".to_owned(), Some(80.0)), ("Sigmoid".to_owned(), None)]);
    assert!(signs.pictures().count() == 1 && signs.answers("depth"));
}
