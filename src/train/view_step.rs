//! Training of what the paper compares itself with: nets that give views without ray depths.
//!
//! *Appearance flow* (Zhou et al. 2016): the depth net with two maps a view, where in the photo each ray's colour lies.
//! *Direct regression*: the same layers say what is to be added to the photo's colours, so it begins near the photo copied.
//! Both learn by ‖L̂ − L‖₁ alone.

use crate::TrainError;
use crate::batch::Batch;
use crate::checkpoint::Checkpoint;
use crate::config::Config;
use crate::loss;
use crate::nets::{Mode, Tape, Task, values, zeros};
use crate::step::{Parts, Report, learn, path, predict, update};

/// A step of such a net; `done` = 0 … 1 of the run behind it.
pub fn step(net: &mut Checkpoint, batch: &Batch, config: &Config, done: f64) -> Result<Report, TrainError> {
    let graph = net.arch.graph();
    let weight = config.losses.w_photometric;
    let task = net.arch.task();
    let losses = |said: &[f32]| {
        let mut gradient = zeros(said.len());
        let loss = match task {
            Task::Flow => loss::flowed(&batch.maps, &batch.photos(), &batch.views, said, weight, &mut gradient),
            _ => loss::regressed(&batch.maps, &batch.photos(), &batch.views, said, weight, &mut gradient),
        };
        (Parts::from([("views", loss)]), gradient)
    };
    let input = batch.net_input(graph.arch.has_coordinates());
    // Channels are left out of depth nets alone.
    let plain = Config { drop: 0.0, ..config.clone() };
    let (parts, gradients, statistics) = learn((net, &graph), batch, input, &plain, losses)?;
    let norm = update(net, config, done, &gradients, &statistics);
    Ok(Report { parts, norm })
}

/// The views `[n, v, 3, h, w]` in 0 … 1 that such a net makes of a batch's photos.
pub fn infer(net: &Checkpoint, batch: &Batch, config: &Config) -> Result<Vec<f32>, TrainError> {
    let mut tape = Tape::new(net.best(), Mode::Infer, path(config))?;
    let said = predict(&mut tape, &net.arch.graph(), batch).map(values)?;
    let made = if net.arch.task() == Task::Flow { loss::flowed_views } else { loss::regressed_views };
    Ok(made(&batch.maps, &batch.photos(), &said))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::tests::toy;
    use crate::nets::Arch;

    #[test]
    fn both_comparisons_learn_a_batch_by_heart() {
        let batch = toy(1, (16, 12))(0).unwrap();
        // What is added to the photo begins small, and large steps throw it far off.
        for (arch, lr) in [(Arch::AppearanceFlow, 4e-3), (Arch::DirectRegression, 1e-3)] {
            let config = Config { lr, warm_up: 1, lr_end: 1.0, clip: 0.0, ..Config::default() };
            let mut net = Checkpoint::new(arch, 1);
            let mut losses = Vec::new();
            for _ in 0..30 {
                losses.push(step(&mut net, &batch, &config, 0.0).unwrap().parts["views"]);
                net.progress.step += 1;
            }
            assert!(losses[29] < 0.9 * losses[0], "{arch:?}: {losses:?}");
            let made = infer(&net, &batch, &config).unwrap();
            assert_eq!(made.len(), batch.views.len());
            assert!(made.iter().all(|c| (0.0..=1.0).contains(c)));
        }
    }
}
