//! Weights in 8 bits as what they stand for. tract takes half a second for the ten million of a depth net, at each size
//! of the picture that the net is made ready for.

use std::collections::BTreeMap;

use tract_onnx::pb::tensor_proto::DataType;
use tract_onnx::pb::{GraphProto, NodeProto, TensorProto};

use super::outside::{Narrow, Outside, number};
use super::{floats, location};

/// Turns weights that one `DequantizeLinear` without zero point reads into its result; all others are left to tract.
/// `outside` hears of those in files.
pub(super) fn widen(graph: &mut GraphProto, outside: &mut Outside) {
    let mut readers: BTreeMap<String, usize> = BTreeMap::new();
    graph.node.iter().flat_map(|node| &node.input).for_each(|name| *readers.entry(name.clone()).or_default() += 1);
    let weights = &mut graph.initializer;
    let places: BTreeMap<String, usize> =
        weights.iter().enumerate().map(|(place, tensor)| (tensor.name.clone(), place)).collect();
    graph.node.retain(|node| {
        let place = |input: usize| node.input.get(input).and_then(|name| places.get(name)).copied();
        let (Some(kept), Some(steps)) = (place(0), place(1)) else { return true };
        let narrow = narrow(node, &weights[kept], &weights[steps]).filter(|_| readers[&node.input[0]] == 1);
        let Some(narrow) = narrow else { return true };
        weights[kept] = widened(std::mem::take(&mut weights[kept]), &narrow, outside);
        weights[kept].name.clone_from(&node.output[0]);
        false
    });
}

/// How the weights that a node widens are kept; none where it is another operation, or where they are kept in another way.
fn narrow(node: &NodeProto, kept: &TensorProto, steps: &TensorProto) -> Option<Narrow> {
    let is_plain = node.op_type == "DequantizeLinear" && node.input.len() == 2 && node.output.len() == 1;
    if !is_plain || kept.data_type != DataType::Int8 as i32 {
        return None;
    }
    let axis = node.attribute.iter().find(|attribute| attribute.name == "axis").map_or(1, |axis| axis.i);
    let lengths: Vec<usize> = kept.dims.iter().map(|&n| usize::try_from(n).ok()).collect::<Option<_>>()?;
    let (channels, each) = lengths.get(usize::try_from(axis).ok()?..)?.split_first()?;
    let steps: Vec<f32> = floats(steps)?.collect();
    let bytes = if location(kept).is_some() { number(kept, "length")? } else { kept.raw_data.len() };
    let fits = steps.len() == *channels && bytes == lengths.iter().product::<usize>();
    fits.then(|| Narrow::Bytes { steps, each: each.iter().product() })
}

/// The same weights as f32, or as what will be f32 when it is read.
fn widened(kept: TensorProto, narrow: &Narrow, outside: &mut Outside) -> TensorProto {
    let raw_data = if outside.notes(&kept, narrow) { kept.raw_data } else { narrow.widened(&kept.raw_data) };
    TensorProto { data_type: DataType::Float as i32, raw_data, ..kept }
}

#[cfg(test)]
mod tests {
    use tract_onnx::data_resolver::ModelDataResolver as _;
    use tract_onnx::pb::tensor_proto::DataLocation;
    use tract_onnx::pb::{AttributeProto, StringStringEntryProto};

    use super::*;

    fn graph(inputs: &[&str]) -> GraphProto {
        let tensor = |name: &str, dims: &[i64], kind: DataType, raw_data: Vec<u8>| TensorProto {
            name: name.to_owned(),
            dims: dims.to_vec(),
            data_type: kind as i32,
            raw_data,
            ..Default::default()
        };
        let steps = [0.5f32, 2.0].iter().flat_map(|step| step.to_le_bytes()).collect();
        let node = |op: &str, inputs: &[&str], output: &str| NodeProto {
            op_type: op.to_owned(),
            input: inputs.iter().map(|&name| name.to_owned()).collect(),
            output: vec![output.to_owned()],
            attribute: vec![AttributeProto { name: "axis".to_owned(), i: 0, ..Default::default() }],
            ..Default::default()
        };
        GraphProto {
            initializer: vec![
                tensor("kept", &[2, 3], DataType::Int8, vec![0, 1, 255, 128, 127, 2]),
                tensor("steps", &[2], DataType::Float, steps),
                tensor("zero", &[2], DataType::Int8, vec![1, 1]),
            ],
            node: vec![node("DequantizeLinear", inputs, "weights"), node("Conv", &["photo", "weights"], "map")],
            ..Default::default()
        }
    }

    #[test]
    fn weights_are_what_their_bytes_stand_for() {
        let mut graph = graph(&["kept", "steps"]);
        widen(&mut graph, &mut Outside::default());
        assert_eq!(graph.node.iter().map(|node| node.op_type.as_str()).collect::<Vec<_>>(), ["Conv"]);
        let weights = graph.initializer.iter().find(|tensor| tensor.name == "weights").unwrap();
        let values = weights.raw_data.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap()));
        assert_eq!(values.collect::<Vec<_>>(), [0.0, 0.5, -0.5, -256.0, 254.0, 4.0]);
        assert_eq!((&weights.dims[..], weights.data_type), (&[2, 3][..], DataType::Float as i32));
    }

    #[test]
    fn those_in_a_file_are_widened_when_they_are_read() {
        let entry = |key: &str, value: &str| StringStringEntryProto { key: key.to_owned(), value: value.to_owned() };
        let mut graph = graph(&["kept", "steps"]);
        let kept = &mut graph.initializer[0];
        let bytes = std::mem::take(&mut kept.raw_data);
        kept.data_location = Some(DataLocation::External as i32);
        kept.external_data = vec![entry("location", "net.onnx"), entry("offset", "7"), entry("length", "6")];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("net.onnx");
        std::fs::write(&path, [&[9; 7][..], &bytes].concat()).unwrap();
        let (mut outside, mut wide) = (Outside::default(), Vec::new());
        widen(&mut graph, &mut outside);
        assert_eq!((graph.node.len(), graph.initializer[0].data_type), (1, DataType::Float as i32));
        outside.read_bytes_from_path(&mut wide, &path, 7, Some(6)).unwrap();
        let values = wide.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap()));
        assert_eq!(values.collect::<Vec<_>>(), [0.0, 0.5, -0.5, -256.0, 254.0, 4.0]);
    }

    #[test]
    fn what_is_kept_in_another_way_is_left_to_tract() {
        let zero_point = graph(&["kept", "steps", "zero"]);
        let mut short = graph(&["kept", "steps"]);
        short.initializer[1].raw_data.truncate(4);
        let mut read_twice = graph(&["kept", "steps"]);
        read_twice.node[1].input.push("kept".to_owned());
        for before in [zero_point, short, read_twice, graph(&["photo", "steps"])] {
            let mut after = before.clone();
            widen(&mut after, &mut Outside::default());
            assert_eq!(after, before);
        }
    }
}
