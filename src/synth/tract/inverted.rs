//! Puts one pass in place of the three operations of an inverted residual block, or of its last two.

use std::sync::Arc;

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::change_axes::AxisOp;

use super::dense::{Product, Weights};
use super::op;
use super::patch_conv::PatchConv;
use crate::job::Cancel;
use crate::kernel::product::{DepthWise, Inverted, Patches, Project};
use crate::kernel::{Activation, Isa, Limits};

/// Rewrites a model that has the kernel's products and convolutions.
pub(super) fn rewrite(model: &mut TypedModel) -> TractResult<()> {
    Rewriter::<()>::default().with_rule_for("inverted", rule).rewrite(&(), model)
}

/// An inverted residual block. Inputs: the picture, and what is added at the end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct InvertedOp {
    isa: Isa,
    patches: Patches,
    /// None where the picture has the channels of the convolution already.
    pub(super) widen: Option<Part>,
    pub(super) depthwise: Part,
    pub(super) narrow: Part,
    shape: TVec<usize>,
}

impl Eq for InvertedOp {}

/// Weights and what follows them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) weights: Arc<[f32]>,
    bias: Arc<[f32]>,
    activation: Activation,
    limits: Limits,
}

fn rule(
    _: &(),
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    conv: &PatchConv,
) -> TractResult<Option<TypedModelPatch>> {
    let Some((patches, depthwise)) = conv.each_channel() else { return Ok(None) };
    let Some(last) = behind(model, node)? else { return Ok(None) };
    let Some((narrow, shape)) = of_planes(last) else { return Ok(None) };
    if narrow.weights.len() != narrow.bias.len() * patches.channels || last.inputs[0].node == node.inputs[0].node {
        return Ok(None);
    }
    let (widen, input) = match before(model, node)? {
        Some((part, input)) => (Some(part), input),
        None => (None, node.inputs[0]),
    };
    if !Inverted::pays(&patches) {
        return Ok(None);
    }
    let op = InvertedOp { isa: conv.isa(), patches, widen, depthwise, narrow, shape };
    let mut patch = TypedModelPatch::default();
    let inputs: TractResult<TVec<_>> =
        std::iter::once(input).chain(last.inputs.get(1).copied()).map(|input| patch.tap_model(model, input)).collect();
    let output = patch.wire_node(format!("{name}.inverted"), op, &inputs?)?;
    patch.shunt_outside(model, last.id.into(), output[0])?;
    Ok(Some(patch))
}

/// The product behind a convolution, where nothing else has its result.
fn behind<'a>(model: &'a TypedModel, node: &TypedNode) -> TractResult<Option<&'a TypedNode>> {
    let (mut from, mut next) = (node.id, model.single_succ(node.id)?);
    while let Some(axis) = next.filter(|next| is_unit_axis(next)) {
        (from, next) = (axis.id, model.single_succ(axis.id)?);
    }
    Ok(next.filter(|next| next.inputs[0].node == from))
}

/// The product before a convolution, where nothing else has its result, and what goes into it.
fn before(model: &TypedModel, node: &TypedNode) -> TractResult<Option<(Part, OutletId)>> {
    let mut from = model.node(node.inputs[0].node);
    while is_unit_axis(from) && model.single_succ(from.id)?.is_some() {
        from = model.node(from.inputs[0].node);
    }
    let alone = model.single_succ(from.id)?.is_some() && from.inputs.len() == 1;
    Ok(of_planes(from).filter(|_| alone).map(|(part, _)| (part, from.inputs[0])))
}

/// A product of planes, and the shape of its result.
fn of_planes(node: &TypedNode) -> Option<(Part, TVec<usize>)> {
    let op = node.op_as::<Product>()?;
    let Weights::Planes { weights, pixels_first: false } = &op.weights else { return None };
    let (weights, bias) = (Arc::clone(weights), Arc::clone(&op.bias));
    Some((Part { weights, bias, activation: op.activation, limits: op.limits }, op.shape.clone()))
}

/// Whether a node only adds or takes away an axis of length 1, which changes nothing in memory.
fn is_unit_axis(node: &TypedNode) -> bool {
    matches!(node.op_as::<AxisOp>(), Some(AxisOp::Add(_) | AxisOp::Rm(_)))
}

impl Part {
    pub(super) fn new(weights: &Arc<[f32]>, bias: &Arc<[f32]>, activation: Activation) -> Self {
        Self { weights: Arc::clone(weights), bias: Arc::clone(bias), activation, limits: Limits::NONE }
    }

    fn project(&self, isa: Isa) -> Project<'_> {
        Project { isa, weights: &self.weights, bias: &self.bias, activation: self.activation, limits: self.limits }
    }
}

impl InvertedOp {
    fn run(&self, x: &Tensor, summand: Option<&Tensor>) -> TractResult<Tensor> {
        let mut output = op::uninitialized(&self.shape)?;
        let cancel = op::cancel();
        let flag = cancel.as_ref().map(Cancel::flag);
        let summand = summand.map(|summand| summand.try_as_plain_ram()?.as_slice::<f32>()).transpose()?;
        let x = x.try_as_plain_ram()?.as_slice::<f32>()?;
        let (isa, Part { weights, bias, activation, .. }) = (self.isa, &self.depthwise);
        let depthwise = DepthWise { isa, patches: &self.patches, weights, bias, activation: *activation };
        let widen = self.widen.as_ref().map(|part| part.project(isa));
        let block = Inverted { widen, depthwise, narrow: self.narrow.project(isa) };
        block.run(x, summand, op::room(&mut output)?, flag)?;
        Ok(output)
    }
}

impl Op for InvertedOp {
    fn name(&self) -> StaticName {
        if self.widen.is_some() { "Inverted".into() } else { "PlaneConvProduct".into() }
    }

    fn info(&self) -> TractResult<Vec<String>> {
        Ok(vec![format!("{} {:?}", self.isa, self.patches)])
    }

    op_as_typed_op!();
}

op::with_summand!(InvertedOp);
