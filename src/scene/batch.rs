//! Many photos through one recipe: in parallel within a memory budget; one bad photo does not stop the others, and what
//! is done already is not done again.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};

use super::export::{Existing, FileExport, Settings, Written};
use super::{Maker, Making, Recipe};
use crate::errors::sentence;
use crate::io::formats::depth_map::GivenDepth;
use crate::io::save;
use crate::job::{Job, Progress, Sink, Stage};

/// Bytes that one pixel of a photo takes on its way: decoded, as a copy, as a picture, and as tiles.
const BYTES_PER_PIXEL: u64 = 24;
/// What is taken for a photo whose size is not known before it is opened.
const USUAL_PIXELS: u64 = 24_000_000;

/// What to do with every photo.
#[derive(Clone, Debug)]
pub struct Order {
    /// The edit.
    pub recipe: Recipe,
    /// The folder that the pictures go to; it is made if it is not there.
    pub out: PathBuf,
    /// How much memory the photos that are worked on together may take.
    pub memory_bytes: u64,
    /// Whether pictures that are there already are made again.
    pub force: bool,
    /// How depth is made.
    pub making: Making,
    /// A map to use instead of any other depth.
    pub own_map: Option<GivenDepth>,
}

/// How it went.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Pictures that were made.
    pub done: Vec<PathBuf>,
    /// Pictures that were there already.
    pub skipped: Vec<PathBuf>,
    /// Photos that failed, each with a sentence that says why.
    pub failed: Vec<(PathBuf, String)>,
    /// Whether it was stopped before the end.
    pub stopped: bool,
}

/// Why nothing could be started.
#[derive(Debug, thiserror::Error)]
#[error("the folder for the pictures cannot be made — {why} — choose another: {}", .path.display())]
pub struct NoFolder {
    why: String,
    path: PathBuf,
}

enum Outcome {
    Done(PathBuf),
    Skipped(PathBuf),
    Failed(String),
    Stopped,
}

/// Runs every photo through the recipe.
pub fn run(inputs: &[PathBuf], order: &Order, maker: &Maker, job: &Job) -> Result<Summary, NoFolder> {
    let failed = |e: std::io::Error| NoFolder { why: e.to_string(), path: order.out.clone() };
    std::fs::create_dir_all(&order.out).map_err(failed)?;
    let targets = targets(inputs, order);
    let budget = Budget::new(order.memory_bytes);
    let next = AtomicUsize::new(0);
    let finished = AtomicUsize::new(0);
    let outcomes: Vec<Mutex<Option<Outcome>>> = inputs.iter().map(|_| Mutex::new(None)).collect();
    let work = || {
        while let Some((input, i)) = take(&next, inputs) {
            let outcome = if job.check().is_err() {
                Outcome::Stopped
            } else {
                budget.with(need(input), || one(input, &targets[i], order, maker, job))
            };
            *outcomes[i].lock().unwrap_or_else(PoisonError::into_inner) = Some(outcome);
            let done = finished.fetch_add(1, Ordering::Relaxed) as u32 + 1;
            // Whether it was stopped is asked before the next photo.
            let _ = job.advance(Stage::Refocus, done, inputs.len() as u32);
        }
    };
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(inputs.len());
    std::thread::scope(|scope| {
        for n in 1..workers {
            let started = std::thread::Builder::new().name(format!("batch-{n}")).spawn_scoped(scope, work);
            if started.is_err() {
                break;
            }
        }
        work();
    });
    Ok(summary(inputs, outcomes))
}

fn take<'a>(next: &AtomicUsize, inputs: &'a [PathBuf]) -> Option<(&'a Path, usize)> {
    let i = next.fetch_add(1, Ordering::Relaxed);
    inputs.get(i).map(|input| (input.as_path(), i))
}

/// Where each photo's picture goes; two photos of one name get two pictures, the same ones in every run.
fn targets(inputs: &[PathBuf], order: &Order) -> Vec<PathBuf> {
    let picture = &order.recipe.export;
    let mut all: Vec<PathBuf> = Vec::with_capacity(inputs.len());
    for input in inputs {
        // The width of the map, on which a recipe of version 1 hangs, changes no name but that of a disparity.
        let stem = picture.stem(input, &order.recipe.edit(order.making.long_side));
        let ending = picture.format.extension();
        let mut free = order.out.join(format!("{stem}.{ending}"));
        let mut n = 2;
        while all.contains(&free) {
            free = order.out.join(format!("{stem}-{n}.{ending}"));
            n += 1;
        }
        all.push(free);
    }
    all
}

fn one(input: &Path, target: &Path, order: &Order, maker: &Maker, job: &Job) -> Outcome {
    // Progress is counted in photos, so only warnings of what goes on inside one are told.
    let named = Named { path: input, outer: job.sink };
    let inner = Job { cancel: job.cancel, sink: &named };
    let existing = if order.force || save::same_file(input, target) { Existing::Replace } else { Existing::Leave };
    let settings = Settings { picture: order.recipe.export.clone(), existing, ..Settings::default() };
    let (recipe, making, own_map) = (&order.recipe, &order.making, order.own_map.as_ref());
    let export = FileExport { path: input, own_map, recipe, settings: &settings, target, maker, making };
    let write = || export.run(&inner);
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(write)) {
        _ if job.check().is_err() && !target.exists() => Outcome::Stopped,
        Ok(Ok(Written::Saved(path))) => Outcome::Done(path),
        Ok(Ok(Written::Skipped(path))) => Outcome::Skipped(path),
        Ok(Err(error)) => Outcome::Failed(sentence(&error)),
        Err(_) => Outcome::Failed("an error in the program; please report it with this photo".to_owned()),
    }
}

