//! Mending depth by hand: what a hand waits for. `cargo bench --bench repair`.
//!
//! A stroke's sample is to be ready within a frame, 16 ms, at the size of the usual map and of one twice as wide.

use divan::Bencher;
use plenoscope::field::{DisparityMap, View};
use plenoscope::job::{Cancel, Job};
use plenoscope::repair::{Brush, Guide, Mender, Operation, Region, Repair, mended};

fn main() {
    divan::main();
}

/// A bright disc with a hole in its depth before a textured ground.
fn parts(width: u32) -> (DisparityMap, Guide) {
    let size = [width, width * 3 / 4];
    let places = move || (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| (x, y)));
    let far = |x: u32, y: u32| (x as f32 / width as f32 - 0.5).hypot(y as f32 / width as f32 - 0.375);
    let grain = |x: u32, y: u32| ((x * 7 + y * 13) % 11) as u8;
    let colour = |(x, y): (u32, u32)| match far(x, y) < 0.25 {
        true => [220 + grain(x, y), 180, 60, 255],
        false => [40 + grain(x, y), 90, 50 + grain(y, x), 255],
    };
    let depth = |(x, y): (u32, u32)| if (0.1..0.25).contains(&far(x, y)) { 1.0 } else { -1.0 };
    let view = View::new(size, places().flat_map(colour).collect()).expect("a view");
    (DisparityMap::new(size, places().map(depth).collect()).expect("a map"), Guide::new(&view, size))
}

/// One more point of a stroke a tenth of the picture wide, a hand's way from the last.
#[divan::bench(args = [540, 1080], consts = [0, 1, 2, 3])]
fn stroke_sample<const BRUSH: usize>(bencher: Bencher, width: u32) {
    let (map, guide) = parts(width);
    let mender = Mender::new(&map, guide);
    let begun = || {
        let mut mender = mender.clone();
        let mut draft = mender.begin(Brush::ALL[BRUSH], 0.1, 1.0);
        let _changed = mender.extend(&mut draft, [0.45, 0.5]);
        (mender, draft)
    };
    bencher.with_inputs(begun).bench_local_values(|(mut mender, mut draft)| {
        let changed = mender.extend(&mut draft, [0.48, 0.5]);
        (changed, mender, draft)
    });
}

/// A click's region, and what is done to it.
#[divan::bench(args = [540, 1080])]
fn click(bencher: Bencher, width: u32) {
    let (map, guide) = parts(width);
    let repair = Repair::Region { of: Region::Click { at: [0.5, 0.5], size: 0.2 }, what: Operation::Join };
    let job = Job { cancel: &Cancel::default(), sink: &() };
    bencher.bench_local(|| mended(&map, guide.clone(), &[&repair], &job));
}
