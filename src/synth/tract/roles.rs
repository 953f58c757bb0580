//! What each axis of a product of two tensors is for.

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::einsum::EinSum;

/// What an axis is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// In the left tensor and the result.
    Rows,
    /// In the right tensor and the result.
    Columns,
    /// In both tensors, summed over.
    Depth,
    /// In all three.
    Batch,
}

/// An axis longer than 1: its role, its length, and where it stands in the left tensor, the right one and the result.
#[derive(Clone, Copy, Debug)]
pub(super) struct RoleAxis {
    pub(super) role: Role,
    pub(super) len: usize,
    pub(super) at: [Option<usize>; 3],
}

/// The lengths of the axes of an outlet, if they are known.
pub(super) fn shape(model: &TypedModel, outlet: OutletId) -> TractResult<Option<TVec<usize>>> {
    Ok(model.outlet_fact(outlet)?.shape.as_concrete().map(TVec::from_slice))
}

/// All axes longer than 1 of an f32 product of two tensors, `left` being the input that counts as the left one. `None`
/// where it is something else.
pub(super) fn roles(
    model: &TypedModel,
    node: &TypedNode,
    op: &EinSum,
    left: usize,
) -> TractResult<Option<Vec<RoleAxis>>> {
    let plain = |outlet| Ok::<_, TractError>(model.outlet_fact(outlet)?.datum_type == f32::datum_type());
    if node.inputs.len() != 2 || op.q_params.is_some() || !plain(node.inputs[0])? || !plain(node.inputs[1])? {
        return Ok(None);
    }
    let (Some(left_shape), Some(right_shape)) =
        (shape(model, node.inputs[left])?, shape(model, node.inputs[1 - left])?)
    else {
        return Ok(None);
    };
    let mut all = Vec::new();
    for axis in op.axes.iter_all_axes() {
        let places = [&axis.inputs[left], &axis.inputs[1 - left], &axis.outputs[0]];
        if places.iter().any(|place| place.len() > 1) {
            return Ok(None);
        }
        let at = places.map(|place| place.first().copied());
        let lens = [at[0].map(|at| left_shape[at]), at[1].map(|at| right_shape[at])];
        let len = lens.into_iter().flatten().max().unwrap_or(1);
        if len == 1 {
            continue;
        }
        let role = match at.map(|at| at.is_some()) {
            [true, false, true] => Role::Rows,
            [false, true, true] => Role::Columns,
            [true, true, false] => Role::Depth,
            [true, true, true] => Role::Batch,
            _ => return Ok(None),
        };
        // An axis of length 1 on one side only would be a broadcast.
        if lens.into_iter().flatten().any(|n| n != len) {
            return Ok(None);
        }
        all.push(RoleAxis { role, len, at });
    }
    Ok(Some(all))
}

/// The axes of one role in the order in which they stand in a tensor (0 left, 1 right, 2 result).
pub(super) fn of(all: &[RoleAxis], role: Role, tensor: usize) -> Vec<RoleAxis> {
    let mut axes: Vec<RoleAxis> = all.iter().copied().filter(|axis| axis.role == role).collect();
    axes.sort_by_key(|axis| axis.at[tensor]);
    axes
}

/// Whether a tensor has its axes in this order: all of the first role, then all of the second.
pub(super) fn in_order(all: &[RoleAxis], tensor: usize, [first, second]: [Role; 2]) -> bool {
    let last = all.iter().filter(|axis| axis.role == first).filter_map(|axis| axis.at[tensor]).max();
    let next = all.iter().filter(|axis| axis.role == second).filter_map(|axis| axis.at[tensor]).min();
    last.zip(next).is_none_or(|(last, next)| last < next)
}

/// Whether the axes of a role follow each other in the same order in two tensors.
pub(super) fn alike(all: &[RoleAxis], role: Role, [a, b]: [usize; 2]) -> bool {
    let order = |tensor| of(all, role, tensor).into_iter().map(|axis| axis.at).collect::<Vec<_>>();
    order(a) == order(b)
}

/// Values between neighbours along each axis of a row-major tensor.
pub(super) fn strides(shape: &[usize]) -> TVec<usize> {
    let mut strides: TVec<usize> = tvec![1; shape.len()];
    for axis in (1..shape.len()).rev() {
        strides[axis - 1] = strides[axis] * shape[axis];
    }
    strides
}

/// The offset of each index of some axes in a row-major tensor, the last axis running fastest.
pub(super) fn offsets(axes: &[RoleAxis], tensor: usize, strides: &[usize]) -> Vec<usize> {
    axes.iter().fold(vec![0], |offsets, axis| {
        let stride = axis.at[tensor].map_or(0, |at| strides[at]);
        offsets.into_iter().flat_map(|offset| (0..axis.len).map(move |i| offset + i * stride)).collect()
    })
}
