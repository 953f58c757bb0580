//! Takes into a direct convolution what is done to its input and its result value by value: limits before it (a ReLU that
//! residual units begin with), a sum with another tensor and limits behind it.

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::binary::TypedBinOp;
use tract_onnx::tract_core::ops::math::Add;

use super::op::DirectConv;
use super::{roles, tail};
use crate::kernel::Kernel;

/// Rewrites a model with direct convolutions.
pub(super) fn rewrite(model: &mut TypedModel) -> TractResult<()> {
    Rewriter::<()>::default().with_rule_for("before", before).with_rule_for("behind", behind).rewrite(&(), model)
}

/// Limits of the input; they may be wanted elsewhere too.
fn before(
    _: &(),
    model: &TypedModel,
    node: &TypedNode,
    _name: &str,
    conv: &DirectConv,
) -> TractResult<Option<TypedModelPatch>> {
    let found = tail::limits(model, model.node(node.inputs[0].node))?;
    let Some((input, limits)) = found.filter(|_| conv.kernel == Kernel::Plane) else { return Ok(None) };
    // The limits of the node are applied first, those that were found before after it.
    let Some(before) = limits.then(conv.before) else { return Ok(None) };
    let inputs: TVec<OutletId> = std::iter::once(input).chain(node.inputs.iter().skip(1).copied()).collect();
    TypedModelPatch::replace_single_op(model, node, &inputs, DirectConv { before, ..conv.clone() }).map(Some)
}

/// A sum with a tensor of the same shape, or limits.
fn behind(
    _: &(),
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    conv: &DirectConv,
) -> TractResult<Option<TypedModelPatch>> {
    let next = model.single_succ(node.id)?.filter(|_| conv.kernel == Kernel::Plane);
    let (Some(next), Some(shape)) = (next, roles::shape(model, node.id.into())?) else { return Ok(None) };
    if roles::shape(model, next.id.into())?.as_ref() != Some(&shape) {
        return Ok(None);
    }
    let (mut inputs, mut conv) = (node.inputs.clone(), conv.clone());
    if let Some(limits) = tail::limits(model, next)?.and_then(|(_, limits)| conv.limits.then(limits)) {
        conv.limits = limits;
    } else if inputs.len() == 1
        && !conv.limits.are_some()
        && next.op_as::<TypedBinOp>().is_some_and(|op| op.0.is::<Add>())
    {
        let Some(&other) = next.inputs.iter().find(|input| input.node != node.id) else { return Ok(None) };
        let fact = model.outlet_fact(other)?;
        if fact.datum_type != f32::datum_type() || fact.shape.as_concrete() != Some(&shape) {
            return Ok(None);
        }
        inputs.push(other);
    } else {
        return Ok(None);
    }
    let mut patch = TypedModelPatch::default();
    let taps: TractResult<TVec<_>> = inputs.iter().map(|input| patch.tap_model(model, *input)).collect();
    let output = patch.wire_node(format!("{name}.end"), conv, &taps?)?;
    patch.shunt_outside(model, next.id.into(), output[0])?;
    Ok(Some(patch))
}
