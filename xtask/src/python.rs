//! The Python package as people use it: staged with the library that the workspace's build made, then its tests, those of
//! its documentation and of the book's page.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::{run, system};

/// The oldest Python that the package is made for.
const OLDEST: [u32; 2] = [3, 9];
/// What the tests need.
const PACKAGES: [&str; 4] = ["numpy", "pytest", "pillow", "mypy"];
/// What notebooks, napari and Ray need beyond that (some hundred megabytes).
const MORE: [&str; 8] =
    ["nbclient", "nbformat", "ipykernel", "matplotlib", "napari[pyqt6]", "npe2", "ray[data]", "psutil"];

/// Tests the package; the workspace's tests must have been built. With `all` the notebooks are executed too, napari
/// opens a light field, and a recipe goes over a Ray dataset.
///
/// # Errors
/// A test that failed; in CI also no Python.
pub fn test(root: &Path, all: bool) -> Result<()> {
    let place = root.join("target/python");
    let Some(python) = found()? else { return Ok(()) };
    let python = environment(&python, &place, all)?;
    let stage = stage(root, &place)?;
    let package = root.join("python");
    eprintln!("xtask: the Python package is tested with {}", python.display());
    let mut pytest = seen(&python, all);
    pytest.args(["-m", "pytest", "--doctest-modules", "-p", "no:cacheprovider", "-p", "no:logging", "-c"]);
    pytest.arg(package.join("pyproject.toml")).arg(package.join("tests")).arg(stage.join("plenoscope"));
    if all {
        pytest.arg(package.join("beyond")).env("PLENOSCOPE_NOTEBOOKS", package.join("notebooks"));
        pytest.env("PLENOSCOPE_TRAIN", trainer(root)?);
    }
    alone(&mut pytest, &place, &stage).env("PLENOSCOPE_PROGRAM", root.join("target/debug/plenoscope"));
    run(pytest.env("PLENOSCOPE_BOOK", root.join("docs/book/src/python.md")))?;
    let mut mypy = Command::new(&python);
    mypy.args(["-m", "mypy", "--no-error-summary", "--config-file"]).arg(package.join("pyproject.toml"));
    run(mypy.arg("--cache-dir").arg(place.join("mypy")).arg(package.join("plenoscope")))
}

/// A Python that is new enough; none where the tests are skipped, which is said.
fn found() -> Result<Option<PathBuf>> {
    let wanted = format!("Python {}.{} or newer with venv", OLDEST[0], OLDEST[1]);
    let python = PathBuf::from(std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into()));
    let check = format!("import sys, ensurepip, venv; sys.exit(sys.version_info < ({}, {}))", OLDEST[0], OLDEST[1]);
    if Command::new(&python).args(["-c", &check]).output().is_ok_and(|out| out.status.success()) {
        return Ok(Some(python));
    }
    let missing = format!("there is no {wanted} — install it (Debian: python3-venv), or name one by PYTHON");
    if std::env::var_os("CI").is_some() {
        bail!("the Python package cannot be tested, and CI must do it: {missing}");
    }
    eprintln!("\nxtask: SKIPPED: the Python package is NOT tested: {missing}\n");
    Ok(None)
}

/// An environment with what the tests need, made at the first call.
fn environment(python: &Path, place: &Path, all: bool) -> Result<PathBuf> {
    let packages: Vec<&str> = PACKAGES.iter().chain(MORE.iter().filter(|_| all)).copied().collect();
    let folder = place.join("venv");
    let inside = folder.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    let (stamp, wanted) = (place.join("packages"), packages.join(" "));
    // What was fetched for more tests does for fewer.
    if inside.exists() && fs::read_to_string(&stamp).is_ok_and(|has| has.starts_with(&wanted)) {
        return Ok(inside);
    }
    fs::create_dir_all(place).with_context(|| format!("cannot make the folder {}", place.display()))?;
    eprintln!("xtask: fetching {wanted}");
    run(Command::new(python).args(["-m", "venv", "--clear"]).arg(&folder))?;
    run(Command::new(&inside).args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(packages))
        .context("the Python package index did not give them — is the network there?")?;
    fs::write(stamp, wanted)?;
    Ok(inside)
}

/// The package with its library, as it would be installed.
fn stage(root: &Path, place: &Path) -> Result<PathBuf> {
    let (source, stage) = (root.join("python/plenoscope"), place.join("stage"));
    let package = stage.join("plenoscope");
    if package.exists() {
        fs::remove_dir_all(&package)?;
    }
    fs::create_dir_all(&package)?;
    for entry in fs::read_dir(&source)?.flatten().filter(|entry| entry.path().is_file()) {
        fs::copy(entry.path(), package.join(entry.file_name()))?;
    }
    let library = root.join("target/debug/deps").join(format!("{DLL_PREFIX}plenoscope_python{DLL_SUFFIX}"));
    let module = package.join(if cfg!(windows) { "_native.pyd" } else { "_native.abi3.so" });
    fs::copy(&library, module).with_context(|| format!("cargo did not build the module {}", library.display()))?;
    Ok(stage)
}

/// A Python, on a virtual display of its own where windows are to be opened.
fn seen(python: &Path, opens_windows: bool) -> Command {
    if !(opens_windows && system::on_path("xvfb-run")) {
        return Command::new(python);
    }
    let mut command = Command::new("xvfb-run");
    command.args(["-a", "-s", "-screen 0 1280x900x24"]).arg(python);
    command
}

/// The trainer, which a notebook runs.
fn trainer(root: &Path) -> Result<PathBuf> {
    run(Command::new(env!("CARGO")).current_dir(root).args(["build", "--package", "plenoscope-train"]))?;
    Ok(root.join("target/debug/plenoscope-train"))
}

/// A command that sees the staged package, away from the settings and caches of whoever runs the tests.
fn alone<'a>(command: &'a mut Command, place: &Path, stage: &Path) -> &'a mut Command {
    for (name, folder) in [("XDG_CACHE_HOME", "cache"), ("XDG_CONFIG_HOME", "config"), ("XDG_DATA_HOME", "data")] {
        command.env(name, place.join(folder));
    }
    command.env("PYTHONPATH", stage).env("PYTHONDONTWRITEBYTECODE", "1").env_remove("RUST_LOG")
}
