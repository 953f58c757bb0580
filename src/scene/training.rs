//! Training, by the trainer's program beside this one: found, started, listened to, ended. It is never linked.

use std::collections::BTreeMap;
use std::env;
use std::fs;
use std::io::{BufRead as _, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread;
use std::time::{Duration, SystemTime};

use serde::Deserialize;

use crate::job::Job;
use crate::synth::ModelTag;
use crate::synth::adopt::Shelf;
use crate::within;

/// The trainer's program.
const PROGRAM: &str = "plenoscope-train";
/// Between two looks at what it wrote.
const LOOK: Duration = Duration::from_millis(400);
/// The most that its metrics may hold, and its config.
const MOST_TEXT_BYTES: u64 = 64 << 20;
/// Lines of a curve, at most: more are thinned out.
const MOST_POINTS: usize = 400;
/// Long side of the pictures that a net sees that is trained on light fields, as the paper's.
const LONG_SIDE_PX: &str = "270";

/// Why training does not go on.
#[derive(Debug, thiserror::Error)]
pub enum TrainingError {
    /// No program.
    #[error(
        "the trainer is not here — it is a program of its own — build it with `cargo build --release --package plenoscope-train` and put plenoscope-train beside plenoscope"
    )]
    NoTrainer,
    /// A program that does not start.
    #[error("the trainer does not start — {source}: {}", path.display())]
    Start {
        /// What the system said.
        source: std::io::Error,
        /// The program.
        path: PathBuf,
    },
    /// What the trainer said last.
    #[error("{0}")]
    Failed(String),
}

/// The trainer's program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Trainer {
    program: PathBuf,
}

/// A run: what it learns from, and where it is kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// Folder of light fields.
    pub data: PathBuf,
    /// Checkpoints, metrics, contact sheets.
    pub folder: PathBuf,
}

/// What a run has told so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Told {
    /// Steps behind it, and in all.
    pub steps: [u64; 2],
    /// Step and value of each loss, at most some 400 of each.
    pub losses: BTreeMap<String, Vec<[f32; 2]>>,
    /// The contact sheet, and when it was drawn.
    pub sheet: Option<(PathBuf, SystemTime)>,
}

/// A line of the metrics; those of other kinds lack the losses.
#[derive(Deserialize)]
struct Line {
    step: u64,
    losses: BTreeMap<String, f32>,
}

/// The part of a run's config that is told.
#[derive(Deserialize)]
struct Saved {
    steps: u64,
    data: PathBuf,
}

impl Run {
    /// The run on a folder of light fields, kept beside the person's own nets; none of a folder without a name.
    pub fn of(data: &Path, shelf: &Shelf) -> Option<Self> {
        let name = data.file_name()?.to_string_lossy().into_owned();
        let own = shelf.folder().with_file_name("training");
        // Folders of one name are told apart.
        let mut names = (1..).map(|n| if n == 1 { name.clone() } else { format!("{name}-{n}") });
        let is_free = |folder: &PathBuf| !folder.exists() || saved(folder).is_some_and(|saved| saved.data == data);
        let folder = names.by_ref().map(|name| own.join(name)).find(is_free)?;
        Some(Self { data: data.to_owned(), folder })
    }

    /// What it has told.
    pub fn told(&self) -> Told {
        let metrics = within::text(&self.folder.join("metrics.jsonl"), MOST_TEXT_BYTES).unwrap_or_default();
        let lines: Vec<Line> = metrics.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        let mut losses: BTreeMap<String, Vec<[f32; 2]>> = BTreeMap::new();
        for line in lines.iter().step_by(lines.len().div_ceil(MOST_POINTS).max(1)) {
            for (name, value) in line.losses.iter().filter(|(_, value)| value.is_finite()) {
                losses.entry(name.clone()).or_default().push([line.step as f32, *value]);
            }
        }
        let sheet = self.folder.join("sheet.png");
        let drawn = fs::metadata(&sheet).and_then(|about| about.modified()).ok();
        let all = saved(&self.folder).map_or(0, |saved| saved.steps);
        Told {
            steps: [lines.last().map_or(0, |line| line.step), all],
            losses,
            sheet: drawn.map(|drawn| (sheet, drawn)),
        }
    }

