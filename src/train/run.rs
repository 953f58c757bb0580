//! A run of the trainer: loop, schedule, metrics, checkpoints, stopping.

use std::any::Any;
use std::fs::OpenOptions;
use std::io::{IsTerminal as _, Write as _};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

use crate::TrainError;
use crate::batch::{Batch, Draw, Loader};
use crate::checkpoint::{Checkpoint, Moments};
use crate::config::{Config, Stage};
use crate::contact;
use crate::corners;
use crate::curves;
use crate::device::Place;
use crate::eval::sheet;
use crate::files;
use crate::nets::{Arch, Graph, Task};
use crate::settle::settle;
use crate::step::{self, Report};
use crate::view_step;
use crate::watch::Watch;

/// File of a run's config, in its folder.
pub const CONFIG_FILE: &str = "config.json";
/// File of a run's depth net.
pub const DEPTH_FILE: &str = "depth.safetensors";
/// File of a net that gives views without ray depths.
pub const VIEWS_FILE: &str = "views.safetensors";
/// File of a net of ray depths between four corners.
pub const CORNER_DEPTH_FILE: &str = "corner-disparity.safetensors";
/// File of the net that corrects the corners' colours.
pub const CORNER_COLOUR_FILE: &str = "corner-colour.safetensors";
/// File of a run's occlusion net.
pub const OCCLUSION_FILE: &str = "occlusion.safetensors";
/// File of a run's metrics, one JSON object a line.
pub const METRICS_FILE: &str = "metrics.jsonl";
/// Its curves.
pub const CURVES_FILE: &str = "curves.svg";
/// Its contact sheet.
pub const SHEET_FILE: &str = "sheet.png";
/// Width of a picture on it.
const TILE_PX: usize = 160;

/// The nets of a run.
#[derive(Clone)]
pub struct Nets {
    /// The net that comes first: of ray depths, or of what the paper compares them with.
    first: Option<Checkpoint>,
    /// The net that corrects what is rendered with it.
    second: Option<Checkpoint>,
}

impl Nets {
    /// Fresh nets, or those that `--init` and `--depth-from` name.
    pub fn start(config: &Config) -> Result<Self, TrainError> {
        let open = |path: &Option<PathBuf>, arch: Arch| match path {
            Some(path) => load(path, arch.task()).map(|from| from.begin(arch, config.seed)),
            None => Ok(Checkpoint::new(arch, config.seed)),
        };
        match config.stage {
            Stage::Depth | Stage::Flow | Stage::Regression => {
                let mut net = open(&config.init, config.main_net())?;
                if config.tie {
                    net.weights.tie_views();
                }
                if let Some(path) = &config.encoder {
                    net.take_encoder(path)?;
                }
                Ok(Self { first: Some(net), second: None })
            }
            Stage::Occlusion => {
                let depth = config.depth_from.as_ref().map(|path| load(path, Task::Depth)).transpose()?;
                Ok(Self { first: depth, second: Some(open(&config.init, Arch::Occlusion)?) })
            }
            Stage::Joint => Ok(Self {
                first: Some(open(&config.depth_from, config.net)?),
                second: Some(open(&config.init, Arch::Occlusion)?),
            }),
            Stage::Corners => Ok(Self {
                first: Some(open(&config.init, config.main_net())?),
                second: Some(Checkpoint::new(Arch::CornerColour, config.seed)),
            }),
        }
    }

    /// The nets of a run's folder, to go on with.
    pub fn resume(config: &Config, folder: &Path) -> Result<Self, TrainError> {
        let first = || load(&folder.join(first_file(config.stage)), config.main_net().task());
        let second = |task: Task| load(&folder.join(second_file(config.stage)), task);
        match config.stage {
            Stage::Depth | Stage::Flow | Stage::Regression => Ok(Self { first: Some(first()?), second: None }),
            Stage::Occlusion => {
                let depth = config.depth_from.as_ref().map(|path| load(path, Task::Depth)).transpose()?;
                Ok(Self { first: depth, second: Some(second(Task::Occlusion)?) })
            }
            Stage::Joint => Ok(Self { first: Some(first()?), second: Some(second(Task::Occlusion)?) }),
            Stage::Corners => Ok(Self { first: Some(first()?), second: Some(second(Task::CornerColour)?) }),
        }
    }

