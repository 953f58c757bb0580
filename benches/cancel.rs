//! How soon a synthesis stops when it is asked to: `cargo bench --bench cancel`.
//!
//! The sample's light field is begun again and again and stopped at moments spread evenly over the time that it takes.

use std::time::{Duration, Instant};

use plenoscope::io::sample;
use plenoscope::job::{Cancel, Job};
use plenoscope::synth::{ModelSource, SynthParams, Synthesizer};

const STOPS: u32 = 60;

#[allow(clippy::print_stdout, reason = "a benchmark's answer")]
fn main() {
    let synthesizer = Synthesizer::load(&ModelSource::Embedded).expect("the shipped nets load");
    let photo = sample::sample().expect("the sample is drawn").photo;
    let params = SynthParams::default();
    let run = |cancel: &Cancel| synthesizer.synthesize(&photo, &params, &Job { cancel, sink: &() });
    run(&Cancel::default()).expect("not stopped");
    let started = Instant::now();
    run(&Cancel::default()).expect("not stopped");
    let whole = started.elapsed();
    let mut latencies: Vec<Duration> =
        (0..STOPS).filter_map(|stop| stopped_after(whole * stop / STOPS, &|cancel| run(cancel).is_err())).collect();
    latencies.sort_unstable();
    let (Some(median), Some(longest)) = (latencies.get(latencies.len() / 2), latencies.last()) else { return };
    println!("{whole:.2?} in all; {} stops: median {median:.1?}, longest {longest:.1?}", latencies.len());
}

/// How long a job goes on after it was asked to stop; none where it was done before that.
fn stopped_after(delay: Duration, run: &(dyn Fn(&Cancel) -> bool + Sync)) -> Option<Duration> {
    let cancel = Cancel::default();
    std::thread::scope(|scope| {
        let job = scope.spawn(|| (run(&cancel), Instant::now()));
        std::thread::sleep(delay);
        let asked = Instant::now();
        cancel.cancel();
        let (was_stopped, ended) = job.join().ok()?;
        was_stopped.then(|| ended.saturating_duration_since(asked))
    })
}
