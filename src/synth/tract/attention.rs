//! Puts the kernel's attention in place of product, softmax, product.
//!
//! Looked for: `softmax(q · k (· a number) (+ bias)) · v`, whatever order the axes of the five tensors have.

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::array::Slice;
use tract_onnx::tract_core::ops::binary::TypedBinOp;
use tract_onnx::tract_core::ops::einsum::EinSum;
use tract_onnx::tract_core::ops::math::{Add, Mul};
use tract_onnx::tract_core::ops::nn::{Softmax, SoftmaxKind};

use super::op;
use super::roles::{self, Role, RoleAxis};
use crate::job::Cancel;
use crate::kernel::Isa;
use crate::kernel::product::{Attention, Heads, Sides};

/// Rewrites a decluttered model.
pub(super) fn rewrite(model: &mut TypedModel, isa: Isa) -> TractResult<()> {
    Rewriter::<Isa>::default().with_rule_for("attention", rule).rewrite(&isa, model)
}

/// Attention. Inputs: queries, keys, values, and a bias where there is one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct AttentionOp {
    isa: Isa,
    attention: Attention,
    shape: TVec<usize>,
}

impl Eq for AttentionOp {}

fn rule(
    isa: &Isa,
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    softmax: &Softmax,
) -> TractResult<Option<TypedModelPatch>> {
    let &[axis] = &softmax.axes[..] else { return Ok(None) };
    if softmax.kind != SoftmaxKind::Softmax || softmax.quant_output_dt.is_some() {
        return Ok(None);
    }
    let Some(scores) = Scores::before(model, node)? else { return Ok(None) };
    let Some((answer, first)) = answer(model, node)? else { return Ok(None) };
    let Some(Parts { heads, sides, values }) = parts(model, &scores, answer, axis, first)? else { return Ok(None) };
    let [queries, keys] = [0, 1].map(|slot| scores.product.inputs[slot]);
    let ((queries, a), (keys, b)) = (unscaled(model, queries)?, unscaled(model, keys)?);
    let Some(shape) = roles::shape(model, answer.id.into())? else { return Ok(None) };
    let attention = Attention { heads, sides, scale: scores.scale * a * b };
    let op = AttentionOp { isa: *isa, attention, shape };
    let mut patch = TypedModelPatch::default();
    let inputs = [queries, keys, values].into_iter().chain(scores.bias);
    let inputs: TractResult<TVec<_>> = inputs.map(|input| patch.tap_model(model, input)).collect();
    let output = patch.wire_node(format!("{name}.attention"), op, &inputs?)?;
    patch.shunt_outside(model, answer.id.into(), output[0])?;
    Ok(Some(patch))
}

/// The second product; and, where tract takes only some of the queries' rows on, their axis and the first of them.
fn answer<'a>(model: &'a TypedModel, softmax: &TypedNode) -> TractResult<Option<(&'a TypedNode, FirstRow)>> {
    let Some(next) = model.single_succ(softmax.id)? else { return Ok(None) };
    let Some(slice) = next.op_as::<Slice>() else { return Ok(Some((next, None))) };
    let (Some(answer), Ok(start)) = (model.single_succ(next.id)?, slice.start.to_usize()) else { return Ok(None) };
    Ok(Some((answer, Some([slice.axis, start]))))
}

/// The axis of the queries' rows in the scores and the first row that is wanted, where not all are.
type FirstRow = Option<[usize; 2]>;

/// What the softmax is made of.
struct Scores<'a> {
    product: &'a TypedNode,
    scale: f32,
    bias: Option<OutletId>,
}

impl<'a> Scores<'a> {
    /// Goes from the softmax up to the product, over a bias and a factor.
    fn before(model: &'a TypedModel, softmax: &TypedNode) -> TractResult<Option<Self>> {
        let (mut scale, mut bias) = (1.0, None);
        let mut node = model.node(softmax.inputs[0].node);
        loop {
            if model.single_succ(node.id)?.is_none() {
                return Ok(None);
            }
            if node.op_is::<EinSum>() {
                return Ok(Some(Self { product: node, scale, bias }));
            }
            let Some(op) = node.op_as::<TypedBinOp>() else { return Ok(None) };
            let same =
                |input: &OutletId| model.outlet_fact(*input).is_ok_and(|f| f.shape == node.outputs[0].fact.shape);
            if op.0.is::<Mul>() {
                let Some((from, factor)) = scaled(model, node)? else { return Ok(None) };
                scale *= factor;
                node = model.node(from.node);
            } else if op.0.is::<Add>() && bias.is_none() && scale == 1.0 {
                let product = |input: &&OutletId| same(input) && leads_to_product(model, **input);
                let Some(&from) = node.inputs.iter().find(product) else { return Ok(None) };
                bias = node.inputs.iter().copied().find(|input| *input != from);
                node = model.node(from.node);
            } else {
                return Ok(None);
            }
        }
    }
}

