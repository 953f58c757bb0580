//! Puts the direct convolution in place of the convolutions that qualify; all others stay tract's own.
//!
//! Looked for: `(Pad edge →) Conv (→ Elu | → Tanh (→ Mul by a number))` with f32, constant weights, group 1, stride 1,
//! a kernel of 3×3 or 3×3×3 with equal dilation of rows and columns, and a padding that keeps the size.

use std::sync::Arc;

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::array::{MultiBroadcastTo, Pad, PadMode};
use tract_onnx::tract_core::ops::binary::TypedBinOp;
use tract_onnx::tract_core::ops::cnn::{Conv, KernelFormat, PaddingSpec};
use tract_onnx::tract_core::ops::element_wise::ElementWiseOp;
use tract_onnx::tract_core::ops::math::{Mul, Tanh};
use tract_onnx::tract_core::ops::nn::DataFormat;

use super::elu::FusedElu;
use super::op::DirectConv;
use super::tail::Tail;
use crate::kernel::{Activation, Isa, Kernel, Limits, Packed, Padding};

/// Rewrites a decluttered model.
pub(super) fn rewrite(model: &mut TypedModel, isa: Isa) -> TractResult<()> {
    Rewriter::<Isa>::default().with_rule_for("direct-conv", rule).rewrite(&isa, model)
}

fn rule(
    isa: &Isa,
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    conv: &Conv,
) -> TractResult<Option<TypedModelPatch>> {
    let Some((kernel, dilation)) = kernel(conv) else { return Ok(None) };
    let Some((input, padding)) = padding(model, node, conv, kernel, dilation)? else { return Ok(None) };
    let input_fact = model.outlet_fact(input)?;
    if input_fact.datum_type != f32::datum_type() || input_fact.rank() != conv.pool_spec.rank() + 2 {
        return Ok(None);
    }
    let constant = |slot: usize| model.outlet_fact(node.inputs[slot]).map(|fact| fact.konst.clone());
    let (Some(weights), Some(bias)) = (constant(1)?, constant(2)?) else { return Ok(None) };
    let [channels_in, channels_out] = [conv.input_channels(), conv.output_channels()];
    let weights = weights.try_as_plain_ram()?.as_slice::<f32>()?.to_vec();
    let mut bias = bias.try_as_plain_ram()?.as_slice::<f32>()?.to_vec();
    if bias.len() == 1 {
        bias.resize(channels_out, bias[0]);
    }
    if weights.len() != channels_in * channels_out * kernel.taps() || bias.len() != channels_out {
        return Ok(None);
    }
    let (activation, last) = activation(model, node)?;
    let shape = model.outlet_fact(last)?.shape.clone();
    // A depth net that has learned one map for all views says it once.
    let results = if are_alike(&weights, &bias) { 1 } else { channels_out };
    let (channels, row) = ([channels_in, results], channels_in * kernel.taps());
    let weights = Arc::new(Packed::of(&weights[..results * row], results, channels_in, kernel));
    let (isa, bias, before, limits) = (*isa, bias[..results].into(), Limits::NONE, Limits::NONE);
    let op = DirectConv { isa, kernel, dilation, padding, activation, channels, weights, bias, before, limits };
    let mut patch = TypedModelPatch::default();
    let tap = patch.tap_model(model, input)?;
    let mut output = patch.wire_node(format!("{name}.direct"), op, &[tap])?;
    if results < channels_out {
        output = patch.wire_node(format!("{name}.alike"), MultiBroadcastTo { shape }, &output)?;
    }
    patch.shunt_outside(model, last, output[0])?;
    Ok(Some(patch))
}

/// Whether all results have the same weights and the same bias.
fn are_alike(weights: &[f32], bias: &[f32]) -> bool {
    let row = weights.len() / bias.len().max(1);
    weights.chunks_exact(row.max(1)).all(|other| other == &weights[..row]) && bias.iter().all(|other| *other == bias[0])
}

