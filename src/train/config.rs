//! What a run is: one struct that is flags, file beside the weights, and presets.

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use clap::{ArgMatches, Args, FromArgMatches as _, ValueEnum, parser::ValueSource};
use serde::{Deserialize, Serialize};

use crate::device::Place;
use crate::nets::Arch;
use crate::scenes::{MEASURED, ROOMS};

/// Last learning rate, relative to the first, unless another is asked for.
pub const LR_END: f32 = 0.02;

/// An encoder's learning rate, relative to that of the net beside it: it knows more than a few thousand photos can teach.
const ENCODER_LR: f32 = 0.1;

/// What is trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// The depth net: supervised where the truth is known, and photometric.
    Depth,
    /// The occlusion net, on views rendered with the true ray depths (or with `--depth-from`'s).
    Occlusion,
    /// Both, as the paper does.
    Joint,
    /// Appearance flow: where in the photo each ray's colour lies, without depth (a comparison of the paper's).
    Flow,
    /// Direct regression: the 64 views themselves (a comparison of the paper's).
    Regression,
    /// Views from the four corners: a disparity net, then a colour net (a comparison of the paper's).
    Corners,
}

/// Starting points. Flags given beside a preset win over it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// The everyday depth net on composed scenes and lifted photos.
    Everyday,
    /// The paper's training on a folder of Lytro ESLF files.
    Paper,
    /// The occlusion net on composed scenes.
    Occlusion,
    /// Both nets together, fine-tuning.
    Joint,
}

/// How much each loss weighs; 0 leaves it out.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
pub struct LossWeights {
    /// |D − D*| where the truth is known
    #[arg(long, default_value_t = 0.5, help_heading = "Losses")]
    pub w_supervised: f32,
    /// ‖L_r − L‖₁ (and ‖L̂ − L‖₁ in the stages that have it)
    #[arg(long, default_value_t = 1.0, help_heading = "Losses")]
    pub w_photometric: f32,
    /// Affine-invariant |s·D + t − D*|: what a photo can tell; it cannot tell the scale of its nearness map
    #[arg(long, default_value_t = 0.8, help_heading = "Losses")]
    pub w_affine: f32,
    /// Gradients of the affine residual, relative to --w-affine
    #[arg(long, default_value_t = 0.4, help_heading = "Losses")]
    pub w_edges: f32,
    /// Residual after each row's mean is taken out
    #[arg(long, default_value_t = 0.5, help_heading = "Losses")]
    pub w_row: f32,
    /// Order of pairs within a row
    #[arg(long, default_value_t = 0.5, help_heading = "Losses")]
    pub w_ordinal: f32,
    /// Order of pairs within a column
    #[arg(long, default_value_t = 0.5, help_heading = "Losses")]
    #[serde(default)]
    pub w_columns: f32,
    /// Order across the edge of a masked subject, whatever its map says
    #[arg(long, default_value_t = 0.3, help_heading = "Losses")]
    #[serde(default)]
    pub w_subject: f32,
    /// Pixels of parts at most 3 px wide that stand before both their sides, beside what every pixel weighs
    #[arg(long, default_value_t = 0.0, help_heading = "Losses")]
    #[serde(default)]
    pub w_thin: f32,
    /// Pixels that stand out of both their sides and in truth do not, as print does, beside what every pixel weighs
    #[arg(long, default_value_t = 0.0, help_heading = "Losses")]
    #[serde(default)]
    pub w_print: f32,
    /// Least step of the true ray depths that makes such a pair, px per view step
    #[arg(long, default_value_t = 0.12, help_heading = "Losses")]
    pub ordinal_apart_px: f32,
    /// Depth consistency ψ_c (the paper: 0.005)
    #[arg(long, default_value_t = 0.02, help_heading = "Losses")]
    pub w_consistency: f32,
    /// Total variation ψ_tv (the paper: 0.01)
    #[arg(long, default_value_t = 0.005, help_heading = "Losses")]
    pub w_tv: f32,
    /// Rays whose point the photo does not see, in ‖L̂ − L‖₁, against those that it sees (the paper: 1)
    #[arg(long, default_value_t = 1.0, help_heading = "Losses")]
    #[serde(default = "one")]
    pub w_hidden: f32,
    /// Rays that leave the crop, whose end no net can know, in ‖L̂ − L‖₁ (the paper: 1)
    #[arg(long, default_value_t = 1.0, help_heading = "Losses")]
    #[serde(default = "one")]
    pub w_outside: f32,
}

fn one() -> f32 {
    1.0
}

/// What runs had before it could be said.
fn measured() -> f32 {
    MEASURED
}

fn rooms() -> f32 {
    ROOMS
}

