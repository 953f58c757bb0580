//! One file for each command; here is which argument goes where.

mod batch;
mod bench;
mod burst;
mod depth;
mod doctor;
mod epi;
mod export;
mod info;
mod input;
mod lens_args;
mod lenses;
mod models;
mod output;
mod pages;
mod refocus;
mod sample;
mod view;

use std::path::PathBuf;

use anyhow::Result;
use plenoscope::crash;
use plenoscope::job::Job;
use plenoscope::scene::asked::Usage;
use plenoscope::synth::adopt::Shelf;
use plenoscope::ui;

use crate::cli::{Cli, Command, Window};

/// Does what was asked for.
pub fn run(cli: Cli, job: Job) -> Result<()> {
    if cli.command.is_some() && !cli.files.is_empty() {
        let text =
            format!("a command comes first — {} stands before it — see plenoscope --help", cli.files[0].display());
        return Err(Usage(text).into());
    }
    if let Some(command) = &cli.command {
        // Its name alone: what was typed behind it may hold paths.
        let all = format!("{command:?}");
        crash::note(all.split(|letter: char| !letter.is_alphanumeric()).next().unwrap_or_default());
    }
    match cli.command {
        Some(Command::Synth(args)) => export::synth(&args, &job),
        Some(Command::Burst(args)) => burst::run(&args, &job),
        Some(Command::Refocus(args)) => refocus::run(&args, &job),
        Some(Command::View(args)) => view::run(&args, &job),
        Some(Command::Epi(args)) => epi::run(&args, &job),
        Some(Command::Depth(args)) => depth::run(&args, &job),
        Some(Command::Export(args)) => export::run(&args, &job),
        Some(Command::Batch(args)) => batch::run(&args, &job),
        Some(Command::Bench(args)) => bench::run(&args, &job),
        Some(Command::Info(args)) => info::run(&args, &job),
        Some(Command::Models(args)) => models::run(&args, &job),
        Some(Command::Lenses(args)) => lenses::run(&args, &job),
        Some(Command::Doctor(args)) => doctor::run(&args, &job),
        Some(Command::Sample(args)) => sample::run(&args, &job),
        Some(Command::Completions { shell }) => pages::completions(shell),
        Some(Command::Icons { output }) => pages::icons(&output),
        Some(Command::Man { output }) => pages::man(output.as_deref()),
        None => window(cli.files, cli.window),
    }
}

/// Opens the window and stays until it is closed.
fn window(files: Vec<PathBuf>, args: Window) -> Result<()> {
    let models = input::model_source(args.models.as_deref());
    let restores_last = files.is_empty() && !args.fresh;
    let (long_side, threads) = (args.long_side, args.threads.into());
    let (shelf, crashes) = (Shelf::user(), crash::folder());
    Ok(ui::run(ui::Options {
        files,
        models,
        shelf,
        trainer: None,
        crashes,
        language: None,
        long_side,
        threads,
        restores_last,
    })?)
}
