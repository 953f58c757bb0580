//! Pieces of public depth nets: what the kernel does of them equals tract's own.

use super::*;

/// Nodes and weights, named as they come.
#[derive(Default)]
struct Graph {
    nodes: Vec<NodeProto>,
    tensors: Vec<TensorProto>,
}

impl Graph {
    fn weights(&mut self, dims: &[i64]) -> String {
        let name = format!("w{}", self.tensors.len());
        let values = numbers(self.tensors.len() as u64, dims.iter().product::<i64>() as usize);
        self.tensors.push(floats(&name, dims, &values));
        name
    }

    fn number(&mut self, value: f32) -> String {
        let name = format!("n{}", self.tensors.len());
        self.tensors.push(floats(&name, &[], &[value]));
        name
    }

    fn integers(&mut self, values: &[i64]) -> String {
        let name = format!("i{}", self.tensors.len());
        self.tensors.push(integers(&name, values));
        name
    }

    fn node(&mut self, op: &str, inputs: &[&str], attributes: Vec<AttributeProto>) -> String {
        let name = format!("{op}{}", self.nodes.len());
        self.nodes.push(node(op, inputs, &name, attributes));
        name
    }

    /// `x · w + b`.
    fn linear(&mut self, x: &str, [depth, columns]: [i64; 2]) -> String {
        let (weights, bias) = (self.weights(&[depth, columns]), self.weights(&[columns]));
        let product = self.node("MatMul", &[x, &weights], vec![]);
        self.node("Add", &[&bias, &product], vec![])
    }

    fn layer_norm(&mut self, x: &str, width: i64) -> String {
        let (scale, shift) = (self.weights(&[width]), self.weights(&[width]));
        self.node("LayerNormalization", &[x, &scale, &shift], vec![])
    }

    /// Heads as `[1, heads, tokens, depth]`, or what `perm` makes of `[1, tokens, heads, depth]`.
    fn heads(&mut self, x: &str, perm: &[i64]) -> String {
        let shape = self.integers(&[1, -1, 3, 4]);
        let heads = self.node("Reshape", &[x, &shape], vec![]);
        self.node("Transpose", &[&heads], vec![ints("perm", perm)])
    }

    fn gelu(&mut self, x: &str) -> String {
        let [root, one, half] = [2f32.sqrt(), 1.0, 0.5].map(|value| self.number(value));
        let divided = self.node("Div", &[x, &root], vec![]);
        let erf = self.node("Erf", &[&divided], vec![]);
        let sum = self.node("Add", &[&erf, &one], vec![]);
        let product = self.node("Mul", &[x, &sum], vec![]);
        self.node("Mul", &[&product, &half], vec![])
    }

    fn finish(mut self, last: &str, input: &[i64], output: &[i64]) -> Vec<u8> {
        self.nodes.push(node("Identity", &[last], "y", vec![]));
        model(self.nodes, self.tensors, input, output)
    }
}

/// A block of a vision transformer over `tokens` tokens of 12 values, as PyTorch writes it, perhaps with a bias of the scores.
fn transformer(tokens: i64, with_bias: bool) -> Vec<u8> {
    let mut g = Graph::default();
    let normed = g.layer_norm("x", 12);
    let [q, k, v] = [0; 3].map(|_| g.linear(&normed, [12, 12]));
    let (q, k, v) = (g.heads(&q, &[0, 2, 1, 3]), g.heads(&k, &[0, 2, 3, 1]), g.heads(&v, &[0, 2, 1, 3]));
    let half = g.number(0.5);
    let q = if with_bias { q } else { g.node("Mul", &[&q, &half], vec![]) };
    let mut scores = g.node("MatMul", &[&q, &k], vec![]);
    if with_bias {
        let bias = g.weights(&[1, 3, tokens, tokens]);
        scores = g.node("Mul", &[&scores, &half], vec![]);
        scores = g.node("Add", &[&scores, &bias], vec![]);
    }
    let shares = g.node("Softmax", &[&scores], vec![]);
    let answer = g.node("MatMul", &[&shares, &v], vec![]);
    let answer = g.node("Transpose", &[&answer], vec![ints("perm", &[0, 2, 1, 3])]);
    let shape = g.integers(&[1, -1, 12]);
    let answer = g.node("Reshape", &[&answer, &shape], vec![]);
    let answer = g.linear(&answer, [12, 12]);
    let gamma = g.weights(&[12]);
    let answer = g.node("Mul", &[&answer, &gamma], vec![]);
    let middle = g.node("Add", &[&answer, "x"], vec![]);
    let normed = g.layer_norm(&middle, 12);
    let wide = g.linear(&normed, [12, 40]);
    let wide = g.gelu(&wide);
    let narrow = g.linear(&wide, [40, 12]);
    let last = g.node("Add", &[&narrow, &middle], vec![]);
    g.finish(&last, &[1, tokens, 12], &[1, tokens, 12])
}

