//! Arguments of `batch`.

use std::path::PathBuf;

use clap::Args;
use plenoscope::shard::Shard;

use super::SynthArgs;

/// Arguments of `batch`.
#[derive(Debug, Args)]
pub struct Batch {
    /// The photos, or folders of them
    #[arg(required_unless_present = "files_from", value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// Take the photos that this list names, one a line; - is the standard input
    #[arg(long, value_name = "LIST", conflicts_with = "inputs")]
    pub files_from: Option<PathBuf>,
    /// The edit, as the window keeps it
    #[arg(long, value_name = "FILE.json")]
    pub recipe: PathBuf,
    /// Folder for the pictures
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Names of the pictures without their ending: {name} is the photo's, {f} the f-number; by default the recipe's
    #[arg(long, value_name = "TEMPLATE")]
    pub name: Option<String>,
    /// Make again what is there already
    #[arg(long)]
    pub force: bool,
    /// Make again of what is there already only what is not whole, or of another recipe or photo
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Print a line of JSON a photo: path, output, state (made, skipped, met, failed), secs, error
    #[arg(long)]
    pub json: bool,
    /// Write the same lines to a file; with --resume after those that are there
    #[arg(long, value_name = "FILE.jsonl")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub share: BatchShare,
    #[command(flatten)]
    pub synth: SynthArgs,
}

/// What one worker of several takes of the work and of the machine.
#[derive(Debug, Args)]
#[command(next_help_heading = "Several workers")]
pub struct BatchShare {
    /// Do the K-th of N parts of the photos; a photo's part hangs on its file name alone
    #[arg(long, value_name = "K/N", default_value_t)]
    pub shard: Shard,
    /// Photos that are worked on together at most; 0 is one for each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    pub jobs: u16,
    /// Memory that these may take together, in MiB
    #[arg(long, value_name = "MIB", default_value_t = 2048, value_parser = clap::value_parser!(u32).range(1..))]
    pub memory: u32,
}
