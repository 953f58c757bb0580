//! Puts the kernel's products in place of the convolutions that the direct one does not do: other kernels and strides, and
//! each channel by itself.

use std::borrow::Cow;
use std::sync::Arc;

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::cnn::{Conv, KernelFormat, PaddingSpec};
use tract_onnx::tract_core::ops::nn::DataFormat;

use super::inverted::Part;
use super::op::DirectConv;
use super::tail::Tail;
use super::{op, roles};
use crate::job::Cancel;
use crate::kernel::product::{Columns, DepthWise, Patches, Project};
use crate::kernel::{Activation, Isa, Kernel, Limits, Padding};

/// Rewrites a decluttered model.
pub(super) fn rewrite(model: &mut TypedModel, isa: Isa) -> TractResult<()> {
    Rewriter::<Isa>::default()
        .with_rule_for("patch-conv", rule)
        .with_rule_for("narrow-conv", narrow)
        .rewrite(&isa, model)
}

/// Columns up to which the direct convolution would leave much of its registers empty.
const NARROW: usize = 10;
/// Channels from which on that costs more than the patches' copies do.
const MANY: usize = 64;

/// A direct convolution of many channels over a few columns becomes one of patches.
fn narrow(
    _: &Isa,
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    conv: &DirectConv,
) -> TractResult<Option<TypedModelPatch>> {
    let Some(shape) = roles::shape(model, node.id.into())? else { return Ok(None) };
    let &[1, _, height, width] = &shape[..] else { return Ok(None) };
    let plain = conv.kernel == Kernel::Plane && conv.padding == Padding::Zero;
    if !plain || width > NARROW || conv.channels.iter().any(|channels| *channels < MANY) {
        return Ok(None);
    }
    let (channels, dilation) = (conv.channels[0], [conv.dilation; 2]);
    let size = [height, width];
    let patches = Patches { channels, size, kernel: [3; 2], stride: [1; 2], dilation, before: dilation, output: size };
    let (isa, bias, activation, limits) = (conv.isa, Arc::clone(&conv.bias), conv.activation, conv.limits);
    let weights = conv.weights.plain().into();
    let (before, depthwise) = (conv.before, false);
    let op = PatchConv { isa, patches, before, weights, bias, activation, limits, shape, depthwise };
    TypedModelPatch::replace_single_op(model, node, &node.inputs, op)
        .map(|patch| Some(patch.with_context(format!("{name} narrow"))))
}

/// A convolution of one picture. Inputs: the picture, and what is added at the end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PatchConv {
    isa: Isa,
    patches: Patches,
    /// Of what comes in.
    before: Limits,
    pub(super) weights: Arc<[f32]>,
    bias: Arc<[f32]>,
    activation: Activation,
    limits: Limits,
    shape: TVec<usize>,
    /// Each channel by itself.
    depthwise: bool,
}

impl Eq for PatchConv {}

fn rule(
    isa: &Isa,
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    conv: &Conv,
) -> TractResult<Option<TypedModelPatch>> {
    let (Some(before), Some(shape)) = (roles::shape(model, node.inputs[0])?, roles::shape(model, node.id.into())?)
    else {
        return Ok(None);
    };
    let Some(patches) = patches(conv, &before, &shape) else { return Ok(None) };
    let depthwise = conv.group > 1;
    let fact = model.outlet_fact(node.inputs[0])?;
    let constant = |slot: usize| model.outlet_fact(node.inputs[slot]).map(|fact| fact.konst.clone());
    let (Some(weights), Some(bias)) = (constant(1)?, constant(2)?) else { return Ok(None) };
    if [fact.datum_type, weights.datum_type(), bias.datum_type()].iter().any(|kind| *kind != f32::datum_type()) {
        return Ok(None);
    }
    let channels = conv.output_channels();
    let weights = weights.try_as_plain_ram()?.as_slice::<f32>()?;
    let bias = bias.try_as_plain_ram()?.as_slice::<f32>()?;
    let depth = if depthwise { patches.depth() / patches.channels } else { patches.depth() };
    if weights.len() != channels * depth || ![1, channels].contains(&bias.len()) {
        return Ok(None);
    }
    let axis = shape.len() - 3;
    let tail = if depthwise {
        Tail::alone(model, node, &[axis], channels)?
    } else {
        Tail::of(model, node, &[axis], channels)?
    };
    let scaled = |(i, weight): (usize, &f32)| weight * tail.scale[i / depth];
    let bias = (0..channels).map(|c| bias[c % bias.len()] * tail.scale[c] + tail.bias[c]).collect();
    let weights = weights.iter().enumerate().map(scaled).collect();
    let (isa, activation, limits) = (*isa, tail.activation, tail.limits);
    let before = Limits::NONE;
    let op = PatchConv { isa, patches, before, weights, bias, activation, limits, shape, depthwise };
    let mut patch = TypedModelPatch::default();
    let inputs: TractResult<TVec<_>> =
        std::iter::once(node.inputs[0]).chain(tail.summand).map(|input| patch.tap_model(model, input)).collect();
    let output = patch.wire_node(format!("{name}.patches"), op, &inputs?)?;
    patch.shunt_outside(model, tail.last, output[0])?;
    Ok(Some(patch))
}

