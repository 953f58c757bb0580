//! `Chain`: consecutive convolutions that Winograd's algorithm does together, as one tract operator.

use std::sync::Arc;

use tract_onnx::tract_core::internal::*;

use super::op::{self, DirectConv};
use crate::job::Cancel;
use crate::kernel::winograd::{Layer, PlaneChain, VolumeChain};
use crate::kernel::{Ending, Kernel, Limits};

/// Pixels from which on the transforms pay in a plane; below, weights would be most of the work.
const LEAST_PIXELS: usize = 144;

/// Convolutions that follow each other. Inputs: the picture, and what is added at the end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chain {
    pub(super) convolutions: Arc<Convolutions>,
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

/// Puts chains in place of direct convolutions.
pub(super) fn fuse(model: &mut TypedModel) -> TractResult<()> {
    Rewriter::<()>::default().with_rule_for("chain", rule).rewrite(&(), model)
}

fn rule(
    _: &(),
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    first: &DirectConv,
) -> TractResult<Option<TypedModelPatch>> {
    let before = model.node(node.inputs[0].node);
    let goes_on = before.op_as::<DirectConv>().is_some_and(|op| follow(op, first)) && !ends(before);
    let shape = model.outlet_fact(node.inputs[0])?.shape.as_concrete().unwrap_or_default();
    if !fits(first, shape) || (goes_on && model.single_succ(before.id)?.is_some()) {
        return Ok(None);
    }
    let (mut layers, mut last) = (vec![first], node);
    while let Some(next) = model.single_succ(last.id)? {
        let Some(op) = next.op_as::<DirectConv>().filter(|op| follow(first, op) && !ends(last)) else { break };
        if next.inputs[0].node != last.id {
            break;
        }
        layers.push(op);
        last = next;
    }
    let mut patch = TypedModelPatch::default();
    let inputs = std::iter::once(node.inputs[0]).chain(last.inputs.get(1).copied());
    let taps: TractResult<TVec<_>> = inputs.map(|input| patch.tap_model(model, input)).collect();
    let output = patch.wire_node(format!("{name}.chain"), Chain::new(&layers), &taps?)?;
    patch.shunt_outside(model, last.id.into(), output[0])?;
    Ok(Some(patch))
}

/// Whether Winograd's algorithm has such a convolution and pays at this shape.
fn fits(op: &DirectConv, shape: &[usize]) -> bool {
    let pixels = shape.iter().rev().take(2).product::<usize>();
    match op.kernel {
        Kernel::Plane => PlaneChain::pays(op.channels) && pixels >= LEAST_PIXELS,
        Kernel::Volume => op.dilation == 1,
        Kernel::Point => false,
    }
}

/// Whether the result of a convolution is changed before the next one can have it.
fn ends(node: &TypedNode) -> bool {
    node.inputs.len() > 1 || node.op_as::<DirectConv>().is_some_and(|op| op.limits.are_some())
}

/// Whether `next` can be done together with `op`, as far as that does not depend on the shape, which they share.
fn follow(op: &DirectConv, next: &DirectConv) -> bool {
    let pays = |op: &DirectConv| op.kernel == Kernel::Volume || PlaneChain::pays(op.channels);
    let alike = |op: &DirectConv| (op.isa, op.kernel, op.padding, op.kernel == Kernel::Volume && op.dilation > 1);
    pays(op) && pays(next) && alike(op) == alike(next) && !next.before.are_some()
}

impl Chain {
    fn new(ops: &[&DirectConv]) -> Self {
        let weights: Vec<Vec<f32>> = ops.iter().map(|op| op.weights.plain()).collect();
        let layers = ops.iter().zip(&weights).map(|(op, weights)| {
            let DirectConv { channels, dilation, padding, activation, ref bias, .. } = **op;
            Layer { weights, bias, channels, dilation, padding, activation }
        });
        let layers: Vec<Layer> = layers.collect();
        let isa = ops[0].isa;
        let convolutions = match ops[0].kernel {
            Kernel::Volume => Convolutions::Volume(VolumeChain::new(&layers, isa)),
            _ => Convolutions::Plane(PlaneChain::new(&layers, isa)),
        };
        let products = |op: &&DirectConv| op.channels[0] * op.channels[1] * op.kernel.taps();
        let channels_out = ops[ops.len() - 1].channels[1];
        Self {
            convolutions: Arc::new(convolutions),
            channels_out,
            len: ops.len(),
            products: ops.iter().map(products).sum(),
            before: ops[0].before,
            limits: ops[ops.len() - 1].limits,
        }
    }

    fn run(&self, input: &Tensor, summand: Option<&Tensor>) -> TractResult<Tensor> {
        let mut shape: TVec<usize> = input.shape().into();
        ensure!(!shape.contains(&0), "an empty input, {shape:?}");
        let one = input.len() / shape[0];
        shape[1] = self.channels_out;
        let mut output = op::uninitialized(&shape)?;
        let one_out = output.len() / shape[0];
        let cancel = op::cancel();
        let flag = cancel.as_ref().map(Cancel::flag);
        let inputs = input.try_as_plain_ram()?.as_slice::<f32>()?.chunks_exact(one);
        let summand = summand.map(|summand| summand.try_as_plain_ram()?.as_slice::<f32>()).transpose()?;
        let outputs = op::room(&mut output)?.chunks_exact_mut(one_out);
        for (n, (x, out)) in inputs.zip(outputs).enumerate() {
            let summand = summand.map(|summand| &summand[n * one_out..][..one_out]);
            let ends = (self.before, Ending { summand, limits: self.limits });
            match (&*self.convolutions, &shape[2..]) {
                (Convolutions::Plane(chain), &[h, w]) => chain.run_between(x, [h, w], ends, out, flag)?,
                (Convolutions::Volume(chain), &[v, h, w]) => chain.run_slice(x, [v, h, w], out, flag)?,
                _ => bail!("a convolution of {shape:?}"),
            }
        }
        Ok(output)
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
        let output = self.run(&inputs[0], inputs.get(1).map(|summand| &**summand))?;
        Ok(tvec!(output.into_tvalue()))
    }
}

impl TypedOp for Chain {
    fn output_facts(&self, inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
        let mut shape = inputs[0].shape.clone();
        shape.set(1, self.channels_out.to_dim());
        Ok(tvec!(f32::fact(shape)))
    }

    as_op!();
}
