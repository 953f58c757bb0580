//! The nets' operations on the kernel that inference uses, as differentiable operations of burn.

use burn::backend::autodiff::NodeId;
use burn::backend::autodiff::checkpoint::{base::Checkpointer, strategy::CheckpointStrategy};
use burn::backend::autodiff::grads::Gradients;
use burn::backend::autodiff::ops::{Backward, Ops, OpsKind};
use burn::backend::flex::FlexTensor;
use burn::backend::tensor::FloatTensor;
use burn::backend::{Autodiff, AutodiffBackend, Backend, Dispatch, Flex, backend_extension};
use burn::tensor::Tensor;

use super::Patch;
use super::own_conv::{Biased, Norm, Saved, SavedBiased, biased_backward, biased_forward, norm_backward, norm_forward};
use super::own_flex::{contiguous, dims, make, pool_backward, pool_forward, slice, up_backward, up_forward};
use super::own_patch::{SavedPatch, patch_forward};

/// Our operations, in terms of a backend's own tensors. Shapes as in [`crate::ops`].
#[backend_extension(Flex, Autodiff)]
pub trait LightFieldOps: Backend {
    /// Convolution, batch normalisation, ELU; and the batch's means and variances.
    fn conv_norm_elu(
        x: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        norm: Norm,
    ) -> (FloatTensor<Self>, FloatTensor<Self>);
    /// Convolution with bias, then ELU or scaled tanh.
    fn conv_biased(
        x: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        end: Biased,
    ) -> FloatTensor<Self>;
    /// Zero-padded convolution with bias, then 0 … 6 if it is clamped.
    fn conv_patch(
        x: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        how: Patch,
    ) -> FloatTensor<Self>;
    /// Mean of 2×2 pixels.
    fn pool(x: FloatTensor<Self>) -> FloatTensor<Self>;
    /// Twice the size, then a skip.
    fn up_concat(low: FloatTensor<Self>, skip: FloatTensor<Self>) -> FloatTensor<Self>;
}

impl LightFieldOps for Flex {
    fn conv_norm_elu(
        x: FlexTensor,
        weight: FlexTensor,
        gamma: FlexTensor,
        beta: FlexTensor,
        norm: Norm,
    ) -> (FlexTensor, FlexTensor) {
        let (y, statistics, _) = norm_forward(x, weight, [gamma, beta], norm);
        (y, statistics)
    }
    fn conv_biased(x: FlexTensor, weight: FlexTensor, bias: FlexTensor, end: Biased) -> FlexTensor {
        biased_forward(x, weight, bias, end).0
    }
    fn conv_patch(x: FlexTensor, weight: FlexTensor, bias: FlexTensor, how: Patch) -> FlexTensor {
        patch_forward(x, weight, bias, how).0
    }
    fn pool(x: FlexTensor) -> FlexTensor {
        pool_forward(&contiguous(x))
    }
    fn up_concat(low: FlexTensor, skip: FlexTensor) -> FlexTensor {
        up_forward(&contiguous(low), &contiguous(skip))
    }
}

/// Hands each parent that wants one its gradient.
fn register<const N: usize>(gradients: &mut Gradients, parents: [Option<NodeId>; N], taken: [Option<FlexTensor>; N]) {
    for (parent, gradient) in parents.into_iter().zip(taken) {
        if let (Some(parent), Some(gradient)) = (parent, gradient) {
            gradients.register::<Flex>(parent, gradient);
        }
    }
}

#[derive(Debug)]
struct NormBackward;

impl Backward<Flex, 4> for NormBackward {
    type State = Saved;

    fn backward(self, ops: Ops<Saved, 4>, gradients: &mut Gradients, _: &mut Checkpointer) {
        let gy = contiguous(gradients.consume::<Flex>(&ops.node));
        let wants_x = ops.parents[0].is_some();
        let taken = norm_backward(&ops.state, slice(&gy), wants_x);
        register(gradients, ops.parents.map(|parent| parent.map(|node| node.id)), taken);
    }
}

#[derive(Debug)]
struct BiasedBackward;

impl Backward<Flex, 3> for BiasedBackward {
    type State = SavedBiased;

    fn backward(self, ops: Ops<SavedBiased, 3>, gradients: &mut Gradients, _: &mut Checkpointer) {
        let gy = contiguous(gradients.consume::<Flex>(&ops.node));
        let wants_x = ops.parents[0].is_some();
        let taken = biased_backward(&ops.state, slice(&gy), wants_x);
        register(gradients, ops.parents.map(|parent| parent.map(|node| node.id)), taken);
    }
}

#[derive(Debug)]
struct PatchBackward;

impl Backward<Flex, 3> for PatchBackward {
    type State = SavedPatch;

    fn backward(self, ops: Ops<SavedPatch, 3>, gradients: &mut Gradients, _: &mut Checkpointer) {
        let gy = contiguous(gradients.consume::<Flex>(&ops.node));
        let wants_x = ops.parents[0].is_some();
        let taken = ops.state.backward(slice(&gy), wants_x);
        register(gradients, ops.parents.map(|parent| parent.map(|node| node.id)), taken);
    }
}

#[derive(Debug)]
struct PoolBackward;

impl Backward<Flex, 1> for PoolBackward {
    type State = Vec<usize>;

    fn backward(self, ops: Ops<Vec<usize>, 1>, gradients: &mut Gradients, _: &mut Checkpointer) {
        let gy = contiguous(gradients.consume::<Flex>(&ops.node));
        if let [Some(parent)] = ops.parents {
            gradients.register::<Flex>(parent.id, make(pool_backward(slice(&gy), &ops.state), &ops.state));
        }
    }
}

#[derive(Debug)]
struct UpBackward;

