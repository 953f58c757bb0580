//! Many photos through one recipe: in parallel within a memory budget; one bad photo does not stop the others, and what
//! is done already is not done again. Several workers, on several machines, can share the photos and the folder.

mod journal;
mod order;

use std::collections::{HashMap, HashSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, OnceLock, PoisonError};
use std::time::{Instant, SystemTime};

use super::Maker;
use super::export::{Existing, FileExport, Settings, Written};
use crate::aside::parent;
use crate::errors::sentence;
use crate::io::{save, several};
use crate::job::{Job, Progress, Sink, Stage};
use journal::Journal;
use order::Place;

pub use order::{BatchError, Earlier, Line, Order, State, Summary};

/// Bytes that one pixel of a photo takes on its way: decoded, as a copy, as a picture, and as tiles.
const BYTES_PER_PIXEL: u64 = 24;
/// What is taken for a photo whose size is not known before it is opened.
const USUAL_PIXELS: u64 = 24_000_000;

/// Takes a line about every photo as soon as it is finished.
pub type Report<'a> = dyn Fn(&Line) -> io::Result<()> + Sync + 'a;

enum Outcome {
    Done(PathBuf),
    Skipped(PathBuf),
    Met(PathBuf),
    Failed(String),
    Stopped,
}

/// What a batch works through: a folder that is no light field stands for its photos.
pub fn all_photos(inputs: &[PathBuf], job: &Job) -> Vec<PathBuf> {
    let photos = |path: &PathBuf| several::folder_of_photos(path, job).unwrap_or_else(|| vec![path.clone()]);
    inputs.iter().flat_map(photos).collect()
}

/// Runs every photo of the order's part through the recipe.
///
/// # Errors
/// [`BatchError`], where no photo could be worked on. What went wrong with one photo stands in the [`Summary`].
pub fn run(
    inputs: &[PathBuf],
    order: &Order,
    maker: &Maker,
    report: &Report,
    job: &Job,
) -> Result<Summary, BatchError> {
    let failed = |e: io::Error| BatchError::NoFolder { why: e.to_string(), path: order.out.clone() };
    std::fs::create_dir_all(&order.out).map_err(failed)?;
    let batch = Batch::new(inputs, order, maker, report, job);
    let all = batch.work.len();
    let workers = match order.jobs {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        jobs => jobs,
    };
    std::thread::scope(|scope| {
        for n in 1..workers.min(all) {
            let started =
                std::thread::Builder::new().name(format!("batch-{n}")).spawn_scoped(scope, || batch.work_on());
            if started.is_err() {
                break;
            }
        }
        batch.work_on();
    });
    batch.ended.into_inner().map_or_else(|| Ok(summary(batch.work, batch.outcomes)), Err)
}

/// What the threads of a batch share.
struct Batch<'a> {
    order: &'a Order,
    maker: &'a Maker,
    report: &'a Report<'a>,
    job: &'a Job<'a>,
    /// Photos and their pictures.
    work: Vec<(&'a Path, PathBuf)>,
    outcomes: Vec<Mutex<Option<Outcome>>>,
    /// Place in the work at which this worker begins.
    first: usize,
    next: AtomicUsize,
    finished: AtomicUsize,
    budget: Budget,
    journal: Journal,
    /// The folders that photos and pictures lie in.
    places: HashMap<PathBuf, Place>,
    ended: OnceLock<BatchError>,
}

impl<'a> Batch<'a> {
    fn new(
        inputs: &'a [PathBuf],
        order: &'a Order,
        maker: &'a Maker,
        report: &'a Report<'a>,
        job: &'a Job<'a>,
    ) -> Self {
        let named = inputs.iter().map(PathBuf::as_path).zip(targets(inputs, order));
        let work: Vec<_> = named.filter(|(input, _)| order.shard.takes_file(input)).collect();
        let folders: HashSet<&Path> = work.iter().map(|(input, _)| parent(input)).chain([&*order.out]).collect();
        let places = folders.into_iter().filter_map(|folder| Some((folder.to_owned(), Place::of(folder)?))).collect();
        Self {
            order,
            maker,
            report,
            job,
            outcomes: work.iter().map(|_| Mutex::new(None)).collect(),
            first: if order.shard.is_whole() { 0 } else { somewhere(work.len()) },
            work,
            next: AtomicUsize::new(0),
            finished: AtomicUsize::new(0),
            budget: Budget::new(order.memory_bytes),
            journal: Journal::new(&order.out, &order.key()),
            places,
            ended: OnceLock::new(),
        }
    }

    /// Takes one photo after the other until none is left.
    fn work_on(&self) {
        while let Some(i) = self.take() {
            let (input, target) = &self.work[i];
            let started = Instant::now();
            let outcome = if self.job.check().is_err() || self.ended.get().is_some() {
                Outcome::Stopped
            } else {
                self.budget.with(need(input), || self.one(input, target))
            };
            self.tell(input, &outcome, started.elapsed().as_secs_f64());
            *self.outcomes[i].lock().unwrap_or_else(PoisonError::into_inner) = Some(outcome);
            let done = self.finished.fetch_add(1, Ordering::Relaxed) as u32 + 1;
            // Whether it was stopped is asked before the next photo.
            let _ = self.job.advance(Stage::Refocus, done, self.work.len() as u32);
        }
    }

