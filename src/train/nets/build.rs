//! The graph of each architecture, built node by node.

use plenoscope::synth::corners::{Between, RANGE_PX as CORNER_RANGE_PX};

use super::encoder::Encoder;
use super::{Arch, Conv, End, FLOW_RANGE_PX, Graph, LAST, Node, RANGE_PX, VIEWS};

/// Channels of the everyday nets, from full size to a sixteenth.
const CONTEXT_WIDTHS: [usize; 5] = [16, 32, 80, 160, 224];
/// Further convolutions of the deepest of them, on the way down and up.
const DEEPER: [&[usize]; 2] = [&[0, 2, 2, 0, 4], &[2, 2, 6, 5]];
/// Those of the nets for tests.
const TINY_DEEP: [&[usize]; 2] = [&[0, 0, 2], &[1; 2]];

/// Builds a graph node by node.
pub(super) struct Builder {
    nodes: Vec<Node>,
    /// Channels of each.
    pub(super) channels: Vec<usize>,
}

impl Builder {
    fn new(inputs: usize) -> Self {
        Self { nodes: vec![Node::Input], channels: vec![inputs] }
    }

    pub(super) fn last(&self) -> usize {
        self.nodes.len() - 1
    }

    fn push(&mut self, node: Node, channels: usize) -> usize {
        self.nodes.push(node);
        self.channels.push(channels);
        self.last()
    }

    /// Adds a convolution of the last node.
    fn conv(&mut self, name: &str, outputs: usize, dilation: usize, end: End) -> usize {
        let from = self.last();
        self.conv_of(from, Conv { dilation, ..Conv::full(name.to_owned(), self.channels[from], outputs, end) })
    }

    pub(super) fn conv_of(&mut self, from: usize, conv: Conv) -> usize {
        let outputs = conv.outputs;
        self.push(Node::Conv(from, conv), outputs)
    }

    /// Adds convolutions of as many channels whose results are added to what they read, with dilations 1 … `farthest` in turn.
    fn refine(&mut self, name: &str, count: usize, farthest: usize) {
        for i in 0..count {
            let dilation = 1 + i % farthest;
            let (from, name) = (self.last(), format!("{name}_more{i}"));
            let width = self.channels[from];
            let conv = Conv::full(name, width, width, End::NormElu);
            self.conv_of(from, Conv { dilation, added: Some(from), ..conv });
        }
    }

    /// Adds to the last node what a convolution of another one says.
    fn take_in(&mut self, name: String, from: usize) {
        let to = self.last();
        let conv = Conv::full(name, self.channels[from], self.channels[to], End::NormElu);
        self.conv_of(from, Conv { added: Some(to), ..conv });
    }

    fn pool(&mut self) -> usize {
        let from = self.last();
        self.push(Node::Pool(from), self.channels[from])
    }

    fn up_concat(&mut self, skip: usize) -> usize {
        let from = self.last();
        self.push(Node::UpConcat(from, skip), self.channels[from] + self.channels[skip])
    }

    fn finish(self, arch: Arch, rank: usize, multiple_of: usize) -> Graph {
        Graph { arch, nodes: self.nodes, rank, multiple_of }
    }
}

/// The paper's depth net: dilated 3×3 convolutions with batch normalisation and ELU, last layer a scaled tanh.
fn paper(arch: Arch, inputs: usize, scale: f32) -> Graph {
    let mut net = Builder::new(inputs);
    let layers = [(16, 1), (64, 1), (128, 1), (128, 2), (128, 4), (128, 8), (128, 16), (128, 1), (64, 1)];
    for (i, (outputs, dilation)) in layers.into_iter().enumerate() {
        net.conv(&format!("conv{i}"), outputs, dilation, End::NormElu);
    }
    net.conv(LAST, VIEWS * arch.rows_per_view(), 1, End::Tanh { scale });
    net.finish(arch, 2, 1)
}