    /// The net that comes first, and the one that corrects what is rendered with it, as far as the run has them.
    pub fn pair(&self) -> [Option<&Checkpoint>; 2] {
        [self.first.as_ref(), self.second.as_ref()]
    }

    /// The net whose progress is the run's.
    pub fn main(&self, stage: Stage) -> Option<&Checkpoint> {
        if stage == Stage::Occlusion { self.second.as_ref() } else { self.first.as_ref() }
    }

    fn trained(&mut self, stage: Stage) -> impl Iterator<Item = &mut Checkpoint> {
        let first = if stage == Stage::Occlusion { None } else { self.first.as_mut() };
        first.into_iter().chain(self.second.as_mut())
    }

    fn save(&self, config: &Config) -> Result<(), TrainError> {
        if let (Some(net), true) = (&self.first, config.stage != Stage::Occlusion) {
            net.save(&config.out.join(first_file(config.stage)), Moments::Exact)?;
        }
        if let Some(net) = &self.second {
            net.save(&config.out.join(second_file(config.stage)), Moments::Exact)?;
        }
        Ok(())
    }

    /// Writes what the nets make of a batch beside the checkpoint.
    fn draw(&self, batch: &Batch, config: &Config) -> Result<(), TrainError> {
        let rows = match (config.stage, &self.first, &self.second) {
            (Stage::Occlusion, depth, Some(net)) => {
                contact::occlusion_rows(net, batch, &depths(depth.as_ref(), batch, config)?, config)?
            }
            (Stage::Flow | Stage::Regression, Some(net), _) => {
                contact::view_rows(batch, &view_step::infer(net, batch, config)?)
            }
            (Stage::Corners, Some(first), Some(second)) => {
                contact::view_rows(batch, &corners::infer([first, second], batch, config)?.0)
            }
            (_, Some(net), _) => contact::depth_rows(net, batch, config)?,
            _ => return Ok(()),
        };
        let path = config.out.join(SHEET_FILE);
        sheet::write_png(&path, &sheet::join(&rows, TILE_PX)).map_err(|e| TrainError::Data { why: e.to_string() })
    }

    /// The weights of the nets that another run of this stage trained.
    pub(crate) fn take_weights(&mut self, other: Self, stage: Stage) {
        let Self { first, second } = other;
        let first = if stage == Stage::Occlusion { None } else { first };
        for (net, other) in self.trained(stage).zip(first.into_iter().chain(second)) {
            net.weights = other.weights;
        }
    }

    pub(crate) fn step(&mut self, batch: &Batch, config: &Config, done: f64) -> Result<Report, TrainError> {
        match (config.stage, &mut self.first, &mut self.second) {
            (Stage::Depth, Some(net), _) => step::depth_step(net, &net.arch.graph(), batch, config, done),
            (Stage::Flow | Stage::Regression, Some(net), _) => view_step::step(net, batch, config, done),
            (Stage::Corners, Some(first), Some(second)) => corners::step([first, second], batch, config, done),
            (Stage::Occlusion, depth, Some(net)) => {
                let depths = depths(depth.as_ref(), batch, config)?;
                step::occlusion_step(net, &net.arch.graph(), batch, &depths, config, done)
            }
            (Stage::Joint, Some(depth), Some(occlusion)) => {
                let graphs: [Graph; 2] = [depth.arch.graph(), occlusion.arch.graph()];
                step::joint_step([depth, occlusion], &graphs, batch, config, done)
            }
            _ => Err(TrainError::Missing { name: "net of this stage".into() }),
        }
    }
}

/// Whether a run's folder has the checkpoints to go on from.
pub fn is_saved(config: &Config) -> bool {
    let has_two = matches!(config.stage, Stage::Joint | Stage::Corners);
    let second = !has_two || config.out.join(second_file(config.stage)).exists();
    second && config.out.join(first_file(config.stage)).exists()
}

/// File of the net that comes first.
fn first_file(stage: Stage) -> &'static str {
    match stage {
        Stage::Flow | Stage::Regression => VIEWS_FILE,
        Stage::Corners => CORNER_DEPTH_FILE,
        Stage::Depth | Stage::Occlusion | Stage::Joint => DEPTH_FILE,
    }
}

