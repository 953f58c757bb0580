//! `batch`: many photos through one recipe.

use anyhow::{Result, bail};
use plenoscope::job::Job;
use plenoscope::scene::Recipe;
use plenoscope::scene::batch::{self, Order, Summary};

use super::input;
use crate::cli::Batch;
use crate::output::{one_line, say};

/// Memory that the photos worked on together may take.
const MEMORY_BYTES: u64 = 2 << 30;

/// Runs all of them, then says how it went.
pub fn run(args: &Batch, job: &Job) -> Result<()> {
    let mut recipe = Recipe::read(&args.recipe)?;
    if let Some(name) = &args.name {
        recipe.export.name.clone_from(name);
    }
    let own_map = input::own_map(&args.synth)?;
    let (out, making) = (args.output.clone(), input::making(&args.synth));
    let order = Order { recipe, out, memory_bytes: MEMORY_BYTES, force: args.force, making, own_map };
    report(&batch::run(&args.inputs, &order, &input::maker(&args.synth), job)?, args.inputs.len(), job)
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
