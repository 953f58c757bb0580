//! `plenoscope-train paper`: the paper's methods trained, judged and reported with one command.
//!
//! Each [`Method`] is a run of its own in `OUT/methods`, and goes on where it was stopped. `judge` asks each for the views of
//! light fields that none has seen; `findings` sets them beside what the paper found; `report` writes it down.

mod charts;
mod fields;
mod findings;
mod judge;
mod method;
mod panels;
mod report;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::{Result, bail, ensure};
use clap::{ArgMatches, Args, Command, FromArgMatches as _};

use crate::config::{Config, LR_END, parse_part};
use crate::device::Place;
use crate::field::TrueField;
use crate::recorded;
use crate::run::Nets;
use crate::scenes::raster::Raster;
use findings::Found;
use judge::{Judged, Shown};
pub use method::Method;
use report::{Summary, Times};

/// Width and height of the light field whose time is taken, as the paper's.
const TIMED_PX: [usize; 2] = [270, 187];

/// What is asked for.
#[derive(Clone, Debug, Args)]
pub struct Asked {
    /// Folder of light fields: Lytro ESLF pictures (*_eslf.png), folders of views, and what else the program opens
    #[arg(long, value_name = "DIR")]
    pub data: PathBuf,
    /// Folder for the report and for the methods' runs, which go on where they were stopped
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Steps of each method (the paper: 120,000)
    #[arg(long, value_name = "N", default_value_t = 120_000)]
    pub steps: u64,
    /// Train these alone; the report has whatever is trained
    #[arg(long, value_enum, value_name = "METHOD", value_delimiter = ',')]
    pub only: Vec<Method>,
    /// Seed of nets, crops and split
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Samples of a step
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(1..=64))]
    pub batch: usize,
    /// Side of a crop in px, after it was halved
    #[arg(long, value_name = "PX", default_value_t = 96, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(8..=512))]
    pub crop: usize,
    /// Last learning rate, relative to the first (the paper: 1, constant, which few steps do not bear)
    #[arg(long, value_name = "PART", default_value_t = LR_END, value_parser = parse_part)]
    pub lr_end: f32,
    /// Long side of the views that methods are judged by
    #[arg(long, value_name = "PX", default_value_t = 270, value_parser = clap::builder::RangedU64ValueParser::<usize>::new().range(16..=4096))]
    pub long_side: usize,
    /// Light fields to judge by, at most
    #[arg(long, value_name = "N", default_value_t = 100)]
    pub most: usize,
    /// Names of files to train on, one a line
    #[arg(long, value_name = "FILE", requires = "test_list")]
    pub train_list: Option<PathBuf>,
    /// Names of files to judge by, one a line
    #[arg(long, value_name = "FILE", requires = "train_list")]
    pub test_list: Option<PathBuf>,
    /// Threads of the trainer; 0 means all
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// What computes
    #[arg(long, value_enum, default_value_t)]
    pub device: Place,
}

impl Asked {
    /// What was typed.
    ///
    /// # Errors
    /// What clap says.
    pub fn from_matches(matches: &ArgMatches) -> Result<Self> {
        Ok(Self::from_arg_matches(matches)?)
    }
}

/// What the command line understands.
pub fn command() -> Command {
    Asked::augment_args(
        Command::new("paper")
            .about("Train the paper's methods, judge them on held-out light fields, and write a report"),
    )
}

/// Trains what is not trained yet, judges, and writes the report; gives its path. `told` hears what goes on.
///
/// # Errors
/// Light fields that cannot be used, runs of other options, a disk that cannot be written. What was trained stays.
pub fn run(asked: &Asked, stop: &AtomicBool, told: &(dyn Fn(&str) + Sync)) -> Result<PathBuf> {
    let lists = [asked.train_list.as_deref(), asked.test_list.as_deref()];
    let split = fields::split(&asked.data, lists, asked.seed)?;
    told(&format!("light fields parted {}", split.how));
    let nets = nets(asked, &split.train, stop, told)?;
    let (mut judged, mut shown) = (Vec::new(), None);
    for path in split.test.iter().take(asked.most) {
        stopped(stop)?;
        match TrueField::open(path) {
            Ok(field) => {
                told(&format!("judging by {}", field.name));
                let field = judge::shrunk(field, asked.long_side);
                let (figures, made) = judge::judge(field, &nets, &Method::Ours.config(asked))?;
                judged.push(figures);
                shown.get_or_insert(made);
            }
            Err(error) => told(&format!("passed over: {error}")),
        }
    }
    ensure!(!judged.is_empty(), "none of the light fields to judge by can be read: {}", asked.data.display());
    told("writing the report");
    written(asked, &split.how, &nets, &judged, shown.as_ref())
}

fn stopped(stop: &AtomicBool) -> Result<()> {
    if stop.load(Ordering::Relaxed) {
        bail!("stopped; what was trained stays, and the same command goes on with it");
    }
    Ok(())
}

/// The nets of all methods that are trained, after those that are asked for were.
fn nets(
    asked: &Asked,
    files: &[PathBuf],
    stop: &AtomicBool,
    told: &(dyn Fn(&str) + Sync),
) -> Result<BTreeMap<Method, Nets>> {
    let mut nets = BTreeMap::new();
    for method in Method::ALL {
        let wanted = asked.only.is_empty() || asked.only.contains(&method);
        if wanted {
            told(&format!("{}: to {} steps", method.title(), asked.steps));
            nets.insert(method, method.trained(asked, files.to_vec(), stop, recorded::told())?);
            stopped(stop)?;
        } else if method.is_begun(asked) {
            nets.insert(method, method.begun(asked, &method.config(asked))?);
        }
    }
    Ok(nets)
}

fn written(
    asked: &Asked,
    split: &str,
    nets: &BTreeMap<Method, Nets>,
    judged: &[Judged],
    shown: Option<&Shown>,
) -> Result<PathBuf> {
    let found = Found::of(judged);
    let steps = |(method, nets): (&Method, &Nets)| {
        let stage = method.config(asked).stage;
        (method.name(), nets.main(stage).map_or(0, |net| net.progress.step))
    };
    let summary = Summary {
        split,
        light_fields: judged.iter().map(|one| one.name.as_str()).collect(),
        seed: asked.seed,
        steps: nets.iter().map(steps).collect(),
        batch: asked.batch,
        crop: asked.crop,
        lr_end: asked.lr_end,
        long_side: asked.long_side,
        found: &found,
        each: judged.iter().map(|one| &one.figures).collect(),
    };
    let panels = shown.map(panels::all).unwrap_or_default();
    let synthesis_secs = nets.get(&Method::Ours).map(|ours| timed(ours, &Method::Ours.config(asked))).transpose()?;
    report::write(&asked.out, &summary, &panels, &Times { synthesis_secs, threads: rayon::current_num_threads() })
}

/// Seconds for a light field of the paper's size.
fn timed(nets: &Nets, config: &Config) -> Result<f64> {
    let texel = |x: usize, y: usize| [x as f32 / TIMED_PX[0] as f32, y as f32 / TIMED_PX[1] as f32, 0.5];
    let photo = Raster::from_fn(TIMED_PX, texel);
    let started = Instant::now();
    judge::synthesized(nets, &photo, config)?;
    Ok(started.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests;
