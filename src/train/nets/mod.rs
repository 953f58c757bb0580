//! The nets: one graph a net, read by the trainer (burn) and by the exporter (ONNX).
//!
//! A net is a list of nodes, each naming the nodes it reads. There is one description, so what is exported is what was trained.

mod forward;
mod weights;

use plenoscope::synth::corners::{Between, RANGE_PX as CORNER_RANGE_PX};
use serde::{Deserialize, Serialize};

pub use forward::{ByArray, Mode, NORM_EPSILON, Statistics, Tape, thinning, values, zeros};
pub use weights::{Tensor32, Weights};

use crate::TrainError;

/// Views of the light field that a depth net describes: the paper's 8 × 8.
pub const VIEWS: usize = 64;
/// Views along one angular axis.
pub const SIDE: usize = 8;
/// Number of the reference view (4, 4) in `[v, u]` order.
pub const REFERENCE: usize = 36;
/// Name of the last layer, whose rows are a depth net's views.
const LAST: &str = "last";
/// Channels of the everyday nets, from full size to a sixteenth.
const CONTEXT_WIDTHS: [usize; 5] = [16, 32, 80, 160, 224];
/// Largest ray depth in px per view step at the net's own width: D = 4·tanh(z / 4).
pub const RANGE_PX: f32 = 4.0;
/// Largest flow in px: what that ray depth moves the outermost view by.
pub const FLOW_RANGE_PX: f32 = 16.0;

/// The architectures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Arch {
    /// The paper's dilated depth net (§4.1, widths of its released notebook): sees 73 px, colour alone.
    Paper,
    /// The paper's depth net with the pixel's two coordinates as further input channels.
    PaperYx,
    /// A U-Net that sees the whole picture, with coordinates: the everyday model.
    Context,
    /// The same with further convolutions at each level, what they say added to what they read: it begins as `Context`.
    ContextDeep,
    /// More of them, on the way down and at the finer levels too: it begins as `ContextDeep`.
    ContextDeeper,
    /// A U-Net of a few channels, for tests.
    Tiny,
    /// The same with such further convolutions.
    #[value(skip)]
    TinyDeep,
    /// The paper's 3-D occlusion net (§4.3).
    Occlusion,
    /// The paper's depth net with two maps a view: the flow to the right and down by which the photo becomes the view
    /// (Zhou et al. 2016, as the paper adapts it).
    #[value(skip)]
    AppearanceFlow,
    /// The same layers with the colours of the 64 views as their result (the paper, §6), told as what is to be added to
    /// those of the photo.
    #[value(skip)]
    DirectRegression,
    /// Ray depth of a view from how far the four corners agree about it (class of Kalantari et al. 2016).
    #[value(skip)]
    CornerDisparity,
    /// What is to be added to the blend of the four corners as that view sees them.
    #[value(skip)]
    CornerColour,
}

/// What a net says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// The ray depths of all views.
    Depth,
    /// What is to be added to Lambertian views.
    Occlusion,
    /// Where in the photo each ray's colour lies.
    Flow,
    /// What is to be added to the photo to become each view.
    Views,
    /// The ray depths of one view between corners.
    CornerDepth,
    /// The colours of one view between corners.
    CornerColour,
}

impl Task {
    /// A net of this task, as sentences name it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Depth => "a depth net",
            Self::Occlusion => "the occlusion net",
            Self::Flow => "an appearance-flow net",
            Self::Views => "a net that regresses views",
            Self::CornerDepth => "a disparity net of four corners",
            Self::CornerColour => "a colour net of four corners",
        }
    }
}

/// How a convolution ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// Batch normalisation, then ELU.
    NormElu,
    /// Bias, then `scale · tanh(z / scale)`.
    Tanh {
        /// Largest magnitude of the result.
        scale: f32,
    },
}

/// One convolution 3×3 (or 3×3×3), stride 1, edge padded, same size.
#[derive(Clone, Debug, PartialEq)]
pub struct Conv {
    /// Name of its weights: `name.weight`, `name.gamma`, …
    pub name: String,
    /// Channels in.
    pub inputs: usize,
    /// Channels out.
    pub outputs: usize,
    /// Step between taps in y and x (the angular axis of a 3-D convolution has 1).
    pub dilation: usize,
    /// How it ends.
    pub end: End,
    /// Whether what it says is added to what it reads. Such a convolution begins silent (γ = 0).
    pub added: bool,
}