    fn take(&self) -> Option<usize> {
        let n = self.next.fetch_add(1, Ordering::Relaxed);
        (n < self.work.len()).then(|| (self.first + n) % self.work.len())
    }

    fn one(&self, input: &Path, target: &Path) -> Outcome {
        let order = self.order;
        if let Some(gone) = self.gone(&order.out) {
            return self.end(gone);
        }
        let was_there = target.exists();
        let is_source = save::same_file(input, target);
        let existing = match order.earlier {
            // What writes over a photo is refused further on.
            _ if is_source => Existing::Replace,
            Earlier::Resume if was_there && self.journal.is_finished(target, input) => {
                return Outcome::Skipped(target.to_owned());
            }
            Earlier::Replace => Existing::Replace,
            Earlier::Resume if was_there => Existing::Replace,
            Earlier::Keep | Earlier::Resume => Existing::Leave,
        };
        match self.export(input, target, existing) {
            Outcome::Failed(why) => match self.gone(&order.out).or_else(|| self.gone(parent(input))) {
                Some(gone) => self.end(gone),
                None => Outcome::Failed(why),
            },
            Outcome::Skipped(path) if !was_there => Outcome::Met(path),
            Outcome::Done(path) => {
                if let Err(error) = self.journal.add(&path, input) {
                    self.job.sink.warning(format!("--resume will not know of it — {error}: {}", path.display()));
                }
                Outcome::Done(path)
            }
            outcome => outcome,
        }
    }

    fn export(&self, input: &Path, target: &Path, existing: Existing) -> Outcome {
        let Self { order, maker, job, .. } = self;
        // Progress is counted in photos, so only warnings of what goes on inside one are told.
        let named = Named { path: input, outer: job.sink };
        let inner = Job { cancel: job.cancel, sink: &named };
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

    /// A folder that was there at the start and is not any more.
    fn gone(&self, folder: &Path) -> Option<BatchError> {
        let place = self.places.get(folder).filter(|place| !place.is_there())?;
        Some(BatchError::Gone(place.path.clone()))
    }

    /// Ends the work of all threads; the first reason is the one to tell.
    fn end(&self, why: BatchError) -> Outcome {
        let _ = self.ended.set(why);
        Outcome::Stopped
    }

    fn tell(&self, input: &Path, outcome: &Outcome, secs: f64) {
        let (state, output, error) = match outcome {
            Outcome::Done(path) => (State::Made, Some(path), None),
            Outcome::Skipped(path) => (State::Skipped, Some(path), None),
            Outcome::Met(path) => (State::Met, Some(path), None),
            Outcome::Failed(why) => (State::Failed, None, Some(why.clone())),
            Outcome::Stopped => return,
        };
        let text = |path: &Path| path.to_string_lossy().into_owned();
        let line = Line {
            path: text(input),
            output: output.map(|path| text(path)),
            state,
            secs: (secs * 1e3).round() / 1e3,
            error,
        };
        if let Err(error) = (self.report)(&line) {
            let _ = self.end(BatchError::Report(error));
        }
    }
}

/// A place that is another for each worker, so that two with the same photos meet late and share the work.
fn somewhere(len: usize) -> usize {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let number = u64::from(now.subsec_nanos()) / 1000 + u64::from(std::process::id()) * 7919;
    (number % len.max(1) as u64) as usize
}

/// Where each photo's picture goes; two photos of one name get two pictures, the same ones in every run and part. Names that differ
/// in capitals alone count as one: some disks, as those of cameras, cannot tell them apart.
fn targets(inputs: &[PathBuf], order: &Order) -> Vec<PathBuf> {
    let picture = &order.recipe.export;
    let mut taken: HashMap<String, u32> = HashMap::with_capacity(inputs.len());
    let mut all = Vec::with_capacity(inputs.len());
    for input in inputs {
        // The width of the map, on which a recipe of version 1 hangs, changes no name but that of a disparity.
        let stem = picture.stem(input, &order.recipe.edit(order.making.long_side));
        let ending = picture.format.extension();
        let plain = format!("{stem}.{ending}");
        let mut free = plain.clone();
        while taken.contains_key(&free.to_lowercase()) {
            let last = taken.entry(plain.to_lowercase()).or_insert(1);
            *last += 1;
            free = format!("{stem}-{last}.{ending}");
        }
        taken.insert(free.to_lowercase(), 1);
        all.push(order.out.join(free));
    }
    all
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

fn summary(work: Vec<(&Path, PathBuf)>, outcomes: Vec<Mutex<Option<Outcome>>>) -> Summary {
    let mut summary = Summary::default();
    for ((input, _), outcome) in work.into_iter().zip(outcomes) {
        match outcome.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some(Outcome::Done(path)) => summary.done.push(path),
            Some(Outcome::Skipped(path)) => summary.skipped.push(path),
            Some(Outcome::Met(path)) => {
                summary.met += 1;
                summary.skipped.push(path);
            }
            Some(Outcome::Failed(why)) => summary.failed.push((input.to_owned(), why)),
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
mod tests;
