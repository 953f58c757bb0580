//! Any ONNX file that takes a picture, in the program's engine and, with the feature `onnxruntime`, in ONNX Runtime.

use std::path::Path;

use serde::Serialize;

use super::nets::numbers;
use super::{BenchError, Options, median, peak_rss_mib, processor, rest, timed};
use crate::job::Job;
use crate::synth::tract::{OnnxBytes, OnnxFile, OpSeconds, Output, Runnable, picture_shape, pool, prepare_file};

/// Width and height of the picture where the file leaves them open.
pub const USUAL_SIZE: [usize; 2] = [518, 392];

/// The answer, in the shape of `bench --model FILE --json`.
#[derive(Clone, Debug, Serialize)]
pub struct ModelReport {
    /// Processor and threads.
    pub machine: String,
    /// Lengths of the axes of the input.
    pub input: Vec<usize>,
    /// Lengths of the axes of the output.
    pub output: Vec<usize>,
    /// Seconds from the file to a net that can run.
    pub prepare_seconds: f64,
    /// Seconds of one run, the median.
    pub seconds: f64,
    /// ONNX Runtime's. `None` without the feature `onnxruntime`.
    pub onnxruntime_seconds: Option<f64>,
    /// ONNX Runtime's over ours.
    pub ratio: Option<f64>,
    /// The largest difference between the two outputs, in standard deviations of ONNX Runtime's.
    pub difference: Option<f64>,
    /// The most memory that the process had before ONNX Runtime was loaded, MiB.
    pub peak_rss_mib: Option<f64>,
    /// Seconds by operation of one more run, if they were asked for.
    pub profile: Option<Vec<OpSeconds>>,
}

/// Times the net in `file` on a made picture of `size` (width, height). The engines take turns.
pub fn run(
    file: &Path,
    size: [usize; 2],
    options: &Options,
    profile: bool,
    job: &Job,
) -> Result<ModelReport, BenchError> {
    let threads = pool(options.threads)?.current_num_threads();
    let (input, prepare_seconds, net) = ready(file, size, options)?;
    let picture = numbers(input.iter().product());
    let mut output = net.run(&picture, job.cancel)?;
    let peak_rss_mib = peak_rss_mib();
    let mut other = Other::new(file, &input, threads)?;
    let (mut ours, mut theirs, mut answer) = (Vec::new(), Vec::new(), None);
    // The first round warms up.
    for round in 0..=options.runs.max(1) {
        rest();
        let (took, made) = timed(|| net.run(&picture, job.cancel));
        output = made?;
        rest();
        let other = other.run(&picture)?;
        if round > 0 {
            ours.push(took);
            theirs.extend(other.iter().map(|(took, _)| *took));
        }
        answer = other.map(|(_, values)| values);
    }
    let seconds = median(ours.into_iter());
    let onnxruntime_seconds = (!theirs.is_empty()).then(|| median(theirs.into_iter()));
    Ok(ModelReport {
        machine: format!("{}, {threads} threads", processor()),
        input,
        output: output.shape().to_vec(),
        prepare_seconds,
        seconds,
        onnxruntime_seconds,
        ratio: onnxruntime_seconds.map(|other| other / seconds),
        difference: answer.map(|values| difference(&output, &values)),
        peak_rss_mib,
        profile: profile.then(|| net.profile(&picture)).transpose()?,
    })
}

/// The shape of the input, the seconds it took to make the net ready for it, and the net.
fn ready(file: &Path, size: [usize; 2], options: &Options) -> Result<(Vec<usize>, f64, Runnable), BenchError> {
    let unreadable = |source| BenchError::Unreadable { path: file.to_owned(), source };
    std::fs::File::open(file).map_err(unreadable)?;
    let input = picture_shape(OnnxBytes::File(file), size)?;
    let (took, net) = timed(|| prepare_file(&OnnxFile::on_disk(file), &input, &options.engine()));
    Ok((input, took, net?))
}

/// The largest difference in standard deviations of `other`; infinite where the lengths differ.
fn difference(ours: &Output, other: &[f32]) -> f64 {
    if ours.len() != other.len() {
        return f64::INFINITY;
    }
    let n = other.len() as f64;
    let mean = other.iter().map(|value| f64::from(*value)).sum::<f64>() / n;
    let variance = other.iter().map(|value| (f64::from(*value) - mean).powi(2)).sum::<f64>() / n;
    let largest = ours.iter().zip(other).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
    largest / variance.sqrt()
}

/// The engine to compare with.
struct Other {
    #[cfg(feature = "onnxruntime")]
    net: super::onnxruntime::Single,
}

impl Other {
    #[cfg(feature = "onnxruntime")]
    fn new(file: &Path, shape: &[usize], threads: usize) -> Result<Self, BenchError> {
        let net = super::onnxruntime::Single::new(file, shape, threads).map_err(BenchError::OnnxRuntime)?;
        Ok(Self { net })
    }

    /// Seconds and values.
    #[cfg(feature = "onnxruntime")]
    fn run(&mut self, input: &[f32]) -> Result<Option<(f64, Vec<f32>)>, BenchError> {
        self.net.run(input).map(Some).map_err(BenchError::OnnxRuntime)
    }

    #[cfg(not(feature = "onnxruntime"))]
    fn new(_file: &Path, _shape: &[usize], _threads: usize) -> Result<Self, BenchError> {
        Ok(Self {})
    }

    #[cfg(not(feature = "onnxruntime"))]
    fn run(&mut self, _input: &[f32]) -> Result<Option<(f64, Vec<f32>)>, BenchError> {
        Ok(None)
    }
}
