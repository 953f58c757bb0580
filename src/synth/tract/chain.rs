//! `Chain`: consecutive convolutions that Winograd's algorithm does together, as one tract operator.

use std::sync::Arc;

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::array::TypedConcat;
use tract_onnx::tract_core::ops::nn::NearestUpsample;

use super::op::{self, DirectConv};
use crate::job::Cancel;
use crate::kernel::winograd::{Layer, PlaneChain, Planes, VolumeChain};
use crate::kernel::{Ending, Halves, Kernel, Limits};

/// Pixels from which on Winograd's transforms pay in a plane; below, weights would be most of the work.
const LEAST_PIXELS: usize = 144;

/// Convolutions that follow each other. Inputs: the parts of the picture, and what is added at the end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chain {
    pub(super) convolutions: Arc<Convolutions>,
    /// Of each part of the picture, some of its channels: whether each pixel stands for two by two.
    doubled: TVec<bool>,
    channels_out: usize,
    /// How many they are.
    pub(super) len: usize,
    /// Multiply-adds of all of them for one pixel of one view.
    pub(super) products: usize,
    /// Of what comes in.
    before: Limits,
    /// Of the result, after something was added.
    limits: Limits,
}

impl Eq for Chain {}

/// What does them.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Convolutions {
    /// `[n, c, y, x]`
    Plane(PlaneChain),
    /// `[n, c, v, y, x]`
    Volume(VolumeChain),
}

/// Puts chains in place of direct convolutions; those of planes are multiplied by `halves` where there are some.
pub(super) fn fuse(model: &mut TypedModel, halves: Option<Halves>) -> TractResult<()> {
    Rewriter::<Option<Halves>>::default().with_rule_for("chain", rule).rewrite(&halves, model)
}

fn rule(
    halves: &Option<Halves>,
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    first: &DirectConv,
) -> TractResult<Option<TypedModelPatch>> {
    let before = model.node(node.inputs[0].node);
    let goes_on = before.op_as::<DirectConv>().is_some_and(|op| follow(op, first)) && !ends(before);
    let shape = model.outlet_fact(node.inputs[0])?.shape.as_concrete().unwrap_or_default();
    if !fits(first, shape, *halves) || (goes_on && reader(model, before).is_some()) {
        return Ok(None);
    }
    let (mut layers, mut last) = (vec![(first, is_residual(node))], node);
    while let Some(next) = reader(model, last) {
        let Some(op) = next.op_as::<DirectConv>().filter(|op| follow(first, op) && !ends(last)) else { break };
        layers.push((op, is_residual(next)));
        last = next;
    }
    if layers.len() == 1 && first.kernel == Kernel::Plane && !PlaneChain::pays_alone(first.channels) {
        return Ok(None);
    }
    let mut patch = TypedModelPatch::default();
    let (parts, doubled): (Vec<_>, TVec<_>) = parts(model, node).into_iter().unzip();
    let taps: TractResult<TVec<_>> =
        parts.into_iter().chain(summand(last)).map(|input| patch.tap_model(model, input)).collect();
    let output = patch.wire_node(format!("{name}.chain"), Chain::new(&layers, doubled, *halves), &taps?)?;
    patch.shunt_outside(model, last.id.into(), output[0])?;
    Ok(Some(patch))
}

/// Whether chains have such a convolution and may pay at this shape.
fn fits(op: &DirectConv, shape: &[usize], halves: Option<Halves>) -> bool {
    let pixels = shape.iter().rev().take(2).product::<usize>();
    match op.kernel {
        Kernel::Plane => PlaneChain::takes(op.channels) && (halves.is_some() || pixels >= LEAST_PIXELS),
        Kernel::Volume => op.dilation == 1,
        Kernel::Point => false,
    }
}

/// What a convolution reads: parts that are joined for it alone, and whether each is enlarged to twice its size before.
fn parts(model: &TypedModel, node: &TypedNode) -> Vec<(OutletId, bool)> {
    let read = node.inputs[0];
    let join = model.node(read.node);
    let is_plane = node.op_as::<DirectConv>().is_some_and(|op| op.kernel == Kernel::Plane);
    let joins = join.op_as::<TypedConcat>().is_some_and(|op| op.axis == 1);
    let alone = join.outputs[0].successors.len() == 1 && !model.outputs.contains(&read);
    if !(is_plane && joins && alone) {
        return vec![(read, false)];
    }
    let part = |input: &OutletId| {
        let enlarging = model.node(input.node);
        let doubles = enlarging.op_as::<NearestUpsample>().is_some_and(|op| op.scales[..] == [1, 1, 2, 2]);
        if doubles { (enlarging.inputs[0], true) } else { (*input, false) }
    };
    join.inputs.iter().map(part).collect()
}

/// The node that alone convolves the result of `node`; it may add it, too.
fn reader<'a>(model: &'a TypedModel, node: &TypedNode) -> Option<&'a TypedNode> {
    let readers = &node.outputs[0].successors;
    let next = model.node(readers.first()?.node);
    let alone = next.inputs[0].node == node.id && readers.iter().all(|reader| reader.node == next.id);
    (alone && model.outputs.iter().all(|output| output.node != node.id)).then_some(next)
}

