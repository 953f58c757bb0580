//! Whether what a net computes fits in memory, asked before it is run: a small file can ask for any amount.

use tract_onnx::prelude::*;
use tract_onnx::tract_core::ops::konst::Const;

use super::EngineError;
use crate::synth::memory;

/// No net of depth that people use has values of so many bytes at one time.
const MOST_BYTES: u64 = 8 << 30;

/// Refuses a net whose values need more memory at one time than is free, or than any net should.
pub(super) fn check(model: &TypedModel) -> Result<(), EngineError> {
    let need_bytes = peak_bytes(model).map_err(EngineError::run)?;
    let most_bytes = memory::free_bytes().map_or(MOST_BYTES, |free| free.min(MOST_BYTES));
    if need_bytes <= most_bytes { Ok(()) } else { Err(EngineError::Room { need_bytes, most_bytes }) }
}

/// Bytes of all values that are there at one time, at most; the weights are there already.
fn peak_bytes(model: &TypedModel) -> TractResult<u64> {
    let order = model.eval_order()?;
    let mut last_step = vec![0; model.nodes().len()];
    for (step, node) in order.iter().enumerate() {
        last_step[*node] = step;
        model.node(*node).inputs.iter().for_each(|input| last_step[input.node] = step);
    }
    model.output_outlets()?.iter().for_each(|output| last_step[output.node] = order.len());
    let (mut there, mut peak, mut done) = (0_u64, 0, vec![Vec::new(); order.len() + 1]);
    for (step, node) in order.iter().enumerate() {
        there = there.saturating_add(bytes(model.node(*node)));
        peak = peak.max(there);
        done[last_step[*node]].push(*node);
        for node in std::mem::take(&mut done[step]) {
            there = there.saturating_sub(bytes(model.node(node)));
        }
    }
    Ok(peak)
}

/// Bytes of a node's values; none of a weight.
fn bytes(node: &TypedNode) -> u64 {
    let of = |fact: &TypedFact| {
        let values = fact.shape.as_concrete().into_iter().flatten().map(|n| *n as u64);
        values.fold(fact.datum_type.size_of() as u64, u64::saturating_mul)
    };
    if node.op_is::<Const>() {
        return 0;
    }
    node.outputs.iter().fold(0, |sum, output| sum.saturating_add(of(&output.fact)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::tract::graph_tests::{DataType, Graph, PICTURE, int};
    use crate::synth::tract::{Options, prepare};

    /// Doubles a picture's rows so often.
    fn doubled(times: usize) -> Vec<u8> {
        let names: Vec<String> = (0..=times).map(|n| format!("x{n}")).collect();
        let graph = Graph::new(13).input("x0", DataType::Float, &PICTURE);
        let double = |graph: Graph, pair: &[String]| {
            graph.node("Concat", &[&pair[0], &pair[0]], &[&pair[1]], vec![int("axis", 2)])
        };
        names.windows(2).fold(graph, double).output(&names[times]).bytes()
    }

    #[test]
    fn a_net_that_asks_for_more_than_there_is_is_refused_before_it_runs() {
        let options = Options { threads: 1, ..Options::default() };
        assert!(prepare(&doubled(3), &[1, 3, 4, 5], &options).is_ok());
        let said = prepare(&doubled(45), &[1, 3, 4, 5], &options).unwrap_err();
        assert!(matches!(said, EngineError::Room { need_bytes, .. } if need_bytes > 1 << 50), "{said}");
    }

    #[test]
    fn what_is_used_no_more_makes_room() {
        let net = prepare(&doubled(3), &[1, 3, 4, 5], &Options { threads: 1, ..Options::default() }).unwrap();
        let picture = 3 * 4 * 5 * 4;
        // The last two: four and eight pictures.
        assert_eq!(peak_bytes(net.plan.model()).unwrap(), (4 + 8) * picture);
    }
}
