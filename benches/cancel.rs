//! How soon long work stops when it is asked to: `cargo bench --bench cancel`.
//!
//! Each job is begun again and again and stopped at moments spread evenly over the time that it takes: a light field of the
//! sample, and a large photo made ready for the lens and refocused.

use std::sync::Arc;
use std::time::{Duration, Instant};

use plenoscope::field::{DisparityMap, Lens, Photo};
use plenoscope::io::sample;
use plenoscope::job::{Cancel, Job};
use plenoscope::render::lens::{self, Rgbd};
use plenoscope::synth::{ModelSource, SynthParams, Synthesizer};

/// A large photo: 54 megapixels.
const LARGE: [u32; 2] = [9000, 6000];

fn main() {
    let synthesizer = Synthesizer::load(&ModelSource::Embedded).expect("the shipped nets load");
    let photo = sample::sample().expect("the sample is drawn").photo;
    let params = SynthParams::default();
    tell("a light field", 60, &|cancel| synthesizer.synthesize(&photo, &params, &quiet(cancel)).is_err());
    let large = large();
    tell("54 megapixels refocused", 30, &|cancel| {
        lens::render_pixels(&large, &Lens::default(), LARGE, 8, &quiet(cancel)).is_err()
    });
}

fn quiet(cancel: &Cancel) -> Job<'_> {
    Job { cancel, sink: &() }
}

/// A textured photo with a step of depth.
fn large() -> Rgbd {
    let [width, height] = LARGE;
    let value = |x: u32, y: u32| ((x * 7 + y * 13) % 97 + 60) as u8;
    let rgba = (0..height).flat_map(|y| (0..width).flat_map(move |x| [value(x, y), value(y, x), 90, 255]));
    let photo = Photo::from_srgb8(LARGE, rgba.collect()).expect("a photo");
    let map = (0..540 * 360).map(|i| if i % 540 < 270 { 1.0 } else { -1.0 });
    Rgbd::new(Arc::new(photo), DisparityMap::new([540, 360], map.collect()).expect("a map")).expect("a scene")
}

/// Prints how long a job goes on after so many stops; `run` says whether it was stopped.
#[allow(clippy::print_stdout, reason = "a benchmark's answer")]
fn tell(name: &str, stops: u32, run: &(dyn Fn(&Cancel) -> bool + Sync)) {
    assert!(!run(&Cancel::default()), "nobody stops it");
    let started = Instant::now();
    run(&Cancel::default());
    let whole = started.elapsed();
    let mut latencies: Vec<Duration> = (0..stops).filter_map(|stop| stopped_after(whole * stop / stops, run)).collect();
    latencies.sort_unstable();
    let (Some(median), Some(longest)) = (latencies.get(latencies.len() / 2), latencies.last()) else { return };
    println!("{name}: {whole:.2?} in all; {} stops: median {median:.1?}, longest {longest:.1?}", latencies.len());
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