/// Whether a convolution adds what it reads to what it makes.
fn is_residual(node: &TypedNode) -> bool {
    let plain = |op: &DirectConv| op.kernel == Kernel::Plane && !op.before.are_some();
    node.inputs.get(1) == Some(&node.inputs[0]) && node.op_as::<DirectConv>().is_some_and(plain)
}

/// What else a convolution adds.
fn summand(node: &TypedNode) -> Option<OutletId> {
    node.inputs.get(1).copied().filter(|_| !is_residual(node))
}

/// Whether the result of a convolution is changed before the next one can have it.
fn ends(node: &TypedNode) -> bool {
    summand(node).is_some() || node.op_as::<DirectConv>().is_some_and(|op| op.limits.are_some())
}

/// Whether `next` can be done together with `op`, as far as that does not depend on the shape, which they share.
fn follow(op: &DirectConv, next: &DirectConv) -> bool {
    let taken = |op: &DirectConv| op.kernel == Kernel::Volume || PlaneChain::takes(op.channels);
    let alike = |op: &DirectConv| (op.isa, op.kernel, op.padding, op.kernel == Kernel::Volume && op.dilation > 1);
    taken(op) && taken(next) && alike(op) == alike(next) && !next.before.are_some()
}

impl Chain {
    /// Of convolutions, and whether each is residual.
    fn new(ops: &[(&DirectConv, bool)], doubled: TVec<bool>, halves: Option<Halves>) -> Self {
        let weights: Vec<Vec<f32>> = ops.iter().map(|(op, _)| op.weights.plain()).collect();
        let layers = ops.iter().zip(&weights).map(|(&(op, is_residual), weights)| {
            let DirectConv { channels, dilation, padding, activation, ref bias, .. } = *op;
            Layer { weights, bias, channels, dilation, padding, activation, is_residual }
        });
        let layers: Vec<Layer> = layers.collect();
        let (first, last) = (ops[0].0, ops[ops.len() - 1].0);
        let isa = first.isa;
        let convolutions = match first.kernel {
            Kernel::Volume => Convolutions::Volume(VolumeChain::new(&layers, isa)),
            _ => Convolutions::Plane(PlaneChain::new(&layers, isa, halves)),
        };
        let products = |(op, _): &(&DirectConv, bool)| op.channels[0] * op.channels[1] * op.kernel.taps();
        Self {
            convolutions: Arc::new(convolutions),
            doubled,
            channels_out: last.channels[1],
            len: ops.len(),
            products: ops.iter().map(products).sum(),
            before: first.before,
            limits: last.limits,
        }
    }

    fn run(&self, inputs: &[TValue]) -> TractResult<Tensor> {
        let mut shape: TVec<usize> = inputs[0].shape().into();
        ensure!(!shape.contains(&0), "an empty input, {shape:?}");
        shape[1] = self.channels_out;
        shape[2..].iter_mut().for_each(|side| *side *= self.scale());
        let mut output = op::uninitialized(&shape)?;
        let batch = shape[0];
        let cancel = op::cancel();
        let flag = cancel.as_ref().map(Cancel::flag);
        let values = inputs.iter().map(|tensor| tensor.try_as_plain_ram()?.as_slice::<f32>());
        let values: TVec<&[f32]> = values.collect::<TractResult<_>>()?;
        let one_out = output.len() / batch;
        for (n, out) in op::room(&mut output)?.chunks_exact_mut(one_out).enumerate() {
            let one = |values: &&[f32]| values.len() / batch;
            let mut of_one = values.iter().map(|values| &values[n * one(values)..][..one(values)]);
            let part = |&is_doubled: &bool| Some(Planes { values: of_one.next()?, is_doubled });
            let planes: TVec<Planes> = self.doubled.iter().filter_map(part).collect();
            let ends = (self.before, Ending { summand: of_one.next(), limits: self.limits });
            match (&*self.convolutions, &shape[2..]) {
                (Convolutions::Plane(chain), &[h, w]) => chain.run_between(&planes, [h, w], ends, out, flag)?,
                (Convolutions::Volume(chain), &[v, h, w]) => chain.run_slice(planes[0].values, [v, h, w], out, flag)?,
                _ => bail!("a convolution of {shape:?}"),
            }
        }
        Ok(output)
    }

    /// Pixels along a side of the result for each of the first part.
    fn scale(&self) -> usize {
        if self.doubled[0] { 2 } else { 1 }
    }
}

impl Op for Chain {
    fn name(&self) -> StaticName {
        "Chain".into()
    }

    fn info(&self) -> TractResult<Vec<String>> {
        Ok(vec![format!("{} convolutions", self.len)])
    }

    op_as_typed_op!();
}

impl EvalOp for Chain {
    op_out_of_plan!();

    fn eval(&self, _context: &EvalContext, inputs: TVec<TValue>) -> TractResult<TVec<TValue>> {
        let output = self.run(&inputs)?;
        Ok(tvec!(output.into_tvalue()))
    }
}

impl TypedOp for Chain {
    fn output_facts(&self, inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
        let mut shape = inputs[0].shape.clone();
        shape.set(1, self.channels_out.to_dim());
        for axis in 2..shape.rank() {
            shape.set(axis, shape[axis].clone() * self.scale());
        }
        Ok(tvec!(f32::fact(shape)))
    }

    as_op!();
}