/// Sizes of a convolution of one picture in two dimensions with zero padding, of all channels or of each by itself.
fn patches(conv: &Conv, before: &[usize], after: &[usize]) -> Option<Patches> {
    let spec = &conv.pool_spec;
    let &[.., channels, height, width] = before else { return None };
    let &[.., rows, columns] = after else { return None };
    let one = match (spec.data_format, before) {
        (DataFormat::NCHW, [n, _, _, _]) => *n == 1,
        (DataFormat::CHW, [_, _, _]) => true,
        _ => false,
    };
    let of_each = conv.group == channels && conv.output_channels() == channels;
    let plain = one && conv.q_params.is_none() && conv.kernel_fmt == KernelFormat::OIHW;
    if !plain || !(conv.group == 1 || of_each) || before.contains(&0) || after.contains(&0) {
        return None;
    }
    let pair = |values: &[usize]| <[usize; 2]>::try_from(values).ok();
    let padding = match &spec.padding {
        PaddingSpec::Explicit(before, _) => pair(before)?,
        PaddingSpec::Valid => [0; 2],
        _ => return None,
    };
    Some(Patches {
        channels,
        size: [height, width],
        kernel: pair(&spec.kernel_shape)?,
        stride: pair(&spec.strides())?,
        dilation: pair(&spec.dilations())?,
        before: padding,
        output: [rows, columns],
    })
}

impl PatchConv {
    pub(super) fn isa(&self) -> Isa {
        self.isa
    }

    /// What it is where each channel is by itself.
    pub(super) fn each_channel(&self) -> Option<(Patches, Part)> {
        let part = || Part::new(&self.weights, &self.bias, self.activation);
        self.depthwise.then(|| (self.patches, part()))
    }

    fn run(&self, x: &Tensor, summand: Option<&Tensor>) -> TractResult<Tensor> {
        let mut output = op::uninitialized(&self.shape)?;
        let cancel = op::cancel();
        let flag = cancel.as_ref().map(Cancel::flag);
        let summand = summand.map(|summand| summand.try_as_plain_ram()?.as_slice::<f32>()).transpose()?;
        let mut x = Cow::Borrowed(x.try_as_plain_ram()?.as_slice::<f32>()?);
        let room = op::room(&mut output)?;
        let &Self { isa, ref patches, before, ref weights, ref bias, activation, limits, .. } = self;
        if before.are_some() {
            // A few values beside the patches that are made of them.
            x.to_mut().iter_mut().for_each(|value| *value = before.of(*value));
        }
        if self.depthwise {
            let planes = DepthWise { isa, patches, weights, bias, activation };
            planes.run(&x, room, flag)?;
        } else {
            let project = Project { isa, weights, bias, activation, limits };
            project.run(Columns::Patches(&x, patches), summand, room, flag)?;
        }
        Ok(output)
    }
}

impl Op for PatchConv {
    fn name(&self) -> StaticName {
        if self.depthwise { "PlaneConv".into() } else { "PatchConv".into() }
    }

    fn info(&self) -> TractResult<Vec<String>> {
        Ok(vec![format!("{} {:?} {:?}", self.isa, self.patches, self.activation)])
    }

    op_as_typed_op!();
}

op::with_summand!(PatchConv);
