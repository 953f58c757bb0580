//! Where the time of a net goes: seconds by operation.

use std::collections::BTreeMap;
use std::time::Instant;

use serde::Serialize;
use tract_onnx::prelude::*;
use tract_onnx::tract_core::internal::EvalContext;
use tract_onnx::tract_core::ops::OpState;
use tract_onnx::tract_core::plan;

use super::{EngineError, Runnable, threads};
use crate::kernel::peak::cpu_seconds;

/// What all nodes of one operation took together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OpSeconds {
    /// The operation, and the shapes of its result and of its first input.
    pub name: String,
    /// How many nodes.
    pub count: usize,
    /// Seconds on the clock.
    pub seconds: f64,
    /// Seconds of all threads together: what a busy machine does not change much.
    pub cpu_seconds: f64,
}

impl Runnable {
    /// Runs the net once on `input` and answers where the time went, the most first.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn profile(&self, input: &[f32]) -> Result<Vec<OpSeconds>, EngineError> {
        let input = Tensor::from_shape(&self.input_shape, input).map_err(EngineError::run)?;
        let mut spent: BTreeMap<String, (usize, f64, f64)> = BTreeMap::new();
        let mut eval =
            |context: &EvalContext, state: Option<&mut (dyn OpState + 'static)>, node: &TypedNode, inputs| {
                let (started, cpu) = (Instant::now(), cpu_seconds());
                let answer = plan::eval(context, state, node, inputs);
                let shape = node.outputs.first().map(|output| format!("{:?}", output.fact.shape)).unwrap_or_default();
                let of = node.inputs.first().and_then(|input| self.plan.model().outlet_fact(*input).ok());
                let of = of.map(|fact| format!(" of {:?}", fact.shape)).unwrap_or_default();
                let entry = spent.entry(format!("{} {shape}{of}", node.op().name())).or_default();
                *entry = (entry.0 + 1, entry.1 + started.elapsed().as_secs_f64(), entry.2 + cpu_seconds() - cpu);
                answer
            };
        let run = || -> TractResult<_> { self.plan.spawn()?.run_plan_with_eval(tvec!(input.into_tvalue()), &mut eval) };
        threads::pool(self.threads)?.install(run).map_err(EngineError::run)?;
        let op = |(name, (count, seconds, cpu_seconds))| OpSeconds { name, count, seconds, cpu_seconds };
        let mut all: Vec<_> = spent.into_iter().map(op).collect();
        all.sort_by(|a, b| b.cpu_seconds.total_cmp(&a.cpu_seconds));
        Ok(all)
    }
}