/// Whether an outlet is a product, perhaps times a number.
fn leads_to_product(model: &TypedModel, outlet: OutletId) -> bool {
    let node = model.node(outlet.node);
    let below = scaled(model, node).ok().flatten().map(|(from, _)| model.node(from.node));
    node.op_is::<EinSum>() || below.is_some_and(|node| node.op_is::<EinSum>())
}

/// What a node multiplies by a number, and the number.
fn scaled(model: &TypedModel, node: &TypedNode) -> TractResult<Option<(OutletId, f32)>> {
    if !node.op_as::<TypedBinOp>().is_some_and(|op| op.0.is::<Mul>()) {
        return Ok(None);
    }
    for (factor, other) in [(0, 1), (1, 0)] {
        let konst = model.outlet_fact(node.inputs[factor])?.konst.clone();
        let same = model.outlet_fact(node.inputs[other])?.shape == node.outputs[0].fact.shape;
        if let Some(konst) = konst.filter(|konst| konst.len() == 1 && konst.datum_type() == f32::datum_type() && same) {
            return Ok(Some((node.inputs[other], konst.cast_to_scalar::<f32>()?)));
        }
    }
    Ok(None)
}

/// An input without the number that it is multiplied by, and that number.
fn unscaled(model: &TypedModel, outlet: OutletId) -> TractResult<(OutletId, f32)> {
    Ok(scaled(model, model.node(outlet.node))?.unwrap_or((outlet, 1.0)))
}

/// Where everything lies.
struct Parts {
    heads: Heads,
    sides: Sides,
    values: OutletId,
}

/// The axes of both products, brought together. In the first, `left` are the queries; in the second the softmax.
fn parts(
    model: &TypedModel,
    scores: &Scores,
    answer: &TypedNode,
    axis: usize,
    first_row: FirstRow,
) -> TractResult<Option<Parts>> {
    let Some(op) = scores.product.op_as::<EinSum>() else { return Ok(None) };
    let Some(first) = roles::roles(model, scores.product, op, 0)? else { return Ok(None) };
    let Some(op) = answer.op_as::<EinSum>() else { return Ok(None) };
    let softmax = |input: &OutletId| {
        let node = model.node(input.node);
        node.op_is::<Softmax>()
            || (first_row.is_some() && node.op_is::<Slice>() && model.node(node.inputs[0].node).op_is::<Softmax>())
    };
    let Some(slot) = answer.inputs.iter().position(softmax) else { return Ok(None) };
    let Some(second) = roles::roles(model, answer, op, slot)? else { return Ok(None) };
    let values = answer.inputs[1 - slot];
    let tensors = [scores.product.inputs[0], scores.product.inputs[1], values, answer.id.into()];
    let mut strides = Vec::new();
    for tensor in tensors {
        let Some(shape) = roles::shape(model, tensor)? else { return Ok(None) };
        strides.push(roles::strides(&shape));
    }
    let bias = match scores.bias {
        Some(bias) => {
            let Some(shape) = roles::shape(model, bias)? else { return Ok(None) };
            let plain = model.outlet_fact(bias)?.datum_type == f32::datum_type();
            if !plain || shape.len() != scores.product.outputs[0].fact.rank() {
                return Ok(None);
            }
            let steps = roles::strides(&shape);
            Some(steps.iter().zip(&shape).map(|(step, len)| if *len == 1 { 0 } else { *step }).collect::<TVec<_>>())
        }
        None => None,
    };
    Ok(Layout { first, second, strides, bias, axis, first_row }.parts(values))
}

struct Layout {
    first: Vec<RoleAxis>,
    second: Vec<RoleAxis>,
    /// Of queries, keys, values, answer.
    strides: Vec<TVec<usize>>,
    /// Of the bias, 0 where it is the same all along.
    bias: Option<TVec<usize>>,
    /// The axis of the scores that the softmax is taken over.
    axis: usize,
    first_row: FirstRow,
}

