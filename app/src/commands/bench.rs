//! `bench`: how fast the nets are here, against what the machine could do and, built for it, against ONNX Runtime.

use std::time::Instant;

use anyhow::{Result, anyhow, bail};
use clap::ValueEnum as _;
use plenoscope::bench::model::{ModelReport, USUAL_SIZE};
use plenoscope::bench::{self, Options, Report};
use plenoscope::io::{self, Opened};
use plenoscope::job::Job;
use plenoscope::synth::tract;
use plenoscope::synth::{ModelSource, SynthParams, Synthesizer};
use serde::Serialize;

use crate::cli::{Bench, EnginePath};
use crate::output::{say, say_json};
use crate::values::Size;

/// Times what was asked for and says it.
pub fn run(args: &Bench, job: &Job) -> Result<()> {
    let models = args.models.clone().map_or(ModelSource::Embedded, ModelSource::Folder);
    let (threads, path, exact) = (args.threads.into(), path(args.path), args.exact);
    let mut options = Options { threads, path, exact, ..Options::default() };
    if let Some(Size(size)) = args.once {
        bench::once(&models, &options, size.map(|side| side as usize), job)?;
        return say(&bench::peak_rss_mib().unwrap_or(f64::NAN).to_string());
    }
    if let Some(file) = &args.model {
        return model(file, &options, args, job);
    }
    if let Some(file) = &args.pipeline {
        return pipeline(file, &models, args, job);
    }
    if !args.size.is_empty() {
        options.sizes = args.size.iter().map(|size| size.0.map(|side| side as usize)).collect();
    }
    let mut report = bench::run(&models, &options, job)?;
    for size in &mut report.sizes {
        size.peak_rss_mib = peak_rss_mib(args, [size.width, size.height]);
    }
    if args.json { say_json(&report) } else { say(&describe(&report)) }
}

/// Which code does the convolutions.
fn path(path: EnginePath) -> tract::Path {
    match path {
        EnginePath::Auto => tract::Path::Auto,
        EnginePath::Avx512 => tract::Path::Avx512,
        EnginePath::Avx2 => tract::Path::Avx2,
        EnginePath::Portable => tract::Path::Portable,
        EnginePath::Stock => tract::Path::Stock,
    }
}

/// Peak memory of one run in a process of its own.
fn peak_rss_mib(args: &Bench, [width, height]: [usize; 2]) -> Option<f64> {
    let mut command = std::process::Command::new(std::env::current_exe().ok()?);
    command.args(["bench", "--once", &format!("{width}x{height}"), "--threads", &args.threads.to_string()]);
    if let Some(path) = args.path.to_possible_value() {
        command.args(["--path", path.get_name()]);
    }
    if args.exact {
        command.arg("--exact");
    }
    if let Some(models) = &args.models {
        command.arg("--models").arg(models);
    }
    let out = command.output().ok().filter(|out| out.status.success())?;
    String::from_utf8(out.stdout).ok()?.trim().parse::<f64>().ok().filter(|mib| mib.is_finite())
}

fn describe(report: &Report) -> String {
    let mut lines = vec![report.machine.clone()];
    for size in &report.sizes {
        let s = &size.seconds;
        lines.push(format!(
            "{}×{}×{}×{}  {:.3} s = depth {:.3} + warp {:.3} + occlusion {:.3};  \
             {:.1} µs a pixel, {:.0} GFLOP, {:.0} % of {:.0} GFLOP/s (the depth net {:.0} %)",
            size.width,
            size.height,
            size.views[0],
            size.views[1],
            s.total,
            s.depth,
            s.warp,
            s.occlusion,
            s.total * 1e6 / (size.width * size.height) as f64,
            size.gflop,
            size.share_of_peak * 100.0,
            size.peak_gflops,
            size.depth_share_of_peak * 100.0,
        ));
        if let (Some(other), Some(ratio)) = (&size.onnxruntime_seconds, size.ratio) {
            let (depth, occlusion) = (other.depth, other.occlusion);
            lines.push(format!("  ONNX Runtime depth {depth:.3} + occlusion {occlusion:.3} s: {ratio:.2} times ours"));
        }
        if let Some(mib) = size.peak_rss_mib {
            lines.push(format!("  peak memory {mib:.0} MiB"));
        }
    }
    lines.join("\n")
}

/// Lines of the profile that a person reads.
const PROFILE_LINES: usize = 30;

/// Times a net of somebody else.
fn model(file: &std::path::Path, options: &Options, args: &Bench, job: &Job) -> Result<()> {
    let size = args.size.first().map_or(USUAL_SIZE, |size| size.0.map(|side| side as usize));
    let report = bench::model::run(file, size, options, args.profile, job)?;
    if args.json {
        return say_json(&report);
    }
    let ModelReport { machine, input, output, prepare_seconds, seconds, .. } = &report;
    let mut lines =
        vec![machine.clone(), format!("{input:?} → {output:?}  {seconds:.3} s (made ready in {prepare_seconds:.2} s)")];
    if let (Some(other), Some(ratio)) = (report.onnxruntime_seconds, report.ratio) {
        let difference = report.difference.unwrap_or(f64::NAN);
        lines.push(format!(
            "  ONNX Runtime {other:.3} s: {ratio:.2} times ours; its map differs by {difference:.1e} deviations"
        ));
    }
    if let Some(mib) = report.peak_rss_mib {
        lines.push(format!("  peak memory {mib:.0} MiB"));
    }
    let profile = report.profile.iter().flatten().take(PROFILE_LINES);
    lines.extend(
        profile.map(|op| {
            format!("{:9.4} s, {:.4} of all threads {:4} × {}", op.seconds, op.cpu_seconds, op.count, op.name)
        }),
    );
    say(&lines.join("\n"))
}

/// What the product does with a photo.
#[derive(Debug, Serialize)]
struct PipelineReport {
    photo: [u32; 2],
    views: [u32; 2],
    open_seconds: f64,
    synth_seconds: f64,
}

/// Runs after one to warm up.
const RUNS: usize = 5;

fn pipeline(file: &std::path::Path, models: &ModelSource, args: &Bench, job: &Job) -> Result<()> {
    let nets = Synthesizer::load(models)?;
    let params = SynthParams { threads: args.threads.into(), ..SynthParams::default() };
    let (mut opened, mut made) = (Vec::new(), Vec::new());
    let mut sizes = None;
    for run in 0..=RUNS {
        let started = Instant::now();
        let Opened::Photo(photo) = io::open(file, job)? else {
            bail!("this is a light field — the pipeline starts with a photo — name one: {}", file.display());
        };
        let open = started.elapsed().as_secs_f64();
        let synthesis = nets.synthesize(&photo.photo, &params, job)?;
        sizes = Some((photo.photo.size(), synthesis.field.size()));
        if run > 0 {
            opened.push(open);
            made.push(synthesis.took.as_secs_f64());
        }
    }
    let (photo, views) = sizes.ok_or_else(|| anyhow!("nothing was timed — try again"))?;
    let report = PipelineReport {
        photo,
        views,
        open_seconds: bench::median(opened.into_iter()),
        synth_seconds: bench::median(made.into_iter()),
    };
    if args.json {
        return say_json(&report);
    }
    let ([w, h], [vw, vh]) = (report.photo, report.views);
    say(&format!(
        "{w}×{h} photo: open {:.3} s, {vw}×{vh} light field {:.3} s",
        report.open_seconds, report.synth_seconds
    ))
}
