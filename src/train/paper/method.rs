//! The methods that the paper compares, each a net of [`crate::nets`] and a loss.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, ensure};
use serde::{Deserialize, Serialize};

use super::Asked;
use crate::config::{Config, LossWeights, Preset, Stage};
use crate::recorded::{self, Note};
use crate::run::{self, Nets};

/// A method that is trained.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Depth net, Lambertian rendering, occlusion net; with both regularisers
    Ours,
    /// The same without ψ_c
    NoConsistency,
    /// The same without ψ_c and ψ_tv
    NoRegularisers,
    /// Flow for each ray in place of depth (Zhou et al. 2016)
    Flow,
    /// The views straight from the photo
    Regression,
    /// The views from the four corners (Kalantari et al. 2016), which it is given
    Corners,
}

impl Method {
    /// All of them, as the report lists them.
    pub const ALL: [Self; 6] =
        [Self::Ours, Self::NoConsistency, Self::NoRegularisers, Self::Flow, Self::Regression, Self::Corners];

    /// Name of its folder, and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::NoConsistency => "no-consistency",
            Self::NoRegularisers => "no-regularisers",
            Self::Flow => "flow",
            Self::Regression => "regression",
            Self::Corners => "corners",
        }
    }

    /// What people read.
    pub fn title(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::NoConsistency => "ours without ψ_c",
            Self::NoRegularisers => "ours without ψ_c and ψ_tv",
            Self::Flow => "appearance flow",
            Self::Regression => "direct regression",
            Self::Corners => "given the four corners",
        }
    }

    /// Folder of its run.
    pub fn folder(self, out: &Path) -> PathBuf {
        out.join("methods").join(self.name())
    }

    /// The run that trains it: the paper's settings, the same seeds and steps for all.
    pub fn config(self, asked: &Asked) -> Config {
        let paper = Config::preset(Preset::Paper);
        let losses = match self {
            Self::NoConsistency => LossWeights { w_consistency: 0.0, ..paper.losses.clone() },
            Self::NoRegularisers => LossWeights { w_consistency: 0.0, w_tv: 0.0, ..paper.losses.clone() },
            Self::Ours | Self::Flow | Self::Regression | Self::Corners => paper.losses.clone(),
        };
        let stage = match self {
            Self::Flow => Stage::Flow,
            Self::Regression => Stage::Regression,
            Self::Corners => Stage::Corners,
            Self::Ours | Self::NoConsistency | Self::NoRegularisers => Stage::Joint,
        };
        Config {
            stage,
            losses,
            data: asked.data.clone(),
            out: self.folder(&asked.out),
            steps: asked.steps,
            seed: asked.seed,
            batch: asked.batch,
            crop: vec![(asked.crop, asked.crop)],
            lr_end: asked.lr_end,
            threads: asked.threads,
            device: asked.device,
            log_steps: 10,
            ..paper
        }
    }

    /// Whether a run of it lies in the report's folder.
    pub fn is_begun(self, asked: &Asked) -> bool {
        self.folder(&asked.out).join(run::CONFIG_FILE).exists()
    }

    /// The nets after so many steps as are asked for: those that lie there, trained on where that is needed.
    ///
    /// # Errors
    /// A run of other options; what the trainer says.
    pub fn trained(self, asked: &Asked, files: Vec<PathBuf>, stop: &AtomicBool, note: Note) -> Result<Nets> {
        let config = self.config(asked);
        let nets = self.begun(asked, &config)?;
        let steps = nets.main(config.stage).map_or(0, |net| net.progress.step);
        if steps >= config.steps {
            return Ok(nets);
        }
        note(&format!("{}: training from step {steps} to {}", self.title(), config.steps));
        let draw = recorded::of_files(files, &config, note)?;
        Ok(run::train(&config, nets, &draw, None, stop)?)
    }

    /// The nets of a run that lies there, else fresh ones.
    pub fn begun(self, asked: &Asked, config: &Config) -> Result<Nets> {
        if !self.is_begun(asked) {
            return Ok(Nets::start(config)?);
        }
        let path = config.out.join(run::CONFIG_FILE);
        let text = std::fs::read_to_string(&path)
            .with_context(|| format!("cannot read the run's config: {}", path.display()))?;
        let saved: Config =
            serde_json::from_str(&text).with_context(|| format!("the run's config is damaged: {}", path.display()))?;
        // How long, where, and from which folder may differ; what is learned may not.
        let alike = Config {
            steps: config.steps,
            threads: config.threads,
            device: config.device,
            data: config.data.clone(),
            out: config.out.clone(),
            ..saved
        };
        ensure!(
            alike == *config,
            "{} was trained with other options: give the same --seed, --batch, --crop and --lr-end, or another --out: {}",
            self.title(),
            config.out.display()
        );
        let is_saved = run::is_saved(config);
        Ok(if is_saved { Nets::resume(config, &config.out)? } else { Nets::start(config)? })
    }
}
