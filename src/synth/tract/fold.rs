//! Computes what does not depend on the picture, once. tract itself stops where a constant in between is larger than a
//! megabyte, as the position tables of some transformers are.

use std::collections::BTreeMap;
use std::sync::Arc;

use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_core::ops::dummy::Dummy;
use tract_onnx::tract_core::ops::konst::Const;
use tract_onnx::tract_core::ops::source::TypedSource;

/// Values of a constant at most; what is larger is computed each time from what it is made of.
const LARGEST: usize = 1 << 20;

/// Puts constants in place of what is made of constants alone; whether there was any.
pub(super) fn constants(model: &mut TypedModel) -> TractResult<bool> {
    let mut known: BTreeMap<OutletId, Arc<Tensor>> = BTreeMap::new();
    for id in model.eval_order()? {
        let node = model.node(id);
        if node.op_is::<TypedSource>() || node.op_is::<Dummy>() || node.op_is::<Const>() {
            continue;
        }
        let value = |input: &OutletId| -> Option<TValue> {
            let konst = model.outlet_fact(*input).ok()?.konst.as_ref();
            known.get(input).or(konst).map(|tensor| Arc::clone(tensor).into_tvalue())
        };
        let Some(inputs) = node.inputs.iter().map(value).collect::<Option<TVec<_>>>() else { continue };
        // What cannot be computed here is left to tract.
        let Ok(Some(values)) = node.op.eval_out_of_plan(inputs) else { continue };
        let plain = |value: &TValue| value.is_plain() && value.len() <= LARGEST;
        if values.iter().all(plain) {
            let values = values.into_iter().enumerate();
            known.extend(values.map(|(slot, value)| (OutletId::new(id, slot), value.into_arc_tensor())));
        }
    }
    let is_wanted = |outlet: &OutletId| {
        let successors = &model.node(outlet.node).outputs[outlet.slot].successors;
        let outside = successors.iter().any(|next| !known.contains_key(&OutletId::new(next.node, 0)));
        outside || model.outputs.contains(outlet)
    };
    let wanted: Vec<OutletId> = known.keys().copied().filter(is_wanted).collect();
    let mut patch = TypedModelPatch::default();
    for outlet in &wanted {
        let name = format!("{}.{}.constant", model.node(outlet.node).name, outlet.slot);
        let constant = patch.add_const(name, Arc::clone(&known[outlet]))?;
        patch.shunt_outside(model, *outlet, constant)?;
    }
    drop(known);
    patch.apply(model)?;
    Ok(!wanted.is_empty())
}