/// File of the net that corrects what is rendered with it.
fn second_file(stage: Stage) -> &'static str {
    if stage == Stage::Corners { CORNER_COLOUR_FILE } else { OCCLUSION_FILE }
}

/// A checkpoint of a net that does what is wanted.
fn load(path: &Path, wanted: Task) -> Result<Checkpoint, TrainError> {
    let net = Checkpoint::load(path)?;
    if net.arch.task() == wanted {
        return Ok(net);
    }
    Err(TrainError::OtherNet { have: net.arch.name(), wanted: wanted.label(), path: path.to_owned() })
}

/// Ray depths that the occlusion net is given: a depth net's, or the true ones.
fn depths(net: Option<&Checkpoint>, batch: &Batch, config: &Config) -> Result<Vec<f32>, TrainError> {
    match net {
        Some(net) => step::infer_depths(net.best(), &net.arch.graph(), batch, config),
        None => Ok(batch.truth.clone()),
    }
}

/// Trains until the schedule ends or `stop` is set; saves either way. Returns the nets. `watch` is looked at beside every
/// checkpoint.
pub fn train(
    config: &Config,
    mut nets: Nets,
    draw: &Draw,
    mut watch: Option<Watch>,
    stop: &AtomicBool,
) -> Result<Nets, TrainError> {
    config.device.ready()?;
    let over_pictures = matches!(config.stage, Stage::Depth | Stage::Flow | Stage::Regression);
    if config.device == Place::Torch && !over_pictures {
        let why = "libtorch trains the stages depth, flow and regression alone".into();
        return Err(TrainError::NoDevice { why });
    }
    prepare(config)?;
    let mut progress = nets.main(config.stage).map(|net| net.progress.clone()).unwrap_or_default();
    let mut loader = Loader::new(draw, progress.step, config.loaders)?;
    let bar = progress_bar();
    let mut log = Log::new(&config.out.join(METRICS_FILE))?;
    let (started, before) = (Instant::now(), progress.secs);
    let (mut saved, mut learned) = (Instant::now(), false);
    loop {
        let done = config.secs.map_or(progress.step as f64 / config.steps.max(1) as f64, |secs| progress.secs / secs);
        if done >= 1.0 || stop.load(Ordering::Relaxed) {
            break;
        }
        let waiting = Instant::now();
        let batch = loader.next_batch()?;
        log.wait_secs += waiting.elapsed().as_secs_f64();
        let report = guarded(config, || nets.step(&batch, config, done))?;
        check_numbers(&report, progress.step, config, &batch)?;
        learned = true;
        progress.step += 1;
        progress.samples += batch.maps.samples as u64;
        progress.secs = before + started.elapsed().as_secs_f64();
        nets.trained(config.stage).for_each(|net| net.progress = progress.clone());
        log.add(&report);
        if progress.step.is_multiple_of(config.log_steps.max(1)) {
            let line = log.write(config, &progress, done)?;
            bar.set_position((1000.0 * done) as u64);
            bar.set_message(line);
        }
        if saved.elapsed().as_secs_f64() > config.save_secs {
            nets.save(config)?;
            nets.draw(&batch, config)?;
            curves::draw(&log.path, &config.out.join(CURVES_FILE))?;
            if let (Some(watch), Some(net)) = (&mut watch, nets.main(config.stage)) {
                let (found, warnings) = watch.look(net, config)?;
                let line = json!({"step": progress.step, "watch": found, "warnings": warnings});
                log.append(&format!("{line}\n"))?;
                // In a log, too, where there is no bar.
                warnings.iter().for_each(|warning| bar.suspend(|| eprintln!("{warning}")));
            }
            saved = Instant::now();
        }
    }
    if learned {
        settle(&mut nets, &mut loader, config, stop)?;
    }
    nets.save(config)?;
    curves::draw(&log.path, &config.out.join(CURVES_FILE))?;
    bar.finish();
    Ok(nets)
}