/// Kernel against tract on one thread and on two, and on the portable path; answers the net.
fn agrees(onnx: &[u8], shape: &[usize]) -> Runnable {
    let input = numbers(9, shape.iter().product());
    let run = |path, threads| {
        let net = prepare(onnx, shape, &Options { path, threads, ..Options::default() }).unwrap();
        let output = net.run(&input, &Cancel::default()).unwrap();
        (net, output)
    };
    let (_, want) = run(Path::Stock, 1);
    let largest = want.iter().fold(0.0, |m: f32, b| m.max(b.abs()));
    for (path, threads) in [(Path::Auto, 1), (Path::Auto, 2), (Path::Avx2, 2), (Path::Portable, 2)] {
        let (_, got) = run(path, threads);
        assert_eq!(got.shape(), want.shape());
        for (got, want) in got.iter().zip(want.iter()) {
            assert!((got - want).abs() <= 1e-5 * (1.0 + largest), "{path:?} {threads} {shape:?}: {got}, not {want}");
        }
    }
    run(Path::Portable, 1).0
}

/// How many nodes are of this operation.
fn count(net: &Runnable, name: &str) -> usize {
    net.plan.model().nodes().iter().filter(|node| node.op().name() == name).count()
}

#[test]
fn a_transformer_is_done_by_the_kernel_and_equals_tract() {
    for (tokens, with_bias) in [(2, false), (37, false), (37, true), (130, false), (130, true)] {
        let net = agrees(&transformer(tokens, with_bias), &[1, tokens as usize, 12]);
        let counts = ["Attention", "LayerNorm", "Product", "Softmax", "OptMatMul"].map(|name| count(&net, name));
        assert_eq!(counts, [1, 2, 6, 0, 0], "{tokens} tokens, bias {with_bias}");
    }
}

/// Resize by ONNX's words.
fn resized(mode: &str, transformation: &str, sizes: &[i64]) -> Vec<u8> {
    let mut g = Graph::default();
    let (weights, bias) = (g.weights(&[7, 3, 1, 1]), g.weights(&[7]));
    let x = g.node("Conv", &["x", &weights, &bias], vec![]);
    let x = g.node("Relu", &[&x], vec![]);
    let sizes_name = g.integers(sizes);
    let words = vec![text("mode", mode), text("coordinate_transformation_mode", transformation)];
    let x = g.node("Resize", &[&x, "", "", &sizes_name], words);
    g.finish(&x, &[1, 3, 11, 6], sizes)
}

#[test]
fn points_and_enlargement_are_done_by_the_kernel_and_equal_tract() {
    for mode in ["linear", "cubic"] {
        for transformation in ["half_pixel", "align_corners", "asymmetric", "pytorch_half_pixel"] {
            for sizes in [[1, 7, 22, 12], [1, 7, 31, 6], [1, 7, 5, 19], [1, 7, 70, 130]] {
                let net = agrees(&resized(mode, transformation, &sizes), &[1, 3, 11, 6]);
                assert_eq!(
                    (count(&net, "PlaneResize"), count(&net, "PlaneProduct")),
                    (1, 1),
                    "{mode} {transformation}"
                );
            }
        }
    }
}

