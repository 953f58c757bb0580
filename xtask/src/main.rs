//! Chores that need more than a line of shell: `cargo xtask test`, `cargo xtask bench`, `cargo xtask package`.

mod beyond;
mod nets;
mod onnxruntime;
mod package;
mod python;
mod system;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result, bail};

const USAGE: &str = "usage: cargo xtask test [--all] [ARG…]   all tests, tract against ONNX Runtime and the Python package among them; --all
                                  also exports depth nets with PyTorch (gigabytes) and compares those, runs a
                                  job array on Slurm, and installs the .deb into bare Debian systems
       cargo xtask python [--all] the tests of the Python package alone; --all also executes its notebooks, opens a
                                  light field in napari, and runs a recipe on a Ray cluster
       cargo xtask beyond         those two last ones alone
       cargo xtask package        what people install, for this system, into target/packages
       cargo xtask bench [ARG…]   plenoscope bench with ONNX Runtime beside it
       cargo xtask onnxruntime    fetches ONNX Runtime and prints where it is

ARG… go to `cargo test` and to `plenoscope bench`.";

fn main() -> ExitCode {
    let mut args = std::env::args().skip(1);
    let task = args.next().unwrap_or_default();
    let rest: Vec<String> = args.collect();
    let done = match task.as_str() {
        "test" => test(&rest),
        "bench" => bench(&rest),
        "python" => python(rest.iter().any(|arg| arg == "--all")),
        "beyond" => beyond::all(&root()),
        "package" => package::make(&root()).map(|made| made.iter().for_each(|file| say(&file.display().to_string()))),
        "onnxruntime" => onnxruntime::library(&root()).map(|path| say(&path.display().to_string())),
        _ => Err(anyhow::anyhow!("{USAGE}")),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Runs the whole test suite. Where ONNX Runtime cannot be had the cross-check is skipped, loudly; in CI that fails.
fn test(args: &[String]) -> Result<()> {
    let root = root();
    system::ensure()?;
    let (all, args): (Vec<&String>, Vec<&String>) = args.iter().partition(|arg| *arg == "--all");
    let mut cargo = cargo_test(&root)?;
    if !all.is_empty() {
        cargo.env("PLENOSCOPE_NETS", nets::folder(&root)?);
    }
    let tested = run(cargo.arg("--no-fail-fast").args(args));
    let python = python::test(&root, !all.is_empty());
    if !all.is_empty() {
        beyond::all(&root)?;
    }
    tested.and(python)
}

/// `cargo test` of the workspace, always with the same selection, so that everything is compiled once.
fn cargo_test(root: &Path) -> Result<Command> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(root).args(["test", "--workspace"]);
    match onnxruntime::library(root) {
        Ok(path) => {
            eprintln!("xtask: tract is checked against ONNX Runtime {} ({})", onnxruntime::VERSION, path.display());
            cargo.args(["--features", "plenoscope/onnxruntime"]).env("ORT_DYLIB_PATH", path);
        }
        Err(error) if std::env::var_os("CI").is_some() => {
            return Err(error.context("without ONNX Runtime there is no cross-check, and CI must have it"));
        }
        Err(error) => eprintln!("\nxtask: SKIPPED: tract is NOT checked against ONNX Runtime: {error:#}\n"),
    }
    Ok(cargo)
}

/// The tests of the Python package, with what `cargo xtask test` builds.
fn python(all: bool) -> Result<()> {
    let root = root();
    run(cargo_test(&root)?.arg("--no-run"))?;
    python::test(&root, all)
}

/// Runs `plenoscope bench` with ONNX Runtime timed on the same files.
fn bench(args: &[String]) -> Result<()> {
    let root = root();
    let library = onnxruntime::library(&root)?;
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(&root).args(["run", "--release", "--package", "plenoscope-app", "--features", "onnxruntime"]);
    run(cargo.args(["--", "bench"]).args(args).env("ORT_DYLIB_PATH", library))
}

/// Runs a command to its end; an error unless it succeeds.
fn run(command: &mut Command) -> Result<()> {
    let name = command.get_program().to_string_lossy().into_owned();
    let status = command.status().with_context(|| format!("cannot start {name}"))?;
    if !status.success() {
        bail!("{name} failed ({status})");
    }
    Ok(())
}

/// The repository's root.
fn root() -> PathBuf {
    // Cargo names the checkout that it runs in; the binary may have been built in another that shares its target folder.
    let package = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    Path::new(&package).parent().map_or_else(PathBuf::new, Path::to_path_buf)
}

#[allow(clippy::print_stdout, reason = "a program's answer belongs on stdout")]
fn say(text: &str) {
    println!("{text}");
}
