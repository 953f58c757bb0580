//! Arguments of the commands beside the pictures: what is known, and what is there.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// Arguments of `info`.
#[derive(Debug, Args)]
pub struct Info {
    /// A photo or a light field
    pub file: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `models`.
#[derive(Debug, Args)]
pub struct Models {
    #[command(subcommand)]
    pub what: ModelsCommand,
}

/// What to do with depth nets.
#[derive(Debug, Subcommand)]
pub enum ModelsCommand {
    /// Try an ONNX file on the sample photo, whose depth is known, and keep it as a source of ray depths
    Add {
        /// The net; files with weights of its own are taken from beside it
        #[arg(value_name = "FILE.onnx")]
        file: PathBuf,
        /// Its name, as --source takes it; by default the file's
        #[arg(long, value_name = "NAME")]
        name: Option<String>,
        /// Take it even if it does not find the sample's depth, and in place of one of that name
        #[arg(long)]
        force: bool,
        /// Also write what it says of the sample as a picture
        #[arg(long, value_name = "FILE.png")]
        depth: Option<PathBuf>,
    },
    /// Show the nets there are
    List {
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// Take a net away
    Remove {
        /// Its name
        name: String,
    },
    /// Use a net for all photos that have no depth of their own; "network" is the program's own again
    Use {
        /// Its name
        name: String,
    },
}

/// Arguments of `lenses`.
#[derive(Debug, Args)]
pub struct Lenses {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `doctor`.
#[derive(Debug, Args)]
pub struct Doctor {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `sample`.
#[derive(Debug, Args)]
pub struct Sample {
    /// Folder for sample.png and sample.pfm
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}