fn encoder_lr() -> f32 {
    ENCODER_LR
}

/// A run of the trainer.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
pub struct Config {
    /// Where to start from
    #[arg(long, value_enum, default_value_t = Preset::Everyday)]
    pub preset: Preset,
    /// Folder of the training data (flowers, everyday, everyday10k, photos_depth, lightfields, meshes, textures; ESLF files for the preset `paper`)
    #[arg(long, default_value = "data")]
    pub data: PathBuf,
    /// Folder of maps that `teach` wrote, in place of those beside the photos
    #[arg(long, value_name = "DIR")]
    #[serde(default)]
    pub maps: Option<PathBuf>,
    /// Folder of the run: checkpoints, config, metrics, contact sheets
    #[arg(long, default_value = "runs/everyday")]
    pub out: PathBuf,
    /// What is trained
    #[arg(long, value_enum, default_value_t = Stage::Depth)]
    pub stage: Stage,
    /// The depth net; one that holds the net of --init begins as that, with more to learn
    #[arg(long, value_enum, default_value_t = Arch::Context)]
    pub net: Arch,
    /// Long side in px of the pictures that samples are cut from
    #[arg(long, default_value_t = 128)]
    pub long_side: usize,
    /// Crops as WIDTHxHEIGHT, drawn in turn; multiples of 16 for the everyday net
    #[arg(long, value_delimiter = ',', default_value = "128x96,96x128,112x112", value_parser = parse_size)]
    pub crop: Vec<(usize, usize)>,
    /// Samples of a step
    #[arg(long, default_value_t = 8)]
    pub batch: usize,
    /// Views of a sample, the reference view among them (64 = all)
    #[arg(long, default_value_t = 6)]
    pub views: usize,
    /// Seed of weights and data
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Steps in all
    #[arg(long, default_value_t = 20_000)]
    pub steps: u64,
    /// Seconds that the schedule spans, in place of --steps
    #[arg(long)]
    pub secs: Option<f64>,
    /// Learning rate after the warm-up
    #[arg(long, default_value_t = 2e-3)]
    pub lr: f32,
    /// Last learning rate, relative to --lr (1 = constant)
    #[arg(long, default_value_t = LR_END, value_parser = parse_part)]
    pub lr_end: f32,
    /// Steps over which the learning rate rises
    #[arg(long, default_value_t = 100)]
    pub warm_up: u64,
    /// Decoupled weight decay of convolution weights
    #[arg(long, default_value_t = 1e-4)]
    pub weight_decay: f32,
    /// Largest norm of the gradient of a step; 0 = no limit
    #[arg(long, default_value_t = 1.0)]
    pub clip: f32,
    /// Part by which the running statistics follow each batch
    #[arg(long, default_value_t = 0.02)]
    pub momentum: f32,
    /// Part of the running average of the weights that a step leaves as it is; the average is what is exported. 0 = none
    #[arg(long, default_value_t = 0.999)]
    #[serde(default)]
    pub average: f32,
    /// Part of the channels that a step leaves out at the depth net's two coarsest levels
    #[arg(long, default_value_t = 0.0)]
    #[serde(default)]
    pub drop: f32,
    /// Normalise by the running statistics, as inference does: a net must not learn that its batch tells it what is usual
    #[arg(long)]
    #[serde(default)]
    pub keep_norm: bool,
    /// How far samples vary in framing, shape and colours; 1 = as much as photos do among themselves
    #[arg(long, default_value_t = 1.0)]
    #[serde(default = "one")]
    pub variety: f32,
    /// Part of the photos of which the depth net is shown all but a few blank patches
    #[arg(long, default_value_t = 0.0)]
    #[serde(default)]
    pub blank: f32,
    /// Part of the photos of which the depth net is not told where in the picture a pixel lies
    #[arg(long, default_value_t = 0.0)]
    #[serde(default)]
    pub drop_yx: f32,
    /// Part of the lifted maps whose depth was measured
    #[arg(long, default_value_t = MEASURED)]
    #[serde(default = "measured")]
    pub measured: f32,
    /// Part of the other lifted maps that are rooms with good maps
    #[arg(long, default_value_t = ROOMS)]
    #[serde(default = "rooms")]
    pub rooms: f32,
    /// Part of the lifted maps that lie on a side or upside down
    #[arg(long, default_value_t = 0.0)]
    #[serde(default)]
    pub turned: f32,
    /// Part of the samples on which falls light that says nothing about depth: slopes, spots, bright sides, veils
    #[arg(long, default_value_t = 0.0)]
    #[serde(default)]
    pub shading: f32,
    /// Part of the scenes in three dimensions that show bare tops under uneven light, bright upper walls, portraits,
    /// wide land, clouds, flowers from near, things on ledges, bold patterns, long shadows, sunlight in patches
    #[arg(long, default_value_t = 0.0)]
    #[serde(default)]
    pub pitfalls: f32,
    /// Part of the scenes in three dimensions of which a window is shown, two or three times as large, as a fine pass sees them
    #[arg(long, default_value_t = 0.0)]
    #[serde(default)]
    pub fine: f32,
    /// Threads of the trainer; 0 means all
    #[arg(long, default_value_t = 0)]
    pub threads: usize,
    /// Threads of the data engine
    #[arg(long, default_value_t = 1)]
    pub loaders: usize,
    /// Seconds between checkpoints
    #[arg(long, default_value_t = 180.0)]
    pub save_secs: f64,
    /// Steps between lines of metrics
    #[arg(long, default_value_t = 50)]
    pub log_steps: u64,
    /// Weights to start from (a checkpoint of the same net)
    #[arg(long)]
    pub init: Option<PathBuf>,
    /// Weights of the encoder of `context-lite`, as `scripts/encoder.py` writes them, for a run that begins from a net without one
    #[arg(long, value_name = "FILE")]
    #[serde(default)]
    pub encoder: Option<PathBuf>,
    /// Learning rate of an encoder, relative to --lr
    #[arg(long, default_value_t = ENCODER_LR, value_parser = parse_part)]
    #[serde(default = "encoder_lr")]
    pub encoder_lr: f32,
    /// Start all views' maps from the reference view's
    #[arg(long)]
    pub tie: bool,
    /// For the stages `occlusion` and `joint`: the depth net's checkpoint
    #[arg(long)]
    pub depth_from: Option<PathBuf>,
    /// Shares of the kinds of samples, as the data engine names them, e.g. `lifted=0.2,pseudo=0.4,real=0.05,solid=0.35`
    #[arg(long, default_value = "")]
    pub mix: String,
    /// File with the names of the files to train on, one a line (the preset `paper`)
    #[arg(long)]
    pub list: Option<PathBuf>,
    /// What computes
    #[arg(long, value_enum, default_value_t)]
    #[serde(default)]
    pub device: Place,
    /// Burn's own operations in place of ours
    #[arg(long)]
    pub stock: bool,
    /// Multiply 16-bit numbers in 3×3 convolutions, where the processor has tiles for them (AMX): steps of wide nets take a
    /// fifth less time
    #[arg(long)]
    #[serde(default)]
    pub halves: bool,
    /// The losses' weights.
    #[command(flatten)]
    #[serde(flatten)]
    pub losses: LossWeights,
}