/// A node of a net. Numbers are indices of earlier nodes.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// What the net is given.
    Input,
    /// Convolution of one node.
    Conv(usize, Conv),
    /// Mean of 2×2 pixels.
    Pool(usize),
    /// The first node at twice its size (nearest pixel), its channels followed by those of the second.
    UpConcat(usize, usize),
}

/// A net: nodes in order of computation; the last one is the result.
#[derive(Clone, Debug, PartialEq)]
pub struct Graph {
    /// Which net it is.
    pub arch: Arch,
    /// The nodes.
    pub nodes: Vec<Node>,
    /// 2 for pictures `[n, c, h, w]`, 3 for stacks of views `[n, c, v, h, w]`.
    pub rank: usize,
    /// Height and width must be multiples of this.
    pub multiple_of: usize,
}

/// Builds a graph node by node.
struct Builder {
    nodes: Vec<Node>,
    channels: Vec<usize>,
}

impl Builder {
    fn new(inputs: usize) -> Self {
        Self { nodes: vec![Node::Input], channels: vec![inputs] }
    }

    fn last(&self) -> usize {
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
        let conv = Conv { name: name.to_owned(), inputs: self.channels[from], outputs, dilation, end, added: false };
        self.push(Node::Conv(from, conv), outputs)
    }

    /// Adds convolutions of as many channels whose results are added to what they read, with dilations 1 … `farthest` in turn.
    fn refine(&mut self, name: &str, count: usize, farthest: usize) {
        for i in 0..count {
            let dilation = 1 + i % farthest;
            let (from, name) = (self.last(), format!("{name}_more{i}"));
            let width = self.channels[from];
            let conv = Conv { name, inputs: width, outputs: width, dilation, end: End::NormElu, added: true };
            self.push(Node::Conv(from, conv), width);
        }
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
/// of each level follow on the way down (the deepest level's, too), then on the way up, from full size on.
fn u_net(arch: Arch, widths: &[usize], [down, up]: [&[usize]; 2]) -> Graph {
    let mut net = Builder::new(5);
    let mut skips = Vec::new();
    let deepest = widths.len() - 1;
    for (level, &width) in widths.iter().enumerate() {
        if level > 0 {
            net.pool();
        }
        let dilations: &[usize] = if level == deepest { &[1, 2, 4] } else { &[1, 1] };
        for (i, &dilation) in dilations.iter().enumerate() {
            net.conv(&format!("down{level}_{i}"), width, dilation, End::NormElu);
        }
        let (name, farthest) = if level == deepest { ("deepest".to_owned(), 2) } else { (format!("down{level}"), 1) };
        net.refine(&name, down.get(level).copied().unwrap_or(0), farthest);
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
            Self::Context => u_net(self, &CONTEXT_WIDTHS, [&[], &[]]),
            Self::ContextDeep => u_net(self, &CONTEXT_WIDTHS, [&[0, 0, 0, 0, 4], &[2; 4]]),
            Self::ContextDeeper => u_net(self, &CONTEXT_WIDTHS, [&[0, 2, 2, 0, 4], &[2, 2, 6, 5]]),
            Self::Tiny => u_net(self, &[6, 8, 8], [&[], &[]]),
            Self::TinyDeep => u_net(self, &[6, 8, 8], [&[0, 0, 2], &[1; 2]]),
            Self::Occlusion => occlusion(),
        }
    }

    /// What it says.
    pub fn task(self) -> Task {
        match self {
            Self::Occlusion => Task::Occlusion,
            Self::AppearanceFlow => Task::Flow,
            Self::DirectRegression => Task::Views,
            Self::CornerDisparity => Task::CornerDepth,
            Self::CornerColour => Task::CornerColour,
            Self::Paper | Self::PaperYx | Self::Context | Self::ContextDeep | Self::ContextDeeper => Task::Depth,
            Self::Tiny | Self::TinyDeep => Task::Depth,
        }
    }

    /// Maps that the last layer gives for each view.
    pub fn rows_per_view(self) -> usize {
        match self.task() {
            Task::Depth | Task::Occlusion | Task::CornerDepth => 1,
            Task::Flow => 2,
            Task::Views | Task::CornerColour => 3,
        }
    }

    /// The manifest's `inputs`: what the channels are, in order.
    pub fn inputs(self) -> &'static [&'static str] {
        match self {
            Self::Paper | Self::AppearanceFlow | Self::DirectRegression => &["rgb"],
            Self::CornerDisparity => &["agreement"],
            Self::CornerColour => &["corners", "disparity", "view"],
            Self::Occlusion => &["rgb", "disparity"],
            Self::PaperYx | Self::Context | Self::ContextDeep | Self::ContextDeeper | Self::Tiny | Self::TinyDeep => {
                &["rgb", "yx"]
            }
        }
    }

