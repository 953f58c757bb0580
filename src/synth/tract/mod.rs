//! The only place that knows tract: a plain ONNX file becomes a [`Runnable`] for one input shape.
//!
//! ```text
//! ONNX bytes ─parse─► typed model at a fixed shape ─rewrite─► direct convolutions, products, attention … ─fuse─► chains
//!            ─optimise─► Runnable
//! ```
//!
//! Optimising costs 20–100 ms and is bound to the shape, so whoever runs a net often keeps its `Runnable`.

mod attention;
mod chain;
mod dense;
mod elu;
mod ends;
mod error;
mod fold;
mod graph;
mod inverted;
mod layer_norm;
mod op;
mod options;
mod patch_conv;
mod picture;
mod profile;
mod resize;
mod rewrite;
mod roles;
mod room;
mod tail;
mod threads;
mod typed;
mod weights;

use std::ops::Deref;
use std::sync::Arc;

use tract_onnx::prelude::*;
use tract_onnx::tract_core::internal::{DimLike as _, EvalContext, format_err};
use tract_onnx::tract_core::ops::OpState;
use tract_onnx::tract_core::plan;

pub use error::EngineError;
#[cfg(test)]
pub(crate) use graph::tests as graph_tests;
pub use graph::{OnnxBytes, OnnxFile, Port, Scale, Signs, Wiring, signs};
pub use options::{Options, Path};
pub use picture::picture_shape;
pub use profile::OpSeconds;
pub(crate) use threads::{Pool, pool};
pub use weights::SharedWeights;

use self::chain::{Chain, Convolutions};
use crate::job::Cancel;
use crate::kernel::Isa;
use crate::kernel::winograd::VolumeChain;
use crate::panics;

/// A net made ready for one input shape. Cheap to clone; may be run from several threads at once.
#[derive(Clone, Debug)]
pub struct Runnable {
    plan: Arc<TypedRunnableModel>,
    input_shape: Vec<usize>,
    output_shape: Vec<usize>,
    threads: usize,
}

/// What a net answered: its values in the order of the ONNX file's output, `[1, C, (V·U,) H, W]`.
#[derive(Clone, Debug)]
pub struct Output(Arc<Tensor>);

impl Output {
    /// Lengths of the axes.
    pub fn shape(&self) -> &[usize] {
        self.0.shape()
    }
}

impl Output {
    fn of(value: TValue) -> TractResult<Self> {
        let tensor = value.into_arc_tensor();
        let is_f32 = tensor.datum_type() == f32::datum_type();
        Ok(Self(if is_f32 { tensor } else { tensor.cast_to::<f32>()?.into_owned().into_arc_tensor() }))
    }
}

impl Deref for Output {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        self.0.try_as_plain_ram().and_then(|view| view.as_slice::<f32>()).unwrap_or_default()
    }
}

/// Makes the net in the bytes of an ONNX file ready to run on inputs of `input_shape`; its first output is answered.
///
/// # Errors
/// Bytes that are no ONNX model, an operator that is not known, a shape that the net does not take, weights that
/// are not finite.
pub fn prepare(onnx_bytes: &[u8], input_shape: &[usize], options: &Options) -> Result<Runnable, EngineError> {
    prepare_file(&OnnxFile::plain(onnx_bytes), input_shape, options)
}

/// Makes an ONNX file ready that may have weights beside it, several inputs and several outputs.
///
/// # Errors
/// Those of [`prepare`]; weights, inputs or outputs that are not there; [`EngineError::Cancelled`].
pub fn prepare_file(file: &OnnxFile, input_shape: &[usize], options: &Options) -> Result<Runnable, EngineError> {
    // tract takes names that lead nowhere, and other faults of a graph, for its own and panics.
    let broken = || Err(EngineError::Unsupported { detail: "its graph is damaged".to_owned() });
    let ready = || op::with_cancel(&options.cancel, || prepared(file, input_shape, options));
    let ready = panics::caught(ready).unwrap_or_else(broken);
    if options.cancel.is_cancelled() { Err(EngineError::Cancelled) } else { ready }
}

fn prepared(file: &OnnxFile, input_shape: &[usize], options: &Options) -> Result<Runnable, EngineError> {
    let isa = options.path.isa();
    let onnx = if isa.is_some() { elu::onnx() } else { onnx() };
    let shape_error = |source| EngineError::shape(input_shape, source);
    let mut model = typed::model(onnx, file, input_shape)?;
    if let Some(isa) = isa {
        rewrite::rewrite(&mut model, isa).map_err(shape_error)?;
        ends::rewrite(&mut model).map_err(shape_error)?;
        foreign(&mut model, isa).map_err(shape_error)?;
        if !options.exact {
            chain::fuse(&mut model, options.halves()).map_err(shape_error)?;
        }
    }
    let mut model = typed::optimised(model).map_err(shape_error)?;
    room::check(&model)?;
    options.weights.share(&mut model);
    let plan = model.into_runnable().map_err(shape_error)?;
    let output_shape = output_shape(&plan).map_err(shape_error)?;
    Ok(Runnable { plan, input_shape: input_shape.to_vec(), output_shape, threads: options.threads })
}

