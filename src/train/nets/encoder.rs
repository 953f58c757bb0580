//! An encoder beside the U-Net: EfficientNet-Lite (Tan and Le 2019; Google's variant without squeeze-and-excitation and with ReLU6), trained
//! on ImageNet by others. What it knows of things, a few thousand photos with depth cannot teach.

use super::build::Builder;
use super::{Conv, End, Form};

/// Names of its layers begin so.
pub const PREFIX: &str = "lite.";

/// Inverted residual blocks of one shape (Sandler et al. 2018).
pub(super) struct Stage {
    /// Pixels along a side of the kernels.
    side: usize,
    /// Stride of the first block.
    stride: usize,
    /// Pixels between taps: a stage that has lost its stride sees as far as it did with it.
    dilation: usize,
    /// Channels within a block against those that come in.
    wider: usize,
    /// Channels of the result.
    outputs: usize,
    /// Blocks.
    blocks: usize,
}

/// The whole encoder.
pub(super) struct Encoder {
    /// Channels after the first convolution, which halves the picture.
    stem: usize,
    stages: &'static [Stage],
}

const fn stage(side: usize, [stride, dilation]: [usize; 2], wider: usize, outputs: usize, blocks: usize) -> Stage {
    Stage { side, stride, dilation, wider, outputs, blocks }
}

impl Encoder {
    /// EfficientNet-Lite0 without its head. Its sixth stage has no stride, as the deepest level of the U-Net is a sixteenth.
    pub(super) const LITE0: Self = Self {
        stem: 32,
        stages: &[
            stage(3, [1, 1], 1, 16, 1),
            stage(3, [2, 1], 6, 24, 2),
            stage(5, [2, 1], 6, 40, 2),
            stage(3, [2, 1], 6, 80, 3),
            stage(5, [1, 1], 6, 112, 3),
            stage(5, [1, 2], 6, 192, 4),
            stage(3, [1, 2], 6, 320, 1),
        ],
    };
    /// One for tests.
    pub(super) const TINY: Self =
        Self { stem: 4, stages: &[stage(3, [1, 1], 1, 4, 1), stage(5, [2, 1], 2, 6, 2), stage(3, [1, 2], 2, 6, 2)] };

    /// Adds its nodes. Returns the last node of each size, and the last one before the dilated stages, each with how often the
    /// picture was halved.
    pub(super) fn build(&self, net: &mut Builder) -> Vec<(usize, usize)> {
        let stem = Form::Patch { side: 3, stride: 2, each: false };
        let mut level = 1;
        net.settled("stem", (stem, 1), self.stem, true, None);
        let mut features = Vec::new();
        for (at, stage) in self.stages.iter().enumerate() {
            for block in 0..stage.blocks {
                self.block(net, stage, &format!("{at}_{block}"), block == 0);
            }
            level += usize::from(stage.stride == 2);
            let rest = &self.stages[at + 1..];
            // The stage that a stride follows, the last one, and the last before the dilated ones.
            let ends = rest.first().is_none_or(|next| next.stride == 2 || next.dilation > stage.dilation);
            if ends {
                features.push((level, net.last()));
            }
        }
        features
    }

    fn block(&self, net: &mut Builder, stage: &Stage, name: &str, first: bool) {
        let from = net.last();
        let inputs = net.channels[from];
        let wide = inputs * stage.wider;
        let pointwise = (Form::Patch { side: 1, stride: 1, each: false }, 1);
        if stage.wider > 1 {
            net.settled(&format!("{name}.wide"), pointwise, wide, true, None);
        }
        let stride = if first { stage.stride } else { 1 };
        let each = Form::Patch { side: stage.side, stride, each: true };
        net.settled(&format!("{name}.each"), (each, stage.dilation), wide, true, None);
        let added = (stride == 1 && inputs == stage.outputs).then_some(from);
        net.settled(&format!("{name}.narrow"), pointwise, stage.outputs, false, added);
    }
}

impl Builder {
    /// Adds a convolution of the last node whose statistics are settled.
    fn settled(
        &mut self,
        name: &str,
        (form, dilation): (Form, usize),
        outputs: usize,
        clamped: bool,
        added: Option<usize>,
    ) {
        let from = self.last();
        let (name, inputs) = (format!("{PREFIX}{name}"), self.channels[from]);
        self.conv_of(from, Conv { name, form, inputs, outputs, dilation, end: End::Settled { clamped }, added });
    }
}
