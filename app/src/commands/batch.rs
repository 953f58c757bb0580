//! `batch`: many photos through one recipe.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Result, anyhow, bail};
use plenoscope::errors::one_line;
use plenoscope::job::Job;
use plenoscope::scene::Recipe;
use plenoscope::scene::batch::{self, Earlier, Line, Order, Summary};

use super::input;
use crate::cli::Batch;
use crate::output::{say, write_out};

/// Runs all of them, then says how it went.
pub fn run(args: &Batch, job: &Job) -> Result<()> {
    let order = order(args)?;
    let inputs = batch::all_photos(&inputs(args)?, job);
    let report = args.report.as_deref().map(|path| open_report(path, args.resume)).transpose()?;
    let tell = |line: &Line| {
        let text = format!("{}\n", serde_json::to_string(line)?);
        if args.json {
            write_out(text.as_bytes()).map_err(io::Error::other)?;
        }
        match &report {
            // One call a line, so that no reader sees half of it.
            Some(file) => file.lock().unwrap_or_else(PoisonError::into_inner).write_all(text.as_bytes()),
            None => Ok(()),
        }
    };
    let summary = batch::run(&inputs, &order, &input::maker(&args.synth), &tell, job)?;
    close(&summary, args, job)
}

fn order(args: &Batch) -> Result<Order> {
    let mut recipe = Recipe::read(&args.recipe)?;
    let how = input::how(&args.synth, None)?;
    if let Some(name) = &args.name {
        recipe.export.name.clone_from(name);
    }
    let earlier = match (args.force, args.resume) {
        (true, _) => Earlier::Replace,
        (false, true) => Earlier::Resume,
        (false, false) => Earlier::Keep,
    };
    Ok(Order {
        recipe,
        out: args.output.clone(),
        memory_bytes: u64::from(args.share.memory) << 20,
        jobs: args.share.jobs.into(),
        earlier,
        shard: args.share.shard,
        making: how.making().clone(),
        own_map: how.own_map().cloned(),
    })
}

/// The photos that were named, or those of the list.
fn inputs(args: &Batch) -> Result<Vec<PathBuf>> {
    let Some(list) = &args.files_from else { return Ok(args.inputs.clone()) };
    let failed = |error| anyhow!("the list of photos cannot be read — {error} — give a text file: {}", list.display());
    let mut text = String::new();
    if list == Path::new("-") {
        io::stdin().read_to_string(&mut text).map_err(failed)?;
    } else {
        text = std::fs::read_to_string(list).map_err(failed)?;
    }
    let photos: Vec<PathBuf> = text.lines().filter(|line| !line.trim().is_empty()).map(PathBuf::from).collect();
    if photos.is_empty() {
        bail!("there is nothing to do — the list names no photo — write one a line: {}", list.display());
    }
    Ok(photos)
}

/// A report, begun anew or gone on with.
fn open_report(path: &Path, go_on: bool) -> Result<Mutex<File>> {
    let mut options = File::options();
    options.create(true).append(go_on).write(true).truncate(!go_on);
    options
        .open(path)
        .map(Mutex::new)
        .map_err(|error| anyhow!("the report cannot be written — {error} — choose another file: {}", path.display()))
}

/// Says which photos failed and why; an error if any did.
fn close(summary: &Summary, args: &Batch, job: &Job) -> Result<()> {
    for (path, why) in &summary.failed {
        job.sink.warning(format!("{} failed: {}", path.display(), one_line(why)));
    }
    if let Some(text) = met(summary) {
        job.sink.warning(text);
    }
    let (done, skipped, failed) = (summary.done.len(), summary.skipped.len(), summary.failed.len());
    if !args.json {
        say(&format!("{done} made, {skipped} there already, {failed} failed"))?;
    }
    if failed > 0 {
        let all = done + skipped + failed;
        bail!("{failed} of {all} photos failed — each for the reason above — mend or leave them out, and run it again");
    }
    Ok(job.check()?)
}

/// What is said where another worker did the same work.
fn met(summary: &Summary) -> Option<String> {
    let n = summary.met;
    let pictures = if n == 1 { "one picture was".to_owned() } else { format!("{n} pictures were") };
    (n > 0).then(|| {
        format!("{pictures} made by another worker meanwhile — two have the same shard — give each its own K of K/N")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_workers_with_one_shard_are_told() {
        assert_eq!(met(&Summary::default()), None);
        assert!(met(&Summary { met: 1, ..Summary::default() }).is_some_and(|text| text.starts_with("one picture was")));
        assert!(met(&Summary { met: 2, ..Summary::default() }).is_some_and(|text| text.contains("same shard")));
    }
}
