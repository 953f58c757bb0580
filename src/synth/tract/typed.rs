//! From an ONNX file to tract's typed model at one shape of the picture, all of it in f32.

use std::sync::Arc;

use tract_onnx::prelude::*;
use tract_onnx::tract_core::optim::Optimizer;

use super::error::EngineError;
use super::fold;
use super::graph::{self, OnnxFile};

/// The decluttered model; its input has this shape.
pub(super) fn model(mut onnx: tract_onnx::Onnx, file: &OnnxFile, shape: &[usize]) -> Result<TypedModel, EngineError> {
    let (proto, outside) = graph::read(&onnx, file)?;
    onnx.provider = Arc::new(outside);
    // Shapes of inner values that were inferred for symbolic axes contradict the shape that is asked for.
    let onnx = onnx.with_ignore_output_shapes(true).with_ignore_value_info(true);
    let parsed = onnx.parse(&proto, file.weights_folder().as_deref()).map_err(EngineError::unsupported)?;
    drop(proto);
    if let Some(name) = parsed.unresolved_inputs.first() {
        return Err(EngineError::Unsupported { detail: format!("nothing makes its value {name}") });
    }
    let typed = || {
        let mut model = parsed.model.with_input_fact(0, f32::fact(shape).into())?.into_typed()?;
        declutter(&mut model)?;
        if fold::constants(&mut model)? {
            declutter(&mut model)?;
        }
        Ok(model)
    };
    typed().map_err(|source| EngineError::shape(shape, source))
}

/// tract's own simplification without the pass that drops a broadcast that the shape of an output needs.
pub(super) fn declutter(model: &mut TypedModel) -> TractResult<()> {
    let mut passes = Optimizer::declutter();
    passes.passes.retain(|pass| !format!("{pass:?}").starts_with("ConcatThenEinsum"));
    passes.optimize(model)
}

/// Prepares a model to be run: the operations that tract is fast at.
pub(super) fn optimised(mut model: TypedModel) -> TractResult<TypedModel> {
    declutter(&mut model)?;
    Optimizer::codegen().optimize(&mut model)?;
    Ok(model)
}
