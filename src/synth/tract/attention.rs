//! Puts the kernel's attention in place of product, softmax, product.
//!
//! Looked for: `softmax(q · k (· a factor, perhaps one a head) (+ biases)) · v`, whatever order the axes of the tensors have.

use std::sync::Arc;

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
use crate::kernel::product::{Attention, Head, MOST_BIASES, Sides};

/// Rewrites a decluttered model.
pub(super) fn rewrite(model: &mut TypedModel, isa: Isa) -> TractResult<()> {
    Rewriter::<Isa>::default().with_rule_for("attention", rule).rewrite(&isa, model)
}

/// Attention. Inputs: queries, keys, values, and biases where there are some.
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
    let Some(Parts { mut heads, sides, values }) = parts(model, &scores, answer, axis, first)? else { return Ok(None) };
    let [queries, keys] = [0, 1].map(|slot| scores.product.inputs[slot]);
    let ((queries, a), (keys, b)) = (unscaled(model, queries)?, unscaled(model, keys)?);
    let Some(shape) = roles::shape(model, answer.id.into())? else { return Ok(None) };
    heads.iter_mut().for_each(|head| head.scale *= scores.scale * a * b);
    // A bias is divided by the factor.
    if heads.iter().any(|head| head.scale == 0.0 || !head.scale.is_finite()) {
        return Ok(None);
    }
    let attention = Attention { heads, sides };
    let op = AttentionOp { isa: *isa, attention, shape };
    let mut patch = TypedModelPatch::default();
    let inputs = [queries, keys, values].into_iter().chain(scores.biases);
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
    /// A factor for each head, as many axes as the scores.
    head_scale: Option<Arc<Tensor>>,
    biases: TVec<OutletId>,
}

impl<'a> Scores<'a> {
    /// Goes from the softmax up to the product, over biases and factors.
    fn before(model: &'a TypedModel, softmax: &TypedNode) -> TractResult<Option<Self>> {
        let (mut scale, mut head_scale, mut biases) = (1.0, None, tvec!());
        let mut node = model.node(softmax.inputs[0].node);
        loop {
            if model.single_succ(node.id)?.is_none() {
                return Ok(None);
            }
            if node.op_is::<EinSum>() {
                return Ok(Some(Self { product: node, scale, head_scale, biases }));
            }
            let Some(op) = node.op_as::<TypedBinOp>() else { return Ok(None) };
            if let Some((from, factor)) = scaled(model, node)? {
                scale *= factor;
                node = model.node(from.node);
            } else if let Some((from, factors)) = scaled_by_heads(model, node)?.filter(|_| head_scale.is_none()) {
                head_scale = Some(factors);
                node = model.node(from.node);
            } else if op.0.is::<Add>() && biases.len() < MOST_BIASES && scale == 1.0 && head_scale.is_none() {
                let Some(from) = product_below(model, node, MOST_BIASES + 2) else { return Ok(None) };
                biases.extend(node.inputs.iter().copied().find(|input| *input != from));
                node = model.node(from.node);
            } else {
                return Ok(None);
            }
        }
    }
}

/// The input of a sum or product that leads to a product of tensors, over at most so many sums and products.
fn product_below(model: &TypedModel, node: &TypedNode, most: usize) -> Option<OutletId> {
    let is_sum = |node: &TypedNode| node.op_as::<TypedBinOp>().is_some_and(|op| op.0.is::<Add>() || op.0.is::<Mul>());
    let leads = |input: &&OutletId| {
        let same = model.outlet_fact(**input).is_ok_and(|fact| fact.shape == node.outputs[0].fact.shape);
        let below = model.node(input.node);
        same && (below.op_is::<EinSum>()
            || (is_sum(below) && most > 0 && product_below(model, below, most - 1).is_some()))
    };
    node.inputs.iter().find(leads).copied()
}