impl Layout {
    fn parts(&self, values: OutletId) -> Option<Parts> {
        let only = |all: &[RoleAxis], role| match roles::of(all, role, 2)[..] {
            [axis] => Some(axis),
            _ => None,
        };
        let depth = match roles::of(&self.first, Role::Depth, 0)[..] {
            [axis] => axis,
            _ => return None,
        };
        let (queries, keys) = (only(&self.first, Role::Rows)?, only(&self.first, Role::Columns)?);
        if keys.at[2] != Some(self.axis) {
            return None;
        }
        // The second product: its left tensor is the scores, so its axes are known by their places there.
        let in_second = |at: Option<usize>| self.second.iter().find(|axis| axis.at[0] == at).copied();
        let (rows, sum) = (in_second(queries.at[2])?, in_second(keys.at[2])?);
        let columns = only(&self.second, Role::Columns)?;
        if rows.role != Role::Rows || sum.role != Role::Depth || self.second.len() != self.first.len() {
            return None;
        }
        let step = |tensor: usize, at: Option<usize>| at.map(|at| self.strides[tensor][at]);
        let bias = |axis: RoleAxis| self.bias.as_ref().zip(axis.at[2]).map_or(0, |(steps, at)| steps[at]);
        let skipped = match self.first_row {
            Some([axis, first]) if queries.at[2] == Some(axis) => first,
            Some(_) => return None,
            None => 0,
        };
        let sides = Sides {
            queries: rows.len,
            keys: keys.len,
            depth: depth.len,
            values: columns.len,
            query_steps: [step(0, queries.at[0])?, step(0, depth.at[0])?],
            key_steps: [step(1, keys.at[1])?, step(1, depth.at[1])?],
            value_steps: [step(2, sum.at[1])?, step(2, columns.at[1])?],
            out_steps: [step(3, rows.at[2])?, step(3, columns.at[2])?],
            bias_steps: [bias(queries), bias(keys)],
        };
        let mut heads = vec![[skipped * sides.query_steps[0], 0, 0, 0, skipped * sides.bias_steps[0]]];
        for axis in roles::of(&self.first, Role::Batch, 2) {
            let second = in_second(axis.at[2]).filter(|axis| axis.role == Role::Batch)?;
            let steps = [
                step(0, axis.at[0])?,
                step(1, axis.at[1])?,
                step(2, second.at[1])?,
                step(3, second.at[2])?,
                bias(axis),
            ];
            let along = |head: [usize; 5]| (0..axis.len).map(move |i| std::array::from_fn(|n| head[n] + i * steps[n]));
            heads = heads.into_iter().flat_map(along).collect();
        }
        let contiguous = sides.query_steps[1] == 1 && sides.out_steps[1] == 1;
        contiguous.then_some(Parts { heads: Heads(heads), sides, values })
    }
}

impl Op for AttentionOp {
    fn name(&self) -> StaticName {
        "Attention".into()
    }

    fn info(&self) -> TractResult<Vec<String>> {
        Ok(vec![format!("{} heads {:?}", self.attention.heads.0.len(), self.attention.sides)])
    }

    op_as_typed_op!();
}

impl EvalOp for AttentionOp {
    op_out_of_plan!();

    fn eval(&self, _context: &EvalContext, inputs: TVec<TValue>) -> TractResult<TVec<TValue>> {
        let slices: TractResult<TVec<&[f32]>> =
            inputs.iter().map(|input| input.try_as_plain_ram()?.as_slice::<f32>()).collect();
        let slices = slices?;
        let mut output = op::uninitialized(&self.shape)?;
        let cancel = op::cancel();
        let flag = cancel.as_ref().map(Cancel::flag);
        let [queries, keys, values] = [slices[0], slices[1], slices[2]];
        let bias = slices.get(3).copied();
        self.attention.run(self.isa, [queries, keys, values], bias, op::room(&mut output)?, flag)?;
        Ok(tvec!(output.into_tvalue()))
    }
}

impl TypedOp for AttentionOp {
    fn output_facts(&self, _inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
        Ok(tvec!(f32::fact(&*self.shape)))
    }

    as_op!();
}