fn parse_size(text: &str) -> Result<(usize, usize), String> {
    let parsed = text.split_once('x').and_then(|(w, h)| Some((w.trim().parse().ok()?, h.trim().parse().ok()?)));
    parsed.ok_or_else(|| format!("{text:?} is no size: write WIDTHxHEIGHT, e.g. 128x96"))
}

/// A part of a whole.
///
/// # Errors
/// What is no number of 0 … 1.
pub fn parse_part(text: &str) -> Result<f32, String> {
    let parsed = text.trim().parse().ok().filter(|part| (0.0..=1.0).contains(part));
    parsed.ok_or_else(|| format!("{text:?} is no part: write a number from 0 to 1, e.g. 0.02"))
}

/// The struct alone as a command, to parse its defaults from nothing.
#[derive(clap::Parser)]
struct Alone {
    #[command(flatten)]
    config: Config,
}

impl Default for Config {
    fn default() -> Self {
        <Alone as clap::Parser>::parse_from(["train"]).config
    }
}

impl Config {
    /// A preset's values.
    pub fn preset(preset: Preset) -> Self {
        let everyday = Self { preset, ..Self::default() };
        match preset {
            Preset::Everyday => everyday,
            Preset::Paper => Self { net: Arch::Paper, ..everyday }.of_the_paper(),
            Preset::Occlusion => Self {
                out: "runs/occlusion".into(),
                stage: Stage::Occlusion,
                // Many samples of a step, that no batch has ray depths of its own which normalisation takes away.
                crop: vec![(40, 40)],
                views: 64,
                batch: 6,
                long_side: 384,
                // Scenes whose ray depths are known everywhere, and what is hidden with them.
                mix: "lifted=0.6,collage=0.4".into(),
                steps: 4000,
                losses: LossWeights { w_hidden: 8.0, w_outside: 0.0, ..everyday.losses },
                ..everyday
            },
            Preset::Joint => Self { out: "runs/joint".into(), lr: 2e-4, ..everyday.of_the_paper() },
        }
    }

