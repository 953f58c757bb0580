//! What follows a product or convolution and can be done with its sums while they are in registers.

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::binary::TypedBinOp;
use tract_onnx::tract_core::ops::element_wise::ElementWiseOp;
use tract_onnx::tract_core::ops::math::{Add, Max, Min, Mul};
use tract_onnx::tract_core::ops::nn::GeluExact;

use super::roles::shape;
use crate::kernel::{Activation, Limits};

/// `limits(act(scale · sums + bias) + summand)`.
#[derive(Clone, Debug)]
pub(super) struct Tail {
    /// One value a channel of the result.
    pub(super) scale: Vec<f32>,
    /// One value a channel of the result.
    pub(super) bias: Vec<f32>,
    pub(super) activation: Activation,
    /// A tensor of the same shape as the result.
    pub(super) summand: Option<OutletId>,
    /// Of the sum with it.
    pub(super) limits: Limits,
    /// What holds the result in the model as it is.
    pub(super) last: OutletId,
}

impl Tail {
    /// Follows the model from `node`, whose result has `channels` values along its axes `axes`, as far as it goes.
    pub(super) fn of(model: &TypedModel, node: &TypedNode, axes: &[usize], channels: usize) -> TractResult<Self> {
        Self::follow(model, node, axes, channels, |_| true)
    }

    /// The same, but scale and bias only.
    pub(super) fn affine(model: &TypedModel, node: &TypedNode, axes: &[usize], channels: usize) -> TractResult<Self> {
        Self::follow(model, node, axes, channels, |tail| tail.activation == Activation::None && tail.summand.is_none())
    }

    /// The same, without a tensor that is added.
    pub(super) fn alone(model: &TypedModel, node: &TypedNode, axes: &[usize], channels: usize) -> TractResult<Self> {
        Self::follow(model, node, axes, channels, |tail| tail.summand.is_none())
    }

    fn follow(
        model: &TypedModel,
        node: &TypedNode,
        axes: &[usize],
        channels: usize,
        wanted: impl Fn(&Self) -> bool,
    ) -> TractResult<Self> {
        let (scale, bias) = (vec![1.0; channels], vec![0.0; channels]);
        let (activation, limits) = (Activation::None, Limits::NONE);
        let mut tail = Self { scale, bias, activation, summand: None, limits, last: node.id.into() };
        let shape = shape(model, node.id.into())?.unwrap_or_default();
        while let Some(next) = model.single_succ(tail.last.node)? {
            let mut longer = tail.clone();
            if !longer.take(model, next, &shape, axes)? || !wanted(&longer) {
                break;
            }
            tail = Self { last: next.id.into(), ..longer };
        }
        Ok(tail)
    }

    /// Whether `next` could be taken in.
    fn take(&mut self, model: &TypedModel, next: &TypedNode, shape: &[usize], axes: &[usize]) -> TractResult<bool> {
        if next.outputs[0].fact.shape.as_concrete() != Some(shape) {
            return Ok(false);
        }
        if self.summand.is_some() {
            let limits = limits(model, next)?.and_then(|(_, limits)| self.limits.then(limits));
            self.limits = limits.unwrap_or(self.limits);
            return Ok(limits.is_some());
        }
        if let Some(op) = next.op_as::<ElementWiseOp>() {
            let gelu = op.0.is::<GeluExact>() && self.activation == Activation::None;
            if gelu {
                self.activation = Activation::Gelu;
            }
            return Ok(gelu);
        }
        let Some(op) = next.op_as::<TypedBinOp>() else { return Ok(false) };
        let Some(&other) = next.inputs.iter().find(|input| **input != self.last) else { return Ok(false) };
        let Some(values) = channel_values(model, other, shape, axes)? else {
            let fact = model.outlet_fact(other)?;
            let adds = op.0.is::<Add>() && fact.konst.is_none() && fact.datum_type == f32::datum_type();
            if adds && fact.shape.as_concrete() == Some(shape) {
                self.summand = Some(other);
            }
            return Ok(self.summand.is_some());
        };
        Ok(self.combine(op, &values))
    }

    /// Takes in an operation with one constant a channel.
    fn combine(&mut self, op: &TypedBinOp, values: &[f32]) -> bool {
        let one = values.iter().all(|value| *value == values[0]).then_some(values[0]);
        let each = |target: &mut [f32], f: fn(f32, f32) -> f32| {
            target.iter_mut().zip(values).for_each(|(target, value)| *target = f(*target, *value));
        };
        match (self.activation, one) {
            (Activation::None, _) if op.0.is::<Add>() => each(&mut self.bias, |a, b| a + b),
            (Activation::None, _) if op.0.is::<Mul>() => {
                each(&mut self.bias, |a, b| a * b);
                each(&mut self.scale, |a, b| a * b);
            }
            (Activation::None, Some(low)) if op.0.is::<Max>() => {
                self.activation = Activation::Clamp { low, high: f32::INFINITY };
            }
            (Activation::None, Some(high)) if op.0.is::<Min>() => {
                self.activation = Activation::Clamp { low: f32::NEG_INFINITY, high };
            }
            (Activation::Clamp { low, high }, Some(value)) if op.0.is::<Min>() && low <= value => {
                self.activation = Activation::Clamp { low, high: high.min(value) };
            }
            _ => return false,
        }
        true
    }
}

/// What a node keeps within limits that are numbers, and the limits.
pub(super) fn limits(model: &TypedModel, node: &TypedNode) -> TractResult<Option<(OutletId, Limits)>> {
    let Some(op) = node.op_as::<TypedBinOp>() else { return Ok(None) };
    for (bound, other) in [(0, 1), (1, 0)] {
        let konst = model.outlet_fact(node.inputs[bound])?.konst.clone();
        let same = model.outlet_fact(node.inputs[other])?.shape == node.outputs[0].fact.shape;
        let Some(konst) = konst.filter(|k| k.len() == 1 && k.datum_type() == f32::datum_type() && same) else {
            continue;
        };
        let bound = konst.cast_to_scalar::<f32>()?;
        let limits = if op.0.is::<Max>() {
            Limits { low: bound, ..Limits::NONE }
        } else if op.0.is::<Min>() {
            Limits { high: bound, ..Limits::NONE }
        } else {
            return Ok(None);
        };
        return Ok(Some((node.inputs[other], limits)));
    }
    Ok(None)
}

/// The values of a constant, one a channel, if it differs along the channels only.
fn channel_values(
    model: &TypedModel,
    outlet: OutletId,
    shape: &[usize],
    axes: &[usize],
) -> TractResult<Option<Vec<f32>>> {
    let fact = model.outlet_fact(outlet)?;
    let Some(konst) = fact.konst.as_ref().filter(|konst| konst.datum_type() == f32::datum_type()) else {
        return Ok(None);
    };
    let channels: usize = axes.iter().map(|axis| shape[*axis]).product();
    let values = konst.try_as_plain_ram()?.as_slice::<f32>()?;
    if values.len() == 1 {
        return Ok(Some(vec![values[0]; channels]));
    }
    let along = |(axis, &len): (usize, &usize)| if axes.contains(&axis) { len == shape[axis] } else { len == 1 };
    let fits = konst.rank() == shape.len() && konst.shape().iter().enumerate().all(along);
    Ok(fits.then(|| values.to_vec()))
}