/// A convolution with what follows it in public nets: a scale and shift, limits, and something added.
fn convolution(channels: [i64; 2], group: i64, attributes: Vec<AttributeProto>, size: [i64; 2]) -> Vec<u8> {
    let mut g = Graph::default();
    let [first, second] = channels;
    let kernel = attributes[0].ints.clone();
    let (weights, bias) = (g.weights(&[second, first / group, kernel[0], kernel[1]]), g.weights(&[second]));
    let group =
        AttributeProto { name: "group".into(), i: group, r#type: AttributeType::Int as i32, ..Default::default() };
    let x = g.node("Conv", &["x", &weights, &bias], [attributes, vec![group]].concat());
    let (scale, low, high) = (g.weights(&[second, 1, 1]), g.number(-0.5), g.number(2.0));
    let x = g.node("Mul", &[&x, &scale], vec![]);
    let clipped = g.node("Clip", &[&x, &low, &high], vec![]);
    let x = g.node("Mul", &[&clipped, &low], vec![]);
    let x = g.node("Add", &[&clipped, &x], vec![]);
    g.finish(&x, &[1, first, size[0], size[1]], &[1, second, -1, -2])
}

#[test]
fn convolutions_of_any_kernel_are_done_by_the_kernel_and_equal_tract() {
    let attributes = |kernel: [i64; 2], stride: i64, pads: [i64; 4], dilation: i64| {
        let (kernel, strides, dilations) = (&kernel, &[stride; 2], &[dilation; 2]);
        vec![ints("kernel_shape", kernel), ints("strides", strides), ints("dilations", dilations), ints("pads", &pads)]
    };
    for (channels, group, attributes, size, name) in [
        ([5, 7], 1, attributes([3, 3], 2, [1; 4], 1), [13, 22], "PatchConv"),
        ([3, 20], 1, attributes([14, 14], 14, [0; 4], 1), [28, 42], "PatchConv"),
        ([3, 4], 1, attributes([5, 7], 1, [2, 3, 2, 3], 1), [9, 40], "PatchConv"),
        ([64, 70], 1, attributes([3, 3], 1, [1; 4], 1), [7, 8], "PatchConv"),
        ([9, 9], 9, attributes([3, 3], 1, [1; 4], 1), [8, 8], "PlaneConv"),
        ([9, 9], 9, attributes([3, 3], 2, [0, 0, 1, 1], 1), [16, 31], "PlaneConv"),
        ([9, 9], 9, attributes([5, 5], 2, [1, 1, 2, 2], 1), [33, 70], "PlaneConv"),
        ([6, 6], 6, attributes([3, 5], 3, [4, 5, 0, 1], 2), [19, 21], "PlaneConv"),
    ] {
        let shape = [1, channels[0] as usize, size[0] as usize, size[1] as usize];
        let net = agrees(&convolution(channels, group, attributes, size), &shape);
        assert_eq!(count(&net, name), 1, "{channels:?} {group} {size:?}");
    }
}

#[test]
fn a_foreign_net_stops_between_its_operations() {
    let onnx = transformer(37, false);
    let net = prepare(&onnx, &[1, 37, 12], &Options::default()).unwrap();
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(matches!(net.run(&[0.0; 37 * 12], &cancel), Err(EngineError::Cancelled)));
}

/// A residual unit of a decoder, as PyTorch writes it: limits before each convolution, a sum and limits behind the last.
fn residual(channels: i64, size: [i64; 2]) -> Vec<u8> {
    let mut g = Graph::default();
    let mut last = "x".to_owned();
    for _ in 0..2 {
        let (weights, bias) = (g.weights(&[channels, channels, 3, 3]), g.weights(&[channels]));
        let limited = g.node("Relu", &[&last], vec![]);
        last = g.node("Conv", &[&limited, &weights, &bias], vec![ints("pads", &[1; 4])]);
    }
    let sum = g.node("Add", &["x", &last], vec![]);
    let (low, high) = (g.number(-1.0), g.number(6.0));
    let limited = g.node("Clip", &[&sum, &low, &high], vec![]);
    let shape = [1, channels, size[0], size[1]];
    g.finish(&limited, &shape, &shape)
}

#[test]
fn limits_and_sums_of_residual_units_are_done_by_their_convolutions() {
    let net = agrees(&residual(7, [9, 21]), &[1, 7, 9, 21]);
    assert_eq!((count(&net, "DirectConv"), net.plan.model().nodes().len()), (2, 3));
    let (onnx, shape) = (residual(32, [40, 33]), [1, 32, 40, 33]);
    let input = numbers(9, shape.iter().product());
    let run = |path, exact| {
        let net = prepare(&onnx, &shape, &Options { path, exact, ..Options::default() }).unwrap();
        let output = net.run(&input, &Cancel::default()).unwrap().to_vec();
        (net, output)
    };
    let (_, want) = run(Path::Stock, true);
    for (path, exact, nodes) in [(Path::Auto, false, 2), (Path::Portable, false, 2), (Path::Auto, true, 3)] {
        let (net, got) = run(path, exact);
        assert_eq!(net.plan.model().nodes().len(), nodes);
        for (got, want) in got.iter().zip(&want) {
            assert!((got - want).abs() < 1e-3, "{path:?} {exact}: {got}, not {want}");
        }
    }
}

#[test]
fn what_does_not_depend_on_the_picture_is_computed_once() {
    let mut g = Graph::default();
    let (three, sides) = (g.integers(&[3]), g.integers(&[900, 900]));
    let table = g.node("Expand", &[&three, &sides], vec![]);
    let largest = g.node("ReduceMax", &[&table], vec![ints("axes", &[0, 1])]);
    let number = AttributeProto { name: "to".into(), i: 1, r#type: AttributeType::Int as i32, ..Default::default() };
    let largest = g.node("Cast", &[&largest], vec![number]);
    let sum = g.node("Add", &["x", &largest], vec![]);
    let net = prepare(&g.finish(&sum, &[2, 2], &[2, 2]), &[2, 2], &Options::default()).unwrap();
    assert!(net.plan.model().nodes().iter().all(|node| !node.op().name().starts_with("Reduce")));
    assert_eq!(net.run(&[0.0, 1.0, 2.0, 3.0], &Cancel::default()).unwrap()[..], [3.0, 4.0, 5.0, 6.0]);
}
