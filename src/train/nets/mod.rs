//! The nets: one graph a net, read by the trainer (burn) and by the exporter (ONNX).
//!
//! A net is a list of nodes, each naming the nodes it reads. There is one description, so what is exported is what was trained.

mod build;
mod encoder;
mod forward;
mod weights;

use serde::{Deserialize, Serialize};

pub use forward::{ByArray, Mode, NORM_EPSILON, Statistics, Tape, thinning, values, zeros};
pub use weights::{Bytes, Tensor32, Weights};

use crate::TrainError;
use crate::ops::Patch;

/// Views of the light field that a depth net describes: the paper's 8 × 8.
pub const VIEWS: usize = 64;
/// Views along one angular axis.
pub const SIDE: usize = 8;
/// Number of the reference view (4, 4) in `[v, u]` order.
pub const REFERENCE: usize = 36;
/// Name of the last layer, whose rows are a depth net's views.
const LAST: &str = "last";
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
    /// The same beside an encoder that has seen a million photos (EfficientNet-Lite0), whose features are added at each level on
    /// the way down: it begins as `ContextDeeper`.
    ContextLite,
    /// A U-Net of a few channels, for tests.
    Tiny,
    /// The same with such further convolutions.
    #[value(skip)]
    TinyDeep,
    /// The same with an encoder of a few channels beside it.
    #[value(skip)]
    TinyLite,
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
    /// Normalisation by statistics that stay as they are, then, if it is clamped, 0 … 6.
    Settled {
        /// Whether it is.
        clamped: bool,
    },
    /// Bias, then `scale · tanh(z / scale)`.
    Tanh {
        /// Largest magnitude of the result.
        scale: f32,
    },
}

/// Which pixels and channels a convolution takes together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// 3×3 (or 3×3×3) of all channels, stride 1, edge padded.
    Full,
    /// So many pixels squared, zero padded so that the result begins where the picture does (TensorFlow's SAME for even sizes).
    Patch {
        /// Pixels along a side.
        side: usize,
        /// Pixels from one patch to the next.
        stride: usize,
        /// Whether each channel is convolved by itself.
        each: bool,
    },
}

impl Form {
    /// Pixels from one result to the next.
    pub fn stride(self) -> usize {
        if let Self::Patch { stride, .. } = self { stride } else { 1 }
    }
}

/// One convolution.
#[derive(Clone, Debug, PartialEq)]
pub struct Conv {
    /// Name of its weights: `name.weight`, `name.gamma`, …
    pub name: String,
    /// What it takes together.
    pub form: Form,
    /// Channels in.
    pub inputs: usize,
    /// Channels out.
    pub outputs: usize,
    /// Step between taps in y and x (the angular axis of a 3-D convolution has 1).
    pub dilation: usize,
    /// How it ends.
    pub end: End,
    /// The node that what it says is added to. A new layer of the U-Net that is added begins silent (γ = 0).
    pub added: Option<usize>,
}

impl Conv {
    fn full(name: String, inputs: usize, outputs: usize, end: End) -> Self {
        Self { name, form: Form::Full, inputs, outputs, dilation: 1, end, added: None }
    }

    /// Sizes of its weights in a net of this rank, outermost first.
    pub fn weight_shape(&self, rank: usize) -> Vec<usize> {
        match self.form {
            Form::Full => [self.outputs, self.inputs].into_iter().chain(vec![3; rank]).collect(),
            Form::Patch { side, each, .. } => vec![self.outputs, if each { 1 } else { self.inputs }, side, side],
        }
    }

    /// How the operations do it where it is zero padded.
    pub fn patch(&self) -> Patch {
        Patch { form: self.form, dilation: self.dilation, clamped: self.end == End::Settled { clamped: true } }
    }

    /// Products of one value of the result.
    fn products(&self, rank: usize) -> usize {
        self.weight_shape(rank)[1..].iter().product()
    }
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

impl Arch {
    /// What it says.
    pub fn task(self) -> Task {
        match self {
            Self::Occlusion => Task::Occlusion,
            Self::AppearanceFlow => Task::Flow,
            Self::DirectRegression => Task::Views,
            Self::CornerDisparity => Task::CornerDepth,
            Self::CornerColour => Task::CornerColour,
            Self::Paper | Self::PaperYx | Self::Context | Self::ContextDeep | Self::ContextDeeper => Task::Depth,
            Self::ContextLite | Self::Tiny | Self::TinyDeep | Self::TinyLite => Task::Depth,
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
            Self::PaperYx | Self::Context | Self::ContextDeep | Self::ContextDeeper | Self::ContextLite => {
                &["rgb", "yx"]
            }
            Self::Tiny | Self::TinyDeep | Self::TinyLite => &["rgb", "yx"],
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
                Node::Conv(from, conv) => areas[*from] / (conv.form.stride() as f64).powi(2),
                Node::Pool(from) => areas[*from] / 4.0,
                Node::UpConcat(low, _) => areas[*low] * 4.0,
            };
        }
        areas
    }

    /// Floating-point operations of one forward pass, per pixel (and view, for rank 3) at full size.
    pub fn flop_per_pixel(&self) -> f64 {
        let of = |node: &Node| match node {
            Node::Conv(_, conv) => 2.0 * (conv.outputs * conv.products(self.rank)) as f64,
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
    fn each_everyday_net_holds_the_one_before_and_fits_its_file() {
        let nets = [Arch::Context, Arch::ContextDeep, Arch::ContextDeeper, Arch::ContextLite].map(Arch::graph);
        let mut weights = Weights::random(&nets[0], 1);
        for (net, (most_bytes, most_flop)) in
            nets[1..].iter().zip([(12 << 20, 320e3), (12 << 20, 320e3), (22 << 20, 340e3)])
        {
            weights = weights.grown(net, 1).unwrap();
            // In 16 bits; in 8 it is half of that.
            assert!(2 * weights.trained_values() < most_bytes, "{} parameters", weights.trained_values());
            assert!(net.flop_per_pixel() < most_flop, "{} FLOP a pixel", net.flop_per_pixel());
        }
    }

    #[test]
    fn the_encoder_is_efficientnet_lite0_without_its_head() {
        let weights = Weights::random(&Arch::ContextLite.graph(), 1);
        let values = |what: &str| {
            let of = weights.tensors.iter().filter(|t| t.is_of_encoder() && t.name.ends_with(what));
            of.map(|t| t.values.len()).sum::<usize>()
        };
        // Counted by the paper's widths, and the weights of the stem for two coordinates.
        assert_eq!(values(".weight"), 2_919_392 + 2 * 9 * 32);
        let last = weights.get("lite.6_0.narrow.weight").unwrap();
        assert_eq!(last.shape, [320, 1152, 1, 1]);
        assert_eq!(weights.get("seen3.weight").unwrap().shape, [224, 112, 3, 3]);
        assert_eq!(weights.get("seen4.weight").unwrap().shape, [224, 320, 3, 3]);
    }
}
