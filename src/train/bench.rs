//! How long a step takes, and what share of the machine's measured peak that is.

use std::time::Instant;

use plenoscope::kernel::{Isa, peak};
use serde::Serialize;

use crate::TrainError;
use crate::batch::Batch;
use crate::checkpoint::Checkpoint;
use crate::config::Config;
use crate::loss::Maps;
use crate::nets::{Arch, VIEWS};
use crate::rng::Rng;
use crate::step;

/// A measured step.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// What was measured.
    pub what: String,
    /// Median seconds of a step.
    pub seconds: f64,
    /// Work of the convolutions, forward and both gradients.
    pub gflop: f64,
    /// The machine's peak on these threads, measured just now.
    pub peak_gflops: f64,
    /// gflop / seconds / peak.
    pub share_of_peak: f64,
    /// Threads.
    pub threads: usize,
}

/// Steps that are timed, after one that is not.
const STEPS: usize = 5;
/// Measurements of the peak, of which the best counts.
const PEAK_TRIES: usize = 20;

/// The paper's step (batch 4, 96² × 8 × 8, both nets, all losses, Adam) and the everyday net's.
pub fn measure(config: &Config) -> Result<Vec<Measured>, TrainError> {
    let peak = peak::gflops(Isa::best(), rayon::current_num_threads(), PEAK_TRIES);
    let losses = Config::preset(crate::config::Preset::Paper).losses;
    let paper = Config { losses, ..config.clone() };
    let batch = random_batch(4, (96, 96), (0..VIEWS).collect());
    let (mut depth, mut occlusion) = (Checkpoint::new(Arch::Paper, 1), Checkpoint::new(Arch::Occlusion, 1));
    let graphs = [Arch::Paper.graph(), Arch::Occlusion.graph()];
    let pixels = 4.0 * 96.0 * 96.0;
    let flop = 3.0 * pixels * (graphs[0].flop_per_pixel() + VIEWS as f64 * graphs[1].flop_per_pixel());
    let seconds = median(|| step::joint_step([&mut depth, &mut occlusion], &graphs, &batch, &paper, 0.5).map(|_| ()))?;
    let mut all = vec![report("joint step of the paper's nets, batch 4, 96x96x8x8", seconds, flop, peak)];

    let (width, height) = config.crop[0];
    let views: Vec<usize> = (0..config.views).map(|i| (36 + 7 * i) % VIEWS).collect();
    let batch = random_batch(config.batch, (width, height), views);
    let mut net = Checkpoint::new(config.net, 1);
    let graph = config.net.graph();
    let flop = 3.0 * (config.batch * width * height) as f64 * graph.flop_per_pixel();
    let seconds = median(|| step::depth_step(&mut net, &graph, &batch, config, 0.5).map(|_| ()))?;
    all.push(report(
        &format!("step of the {} net, batch {}, {width}x{height}", config.net.name(), config.batch),
        seconds,
        flop,
        peak,
    ));
    Ok(all)
}

fn report(what: &str, seconds: f64, flop: f64, peak: f64) -> Measured {
    let gflop = flop / 1e9;
    let share_of_peak = gflop / seconds / peak;
    Measured {
        what: what.to_owned(),
        seconds,
        gflop,
        peak_gflops: peak,
        share_of_peak,
        threads: rayon::current_num_threads(),
    }
}

fn median(mut run: impl FnMut() -> Result<(), TrainError>) -> Result<f64, TrainError> {
    run()?;
    let mut times = Vec::new();
    for _ in 0..STEPS {
        let start = Instant::now();
        run()?;
        times.push(start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[STEPS / 2])
}

fn random_batch(samples: usize, (width, height): (usize, usize), views: Vec<usize>) -> Batch {
    let maps = Maps { samples, views, height, width };
    let mut rng = Rng::new(3, 0);
    let views = (0..3 * maps.len()).map(|_| rng.unit()).collect();
    let truth = (0..maps.len()).map(|_| rng.range(-0.5, 0.5)).collect();
    let (yx, worth) = (vec![[-1.0, 1.0, -1.0, 1.0]; samples], vec![1.0; samples]);
    Batch { first_sample: 0, views, truth, yx, worth, subjects: vec![Vec::new(); samples], maps }
}
