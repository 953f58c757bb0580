//! Nets of one convolution on a picture whose red is its depth.

use std::fs;
use std::path::{Path, PathBuf};

use super::{AdoptError, Adopted, Known, Shelf, adopt};
use crate::field::{DisparityMap, View};
use crate::job::{Cancel, Job};
use crate::synth::tract::graph_tests::{DataType, Graph, PICTURE};
use crate::synth::{ColourOrder, RelativeOutput, Task};

/// A picture whose red grows with nearness; green and blue say nothing of it.
fn scene() -> (View, DisparityMap) {
    let size = [96, 64];
    let near = |i: u32| ((i % 96) as f32 / 96.0 + if i / 96 % 64 > 40 { 0.8 } else { 0.0 }) / 1.8;
    let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8;
    let rgba = (0..96 * 64).flat_map(|i| [(near(i) * 255.0) as u8, noise(i), noise(i + 7_000), 255]).collect();
    let map = DisparityMap::new(size, (0..96 * 64).map(near).collect()).unwrap();
    (View::new(size, rgba).unwrap(), map)
}

/// A net that multiplies the colours of each pixel with three numbers and adds a fourth.
fn net(weights: [f32; 3], bias: f32) -> Graph {
    Graph::new(13)
        .input("image", DataType::Float, &PICTURE)
        .weights("w", &[1, 3, 1, 1], &weights)
        .weights("b", &[1], &[bias])
        .node("Conv", &["image", "w", "b"], &["depth"], vec![])
        .output("depth")
}

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    }

    fn shelf(&self) -> Shelf {
        Shelf::new(&self.0.path().join("shelf"))
    }
}

fn tried(path: &Path, any: bool) -> Result<Adopted, AdoptError> {
    let (view, disparity) = scene();
    adopt(path, Known { view: &view, disparity: &disparity }, any, &Job { cancel: &Cancel::default(), sink: &() })
}

fn put(shelf: &Shelf, path: &Path, replace: bool) -> Result<(), AdoptError> {
    shelf.put(path, &tried(path, false)?, replace, &Job { cancel: &Cancel::default(), sink: &() })
}

#[test]
fn a_net_that_orders_the_depth_is_taken_and_its_sense_is_found() {
    let place = Place::new();
    for (weights, bias, output) in
        [([1.0, 0.0, 0.0], 0.0, RelativeOutput::Nearness), ([-1.0, 0.0, 0.0], 0.0, RelativeOutput::Farness)]
    {
        let adopted = tried(&place.file("mine.onnx", &net(weights, bias).bytes()), false).unwrap();
        assert!(adopted.correlation > 0.95, "{}", adopted.correlation);
        assert_eq!((adopted.manifest.id.as_str(), adopted.manifest.relative.output), ("mine", output));
        assert_eq!(adopted.manifest.relative.output_name, "depth");
    }
}

#[test]
fn the_order_of_the_colours_is_found() {
    let place = Place::new();
    let adopted = tried(&place.file("bgr.onnx", &net([0.0, 0.0, 1.0], 0.0).bytes()), false).unwrap();
    assert_eq!(adopted.manifest.relative.order, ColourOrder::Bgr);
    assert!(adopted.correlation > 0.95);
}

#[test]
fn what_is_no_depth_net_is_refused_in_a_sentence() {
    let place = Place::new();
    let words = Graph::new(13)
        .input("input_ids", DataType::Int64, &[Some(1), None])
        .node("Cast", &["input_ids"], &["logits"], vec![])
        .output("logits");
    let two = net([1.0; 3], 0.0).input("second", DataType::Float, &PICTURE);
    let whole = net([1.0, 0.0, 0.0], 0.0).bytes();
    for (bytes, word) in [
        (b"no net at all".to_vec(), "no ONNX file"),
        (Vec::new(), "no ONNX file"),
        (vec![0; 1 << 20], "no ONNX file"),
        (whole[..whole.len() / 2].to_vec(), "was not added"),
        (words.bytes(), "takes no picture"),
        (two.bytes(), "several pictures"),
        (net([0.0; 3], 3.0).bytes(), "one depth everywhere"),
        (net([0.0, 1.0, 0.0], 0.0).bytes(), "correlation"),
        (net([f32::NAN, 0.0, 0.0], 0.0).bytes(), "not all finite"),
    ] {
        let path = place.file("bad.onnx", &bytes);
        let said = put(&place.shelf(), &path, false).unwrap_err().to_string();
        assert!(said.contains(word), "{said} should say {word}");
        assert!(place.shelf().nets().is_empty(), "nothing is left behind");
    }
    assert!(tried(&place.file("noise.onnx", &net([0.0, 1.0, 0.0], 0.0).bytes()), true).is_ok(), "unless it is wanted");
}

#[test]
fn a_shelf_keeps_nets_whole_and_names_broken_ones() {
    let place = Place::new();
    let shelf = place.shelf();
    let path = place.file("mine.onnx", &net([1.0, 0.0, 0.0], 0.0).bytes());
    put(&shelf, &path, false).unwrap();
    assert!(matches!(put(&shelf, &path, false), Err(AdoptError::Exists { .. })));
    put(&shelf, &path, true).unwrap();
    assert!(shelf.source().model("mine", Task::RelativeDepth).is_ok(), "its checksum is right");
    shelf.prefer(Some("mine")).unwrap();
    assert_eq!(shelf.preferred().as_deref(), Some("mine"));
    fs::create_dir(shelf.folder().join("broken")).unwrap();
    let nets = shelf.nets();
    assert_eq!(nets.iter().map(|net| net.name.as_str()).collect::<Vec<_>>(), ["broken", "mine"]);
    assert!(nets[0].manifest.is_err() && nets[1].manifest.is_ok() && nets[1].is_preferred);
    assert!(shelf.prefer(Some("broken")).is_err(), "one that cannot be read is not preferred");
    shelf.remove("mine").unwrap();
    assert!(shelf.preferred().is_none());
    assert!(matches!(shelf.remove("mine"), Err(AdoptError::Unknown { .. })));
}

#[test]
fn a_stopped_copy_leaves_nothing_and_odd_names_are_refused() {
    let place = Place::new();
    let path = place.file("mine.onnx", &net([1.0, 0.0, 0.0], 0.0).bytes());
    let adopted = tried(&path, false).unwrap();
    let cancel = Cancel::default();
    cancel.cancel();
    let stopped = place.shelf().put(&path, &adopted, false, &Job { cancel: &cancel, sink: &() });
    assert!(matches!(stopped, Err(AdoptError::Cancelled(_))));
    assert!(place.shelf().nets().is_empty());
    for name in ["", "..", "a/b", "network", "everyday", "-x"] {
        assert!(matches!(place.shelf().check(name, true), Err(AdoptError::Name { .. })), "{name}");
    }
}
