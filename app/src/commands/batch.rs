//! `batch`: many photos through one recipe.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use anyhow::{Result, bail};
use plenoscope::batch::{self, Settings, Summary};
use plenoscope::io::Opened;
use plenoscope::job::{Job, Sink};
use plenoscope::recipe::Recipe;
use plenoscope::render::lens;
use plenoscope::synth::Synthesizer;

use super::{input, refocus};
use crate::cli::{Batch, SynthArgs};
use crate::output::{one_line, say};

/// Memory that the photos worked on together may take.
const MEMORY_BYTES: u64 = 2 << 30;

/// Runs all of them, then says how it went.
pub fn run(args: &Batch, job: &Job) -> Result<()> {
    let mut recipe = Recipe::read(&args.recipe)?;
    if let Some(name) = &args.name {
        recipe.export.name.clone_from(name);
    }
    let settings = Settings { recipe, out: args.output.clone(), memory_bytes: MEMORY_BYTES, force: args.force };
    let nets = OnceLock::new();
    let make = |path: &Path, inner: &Job| {
        let sink = Named { path, outer: job.sink };
        let job = Job { cancel: inner.cancel, sink: &sink };
        scene(path, &args.synth, &nets, &job).map_err(Into::into)
    };
    let inputs: Vec<PathBuf> = args.inputs.clone();
    report(&batch::run(&inputs, &settings, &make, job)?, inputs.len(), job)
}

/// A photo's scene; the nets are loaded once for all photos.
fn scene(path: &Path, args: &SynthArgs, nets: &OnceLock<Synthesizer>, job: &Job) -> Result<lens::Scene> {
    let Opened::Photo(file) = input::open(path, job)? else {
        bail!("this is a light field — batch takes photos — use `plenoscope refocus`: {}", path.display());
    };
    if let Some(map) = input::disparity(args)? {
        return Ok(lens::Scene::new(file.photo, map)?);
    }
    let nets = match nets.get() {
        Some(nets) => nets,
        None => {
            let loaded = Synthesizer::load(&input::model_source(args))?;
            nets.get_or_init(|| loaded)
        }
    };
    let scene = input::with_nets(nets, &file, args, job)?;
    refocus::lens_scene(file.photo, &scene, job)
}

/// Only warnings go on, with the photo's name: how far each photo is would make the bar jump.
struct Named<'a> {
    path: &'a Path,
    outer: &'a dyn Sink,
}

impl Sink for Named<'_> {
    fn warning(&self, text: String) {
        self.outer.warning(format!("{text}: {}", self.path.display()));
    }
}

/// Says which photos failed and why; an error if any did.
fn report(summary: &Summary, all: usize, job: &Job) -> Result<()> {
    for (path, why) in &summary.failed {
        job.sink.warning(format!("{} failed: {}", path.display(), one_line(why)));
    }
    say(&format!(
        "{} made, {} there already, {} failed",
        summary.done.len(),
        summary.skipped.len(),
        summary.failed.len()
    ))?;
    if !summary.failed.is_empty() {
        bail!(
            "{} of {all} photos failed — each for the reason above — mend or leave them out, and run it again",
            summary.failed.len()
        );
    }
    Ok(job.check()?)
}