    fn is_begun(&self) -> bool {
        self.folder.join("depth.safetensors").exists()
    }
}

fn saved(folder: &Path) -> Option<Saved> {
    serde_json::from_str(&within::text(&folder.join("config.json"), MOST_TEXT_BYTES).ok()?).ok()
}

impl Trainer {
    /// A program of one's own.
    pub fn new(program: &Path) -> Self {
        Self { program: program.to_owned() }
    }

    /// The program beside this one, else on the path.
    ///
    /// # Errors
    /// Neither is there.
    pub fn found() -> Result<Self, TrainingError> {
        let name = format!("{PROGRAM}{}", env::consts::EXE_SUFFIX);
        let beside = env::current_exe().ok().and_then(|own| Some(own.parent()?.to_owned()));
        let path = env::var_os("PATH").unwrap_or_default();
        let folders = beside.into_iter().chain(env::split_paths(&path));
        let program = folders.map(|folder| folder.join(&name)).find(|program| program.is_file());
        program.map(|program| Self { program }).ok_or(TrainingError::NoTrainer)
    }

    /// Trains until the run's steps are done or the job is stopped; then the trainer saves and ends. `told` hears what the run says.
    ///
    /// # Errors
    /// A trainer that does not start, or gives up.
    pub fn train(&self, run: &Run, job: &Job, told: &mut dyn FnMut(Told)) -> Result<(), TrainingError> {
        let mut command = self.command();
        command.args(["train", "--attended"]);
        match run.is_begun() {
            true => command.arg("--resume").arg(&run.folder),
            false => command.args(["--preset", "paper", "--save-secs", "60", "--log-steps", "5"]).args([
                "--data".as_ref(),
                run.data.as_os_str(),
                "--out".as_ref(),
                run.folder.as_os_str(),
            ]),
        };
        let mut child = self.spawn(&mut command)?;
        let mut ours: Option<ChildStdin> = child.stdin.take();
        let said = self.started(last_line(child.stderr.take()))?;
        let mut before = Told::default();
        let status = loop {
            if let Some(status) = self.started(child.try_wait())? {
                break status;
            }
            if job.check().is_err() {
                // The end of what it reads is its sign to save and end.
                ours = None;
            }
            let now = run.told();
            if now != before {
                told(now.clone());
                before = now;
            }
            thread::sleep(LOOK);
        };
        drop(ours);
        told(run.told());
        let said = said.join().unwrap_or_default();
        if status.success() { Ok(()) } else { Err(TrainingError::Failed(said)) }
    }

    /// Puts the run's depth net on a shelf, named like the run; the light field's occlusions stay the program's.
    ///
    /// # Errors
    /// A run without a checkpoint; what the trainer says.
    pub fn export(&self, run: &Run, shelf: &Shelf) -> Result<ModelTag, TrainingError> {
        let name = run.folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut command = self.command();
        command.arg("export").arg(run.folder.join("depth.safetensors")).args(["--long-side", LONG_SIDE_PX]);
        command.args(["--id", &name, "--training-data", &run.data.to_string_lossy(), "--models"]).arg(shelf.folder());
        let mut child = self.spawn(&mut command)?;
        let said = self.started(last_line(child.stderr.take()))?;
        let status = self.started(child.wait())?;
        let said = said.join().unwrap_or_default();
        let tag = shelf.tag(&name).filter(|_| status.success());
        tag.ok_or(TrainingError::Failed(said))
    }

