//! Small nets, written here, through the engine.

use prost::Message as _;
use tract_onnx::pb::*;
use tract_onnx::pb::{attribute_proto::AttributeType, tensor_proto::DataType};

use super::*;

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
