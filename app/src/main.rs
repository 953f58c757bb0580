//! The program `plenoscope`: the window without a command, the command line with one.
//!
//! Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted. One line on stderr says what went wrong.

mod cli;
mod commands;
mod output;
mod progress;
mod values;

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use plenoscope::apart::{self, Work};
use plenoscope::aside;
use plenoscope::crash;
use plenoscope::io::decoder;
use plenoscope::job::{Cancel, Job};
use plenoscope::kernel::blocks::LargeBlocks;
use plenoscope::scene::SceneError;
use plenoscope::scene::asked::Usage;
use plenoscope::synth::adopt::{self, Shelf};
use plenoscope::synth::cache::Cache;

use crate::cli::{Cli, Talk};
use crate::progress::Bar;

/// Exit code of a job that Ctrl-C stopped, as shells have it.
const INTERRUPTED: u8 = 130;
/// Exit code of wrong usage, as clap has it.
const USAGE: u8 = 2;

#[global_allocator]
static BLOCKS: LargeBlocks = LargeBlocks::keeping(384 << 20);

fn main() -> ExitCode {
    if let Some(work) = Work::asked_for(std::env::args_os()) {
        return serve(&work).map_or(ExitCode::FAILURE, |()| ExitCode::SUCCESS);
    }
    work_apart();
    let cli = Cli::parse_from(values::spread(std::env::args_os()));
    log_to_stderr(&cli.talk);
    if let Some(folder) = crash::folder() {
        crash::watch(folder);
    }
    // What killed programs left in the person's own folders; elsewhere it goes when something is written there.
    let own =
        [Cache::user().map(|cache| cache.folder().to_owned()), Shelf::user().map(|shelf| shelf.folder().to_owned())];
    own.iter().flatten().for_each(|folder| aside::sweep(folder));
    let cancel = Cancel::default();
    let bar = Bar::new(cli.talk.quiet);
    let done = stop_on_ctrl_c(&cancel).and_then(|()| commands::run(cli, Job { cancel: &cancel, sink: &bar }));
    bar.finish();
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) if cancel.is_cancelled() => ExitCode::from(INTERRUPTED),
        Err(error) => {
            eprintln!("error: {}", plenoscope::errors::one_line(&error));
            if is_usage(&error) { ExitCode::from(USAGE) } else { ExitCode::FAILURE }
        }
    }
}

/// Does what another process of this program asked for.
fn serve(work: &Work) -> std::io::Result<()> {
    match work {
        Work::Decode => decoder::serve(),
        Work::ReadNet { path, picture } => adopt::serve(path, *picture),
    }
}

/// Lets this same program do what could break it, in processes of their own.
fn work_apart() {
    // The name of a program that was replaced since leads nowhere.
    let itself = Path::new("/proc/self/exe");
    match std::env::current_exe() {
        _ if itself.exists() => apart::work_with(itself.to_owned()),
        Ok(program) => apart::work_with(program),
        Err(_) => {}
    }
}

/// Whether the arguments are wrong, and not what they name.
fn is_usage(error: &anyhow::Error) -> bool {
    error.is::<Usage>() || matches!(error.downcast_ref(), Some(SceneError::Usage(_)))
}

/// `-v` shows what the program says, `-vv` and `-vvv` what its libraries say; `RUST_LOG` is heard too.
fn log_to_stderr(talk: &Talk) {
    let filter = match (talk.quiet, talk.verbose) {
        (true, _) => "off",
        (false, 0) => "error",
        (false, 1) => "plenoscope=info",
        (false, 2) => "plenoscope=debug,warn",
        (false, _) => "trace",
    };
    let mut builder = env_logger::Builder::new();
    builder.parse_filters(filter);
    if let Ok(wanted) = std::env::var("RUST_LOG") {
        builder.parse_filters(&wanted);
    }
    builder.init();
}

/// The first Ctrl-C asks the job to stop, so that nothing half-written stays; the second does not wait.
fn stop_on_ctrl_c(cancel: &Cancel) -> anyhow::Result<()> {
    let cancel = cancel.clone();
    ctrlc::set_handler(move || {
        if cancel.is_cancelled() {
            #[allow(clippy::disallowed_methods, reason = "asked twice: no longer politely")]
            std::process::exit(INTERRUPTED.into());
        }
        cancel.cancel();
    })
    .map_err(|error| anyhow::anyhow!("Ctrl-C cannot be listened to — {error} — start the program again"))
}