/// A step, whose panic is an error where a graphics device can run out of memory.
pub(crate) fn guarded(
    config: &Config,
    step: impl FnOnce() -> Result<Report, TrainError>,
) -> Result<Report, TrainError> {
    if config.device == Place::Cpu {
        return step();
    }
    let failed = |panic: Box<dyn Any + Send>| {
        let told = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        let why = told.and_then(|text| text.lines().next()).unwrap_or("it did not say why").to_owned();
        TrainError::Device { why, batch: config.batch }
    };
    catch_unwind(AssertUnwindSafe(step)).map_err(failed)?
}

/// Makes the run's folder and puts the config there.
fn prepare(config: &Config) -> Result<(), TrainError> {
    let path = config.out.join(CONFIG_FILE);
    let failed = |source| TrainError::File { action: "make the run's folder", source, path: config.out.clone() };
    std::fs::create_dir_all(&config.out).map_err(failed)?;
    files::write(&path, format!("{:#}\n", json!(config)).as_bytes(), "write the run's config")
}

fn check_numbers(report: &Report, step: u64, config: &Config, batch: &Batch) -> Result<(), TrainError> {
    if report.norm.is_finite() && report.parts.values().all(|v| v.is_finite()) {
        return Ok(());
    }
    Err(TrainError::NotANumber { step, seed: config.seed, first_sample: batch.first_sample })
}

fn progress_bar() -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{wide_bar} {percent}% {eta} left\n{msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(1000).with_style(style)
}

/// Means of the reports since the last line.
struct Log {
    path: PathBuf,
    sums: std::collections::BTreeMap<&'static str, f64>,
    norm: f64,
    count: u64,
    wait_secs: f64,
    since: Instant,
}

impl Log {
    fn new(path: &Path) -> Result<Self, TrainError> {
        let log = Self {
            path: path.to_owned(),
            sums: Default::default(),
            norm: 0.0,
            count: 0,
            wait_secs: 0.0,
            since: Instant::now(),
        };
        log.append("")?;
        Ok(log)
    }

    fn append(&self, text: &str) -> Result<(), TrainError> {
        let opened = OpenOptions::new().create(true).append(true).open(&self.path);
        let written = opened.and_then(|mut file| file.write_all(text.as_bytes()));
        written.map_err(|source| TrainError::File { action: "write the metrics", source, path: self.path.clone() })
    }

    fn add(&mut self, report: &Report) {
        for (name, value) in &report.parts {
            *self.sums.entry(name).or_default() += f64::from(*value);
        }
        self.norm += f64::from(report.norm);
        self.count += 1;
    }

