//! Puts the kernel's product in place of each product with constant weights, with what follows it.

use std::sync::Arc;

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::einsum::EinSum;

use super::op;
use super::roles::{self, Role, RoleAxis};
use super::tail::Tail;
use crate::job::Cancel;
use crate::kernel::product::{Columns, Dense, Panels, Project};
use crate::kernel::{Activation, Isa, Limits};

/// Rewrites a decluttered model.
pub(super) fn rewrite(model: &mut TypedModel, isa: Isa) -> TractResult<()> {
    Rewriter::<Isa>::default().with_rule_for("dense", rule).rewrite(&isa, model)
}

/// A product with constant weights, and what follows it. Inputs: the activations, and what is added at the end.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Product {
    isa: Isa,
    pub(super) weights: Weights,
    pub(super) bias: Arc<[f32]>,
    pub(super) activation: Activation,
    pub(super) limits: Limits,
    pub(super) shape: TVec<usize>,
}

impl Eq for Product {}

/// How activations and result lie in memory.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Weights {
    /// `[rows, depth]` → `[rows, columns]`
    Rows(Arc<Panels>),
    /// `[depth, pixels]`, or `[pixels, depth]` if it says so, → `[channels, pixels]`; the weights `[channels, depth]`.
    Planes { weights: Arc<[f32]>, pixels_first: bool },
}

fn rule(
    isa: &Isa,
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    op: &EinSum,
) -> TractResult<Option<TypedModelPatch>> {
    let konst = |slot: usize| model.outlet_fact(node.inputs[slot]).map(|fact| fact.konst.clone());
    let (slot, weights) = match (node.inputs.len() == 2).then(|| (konst(0), konst(1))) {
        Some((Ok(None), Ok(Some(weights)))) => (0, weights),
        Some((Ok(Some(weights)), Ok(None))) => (1, weights),
        _ => return Ok(None),
    };
    let Some(all) = roles::roles(model, node, op, slot)? else { return Ok(None) };
    let Some(shape) = roles::shape(model, node.id.into())? else { return Ok(None) };
    let Some(layout) = layout(&all) else { return Ok(None) };
    let columns = roles::of(&all, Role::Columns, 2);
    let channels: usize = columns.iter().map(|axis| axis.len).product();
    let axes: Vec<usize> = columns.iter().filter_map(|axis| axis.at[2]).collect();
    let tail = Tail::of(model, node, &axes, channels)?;
    let strides = roles::strides(weights.shape());
    let at = [Role::Depth, Role::Columns].map(|role| {
        let order = if role == Role::Depth { 0 } else { 2 };
        roles::offsets(&roles::of(&all, role, order), 1, &strides)
    });
    // Weights of 4 bits are unpacked by tract as it multiplies.
    let Ok(values) = weights.try_as_plain_ram() else { return Ok(None) };
    let values = values.as_slice::<f32>()?;
    let weights = pack(*isa, layout, at, values, &tail.scale);
    let (bias, activation, limits) = (tail.bias.into(), tail.activation, tail.limits);
    let product = Product { isa: *isa, weights, bias, activation, limits, shape };
    let mut patch = TypedModelPatch::default();
    let inputs: TractResult<TVec<_>> =
        std::iter::once(node.inputs[slot]).chain(tail.summand).map(|input| patch.tap_model(model, input)).collect();
    let output = patch.wire_node(format!("{name}.product"), product, &inputs?)?;
    patch.shunt_outside(model, tail.last, output[0])?;
    Ok(Some(patch))
}

/// Which side the pixels lie on.
#[derive(Clone, Copy, PartialEq)]
enum Layout {
    Rows,
    Planes,
    PixelsFirst,
}

fn layout(all: &[RoleAxis]) -> Option<Layout> {
    use Role::{Columns, Depth, Rows};
    if all.iter().any(|axis| axis.role == Role::Batch) || !roles::alike(all, Rows, [0, 2]) {
        return None;
    }
    let rows_first = roles::in_order(all, 0, [Rows, Depth]);
    if rows_first && roles::in_order(all, 2, [Rows, Columns]) {
        return Some(Layout::Rows);
    }
    match (roles::in_order(all, 0, [Depth, Rows]), roles::in_order(all, 2, [Columns, Rows])) {
        (true, true) => Some(Layout::Planes),
        (false, true) if rows_first => Some(Layout::PixelsFirst),
        _ => None,
    }
}

/// Packs weights whose value at (depth, column) lies at the sum of the two offsets.
fn pack(isa: Isa, layout: Layout, [depth, columns]: [Vec<usize>; 2], values: &[f32], scale: &[f32]) -> Weights {
    let value = |k: usize, column: usize| values[depth[k] + columns[column]] * scale[column];
    if layout == Layout::Rows {
        return Weights::Rows(Arc::new(Panels::of(isa, [depth.len(), columns.len()], value)));
    }
    let rows = (0..columns.len()).flat_map(|column| (0..depth.len()).map(move |k| (k, column)));
    let weights = rows.map(|(k, column)| value(k, column)).collect();
    Weights::Planes { weights, pixels_first: layout == Layout::PixelsFirst }
}

impl Product {
    fn run(&self, x: &Tensor, summand: Option<&Tensor>) -> TractResult<Tensor> {
        let mut output = op::uninitialized(&self.shape)?;
        let cancel = op::cancel();
        let flag = cancel.as_ref().map(Cancel::flag);
        let summand = summand.map(|summand| summand.try_as_plain_ram()?.as_slice::<f32>()).transpose()?;
        let x = x.try_as_plain_ram()?.as_slice::<f32>()?;
        let room = op::room(&mut output)?;
        let &Self { isa, ref bias, activation, limits, .. } = self;
        match &self.weights {
            Weights::Rows(weights) => {
                Dense { isa, weights, bias, activation, limits }.run(x, summand, room, flag)?;
            }
            Weights::Planes { weights, pixels_first } => {
                let columns = if *pixels_first { Columns::PixelsFirst(x) } else { Columns::Planes(x) };
                Project { isa, weights, bias, activation, limits }.run(columns, summand, room, flag)?;
            }
        }
        Ok(output)
    }
}

impl Op for Product {
    fn name(&self) -> StaticName {
        match &self.weights {
            Weights::Rows(_) => "Product".into(),
            Weights::Planes { .. } => "PlaneProduct".into(),
        }
    }

    fn info(&self) -> TractResult<Vec<String>> {
        Ok(vec![format!("{} {:?}", self.isa, self.activation)])
    }

    op_as_typed_op!();
}

op::with_summand!(Product);
