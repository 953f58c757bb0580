//! The command line. Others script against these names: they stay.

mod batch;
mod bench;
mod burst;
mod embed;
mod fields;
mod pictures;
mod shared;
mod stereo;
mod tools;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use plenoscope::scene::asked;

pub use batch::Batch;
pub use bench::{Bench, EnginePath};
pub use burst::Burst;
pub use embed::EmbedArgs;
pub use fields::{Export, Synth};
pub use pictures::{Depth, DepthKind, Epi, Refocus, View};
pub use shared::{LensArgs, RecipeArgs, SynthArgs};
pub use stereo::StereoArgs;
pub use tools::{Doctor, Info, Lenses, Models, ModelsCommand, Sample};

use crate::values;

/// Turns a photo into a light field, to look into and to refocus.
#[derive(Debug, Parser)]
#[command(name = "plenoscope", version, max_term_width = 100, disable_help_subcommand = false)]
#[command(after_help = "Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted.")]
pub struct Cli {
    /// Photos and light fields to open in the window
    #[arg(value_name = "FILE")]
    pub files: Vec<PathBuf>,
    #[command(flatten)]
    pub window: Window,
    #[command(flatten)]
    pub talk: Talk,
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What the window starts with.
#[derive(Debug, Args)]
#[command(next_help_heading = "Window")]
pub struct Window {
    /// Long side of a view, in pixels; by default what the settings say
    #[arg(long, value_name = "N", value_parser = values::whole(asked::LONG_SIDES))]
    pub long_side: Option<u32>,
    /// Take the nets from this folder instead of those in the program
    #[arg(long, value_name = "DIR")]
    pub models: Option<PathBuf>,
    /// Threads that compute; 0 is one for each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = values::whole(asked::THREADS))]
    pub threads: u16,
    /// Do not open the file of the last time
    #[arg(long)]
    pub fresh: bool,
}

/// How much the program says.
#[derive(Debug, Args)]
pub struct Talk {
    /// Say nothing but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say more; twice and three times even more
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Make a light field of a photo
    Synth(Synth),
    /// Make a light field of several photos of one subject
    Burst(Burst),
    /// Write a refocused picture
    Refocus(Refocus),
    /// Write the view from a place of the lens
    View(View),
    /// Write an epipolar slice
    Epi(Epi),
    /// Write the ray depths of a view
    Depth(Depth),
    /// Write a light field in another format, or what is made of it
    Export(Export),
    /// Put many photos through one recipe
    Batch(Batch),
    /// Time the nets, stage by stage
    Bench(Bench),
    /// What a file is: format, size, views, depth that came with it
    Info(Info),
    /// Depth nets of other people: add, list, remove, use
    Models(Models),
    /// The lenses that --as-lens knows
    Lenses(Lenses),
    /// Say what the program finds on this machine, and what is wrong with it
    Doctor(Doctor),
    /// Write the built-in sample photo and its disparity
    Sample(Sample),
    /// Print the completions for a shell
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Write the program's icon in all sizes, laid out as desktops look for it
    #[command(hide = true)]
    Icons {
        /// Folder for it, such as /usr/share/icons/hicolor
        #[arg(short, long, value_name = "DIR")]
        output: PathBuf,
    },
    /// Print the man page, or write those of all commands into a folder
    Man {
        /// Folder for the pages of all commands
        #[arg(short, long, value_name = "DIR")]
        output: Option<PathBuf>,
    },
}
