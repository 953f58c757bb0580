//! `plenoscope bench`, the library side: both nets and the warp at an exact size, stage by stage, against the machine's
//! measured peak and, built with the feature `onnxruntime`, against ONNX Runtime on the same files in the same run.
//!
//! [`model`] times any other ONNX file.
//!
//! Peak memory grows with everything a process has done before, so ask [`peak_rss_mib`] in a process of its own that
//! has called nothing but [`once`].

pub mod model;
mod nets;
#[cfg(feature = "onnxruntime")]
mod onnxruntime;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;

use self::nets::Nets;
use crate::job::{Cancelled, Job};
use crate::kernel::{Isa, peak};
use crate::synth::tract::{self, EngineError, Path, pool};
use crate::synth::{ModelError, ModelSource};

/// What is to be timed.
#[derive(Clone, Debug)]
pub struct Options {
    /// Width and height of the views, one pair per line of the report.
    pub sizes: Vec<[usize; 2]>,
    /// Timed runs of each size, after one to warm up; the report has their medians.
    pub runs: usize,
    /// Threads; 0 means one per processor core.
    pub threads: usize,
    /// Which code does the convolutions.
    pub path: Path,
    /// Without Winograd's algorithm.
    pub exact: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { sizes: vec![[270, 187], [540, 372]], runs: 5, threads: 0, path: Path::Auto, exact: false }
    }
}

impl Options {
    /// As the engine takes them.
    fn engine(&self) -> tract::Options {
        tract::Options { path: self.path, exact: self.exact, threads: self.threads, ..tract::Options::default() }
    }
}

/// The answer, in the shape of `bench --json`.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Processor, instructions, threads.
    pub machine: String,
    /// One entry per size.
    pub sizes: Vec<SizeReport>,
}

/// Medians at one size.
#[derive(Clone, Debug, Serialize)]
pub struct SizeReport {
    /// Columns of a view.
    pub width: usize,
    /// Rows of a view.
    pub height: usize,
    /// Rows and columns of the grid of views.
    pub views: [usize; 2],
    /// Useful operations of both nets, in 10⁹ (two per multiply-add).
    pub gflop: f64,
    /// Ours.
    pub seconds: Seconds,
    /// ONNX Runtime's; its total has our warp in it. `None` without the feature `onnxruntime`.
    pub onnxruntime_seconds: Option<OtherSeconds>,
    /// ONNX Runtime's total over ours.
    pub ratio: Option<f64>,
    /// The processor's measured f32 peak with these threads, GFLOP/s.
    pub peak_gflops: f64,
    /// `gflop` per second of the total, as a share of the peak.
    pub share_of_peak: f64,
    /// The depth net's operations per second of its own stage, as a share of the peak.
    pub depth_share_of_peak: f64,
    /// Peak memory of a process that ran only this size, MiB; `None` where nobody measured it.
    pub peak_rss_mib: Option<f64>,
}

/// Seconds of each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Seconds {
    /// The depth net.
    pub depth: f64,
    /// Lambertian rendering into the occlusion net's input.
    pub warp: f64,
    /// The occlusion net.
    pub occlusion: f64,
    /// All three.
    pub total: f64,
}

/// Seconds of another engine, which has no warp of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct OtherSeconds {
    /// The depth net.
    pub depth: f64,
    /// The occlusion net.
    pub occlusion: f64,
    /// Both, and our warp.
    pub total: f64,
}

