//! Reads an exported file back with tract and compares it with burn's own operations.

use tract_onnx::prelude::*;

use crate::TrainError;
use crate::checkpoint::Checkpoint;
use crate::nets::{Mode, Tape, VIEWS, values};
use crate::ops::Path;
use crate::rng::Rng;

/// Largest absolute difference between the file and the trained net on random pictures, one square, one wide.
pub fn difference(net: &Checkpoint, bytes: &[u8], side: usize) -> Result<f32, TrainError> {
    let volume = net.arch.graph().rank == 3;
    let sizes = if volume { [(12, 16), (9, 7)] } else { [(side, side), (side, side + net.arch.graph().multiple_of)] };
    let mut largest = 0.0f32;
    for (i, (height, width)) in sizes.into_iter().enumerate() {
        let mut rng = Rng::new(99, i as u64);
        let views = if volume { VIEWS } else { 1 };
        let n = net.arch.graph().input_channels() * views * height * width;
        let input: Vec<f32> = (0..n).map(|_| rng.range(-1.0, 1.0)).collect();
        let ours = trained(net, input.clone(), [height, width])?;
        let theirs = exported(bytes, &input, net, [height, width])
            .map_err(|e| TrainError::Data { why: format!("tract cannot run the exported file: {e:#}") })?;
        let worst = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        largest = if ours.len() == theirs.len() && !worst.is_nan() { largest.max(worst) } else { f32::NAN };
    }
    Ok(largest)
}

pub(super) fn trained(net: &Checkpoint, input: Vec<f32>, [height, width]: [usize; 2]) -> Result<Vec<f32>, TrainError> {
    let graph = net.arch.graph();
    let mut tape = Tape::new(net.best(), Mode::Infer, Path::Stock)?;
    if graph.rank == 3 {
        let x = tape.input(input, [1, graph.input_channels(), VIEWS, height, width]);
        return tape.run3(&graph, x).map(values);
    }
    let x = tape.input(input, [1, graph.input_channels(), height, width]);
    tape.run2(&graph, x, None).map(values)
}

fn exported(bytes: &[u8], input: &[f32], net: &Checkpoint, [height, width]: [usize; 2]) -> TractResult<Vec<f32>> {
    let graph = net.arch.graph();
    let mut shape = vec![1, graph.input_channels()];
    shape.extend((graph.rank == 3).then_some(VIEWS));
    shape.extend([height, width]);
    let model = tract_onnx::onnx().model_for_read(&mut &bytes[..])?.with_input_fact(0, f32::fact(&shape).into())?;
    let model = model.into_optimized()?.into_runnable()?;
    let result = model.run(tvec!(Tensor::from_shape(&shape, input)?.into()))?;
    Ok(result[0].to_plain_array_view::<f32>()?.iter().copied().collect())
}
