//! One file for each command; here is which argument goes where.

mod info;
mod pages;

use anyhow::Result;
use plenoscope::job::Job;

use crate::cli::{Cli, Command};

/// Arguments that do not go together, found after parsing: exit code 2.
#[derive(Debug)]
pub struct Usage(pub String);

impl std::fmt::Display for Usage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Usage {}

/// Does what was asked for.
pub fn run(cli: Cli, job: Job) -> Result<()> {
    match cli.command {
        Some(Command::Info(args)) => info::run(&args, &job),
        Some(Command::Completions { shell }) => pages::completions(shell),
        Some(Command::Man { output }) => pages::man(output.as_deref()),
        None => Err(Usage("a command is missing — see plenoscope --help".to_owned()).into()),
    }
}