    fn command(&self) -> Command {
        let mut command = Command::new(&self.program);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    fn spawn(&self, command: &mut Command) -> Result<Child, TrainingError> {
        self.started(command.spawn())
    }

    fn started<T>(&self, done: std::io::Result<T>) -> Result<T, TrainingError> {
        done.map_err(|source| TrainingError::Start { source, path: self.program.clone() })
    }
}

/// Reads to the end, on a thread of its own; gives the last line that says something, as a sentence.
fn last_line(from: Option<impl Read + Send + 'static>) -> std::io::Result<thread::JoinHandle<String>> {
    thread::Builder::new().name("trainer".into()).spawn(move || {
        let lines = from.into_iter().flat_map(|from| BufReader::new(from).lines().map_while(Result::ok));
        let last = lines.filter(|line| !line.trim().is_empty()).last().unwrap_or_default();
        last.strip_prefix("error: ").unwrap_or(&last).to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run_in(folder: &Path) -> Run {
        Run { data: folder.join("fields"), folder: folder.join("run") }
    }

    #[test]
    fn a_run_tells_its_losses_thinned_out_and_what_is_damaged_is_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let run = run_in(folder.path());
        assert_eq!(run.told(), Told::default());
        fs::create_dir(&run.folder).unwrap();
        let line = |step: usize| format!("{{\"step\":{step},\"losses\":{{\"full\":0.5}},\"norm\":1}}\n");
        let text: String = (1..=1000).map(line).collect();
        let watch = "{\"step\":1000,\"watch\":{}}\nno json\n{\"step\":";
        fs::write(run.folder.join("metrics.jsonl"), text + watch).unwrap();
        fs::write(run.folder.join("config.json"), "{\"steps\": 5000, \"data\": \"fields\"}").unwrap();
        let told = run.told();
        assert_eq!(told.steps, [1000, 5000]);
        assert!((300..=400).contains(&told.losses["full"].len()), "{}", told.losses["full"].len());
        assert_eq!(told.losses["full"][0], [1.0, 0.5]);
    }

    /// A program that takes the trainer's place.
    #[cfg(unix)]
    fn stand_in(folder: &Path, script: &str) -> Trainer {
        use std::os::unix::fs::PermissionsExt as _;
        let program = folder.join("trainer");
        fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
        Trainer::new(&program)
    }

    #[test]
    fn folders_of_one_name_have_runs_of_their_own() {
        let folder = tempfile::tempdir().unwrap();
        let shelf = Shelf::new(&folder.path().join("models"));
        let run = Run::of(Path::new("/a/fields"), &shelf).unwrap();
        assert_eq!(run.folder, folder.path().join("training/fields"));
        fs::create_dir_all(&run.folder).unwrap();
        fs::write(run.folder.join("config.json"), "{\"steps\": 9, \"data\": \"/a/fields\"}").unwrap();
        assert_eq!(Run::of(Path::new("/a/fields"), &shelf), Some(run));
        let other = Run::of(Path::new("/b/fields"), &shelf).unwrap();
        assert_eq!(other.folder, folder.path().join("training/fields-2"));
    }

    #[cfg(unix)]
    #[test]
    fn a_trainer_is_listened_to_and_ends_by_itself_once_it_is_stopped() {
        use crate::job::Cancel;
        let folder = tempfile::tempdir().unwrap();
        let run = run_in(folder.path());
        fs::create_dir(&run.folder).unwrap();
        let metrics = run.folder.join("metrics.jsonl");
        let line = "{\"step\":7,\"losses\":{\"full\":0.25}}";
        // It reads until its input ends, as the trainer does when it is attended.
        let script = format!("echo '{line}' > '{}'; cat > /dev/null; echo saved >> '{0}'", metrics.display());
        let cancel = Cancel::default();
        let mut heard = Vec::new();
        let job = Job { cancel: &cancel, sink: &() };
        stand_in(folder.path(), &script)
            .train(&run, &job, &mut |told| {
                if told.steps[0] == 7 {
                    cancel.cancel();
                }
                heard.push(told.steps[0]);
            })
            .unwrap();
        assert_eq!(heard.last(), Some(&7));
        assert!(fs::read_to_string(&metrics).unwrap().ends_with("saved\n"), "it was given the time to save");
    }

    #[cfg(unix)]
    #[test]
    fn what_the_trainer_says_last_is_the_error() {
        use crate::job::Cancel;
        let folder = tempfile::tempdir().unwrap();
        let trainer =
            stand_in(folder.path(), "echo 'reading' >&2; echo 'error: no light fields: give others' >&2; exit 1");
        let (cancel, run) = (Cancel::default(), run_in(folder.path()));
        let failed = trainer.train(&run, &Job { cancel: &cancel, sink: &() }, &mut |_| ()).unwrap_err();
        assert_eq!(failed.to_string(), "no light fields: give others");
        let shelf = Shelf::new(&folder.path().join("shelf"));
        assert_eq!(trainer.export(&run, &shelf).unwrap_err().to_string(), "no light fields: give others");
    }
}
