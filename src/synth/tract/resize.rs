//! Puts the kernel's enlargement in place of tract's, which works on one thread through copies of all planes.

use std::sync::Arc;

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::nn::Resize;

use super::{op, roles};
use crate::job::Cancel;
use crate::kernel::Isa;
use crate::kernel::resize::{Taps, resize};

/// Rewrites a decluttered model.
pub(super) fn rewrite(model: &mut TypedModel, isa: Isa) -> TractResult<()> {
    Rewriter::<Isa>::default().with_rule_for("resize", rule).rewrite(&isa, model)
}

/// Rows and columns at another size; all axes before them stay.
#[derive(Clone, Debug, PartialEq)]
struct PlaneResize {
    isa: Isa,
    size: [usize; 2],
    taps: Arc<[Taps; 2]>,
    shape: TVec<usize>,
}

impl Eq for PlaneResize {}

fn rule(
    isa: &Isa,
    model: &TypedModel,
    node: &TypedNode,
    name: &str,
    op: &Resize,
) -> TractResult<Option<TypedModelPatch>> {
    let fact = model.outlet_fact(node.inputs[0])?;
    let (Some(before), Some(shape)) = (roles::shape(model, node.inputs[0])?, roles::shape(model, node.id.into())?)
    else {
        return Ok(None);
    };
    let rank = before.len();
    if fact.datum_type != f32::datum_type() || rank < 2 || before.contains(&0) {
        return Ok(None);
    }
    let Some(scales) = scales(model, node, op, &before, &shape)? else { return Ok(None) };
    let stays = |axis: usize| before[axis] == shape[axis] && scales[axis] == 1.0;
    if !(0..rank - 2).all(stays) {
        return Ok(None);
    }
    let taps = |axis: usize| {
        if stays(axis) {
            return Taps { window: 1, places: (0..before[axis]).collect(), weights: vec![1.0; before[axis]] };
        }
        let plan = op.plan_axis(scales[axis], before[axis], shape[axis]);
        Taps { window: plan.window, places: plan.indices, weights: plan.weights }
    };
    let taps = Arc::new([taps(rank - 2), taps(rank - 1)]);
    let resize = PlaneResize { isa: *isa, size: [before[rank - 2], before[rank - 1]], taps, shape };
    let mut patch = TypedModelPatch::default();
    let tap = patch.tap_model(model, node.inputs[0])?;
    let output = patch.wire_node(format!("{name}.resize"), resize, &[tap])?;
    patch.shunt_outside(model, node.id.into(), output[0])?;
    Ok(Some(patch))
}

/// New length over old along each axis, as tract counts it.
fn scales(
    model: &TypedModel,
    node: &TypedNode,
    op: &Resize,
    before: &[usize],
    after: &[usize],
) -> TractResult<Option<Vec<f32>>> {
    let input = |slot: Option<usize>| slot.and_then(|slot| node.inputs.get(slot)).copied();
    if let Some(scales) = input(op.optional_scales_input) {
        let Some(konst) = model.outlet_fact(scales)?.konst.clone() else { return Ok(None) };
        if konst.len() == before.len() {
            return Ok(Some(konst.cast_to::<f32>()?.try_as_plain_ram()?.as_slice::<f32>()?.to_vec()));
        }
    }
    Ok(Some(after.iter().zip(before).map(|(after, before)| *after as f32 / *before as f32).collect()))
}

impl Op for PlaneResize {
    fn name(&self) -> StaticName {
        "PlaneResize".into()
    }

    fn info(&self) -> TractResult<Vec<String>> {
        Ok(vec![format!("{} {:?} to {:?}", self.isa, self.size, self.shape)])
    }

    op_as_typed_op!();
}

impl EvalOp for PlaneResize {
    op_out_of_plan!();

    fn eval(&self, _context: &EvalContext, inputs: TVec<TValue>) -> TractResult<TVec<TValue>> {
        let input = args_1!(inputs);
        let mut output = op::uninitialized(&self.shape)?;
        let cancel = op::cancel();
        let flag = cancel.as_ref().map(Cancel::flag);
        let [down, across] = &*self.taps;
        let x = input.try_as_plain_ram()?.as_slice::<f32>()?;
        resize(self.isa, x, self.size, [down, across], op::room(&mut output)?, flag)?;
        Ok(tvec!(output.into_tvalue()))
    }
}

impl TypedOp for PlaneResize {
    fn output_facts(&self, _inputs: &[&TypedFact]) -> TractResult<TVec<TypedFact>> {
        Ok(tvec!(f32::fact(&*self.shape)))
    }

    as_op!();
}