/// The kernel and its dilation, if the direct convolution has it.
fn kernel(conv: &Conv) -> Option<(Kernel, usize)> {
    let spec = &conv.pool_spec;
    let dilations = spec.dilations();
    let kernel = match spec.kernel_shape[..] {
        [3, 3] => Kernel::Plane,
        [3, 3, 3] if dilations[0] == 1 => Kernel::Volume,
        _ => return None,
    };
    let [.., rows, columns] = dilations[..] else { return None };
    let plain = conv.group == 1 && conv.q_params.is_none() && conv.kernel_fmt == KernelFormat::OIHW;
    let fits = spec.data_format == DataFormat::NCHW && spec.strides().iter().all(|&step| step == 1) && rows == columns;
    (plain && fits).then_some((kernel, rows))
}

/// Where the unpadded input comes from, and what it is padded with, if the padding keeps the size.
fn padding(
    model: &TypedModel,
    node: &TypedNode,
    conv: &Conv,
    kernel: Kernel,
    dilation: usize,
) -> TractResult<Option<(OutletId, Padding)>> {
    let same: Vec<usize> = match kernel {
        Kernel::Volume => vec![1, dilation, dilation],
        _ => vec![dilation; 2],
    };
    let input = node.inputs[0];
    let none = match &conv.pool_spec.padding {
        PaddingSpec::Explicit(before, after) if before[..] == same[..] && after[..] == same[..] => {
            return Ok(Some((input, Padding::Zero)));
        }
        PaddingSpec::SameUpper | PaddingSpec::SameLower => return Ok(Some((input, Padding::Zero))),
        PaddingSpec::Explicit(before, after) => before.iter().chain(after).all(|&n| n == 0),
        PaddingSpec::Valid => true,
        PaddingSpec::ExplicitOnnxPool(..) => false,
    };
    let before = model.node(input.node);
    let Some(pad) = before.op_as::<Pad>() else { return Ok(None) };
    let padding = match &pad.mode {
        PadMode::Edge => Padding::Edge,
        PadMode::Constant(value) if value.cast_to_scalar::<f32>()? == 0.0 => Padding::Zero,
        _ => return Ok(None),
    };
    let expected = [0, 0].iter().chain(&same).map(|&n| (n, n));
    let fits = none && pad.pads.iter().copied().eq(expected);
    Ok(fits.then_some((before.inputs[0], padding)))
}

/// The activation that follows, and the outlet behind it.
fn activation(model: &TypedModel, node: &TypedNode) -> TractResult<(Activation, OutletId)> {
    let plain = (Activation::None, node.id.into());
    let Some(next) = model.single_succ(node.id)? else { return Ok(plain) };
    let Some(op) = next.op_as::<ElementWiseOp>() else { return clamp(model, node) };
    if op.0.is::<FusedElu>() {
        return Ok((Activation::Elu, next.id.into()));
    }
    if !op.0.is::<Tanh>() {
        return Ok(plain);
    }
    let tanh = (Activation::Tanh { scale: 1.0 }, next.id.into());
    let Some(scaled) = model.single_succ(next.id)? else { return Ok(tanh) };
    Ok(match scale(model, scaled, next.id)? {
        Some(scale) => (Activation::Tanh { scale }, scaled.id.into()),
        None => tanh,
    })
}

/// The limits that the result is kept within, and the outlet behind them.
fn clamp(model: &TypedModel, node: &TypedNode) -> TractResult<(Activation, OutletId)> {
    let tail = Tail::alone(model, node, &[], 1)?;
    let plain = tail.scale == [1.0] && tail.bias == [0.0];
    Ok(if plain { (tail.activation, tail.last) } else { (Activation::None, node.id.into()) })
}

/// The positive number by which `node` multiplies the result of the node `of`.
fn scale(model: &TypedModel, node: &TypedNode, of: usize) -> TractResult<Option<f32>> {
    if !node.op_as::<TypedBinOp>().is_some_and(|op| op.0.is::<Mul>()) {
        return Ok(None);
    }
    let Some(&other) = node.inputs.iter().find(|input| input.node != of) else { return Ok(None) };
    let fact = model.outlet_fact(other)?;
    let same_shape = node.outputs[0].fact.shape == model.node(of).outputs[0].fact.shape;
    let number = fact.konst.as_ref().filter(|konst| konst.len() == 1 && same_shape);
    number.map(|konst| konst.cast_to_scalar::<f32>()).transpose()
}