    /// Whether the pixel's coordinates are among the inputs.
    pub fn has_coordinates(self) -> bool {
        self.inputs().contains(&"yx")
    }

    /// The name as it is written on the command line and in checkpoints.
    pub fn name(self) -> String {
        serde_json::to_value(self).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
    }
}

impl Graph {
    /// All convolutions in order.
    pub fn convs(&self) -> impl Iterator<Item = &Conv> {
        self.nodes.iter().filter_map(|node| if let Node::Conv(_, conv) = node { Some(conv) } else { None })
    }

    /// Channels that the net takes.
    pub fn input_channels(&self) -> usize {
        self.convs().next().map_or(0, |conv| conv.inputs)
    }

    /// Area of each node's maps against the picture's.
    pub fn areas(&self) -> Vec<f64> {
        let mut areas = vec![1.0; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate() {
            areas[i] = match node {
                Node::Input => 1.0,
                Node::Conv(from, _) => areas[*from],
                Node::Pool(from) => areas[*from] / 4.0,
                Node::UpConcat(low, _) => areas[*low] * 4.0,
            };
        }
        areas
    }

    /// Floating-point operations of one forward pass, per pixel (and view, for rank 3) at full size.
    pub fn flop_per_pixel(&self) -> f64 {
        let of = |node: &Node| match node {
            Node::Conv(_, conv) => 2.0 * (conv.inputs * conv.outputs * 3usize.pow(self.rank as u32)) as f64,
            _ => 0.0,
        };
        self.nodes.iter().zip(self.areas()).map(|(node, area)| of(node) * area).sum()
    }

    /// `Err` when a picture of this size cannot go through the net.
    pub fn check_size(&self, width: usize, height: usize) -> Result<(), TrainError> {
        let m = self.multiple_of;
        if width > 0 && height > 0 && width.is_multiple_of(m) && height.is_multiple_of(m) {
            Ok(())
        } else {
            Err(TrainError::Size { width, height, multiple_of: m })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_net_has_the_papers_work() {
        assert_eq!(Arch::Paper.graph().flop_per_pixel(), 2.0 * 931_248.0);
        assert_eq!(Arch::Occlusion.graph().flop_per_pixel(), 13_392.0);
    }

    #[test]
    fn the_everyday_net_is_small() {
        let graph = Arch::Context.graph();
        let parameters = Weights::random(&graph, 1).trained_values();
        assert!(parameters < 4_000_000, "{parameters} parameters");
        assert!(graph.flop_per_pixel() < 160_000.0, "{} FLOP a pixel", graph.flop_per_pixel());
        assert_eq!(graph.multiple_of, 16);
    }

    #[test]
    fn each_everyday_net_holds_the_one_before_and_fits_its_file_in_16_bits() {
        let [context, deep, deeper] = [Arch::Context, Arch::ContextDeep, Arch::ContextDeeper].map(Arch::graph);
        let grown = Weights::random(&context, 1).grown(&deep, 1).and_then(|weights| weights.grown(&deeper, 1)).unwrap();
        assert!(2 * grown.trained_values() < 12 << 20, "{} parameters", grown.trained_values());
        assert!(deeper.flop_per_pixel() < 320_000.0, "{} FLOP a pixel", deeper.flop_per_pixel());
    }
}