impl Backward<Flex, 2> for UpBackward {
    type State = [Vec<usize>; 2];

    fn backward(self, ops: Ops<[Vec<usize>; 2], 2>, gradients: &mut Gradients, _: &mut Checkpointer) {
        let gy = contiguous(gradients.consume::<Flex>(&ops.node));
        let [low, skip] = &ops.state;
        let (to_low, to_skip) = up_backward(slice(&gy), low, skip);
        let [low_parent, skip_parent] = ops.parents;
        if let Some(parent) = low_parent {
            gradients.register::<Flex>(parent.id, make(to_low, low));
        }
        if let Some(parent) = skip_parent {
            gradients.register::<Flex>(parent.id, make(to_skip, skip));
        }
    }
}

impl<C: CheckpointStrategy> LightFieldOps for Autodiff<Flex, C> {
    fn conv_norm_elu(
        x: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        gamma: FloatTensor<Self>,
        beta: FloatTensor<Self>,
        norm: Norm,
    ) -> (FloatTensor<Self>, FloatTensor<Self>) {
        let ((x, nx), (weight, nw), (gamma, ng), (beta, nb)) =
            (x.into_parts(), weight.into_parts(), gamma.into_parts(), beta.into_parts());
        let (y, statistics, saved) = norm_forward(x, weight, [gamma, beta], norm);
        let y = match NormBackward.prepare::<C>([nx, nw, ng, nb]).compute_bound().stateful() {
            OpsKind::Tracked(prepared) => prepared.finish(saved, y),
            OpsKind::UnTracked(prepared) => prepared.finish(y),
        };
        (y, <Self as AutodiffBackend>::from_inner(statistics))
    }

    fn conv_biased(
        x: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        end: Biased,
    ) -> FloatTensor<Self> {
        let ((x, nx), (weight, nw), (bias, nb)) = (x.into_parts(), weight.into_parts(), bias.into_parts());
        let (y, saved) = biased_forward(x, weight, bias, end);
        match BiasedBackward.prepare::<C>([nx, nw, nb]).compute_bound().stateful() {
            OpsKind::Tracked(prepared) => prepared.finish(saved, y),
            OpsKind::UnTracked(prepared) => prepared.finish(y),
        }
    }

    fn conv_patch(
        x: FloatTensor<Self>,
        weight: FloatTensor<Self>,
        bias: FloatTensor<Self>,
        how: Patch,
    ) -> FloatTensor<Self> {
        let ((x, nx), (weight, nw), (bias, nb)) = (x.into_parts(), weight.into_parts(), bias.into_parts());
        let (y, saved) = patch_forward(x, weight, bias, how);
        match PatchBackward.prepare::<C>([nx, nw, nb]).compute_bound().stateful() {
            OpsKind::Tracked(prepared) => prepared.finish(saved, y),
            OpsKind::UnTracked(prepared) => prepared.finish(y),
        }
    }

    fn pool(x: FloatTensor<Self>) -> FloatTensor<Self> {
        let (x, node) = x.into_parts();
        let x = contiguous(x);
        let y = pool_forward(&x);
        match PoolBackward.prepare::<C>([node]).compute_bound().stateful() {
            OpsKind::Tracked(prepared) => prepared.finish(dims(&x), y),
            OpsKind::UnTracked(prepared) => prepared.finish(y),
        }
    }

    fn up_concat(low: FloatTensor<Self>, skip: FloatTensor<Self>) -> FloatTensor<Self> {
        let ((low, nl), (skip, ns)) = (low.into_parts(), skip.into_parts());
        let (low, skip) = (contiguous(low), contiguous(skip));
        let y = up_forward(&low, &skip);
        match UpBackward.prepare::<C>([nl, ns]).compute_bound().stateful() {
            OpsKind::Tracked(prepared) => prepared.finish([dims(&low), dims(&skip)], y),
            OpsKind::UnTracked(prepared) => prepared.finish(y),
        }
    }
}

pub(super) fn conv_norm_elu<const D: usize>(
    x: Tensor<D>,
    weight: Tensor<D>,
    gamma: Tensor<1>,
    beta: Tensor<1>,
    norm: Norm,
) -> (Tensor<D>, Tensor<2>) {
    let (y, statistics) = <Dispatch as LightFieldOps>::conv_norm_elu(
        x.into_dispatch(),
        weight.into_dispatch(),
        gamma.into_dispatch(),
        beta.into_dispatch(),
        norm,
    );
    (Tensor::from_dispatch(y), Tensor::from_dispatch(statistics))
}

pub(super) fn conv_biased<const D: usize>(x: Tensor<D>, weight: Tensor<D>, bias: Tensor<1>, end: Biased) -> Tensor<D> {
    Tensor::from_dispatch(<Dispatch as LightFieldOps>::conv_biased(
        x.into_dispatch(),
        weight.into_dispatch(),
        bias.into_dispatch(),
        end,
    ))
}

pub(super) fn conv_patch(x: Tensor<4>, weight: Tensor<4>, bias: Tensor<1>, how: Patch) -> Tensor<4> {
    Tensor::from_dispatch(<Dispatch as LightFieldOps>::conv_patch(
        x.into_dispatch(),
        weight.into_dispatch(),
        bias.into_dispatch(),
        how,
    ))
}

pub(super) fn pool(x: Tensor<4>) -> Tensor<4> {
    Tensor::from_dispatch(<Dispatch as LightFieldOps>::pool(x.into_dispatch()))
}

pub(super) fn up_concat(low: Tensor<4>, skip: Tensor<4>) -> Tensor<4> {
    Tensor::from_dispatch(<Dispatch as LightFieldOps>::up_concat(low.into_dispatch(), skip.into_dispatch()))
}
