//! Arguments of `bench`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use plenoscope::scene::asked;

use crate::values::{self, Size};

/// Arguments of `bench`.
#[derive(Debug, Args)]
pub struct Bench {
    /// Width and height of the views; may be given more than once; by default 270x187 and 540x372
    #[arg(long, value_name = "WxH")]
    pub size: Vec<Size>,
    /// Time what the program does with this photo, from the file to the light field
    #[arg(long, value_name = "FILE", conflicts_with = "size")]
    pub pipeline: Option<PathBuf>,
    /// Time this net of your own on a picture of --size, by default 518x392 or what the file fixes
    #[arg(long, value_name = "FILE.onnx", conflicts_with_all = ["pipeline", "models"])]
    pub model: Option<PathBuf>,
    /// With --model: say which operations took the time
    #[arg(long, requires = "model")]
    pub profile: bool,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// Take the nets from this folder instead of those in the program
    #[arg(long, value_name = "DIR")]
    pub models: Option<PathBuf>,
    /// Threads that compute; 0 is one for each core
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = values::whole(asked::THREADS))]
    pub threads: u16,
    /// Which code does the convolutions
    #[arg(long, value_enum, default_value_t = EnginePath::Auto)]
    pub path: EnginePath,
    /// Convolutions one by one, without Winograd's algorithm
    #[arg(long)]
    pub exact: bool,
    /// Run once and print the peak memory in MiB
    #[arg(long, value_name = "WxH", hide = true)]
    pub once: Option<Size>,
}

/// Code that does the convolutions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum EnginePath {
    /// The fastest that this processor has
    Auto,
    /// AVX-512
    Avx512,
    /// AVX2 and FMA
    Avx2,
    /// The same in plain Rust
    Portable,
    /// tract's own
    Stock,
}