/// A U-Net: two convolutions a level, mean pooling down, nearest pixel up, skips joined by concatenation; the
/// deepest level looks further with dilations 1, 2, 4, so that every pixel sees the whole picture. `further` convolutions
/// of each level follow on the way down (the deepest level's, too), then on the way up, from full size on. What an encoder
/// says of the same picture is added at the end of each level on the way down.
fn u_net(arch: Arch, widths: &[usize], [down, up]: [&[usize]; 2], encoder: Option<&Encoder>) -> Graph {
    let mut net = Builder::new(5);
    let features = encoder.map(|encoder| encoder.build(&mut net)).unwrap_or_default();
    let mut skips = Vec::new();
    let deepest = widths.len() - 1;
    for (level, &width) in widths.iter().enumerate() {
        let mut from = if level > 0 { net.pool() } else { 0 };
        let dilations: &[usize] = if level == deepest { &[1, 2, 4] } else { &[1, 1] };
        for (i, &dilation) in dilations.iter().enumerate() {
            let conv = Conv::full(format!("down{level}_{i}"), net.channels[from], width, End::NormElu);
            from = net.conv_of(from, Conv { dilation, ..conv });
        }
        let (name, farthest) = if level == deepest { ("deepest".to_owned(), 2) } else { (format!("down{level}"), 1) };
        net.refine(&name, down.get(level).copied().unwrap_or(0), farthest);
        for (i, (_, from)) in features.iter().enumerate().filter(|(_, (at, _))| *at == level) {
            net.take_in(format!("seen{i}"), *from);
        }
        skips.push(net.last());
    }
    for level in (0..deepest).rev() {
        net.up_concat(skips[level]);
        for i in 0..2 {
            net.conv(&format!("up{level}_{i}"), widths[level], 1, End::NormElu);
        }
        net.refine(&format!("up{level}"), up.get(level).copied().unwrap_or(0), 1);
    }
    net.conv(LAST, VIEWS, 1, End::Tanh { scale: RANGE_PX });
    net.finish(arch, 2, 1 << deepest)
}

/// The paper's occlusion net: five 3×3×3 convolutions over (views, y, x), the last a tanh; its result is added to the
/// Lambertian views.
fn occlusion() -> Graph {
    let mut net = Builder::new(4);
    for i in 0..4 {
        net.conv(&format!("conv{i}"), 8, 1, End::NormElu);
    }
    net.conv(LAST, 3, 1, End::Tanh { scale: 1.0 });
    net.finish(Arch::Occlusion, 3, 1)
}

/// Either net between four corners: few layers, as what tells is in each place's own features.
fn corners(arch: Arch, inputs: usize, outputs: usize, scale: f32) -> Graph {
    let mut net = Builder::new(inputs);
    for (i, (width, dilation)) in [(64, 1), (64, 2), (64, 4), (32, 1)].into_iter().enumerate() {
        net.conv(&format!("conv{i}"), width, dilation, End::NormElu);
    }
    net.conv(LAST, outputs, 1, End::Tanh { scale });
    net.finish(arch, 2, 1)
}

impl Arch {
    /// The net's graph.
    pub fn graph(self) -> Graph {
        match self {
            Self::Paper => paper(self, 3, RANGE_PX),
            Self::PaperYx => paper(self, 5, RANGE_PX),
            Self::AppearanceFlow => paper(self, 3, FLOW_RANGE_PX),
            Self::DirectRegression => paper(self, 3, 1.0),
            Self::CornerDisparity => corners(self, Between::AGREEMENT_CHANNELS, 1, CORNER_RANGE_PX),
            Self::CornerColour => corners(self, Between::COLOUR_CHANNELS, 3, 1.0),
            Self::Context => u_net(self, &CONTEXT_WIDTHS, [&[], &[]], None),
            Self::ContextDeep => u_net(self, &CONTEXT_WIDTHS, [&[0, 0, 0, 0, 4], &[2; 4]], None),
            Self::ContextDeeper => u_net(self, &CONTEXT_WIDTHS, DEEPER, None),
            Self::ContextLite => u_net(self, &CONTEXT_WIDTHS, DEEPER, Some(&Encoder::LITE0)),
            Self::Tiny => u_net(self, &[6, 8, 8], [&[], &[]], None),
            Self::TinyDeep => u_net(self, &[6, 8, 8], TINY_DEEP, None),
            Self::TinyLite => u_net(self, &[6, 8, 8], TINY_DEEP, Some(&Encoder::TINY)),
            Self::Occlusion => occlusion(),
        }
    }
}