/// What a node multiplies by constants that differ along few axes, and these.
fn scaled_by_heads(model: &TypedModel, node: &TypedNode) -> TractResult<Option<(OutletId, Arc<Tensor>)>> {
    if !node.op_as::<TypedBinOp>().is_some_and(|op| op.0.is::<Mul>()) {
        return Ok(None);
    }
    for (factor, other) in [(0, 1), (1, 0)] {
        let konst = model.outlet_fact(node.inputs[factor])?.konst.clone();
        let same = model.outlet_fact(node.inputs[other])?.shape == node.outputs[0].fact.shape;
        if let Some(konst) = konst.filter(|konst| konst.datum_type() == f32::datum_type() && same) {
            return Ok((konst.rank() == node.outputs[0].fact.rank()).then_some((node.inputs[other], konst)));
        }
    }
    Ok(None)
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
    heads: Vec<Head>,
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
    let mut biases = Vec::new();
    for bias in &scores.biases {
        let Some(shape) = roles::shape(model, *bias)? else { return Ok(None) };
        let plain = model.outlet_fact(*bias)?.datum_type == f32::datum_type();
        if !plain || shape.len() != scores.product.outputs[0].fact.rank() {
            return Ok(None);
        }
        biases.push(steps(&shape));
    }
    let scale = match &scores.head_scale {
        Some(factors) => Some((steps(factors.shape()), factors.try_as_plain_ram()?.as_slice::<f32>()?.to_vec())),
        None => None,
    };
    Ok(Layout { first, second, strides, biases, scale, axis, first_row }.parts(values))
}

/// Values between neighbours along each axis; 0 where there is only one.
fn steps(shape: &[usize]) -> TVec<usize> {
    roles::strides(shape).iter().zip(shape).map(|(step, len)| if *len == 1 { 0 } else { *step }).collect()
}

struct Layout {
    first: Vec<RoleAxis>,
    second: Vec<RoleAxis>,
    /// Of queries, keys, values, answer.
    strides: Vec<TVec<usize>>,
    /// Of each bias, 0 where it is the same all along.
    biases: Vec<TVec<usize>>,
    /// The same of the factors of the heads, and these.
    scale: Option<(TVec<usize>, Vec<f32>)>,
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
        let bias = |axis: RoleAxis| {
            let step = |i: usize| self.biases.get(i).zip(axis.at[2]).map_or(0, |(steps, at)| steps[at]);
            std::array::from_fn::<usize, MOST_BIASES, _>(step)
        };
        let scale = |axis: RoleAxis| self.scale.as_ref().zip(axis.at[2]).map_or(0, |((steps, _), at)| steps[at]);
        if scale(queries) > 0 || scale(keys) > 0 {
            return None;
        }
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
            bias_steps: std::array::from_fn(|i| [bias(queries)[i], bias(keys)[i]]),
        };
        let first = Head {
            starts: [skipped * sides.query_steps[0], 0, 0, 0],
            biases: sides.bias_steps.map(|steps| skipped * steps[0]),
            scale: 1.0,
        };
        // Each head, and where its factor lies.
        let mut heads = vec![(first, 0)];
        for axis in roles::of(&self.first, Role::Batch, 2) {
            let second = in_second(axis.at[2]).filter(|axis| axis.role == Role::Batch)?;
            let steps = [step(0, axis.at[0])?, step(1, axis.at[1])?, step(2, second.at[1])?, step(3, second.at[2])?];
            let (bias, scale) = (bias(axis), scale(axis));
            let along = |(head, factor): (Head, usize)| {
                (0..axis.len).map(move |i| {
                    let starts = std::array::from_fn(|n| head.starts[n] + i * steps[n]);
                    let biases = std::array::from_fn(|n| head.biases[n] + i * bias[n]);
                    (Head { starts, biases, ..head }, factor + i * scale)
                })
            };
            heads = heads.into_iter().flat_map(along).collect();
        }
        let factor = |at: usize| self.scale.as_ref().map_or(1.0, |(_, factors)| factors[at]);
        let heads = heads.into_iter().map(|(head, at)| Head { scale: factor(at), ..head }).collect();
        let contiguous = sides.query_steps[1] == 1 && sides.out_steps[1] == 1;
        contiguous.then_some(Parts { heads, sides, values })
    }
}

impl Op for AttentionOp {
    fn name(&self) -> StaticName {
        "Attention".into()
    }

    fn info(&self) -> TractResult<Vec<String>> {
        Ok(vec![format!("{} heads {:?}", self.attention.heads.len(), self.attention.sides)])
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
        self.attention.run(self.isa, [queries, keys, values], &slices[3..], op::room(&mut output)?, flag)?;
        Ok(tvec!(output.into_tvalue()))
    }
}

impl TypedOp for AttentionOp {
    fn output_facts(&self, _inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
        Ok(tvec!(f32::fact(&*self.shape)))
    }

    as_op!();
}