/// Passes warnings on with the photo's name.
struct Named<'a> {
    path: &'a Path,
    outer: &'a dyn Sink,
}

impl Sink for Named<'_> {
    fn progress(&self, _: Progress) {}
    fn warning(&self, text: String) {
        self.outer.warning(format!("{text}: {}", self.path.display()));
    }
}

fn summary(inputs: &[PathBuf], outcomes: Vec<Mutex<Option<Outcome>>>) -> Summary {
    let mut summary = Summary::default();
    for (input, outcome) in inputs.iter().zip(outcomes) {
        match outcome.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(Outcome::Done(path)) => summary.done.push(path),
            Some(Outcome::Skipped(path)) => summary.skipped.push(path),
            Some(Outcome::Failed(why)) => summary.failed.push((input.clone(), why)),
            Some(Outcome::Stopped) | None => summary.stopped = true,
        }
    }
    summary
}

/// Memory that a photo will take, from its header where that can be read.
fn need(path: &Path) -> u64 {
    let pixels = image::image_dimensions(path).map_or(USUAL_PIXELS, |(w, h)| u64::from(w) * u64::from(h));
    pixels * BYTES_PER_PIXEL
}

/// Lets work begin while there is memory for it; one piece of work may always run.
struct Budget {
    total: u64,
    taken: Mutex<u64>,
    freed: Condvar,
}

impl Budget {
    fn new(total: u64) -> Self {
        Self { total, taken: Mutex::new(0), freed: Condvar::new() }
    }

    fn with<T>(&self, bytes: u64, work: impl FnOnce() -> T) -> T {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        while *taken > 0 && *taken + bytes > self.total {
            taken = self.freed.wait(taken).unwrap_or_else(PoisonError::into_inner);
        }
        *taken += bytes;
        drop(taken);
        let result = work();
        *self.taken.lock().unwrap_or_else(PoisonError::into_inner) -= bytes;
        self.freed.notify_all();
        result
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicU32;

    use super::*;
    use crate::job::Cancel;

    /// Two photos and a file that is none; without nets, so that the photos fail too unless they bring a depth.
    fn inputs(dir: &Path) -> Vec<PathBuf> {
        let photo = image::RgbImage::from_fn(48, 32, |x, y| image::Rgb([x as u8 * 5, y as u8 * 7, 90]));
        let paths = ["a/x.png", "bad.jpg", "b/x.jpg"].map(|name| dir.join(name)).to_vec();
        for folder in ["a", "b"] {
            std::fs::create_dir_all(dir.join(folder)).unwrap();
        }
        photo.save(&paths[0]).unwrap();
        std::fs::write(&paths[1], "no photo").unwrap();
        photo.save(&paths[2]).unwrap();
        paths
    }

    fn order(out: &Path) -> Order {
        let making = Making { long_side: 48, ..Making::default() };
        Order { recipe: Recipe::default(), out: out.to_owned(), memory_bytes: 1, force: false, making, own_map: None }
    }

    #[test]
    fn a_bad_photo_does_not_stop_the_others_and_a_second_run_does_nothing_again() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("new");
        let inputs = inputs(dir.path());
        let (cancel, maker) = (Cancel::default(), Maker::default());
        let job = Job { cancel: &cancel, sink: &() };
        let first = run(&inputs, &order(&out), &maker, &job).unwrap();
        assert_eq!(first.done, [out.join("x-f3.5.jpg"), out.join("x-f3.5-2.jpg")]);
        assert!(first.failed.len() == 1 && first.failed[0].0 == inputs[1] && first.failed[0].1.contains("bad.jpg"));
        let second = run(&inputs, &order(&out), &maker, &job).unwrap();
        assert_eq!((second.done.len(), second.skipped.len(), second.failed.len()), (0, 2, 1));
        let forced = run(&inputs, &Order { force: true, ..order(&out) }, &maker, &job).unwrap();
        assert_eq!(forced.done.len(), 2);
    }

    #[test]
    fn a_stopped_batch_says_so_and_leaves_no_picture() {
        let dir = tempfile::tempdir().unwrap();
        let cancel = Cancel::default();
        cancel.cancel();
        let job = Job { cancel: &cancel, sink: &() };
        let summary = run(&["a.jpg".into()], &order(dir.path()), &Maker::default(), &job).unwrap();
        assert!(summary.stopped && summary.done.is_empty());
        assert_eq!(dir.path().read_dir().unwrap().count(), 0);
    }

    #[test]
    fn work_waits_for_memory() {
        let budget = Budget::new(10);
        let (running, most) = (AtomicU32::new(0), AtomicU32::new(0));
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    budget.with(6, || {
                        most.fetch_max(running.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                        std::thread::sleep(std::time::Duration::from_millis(5));
                        running.fetch_sub(1, Ordering::SeqCst);
                    });
                });
            }
        });
        assert_eq!(most.into_inner(), 1);
    }
}
