//! Puts one pass in place of the six that tract spends on a layer normalisation.
//!
//! Looked for: `RmsNorm(x − Σx/n) (· a constant) (+ a constant)` over the last axis, what tract makes of `LayerNormalization`
//! and of the same written out by exporters.

use std::sync::Arc;

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::binary::TypedBinOp;
use tract_onnx::tract_core::ops::math::{Mul, Sub};
use tract_onnx::tract_core::ops::nn::{Reduce, Reducer, RmsNorm};

use super::tail::Tail;
use super::{op, roles};
use crate::job::Cancel;
use crate::kernel::Isa;
use crate::kernel::{Activation, token};

/// Rewrites a decluttered model.
pub(super) fn rewrite(model: &mut TypedModel, isa: Isa) -> TractResult<()> {
    Rewriter::<Isa>::default().with_rule_for("layer-norm", rule).rewrite(&isa, model)
}

/// `(x − mean) / √(variance + ε) · scale + shift` over the last axis.
#[derive(Clone, Debug, PartialEq)]
struct LayerNorm {
    isa: Isa,
    epsilon: f32,
    scale: Arc<[f32]>,
    shift: Arc<[f32]>,
}

impl Eq for LayerNorm {}

fn rule(
    isa: &Isa,
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    norm: &RmsNorm,
) -> TractResult<Option<TypedModelPatch>> {
    let Some(shape) = roles::shape(model, node.id.into())? else { return Ok(None) };
    let last = shape.len().wrapping_sub(1);
    if norm.axis != last || model.outlet_fact(node.inputs[0])?.datum_type != f32::datum_type() {
        return Ok(None);
    }
    let Some(input) = centred(model, model.node(node.inputs[0].node), last, shape[last])? else { return Ok(None) };
    let tail = Tail::affine(model, node, &[last], shape[last])?;
    let epsilon = norm.eps.cast_to_scalar::<f32>()?;
    let op = LayerNorm { isa: *isa, epsilon, scale: tail.scale.into(), shift: tail.bias.into() };
    debug_assert!(tail.activation == Activation::None && tail.summand.is_none());
    let mut patch = TypedModelPatch::default();
    let tap = patch.tap_model(model, input)?;
    let output = patch.wire_node(format!("{name}.layer-norm"), op, &[tap])?;
    patch.shunt_outside(model, tail.last, output[0])?;
    Ok(Some(patch))
}

/// The `x` of `x − Σx · 1/n`.
fn centred(model: &TypedModel, node: &TypedNode, axis: usize, len: usize) -> TractResult<Option<OutletId>> {
    if !node.op_as::<TypedBinOp>().is_some_and(|op| op.0.is::<Sub>()) {
        return Ok(None);
    }
    let (x, mean) = (node.inputs[0], model.node(node.inputs[1].node));
    if !mean.op_as::<TypedBinOp>().is_some_and(|op| op.0.is::<Mul>()) {
        return Ok(None);
    }
    let sum = |input: &&OutletId| {
        let node = model.node(input.node);
        let sums = |op: &Reduce| op.reducer == Reducer::Sum && op.axes[..] == [axis];
        node.op_as::<Reduce>().is_some_and(sums) && node.inputs[0] == x
    };
    let Some(sum) = mean.inputs.iter().find(sum) else { return Ok(None) };
    let Some(&factor) = mean.inputs.iter().find(|input| *input != sum) else { return Ok(None) };
    let Some(konst) = model.outlet_fact(factor)?.konst.clone().filter(|konst| konst.len() == 1) else {
        return Ok(None);
    };
    let factor = konst.cast_to_scalar::<f32>()?;
    Ok(((factor * len as f32 - 1.0).abs() < 1e-6).then_some(x))
}

impl Op for LayerNorm {
    fn name(&self) -> StaticName {
        "LayerNorm".into()
    }

    op_as_typed_op!();
}

impl EvalOp for LayerNorm {
    op_out_of_plan!();

    fn eval(&self, _context: &EvalContext, inputs: TVec<TValue>) -> TractResult<TVec<TValue>> {
        let input = args_1!(inputs);
        let mut output = op::uninitialized(input.shape())?;
        let cancel = op::cancel();
        let flag = cancel.as_ref().map(Cancel::flag);
        let Self { isa, epsilon, scale, shift } = self;
        let x = input.try_as_plain_ram()?.as_slice::<f32>()?;
        token::layer_norm(*isa, x, *epsilon, [scale, shift], op::room(&mut output)?, flag)?;
        Ok(tvec!(output.into_tvalue()))
    }
}

impl TypedOp for LayerNorm {
    fn output_facts(&self, inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
        Ok(tvec!(inputs[0].without_value()))
    }

    as_op!();
}