    /// Adam 1e-3, batch 4, 96² crops of halved pictures, the paper's losses, 120,000 steps.
    fn of_the_paper(self) -> Self {
        let losses = LossWeights {
            w_supervised: 0.0,
            w_photometric: 1.0,
            w_affine: 0.0,
            w_edges: 0.0,
            w_row: 0.0,
            w_ordinal: 0.0,
            w_columns: 0.0,
            w_subject: 0.0,
            w_consistency: 0.005,
            w_tv: 0.01,
            ..self.losses
        };
        let out = if self.preset == Preset::Paper { "runs/paper".into() } else { self.out };
        let (crop, stage) = (vec![(96, 96)], Stage::Joint);
        Self {
            stage,
            crop,
            out,
            losses,
            views: 64,
            batch: 4,
            long_side: 270,
            steps: 120_000,
            lr: 1e-3,
            lr_end: 1.0,
            weight_decay: 0.0,
            clip: 0.0,
            // No average follows it: a run that is stopped is used with statistics that lag ten steps, not fifty.
            momentum: 0.1,
            average: 0.0,
            ..self
        }
    }

    /// The net whose progress is the run's.
    pub fn main_net(&self) -> Arch {
        match self.stage {
            Stage::Depth | Stage::Joint => self.net,
            Stage::Occlusion => Arch::Occlusion,
            Stage::Flow => Arch::AppearanceFlow,
            Stage::Regression => Arch::DirectRegression,
            Stage::Corners => Arch::CornerDisparity,
        }
    }

    /// The config of parsed flags: those given on the command line, the rest from `base` (a saved run) or from the preset.
    pub fn from_matches(matches: &ArgMatches, base: Option<Self>) -> Result<Self> {
        let given = Self::from_arg_matches(matches)?;
        let mut result = serde_json::to_value(base.unwrap_or_else(|| Self::preset(given.preset)))?;
        let flags = serde_json::to_value(&given)?;
        let (result_map, flags) = (result.as_object_mut().context("config")?, flags.as_object().context("config")?);
        for (key, value) in flags {
            if matches.value_source(key) == Some(ValueSource::CommandLine) {
                result_map.insert(key.clone(), value.clone());
            }
        }
        Ok(serde_json::from_value(result)?)
    }

    /// Learning rate at a step, `done` = 0 … 1 of the run behind it: a linear rise, then half a cosine.
    pub fn learning_rate(&self, step: u64, done: f64) -> f32 {
        let rise = ((step + 1) as f32 / self.warm_up.max(1) as f32).min(1.0);
        let fall = 0.5 * (1.0 + (std::f64::consts::PI * done.clamp(0.0, 1.0)).cos()) as f32;
        self.lr * rise * (self.lr_end + (1.0 - self.lr_end) * fall)
    }
}

#[cfg(test)]
mod tests {
    use clap::{Args as _, Command};

    use super::*;

    fn parse(line: &[&str], base: Option<Config>) -> Config {
        let matches = Config::augment_args(Command::new("train")).get_matches_from(line);
        Config::from_matches(&matches, base).unwrap()
    }

    #[test]
    fn flags_win_over_the_preset_and_the_saved_run() {
        let config = parse(&["train", "--preset", "paper", "--batch", "2"], None);
        assert_eq!((config.batch, config.steps, config.net), (2, 120_000, Arch::Paper));
        let saved = Config { seed: 9, lr: 0.5, ..Config::default() };
        let config = parse(&["train", "--lr", "0.25"], Some(saved));
        assert_eq!((config.seed, config.lr), (9, 0.25));
    }

    #[test]
    fn the_config_survives_its_file() {
        let config = Config::preset(Preset::Joint);
        let text = serde_json::to_string(&config).unwrap();
        assert_eq!(serde_json::from_str::<Config>(&text).unwrap(), config);
    }

    #[test]
    fn the_learning_rate_rises_then_falls() {
        let config = Config { warm_up: 10, lr: 1.0, lr_end: 0.1, ..Config::default() };
        assert!((config.learning_rate(0, 0.0) - 0.1).abs() < 1e-6);
        assert!((config.learning_rate(20, 0.0) - 1.0).abs() < 1e-6);
        assert!((config.learning_rate(20, 1.0) - 0.1).abs() < 1e-6);
    }

    #[test]
    fn a_part_is_of_nothing_to_all() {
        assert_eq!([parse_part("0"), parse_part(" 0.02 "), parse_part("1")], [Ok(0.0), Ok(0.02), Ok(1.0)]);
        for wrong in ["-0.1", "1.5", "NaN", "half"] {
            assert!(parse_part(wrong).unwrap_err().contains(wrong), "{wrong}");
        }
    }
}
