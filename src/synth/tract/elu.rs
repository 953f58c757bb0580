//! ELU as one operator: tract spends four to five passes over memory on it.

use tract_onnx::Onnx;
use tract_onnx::model::ParsingContext;
use tract_onnx::pb::NodeProto;
use tract_onnx::tract_core::element_wise;
use tract_onnx::tract_core::internal::*;
use tract_onnx::tract_hir::internal::{InferenceOp, expand};
use tract_onnx::tract_hir::ops::activations;
use tract_onnx::tract_hir::ops::element_wise::ElementWiseIntoHir as _;

use crate::kernel::{Activation, Isa, norm};

element_wise!(fused_elu, FusedElu,
    [f32] => |_, values| {
        norm::activate(Isa::best(), values, Activation::Elu);
        Ok(())
    }
);

fn elu(_context: &ParsingContext, node: &NodeProto) -> TractResult<(Box<dyn InferenceOp>, Vec<String>)> {
    let alpha = node.get_attr_opt::<f32>("alpha")?.unwrap_or(1.0);
    let op = if alpha == 1.0 { fused_elu().into_hir() } else { expand(activations::Elu(alpha)) };
    Ok((op, vec![]))
}

/// tract's ONNX reader, with this ELU where its α is 1.
pub(super) fn onnx() -> Onnx {
    let mut onnx = tract_onnx::onnx();
    onnx.op_register.insert("Elu", elu);
    onnx
}
