//! `DirectConv`: the kernel's convolution with bias and activation as a tract operator.

use std::cell::RefCell;
use std::mem::MaybeUninit;
use std::sync::Arc;

use tract_onnx::tract_core::internal::*;

use crate::job::{Cancel, Cancelled};
use crate::kernel::{Activation, Conv, ConvShape, Ending, Isa, Kernel, Limits, Packed, Padding};

thread_local! {
    /// The cancel flag of the net that runs on this thread.
    static CANCEL: RefCell<Option<Cancel>> = const { RefCell::new(None) };
}

/// Runs `f`, whose convolutions look at `cancel`.
pub(super) fn with_cancel<R>(cancel: &Cancel, f: impl FnOnce() -> R) -> R {
    let before = CANCEL.replace(Some(cancel.clone()));
    let result = f();
    CANCEL.set(before);
    result
}

/// The cancel flag of the net that is prepared or runs on this thread.
pub(super) fn cancel() -> Option<Cancel> {
    CANCEL.with_borrow(Clone::clone)
}

/// An error once the net that is prepared or runs on this thread was stopped.
pub(super) fn stop() -> Result<(), Cancelled> {
    cancel().map_or(Ok(()), |cancel| cancel.check())
}

/// A convolution of stride 1 and group 1 with constant weights; `[n, c, y, x]`, or `[n, c, v, y, x]` where the kernel
/// is a volume. Inputs: the picture, and what is added at the end.
#[derive(Clone, Debug)]
pub(super) struct DirectConv {
    pub(super) isa: Isa,
    pub(super) kernel: Kernel,
    pub(super) dilation: usize,
    pub(super) padding: Padding,
    pub(super) activation: Activation,
    pub(super) channels: [usize; 2],
    pub(super) weights: Arc<Packed>,
    pub(super) bias: Arc<[f32]>,
    /// Of what comes in.
    pub(super) before: Limits,
    /// Of the result, after something was added.
    pub(super) limits: Limits,
}

impl PartialEq for DirectConv {
    fn eq(&self, other: &Self) -> bool {
        let plain = |op: &Self| (op.isa, op.kernel, op.dilation, op.padding, op.activation, op.channels);
        let limits = |op: &Self| (op.before, op.limits);
        plain(self) == plain(other)
            && limits(self) == limits(other)
            && self.weights == other.weights
            && self.bias == other.bias
    }
}

impl Eq for DirectConv {}

impl DirectConv {
    fn conv(&self, shape: &[usize]) -> TractResult<Conv> {
        let (batch, [views, height, width]) = match *shape {
            [n, _, y, x] => (n, [1, y, x]),
            [n, _, v, y, x] => (n, [v, y, x]),
            _ => bail!("a convolution of {shape:?}"),
        };
        ensure!(!shape.contains(&0), "an empty input, {shape:?}");
        let [channels_in, channels_out] = self.channels;
        let (kernel, dilation, padding) = (self.kernel, self.dilation, self.padding);
        let shape = ConvShape { batch, channels_in, channels_out, views, height, width, kernel, dilation, padding };
        Ok(Conv::new(shape, self.isa))
    }

    fn run(&self, input: &Tensor, summand: Option<&Tensor>) -> TractResult<Tensor> {
        let conv = self.conv(input.shape())?;
        let mut shape: TVec<usize> = input.shape().into();
        shape[1] = self.channels[1];
        let cancel = cancel();
        let flag = cancel.as_ref().map(Cancel::flag);
        let input = conv.pad_input_within(input.try_as_plain_ram()?.as_slice::<f32>()?, self.before);
        let summand = summand.map(|summand| summand.try_as_plain_ram()?.as_slice::<f32>()).transpose()?;
        let ending = Ending { summand, limits: self.limits };
        let mut output = uninitialized(&shape)?;
        let room = room(&mut output)?;
        conv.forward_onto(&input, &self.weights, (&self.bias, self.activation), ending, room, flag)?;
        Ok(output)
    }
}

/// A tensor whose values are still to be written.
#[allow(unsafe_code, reason = "zeroing tens of megabytes that are written over at once costs as much as a layer")]
pub(super) fn uninitialized(shape: &[usize]) -> TractResult<Tensor> {
    // SAFETY: the caller writes every value before anyone reads; on an error the tensor is dropped, and f32 has no drop.
    unsafe { Tensor::uninitialized::<f32>(shape) }
}

/// The values of a tensor as memory to be written.
#[allow(unsafe_code, reason = "see above")]
pub(super) fn room(tensor: &mut Tensor) -> TractResult<&mut [MaybeUninit<f32>]> {
    let (len, first) = (tensor.len(), tensor.as_ptr_mut::<f32>()?);
    // SAFETY: a plain tensor holds `len` values from `first` on, and is borrowed for as long as the slice.
    Ok(unsafe { std::slice::from_raw_parts_mut(first.cast(), len) })
}

/// What tract asks of an operator that makes a tensor of `self.shape` by `self.run(x, summand)`.
macro_rules! with_summand {
    ($operator:ty) => {
        impl EvalOp for $operator {
            op_out_of_plan!();

            fn eval(&self, _context: &EvalContext, inputs: TVec<TValue>) -> TractResult<TVec<TValue>> {
                let output = self.run(&inputs[0], inputs.get(1).map(|summand| &**summand))?;
                Ok(tvec!(output.into_tvalue()))
            }
        }

        impl TypedOp for $operator {
            fn output_facts(&self, _inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
                Ok(tvec!(f32::fact(&*self.shape)))
            }

            as_op!();
        }
    };
}
pub(super) use with_summand;

impl Op for DirectConv {
    fn name(&self) -> StaticName {
        "DirectConv".into()
    }

    fn info(&self) -> TractResult<Vec<String>> {
        let Self { isa, kernel, dilation, padding, activation, channels, .. } = self;
        Ok(vec![format!("{isa} {kernel:?} {channels:?} dilation {dilation} {padding:?} {activation:?}")])
    }

    op_as_typed_op!();
}

impl EvalOp for DirectConv {
    op_out_of_plan!();

    fn eval(&self, _context: &EvalContext, inputs: TVec<TValue>) -> TractResult<TVec<TValue>> {
        let output = self.run(&inputs[0], inputs.get(1).map(|summand| &**summand))?;
        Ok(tvec!(output.into_tvalue()))
    }
}

impl TypedOp for DirectConv {
    fn output_facts(&self, inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
        let mut shape = inputs[0].shape.clone();
        shape.set(1, self.channels[1].to_dim());
        Ok(tvec!(f32::fact(shape)))
    }

    as_op!();
}
