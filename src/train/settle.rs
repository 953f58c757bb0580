//! Statistics of batch normalisation for the weights that a run ends with.
//!
//! Running statistics lag 1 / `momentum` steps behind weights that still learn fast: what is judged then is a net that
//! no step has seen. Runs that average their weights average these with them; the others take them anew.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::TrainError;
use crate::batch::Loader;
use crate::config::Config;
use crate::run::{Nets, guarded};

/// Batches that the statistics are taken from.
const BATCHES: u16 = 24;

/// Takes the running statistics of the nets anew, as the mean over the batches that come next; the rest of the weights
/// stay. A run that is stopped here keeps those that it had.
///
/// # Errors
/// What a step says.
pub fn settle(nets: &mut Nets, loader: &mut Loader, config: &Config, stop: &AtomicBool) -> Result<(), TrainError> {
    if config.average > 0.0 || config.keep_norm {
        return Ok(());
    }
    let mut trial = nets.clone();
    for batch in 0..BATCHES {
        if stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        // A step that learns nothing; each batch moves the mean by its share.
        let momentum = 1.0 / (f32::from(batch) + 1.0);
        let still = Config { lr: 0.0, momentum, drop: 0.0, blank: 0.0, drop_yx: 0.0, ..config.clone() };
        let batch = loader.next_batch()?;
        guarded(config, || trial.step(&batch, &still, 1.0))?;
    }
    nets.take_weights(trial, config.stage);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::tests::toy;
    use crate::config::Stage;
    use crate::nets::{Arch, Weights};

    fn settled(config: &Config, stop: bool) -> [Weights; 2] {
        let mut nets = Nets::start(config).unwrap();
        let weights = |nets: &Nets| nets.main(Stage::Depth).unwrap().weights.clone();
        let before = weights(&nets);
        let mut loader = Loader::new(&toy(2, (16, 8)), 0, 1).unwrap();
        settle(&mut nets, &mut loader, config, &AtomicBool::new(stop)).unwrap();
        [before, weights(&nets)]
    }

    #[test]
    fn statistics_are_the_mean_of_the_batches_and_nothing_else_changes() {
        let config = Config { net: Arch::Tiny, average: 0.0, ..Config::default() };
        let [before, after] = settled(&config, false);
        let changed: Vec<_> = before.tensors.iter().zip(&after.tensors).filter(|(a, b)| a != b).collect();
        assert!(!changed.is_empty() && changed.iter().all(|(_, now)| !now.trained));
        // The first layer's inputs do not depend on other statistics: its mean is that of all batches together.
        let mut expected = Nets::start(&config).unwrap();
        let mut sum: Vec<f32> = Vec::new();
        let mut loader = Loader::new(&toy(2, (16, 8)), 0, 1).unwrap();
        let first = |weights: &Weights| weights.tensors.iter().find(|t| t.name.ends_with(".mean")).unwrap().clone();
        for _ in 0..BATCHES {
            let alone = Config { lr: 0.0, momentum: 1.0, ..config.clone() };
            expected.step(&loader.next_batch().unwrap(), &alone, 1.0).unwrap();
            let mean = first(&expected.main(Stage::Depth).unwrap().weights).values;
            sum.resize(mean.len(), 0.0);
            sum.iter_mut().zip(&mean).for_each(|(s, m)| *s += m / f32::from(BATCHES));
        }
        for (taken, expected) in first(&after).values.iter().zip(&sum) {
            assert!((taken - expected).abs() < 1e-5, "{taken} for {expected}");
        }
    }

    #[test]
    fn a_run_that_averages_or_is_stopped_keeps_its_own() {
        let plain = Config { net: Arch::Tiny, average: 0.0, ..Config::default() };
        let averages = Config { average: 0.9, ..plain.clone() };
        for (config, stop) in [(&plain, true), (&averages, false)] {
            let [before, after] = settled(config, stop);
            assert_eq!(before, after);
        }
    }
}