/// What public nets are made of, done by the kernel.
fn foreign(model: &mut TypedModel, isa: Isa) -> TractResult<()> {
    let packing: [fn(&mut TypedModel, Isa) -> TractResult<()>; 4] =
        [attention::rewrite, layer_norm::rewrite, dense::rewrite, patch_conv::rewrite];
    for rewrite in packing {
        op::stop()?;
        rewrite(model, isa)?;
    }
    inverted::rewrite(model)?;
    resize::rewrite(model, isa)
}

fn output_shape(plan: &TypedRunnableModel) -> TractResult<Vec<usize>> {
    plan.model().output_fact(0)?.shape.iter().map(|dim| Ok(dim.to_usize()?)).collect()
}

impl Runnable {
    /// The shape that [`run`](Self::run) takes.
    pub fn input_shape(&self) -> &[usize] {
        &self.input_shape
    }

    /// The shape that [`run`](Self::run) answers.
    pub fn output_shape(&self) -> &[usize] {
        &self.output_shape
    }

    /// How many convolutions of the net are done by the kernel.
    pub fn direct_convolutions(&self) -> usize {
        let of = |node: &TypedNode| match node.op_as::<Chain>() {
            Some(chain) => chain.len,
            None => usize::from(node.op_is::<op::DirectConv>()),
        };
        self.plan.model().nodes().iter().map(of).sum()
    }

    /// Useful floating-point operations of one run in the convolutions that the kernel does: two per multiply-add of
    /// the plain sum, whatever algorithm does it.
    pub fn flop(&self) -> f64 {
        let of = |node: &TypedNode| {
            let products = match (node.op_as::<op::DirectConv>(), node.op_as::<Chain>()) {
                (Some(op), _) => op.channels[0] * op.channels[1] * op.kernel.taps(),
                (_, Some(chain)) => chain.products,
                _ => return None,
            };
            let plane: usize = node.outputs[0].fact.shape.as_concrete()?.iter().skip(2).product();
            Some(2.0 * plane as f64 * products as f64)
        };
        self.plan.model().nodes().iter().filter_map(of).sum()
    }

    /// The net, if it is nothing but one chain of convolutions over views: it takes pictures of any size, row by row.
    pub fn volume_chain(&self) -> Option<&VolumeChain> {
        let nodes = self.plan.model().nodes();
        let [source, chain] = nodes else { return None };
        let chain = chain.op_as::<Chain>().filter(|_| source.outputs.len() == 1)?;
        match &*chain.convolutions {
            Convolutions::Volume(chain) => Some(chain),
            Convolutions::Plane(_) => None,
        }
    }

    /// Runs the net on `input` (row-major values of [`input_shape`](Self::input_shape)); answers the first output.
    ///
    /// `cancel` is looked at before each operation, and between blocks of rows of the kernel's.
    ///
    /// # Errors
    /// [`EngineError::Cancelled`]; [`EngineError::Run`] where the input does not have the length of the shape.
    pub fn run(&self, input: &[f32], cancel: &Cancel) -> Result<Output, EngineError> {
        Ok(self.run_all(input, cancel)?.swap_remove(0))
    }

    /// The same with all outputs that the file's wiring names, in that order.
    ///
    /// # Errors
    /// Those of [`run`](Self::run).
    pub fn run_all(&self, input: &[f32], cancel: &Cancel) -> Result<Vec<Output>, EngineError> {
        let stop = || if cancel.is_cancelled() { Err(EngineError::Cancelled) } else { Ok(()) };
        stop()?;
        let input = Tensor::from_shape(&self.input_shape, input).map_err(EngineError::run)?;
        let eval = |context: &EvalContext, state: Option<&mut (dyn OpState + 'static)>, node: &TypedNode, inputs| {
            cancel.check()?;
            plan::eval(context, state, node, inputs)
        };
        let run = || -> TractResult<_> { self.plan.spawn()?.run_plan_with_eval(tvec!(input.into_tvalue()), eval) };
        let broken = || Err(format_err!("its graph is damaged"));
        let caught = || op::with_cancel(cancel, || panics::caught(run).unwrap_or_else(broken));
        let outputs = threads::pool(self.threads)?.install(caught);
        stop()?;
        outputs.and_then(|outputs| outputs.into_iter().map(Output::of).collect()).map_err(EngineError::run)
    }
}

#[cfg(test)]
mod tests;