/// Why nothing could be timed.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The models.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A net.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The file could not be read.
    #[error("the file cannot be read — {source} — check its name: {}", path.display())]
    Unreadable {
        /// Which file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// ONNX Runtime did not work.
    #[error("ONNX Runtime cannot be timed — {0} — set ORT_DYLIB_PATH to libonnxruntime.so of version 1.24 or later")]
    OnnxRuntime(String),
    /// Stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Times all sizes. Sizes and engines take turns, so that a noisy machine treats them alike.
pub fn run(models: &ModelSource, options: &Options, job: &Job) -> Result<Report, BenchError> {
    let pool = pool(options.threads)?;
    let threads = pool.current_num_threads();
    let isa = if options.path == Path::Avx2 { Isa::avx2().unwrap_or_default() } else { Isa::best() };
    let runners: Result<Vec<_>, _> = options.sizes.iter().map(|&size| Runner::new(models, options, size)).collect();
    let mut runners = runners?;
    let mut peaks = Vec::new();
    // The first round warms up.
    for round in 0..=options.runs.max(1) {
        peaks.push(peak::gflops(isa, threads, 20));
        for runner in &mut runners {
            runner.run(round > 0, job)?;
        }
    }
    let peak_gflops = median(peaks.into_iter());
    let sizes = runners.iter().map(|runner| runner.report(peak_gflops)).collect();
    let tiles = if options.engine().halves().is_some() { " and tiles" } else { "" };
    Ok(Report { machine: format!("{}, {isa}{tiles}, {threads} threads", processor()), sizes })
}

/// Runs the nets once at a size: for a process whose peak memory is then asked for.
pub fn once(models: &ModelSource, options: &Options, size: [usize; 2], job: &Job) -> Result<Seconds, BenchError> {
    Nets::new(models, options, size)?.run(job)
}

/// Both engines at one size, and how long they took.
struct Runner {
    size: [usize; 2],
    nets: Nets,
    other: Other,
    ours: Vec<Seconds>,
    theirs: Vec<[f64; 2]>,
}

impl Runner {
    fn new(models: &ModelSource, options: &Options, size: [usize; 2]) -> Result<Self, BenchError> {
        let nets = Nets::new(models, options, size)?;
        let other = Other::new(&nets, options)?;
        Ok(Self { size, nets, other, ours: Vec::new(), theirs: Vec::new() })
    }

    fn run(&mut self, counts: bool, job: &Job) -> Result<(), BenchError> {
        rest();
        let ours = self.nets.run(job)?;
        rest();
        let theirs = self.other.run()?;
        if counts {
            self.ours.push(ours);
            self.theirs.extend(theirs);
        }
        Ok(())
    }

    fn report(&self, peak_gflops: f64) -> SizeReport {
        let of = |stage: fn(&Seconds) -> f64| median(self.ours.iter().map(stage));
        let seconds = Seconds {
            depth: of(|s| s.depth),
            warp: of(|s| s.warp),
            occlusion: of(|s| s.occlusion),
            total: of(|s| s.total),
        };
        let onnxruntime_seconds = (!self.theirs.is_empty()).then(|| {
            let of = |stage: usize| median(self.theirs.iter().map(|seconds| seconds[stage]));
            let (depth, occlusion) = (of(0), of(1));
            OtherSeconds { depth, occlusion, total: depth + occlusion + seconds.warp }
        });
        let gflop = self.nets.flop() / 1e9;
        SizeReport {
            width: self.size[0],
            height: self.size[1],
            views: self.nets.views(),
            gflop,
            seconds,
            onnxruntime_seconds,
            ratio: onnxruntime_seconds.map(|other| other.total / seconds.total),
            peak_gflops,
            share_of_peak: gflop / seconds.total / peak_gflops,
            depth_share_of_peak: self.nets.depth_flop() / 1e9 / seconds.depth / peak_gflops,
            peak_rss_mib: None,
        }
    }
}

/// The engine to compare with.
struct Other {
    #[cfg(feature = "onnxruntime")]
    engine: onnxruntime::Engine,
}

impl Other {
    #[cfg(feature = "onnxruntime")]
    fn new(nets: &Nets, options: &Options) -> Result<Self, BenchError> {
        Ok(Self { engine: onnxruntime::Engine::new(nets, options.threads).map_err(BenchError::OnnxRuntime)? })
    }

    #[cfg(feature = "onnxruntime")]
    fn run(&mut self) -> Result<Option<[f64; 2]>, BenchError> {
        self.engine.run().map(Some).map_err(BenchError::OnnxRuntime)
    }

    #[cfg(not(feature = "onnxruntime"))]
    fn new(_nets: &Nets, _options: &Options) -> Result<Self, BenchError> {
        Ok(Self {})
    }

    #[cfg(not(feature = "onnxruntime"))]
    fn run(&mut self) -> Result<Option<[f64; 2]>, BenchError> {
        Ok(None)
    }
}

/// How long both engines rest before the other's turn: their threads look for work for a while after a run, and would
/// take a processor from it. ONNX Runtime's do for 20 to 50 ms.
const REST: Duration = Duration::from_millis(100);

/// Waits until no thread of an engine looks for work any more.
fn rest() {
    std::thread::sleep(REST);
}

/// Seconds that `f` takes, and its answer.
fn timed<R>(f: impl FnOnce() -> R) -> (f64, R) {
    let started = Instant::now();
    let answer = f();
    (started.elapsed().as_secs_f64(), answer)
}

/// The middle one; of an even number, the upper middle; of none, NaN.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The most memory this process has had, MiB; `None` where the system does not say.
pub fn peak_rss_mib() -> Option<f64> {
    line_of("/proc/self/status", "VmHWM:")
        .and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok())
        .map(|kib| kib / 1024.0)
}

fn processor() -> String {
    let name = line_of("/proc/cpuinfo", "model name");
    name.map_or_else(|| std::env::consts::ARCH.to_owned(), |name| name.trim_start_matches([' ', '\t', ':']).to_owned())
}

/// What follows `key` in the first line of a file that begins with it.
fn line_of(path: &str, key: &str) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    text.lines().find_map(|line| line.strip_prefix(key)).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle() {
        assert_eq!(median([3.0, 1.0, 2.0].into_iter()), 2.0);
        assert_eq!(median([3.0, 1.0, 2.0, 4.0].into_iter()), 3.0);
        assert!(median(std::iter::empty()).is_nan());
    }

    #[test]
    fn the_report_has_the_names_that_scripts_rely_on() {
        let size = SizeReport {
            width: 270,
            height: 187,
            views: [8, 8],
            gflop: 137.3,
            seconds: Seconds::default(),
            onnxruntime_seconds: None,
            ratio: None,
            peak_gflops: 200.0,
            share_of_peak: 0.7,
            depth_share_of_peak: 0.8,
            peak_rss_mib: None,
        };
        let report = Report { machine: "a machine".into(), sizes: vec![size] };
        let json = serde_json::to_value(&report).unwrap();
        let size = &json["sizes"][0];
        assert_eq!(json["machine"], "a machine");
        assert_eq!((&size["width"], &size["views"][1]), (&270.into(), &8.into()));
        for key in ["gflop", "seconds", "onnxruntime_seconds", "ratio", "peak_gflops", "peak_rss_mib"] {
            assert!(size.get(key).is_some(), "{key}");
        }
        assert_eq!((&size["share_of_peak"], &size["depth_share_of_peak"]), (&0.7.into(), &0.8.into()));
        for key in ["depth", "warp", "occlusion", "total"] {
            assert!(size["seconds"].get(key).is_some(), "{key}");
        }
    }
}