    /// Writes a line of means and begins anew.
    fn write(
        &mut self,
        config: &Config,
        progress: &crate::checkpoint::Progress,
        done: f64,
    ) -> Result<String, TrainError> {
        let n = self.count.max(1) as f64;
        let round = |v: f64| (v * 1e5).round() / 1e5;
        let losses: serde_json::Map<_, _> =
            self.sums.iter().map(|(name, sum)| ((*name).to_owned(), json!(round(sum / n)))).collect();
        let line = json!({
            "step": progress.step, "samples": progress.samples, "secs": round(progress.secs), "done": round(done),
            "lr": config.learning_rate(progress.step, done), "norm": round(self.norm / n),
            "secs_per_step": round(self.since.elapsed().as_secs_f64() / n), "wait_secs": round(self.wait_secs), "losses": losses,
        });
        self.append(&format!("{line}\n"))?;
        *self = Self {
            path: self.path.clone(),
            sums: Default::default(),
            norm: 0.0,
            count: 0,
            wait_secs: 0.0,
            since: Instant::now(),
        };
        Ok(line.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::tests::toy;
    use crate::nets::Arch;

    fn config(out: &Path, steps: u64) -> Config {
        let plain =
            Config { net: Arch::Tiny, out: out.to_owned(), steps: 100, warm_up: 2, log_steps: 1, ..Config::default() };
        Config { secs: None, steps: plain.steps.min(steps), lr_end: 1.0, drop: 0.2, ..plain }
    }

    fn weights(nets: &Nets) -> &Checkpoint {
        nets.main(Stage::Depth).unwrap()
    }

    #[test]
    fn a_resumed_run_is_the_uninterrupted_one() {
        let folder = tempfile::tempdir().unwrap();
        let (stop, draw) = (AtomicBool::new(false), toy(2, (16, 8)));
        let whole = config(&folder.path().join("whole"), 6);
        let nets = train(&whole, Nets::start(&whole).unwrap(), &draw, None, &stop).unwrap();
        let half = config(&folder.path().join("half"), 3);
        train(&half, Nets::start(&half).unwrap(), &draw, None, &stop).unwrap();
        let rest = Config { steps: 6, ..half };
        let resumed = train(&rest, Nets::resume(&rest, &rest.out).unwrap(), &draw, None, &stop).unwrap();
        assert_eq!(weights(&nets).weights, weights(&resumed).weights);
        assert_eq!(weights(&nets).average, weights(&resumed).average);
        assert_eq!(weights(&nets).adam, weights(&resumed).adam);
    }

    #[test]
    fn a_checkpoint_of_the_other_net_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = |arch: Arch| folder.path().join(arch.name());
        for arch in [Arch::Tiny, Arch::Occlusion] {
            Checkpoint::new(arch, 1).save(&path(arch), Moments::Without).unwrap();
        }
        let [depth, occlusion] = [Arch::Tiny, Arch::Occlusion].map(|arch| Some(path(arch)));
        let plain = config(folder.path(), 1);
        let configs = [
            Config { init: occlusion.clone(), ..plain.clone() },
            Config { stage: Stage::Occlusion, init: depth.clone(), ..plain.clone() },
            Config { stage: Stage::Occlusion, depth_from: occlusion.clone(), ..plain.clone() },
            Config { stage: Stage::Joint, init: depth.clone(), ..plain.clone() },
            Config { stage: Stage::Joint, depth_from: occlusion.clone(), ..plain.clone() },
        ];
        for config in &configs {
            let text = Nets::start(config).err().unwrap().to_string();
            let (have, want) =
                if text.contains("net tiny") { ("tiny", "the occlusion") } else { ("occlusion", "a depth") };
            assert!(text.contains(want) && text.ends_with(have), "{text}");
        }
        assert!(Nets::start(&Config { stage: Stage::Joint, init: occlusion, depth_from: depth, ..plain }).is_ok());
    }

    #[test]
    fn one_batch_is_learned_by_heart() {
        let folder = tempfile::tempdir().unwrap();
        let toy = toy(2, (16, 8));
        let one: Draw = std::sync::Arc::new(move |_| toy(0));
        let config = Config { lr: 1e-2, ..config(folder.path(), 100) };
        let nets = train(&config, Nets::start(&config).unwrap(), &one, None, &AtomicBool::new(false)).unwrap();
        let text = std::fs::read_to_string(folder.path().join(METRICS_FILE)).unwrap();
        let lines: Vec<serde_json::Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
        let loss = |line: &serde_json::Value| line["losses"]["supervised"].as_f64().unwrap();
        assert!(loss(&lines[99]) < 0.5 * loss(&lines[0]), "{} → {}", loss(&lines[0]), loss(&lines[99]));
        assert_eq!(weights(&nets).progress.step, 100);
    }

    #[test]
    fn a_contact_sheet_lies_beside_the_checkpoint() {
        let folder = tempfile::tempdir().unwrap();
        let config = Config { save_secs: 0.0, ..config(folder.path(), 1) };
        train(&config, Nets::start(&config).unwrap(), &toy(2, (16, 8)), None, &AtomicBool::new(false)).unwrap();
        let sheet = image::open(folder.path().join(SHEET_FILE)).unwrap();
        // Two samples, five pictures each, 4 px between them; 160 px of 16×8 are 80 px high.
        assert_eq!((sheet.width(), sheet.height()), (5 * (TILE_PX as u32 + 4), 2 * (640 + 4)));
    }

    #[test]
    fn a_loss_that_is_no_number_stops_the_run_and_names_the_step() {
        let folder = tempfile::tempdir().unwrap();
        let toy = toy(2, (16, 8));
        let poisoned: Draw = std::sync::Arc::new(move |number| {
            let mut batch = toy(number)?;
            if number == 2 {
                batch.views[0] = f32::NAN;
            }
            Ok(batch)
        });
        let config = config(folder.path(), 5);
        let result = train(&config, Nets::start(&config).unwrap(), &poisoned, None, &AtomicBool::new(false));
        let text = result.err().unwrap().to_string();
        assert!(text.contains("step 2") && text.contains("samples 4"), "{text}");
    }
}
