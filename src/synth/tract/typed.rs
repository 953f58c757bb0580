//! From an ONNX file to tract's typed model at one shape of the picture, all of it in f32.

use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use tract_onnx::prelude::*;
use tract_onnx::tract_core::internal::bail;
use tract_onnx::tract_core::optim::{Optimizer, OptimizerSession, TypedPass};

use super::error::EngineError;
use super::fold;
use super::graph::{self, OnnxFile};
use super::op;
use crate::panics;

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
        let mut model = analysed(parsed.model.with_input_fact(0, f32::fact(shape).into())?)?;
        declutter(&mut model)?;
        if fold::constants(&mut model)? {
            declutter(&mut model)?;
        }
        Ok(model)
    };
    typed().map_err(|source| EngineError::shape(shape, source))
}

/// How often the cancel flag is looked at meanwhile.
const LOOK: Duration = Duration::from_millis(20);

/// tract's own analysis. It computes constants, takes seconds for some nets, and cannot be stopped: whoever stops it leaves it
/// to itself, and it ends when it is done.
fn analysed(model: InferenceModel) -> TractResult<TypedModel> {
    let (sender, answer) = mpsc::sync_channel(1);
    // Nobody may be there any more to hear of it.
    let work = move || _ = sender.send(panics::caught(|| model.into_typed()));
    thread::Builder::new().name("net-analysis".to_owned()).spawn(work)?;
    loop {
        match answer.recv_timeout(LOOK) {
            Ok(Some(typed)) => return typed,
            Err(RecvTimeoutError::Timeout) => op::stop()?,
            Ok(None) | Err(RecvTimeoutError::Disconnected) => bail!("its graph is damaged"),
        }
    }
}

/// tract's own simplification without the pass that drops a broadcast that the shape of an output needs.
pub(super) fn declutter(model: &mut TypedModel) -> TractResult<()> {
    let mut passes = Optimizer::declutter();
    passes.passes.retain(|pass| !format!("{pass:?}").starts_with("ConcatThenEinsum"));
    watched(passes).optimize(model)
}

/// The same passes, which end once the preparation was stopped.
fn watched(mut passes: Optimizer) -> Optimizer {
    passes.passes = passes.passes.into_iter().map(|pass| -> Box<dyn TypedPass> { Box::new(Watched(pass)) }).collect();
    passes
}

/// A pass that looks at the cancel flag before each of its steps.
#[derive(Clone, Debug)]
struct Watched(Box<dyn TypedPass>);

impl TypedPass for Watched {
    fn reset(&mut self) -> TractResult<()> {
        self.0.reset()
    }

    fn next(&mut self, session: &mut OptimizerSession, model: &TypedModel) -> TractResult<Option<TypedModelPatch>> {
        op::stop()?;
        self.0.next(session, model)
    }

    fn run_direct(&mut self, model: &mut TypedModel) -> TractResult<bool> {
        op::stop()?;
        self.0.run_direct(model)
    }
}

/// Prepares a model to be run: the operations that tract is fast at.
pub(super) fn optimised(mut model: TypedModel) -> TractResult<TypedModel> {
    declutter(&mut model)?;
    watched(Optimizer::codegen()).optimize(&mut model)?;
    Ok(model)
}
