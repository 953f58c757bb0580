//! The lens renderer: time over pixels, and over the diameter of the blur. `cargo bench --bench lens`.
//!
//! Both tables are to be read along: twice the pixels may take twice as long, twice the diameter at most twice as long.

use std::sync::Arc;

use divan::Bencher;
use plenoscope::field::{DisparityMap, FocalPlane, Lens, Photo};
use plenoscope::job::{Cancel, Job};
use plenoscope::render::lens::{Prepared, Region, Rgbd};

fn main() {
    divan::main();
}

/// Textured ground at disparity −1 with posts at 1 before it, a third of the picture.
fn posts(width: u32) -> Prepared {
    let size = [width, width * 3 / 4];
    let is_post = |x: u32, y: u32| (x / (width / 12)).is_multiple_of(3) && y > size[1] / 3;
    let all = || (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| (x, y)));
    let value = |x: u32, y: u32, seed: u32| ((x * 7 + y * 13 + seed * 31) % 97 + 60) as u8;
    let rgba = all().flat_map(|(x, y)| [value(x, y, 1), value(x, y, 2), value(y, x, 3), 255]);
    let photo = Photo::from_srgb8(size, rgba.collect()).expect("a photo");
    let map_size = [540, 405];
    let cells = (0..map_size[1]).flat_map(|y| (0..map_size[0]).map(move |x| (x, y)));
    let scale = |x: u32, y: u32| [x * size[0] / map_size[0], y * size[1] / map_size[1]];
    let map = cells.map(|(x, y)| {
        let [x, y] = scale(x, y);
        if is_post(x, y) { 1.0 } else { -1.0 }
    });
    let map = DisparityMap::new(map_size, map.collect()).expect("a map");
    Rgbd::new(Arc::new(photo), map).expect("a scene").prepare(size, &Cancel::default()).expect("nobody stops it")
}

/// All that a lens focused between ground and posts makes of it; the added blur is `diameter_px` everywhere.
fn render(prepared: &Prepared, diameter_px: f32) {
    let focus = FocalPlane { disparity_px: 0.0, ..FocalPlane::default() };
    let views = diameter_px * 540.0 / prepared.size()[0] as f32;
    let f_number = plenoscope::field::FNumber(28.0 / views.hypot(1.0));
    let lens = Lens { f_number, focus, ..Lens::default() };
    let whole = Region { at: [0; 2], size: prepared.size() };
    let job = Job { cancel: &Cancel::default(), sink: &() };
    divan::black_box(prepared.render(&lens, whole, &job)).expect("not stopped");
}

#[divan::bench(args = [700, 1000, 1400, 2000, 2800, 4000], sample_count = 3)]
fn width_px(bencher: Bencher, width: u32) {
    let prepared = posts(width);
    bencher.bench(|| render(&prepared, 24.0));
}

#[divan::bench(args = [4, 8, 16, 32, 64, 128, 256], sample_count = 3)]
fn diameter_px(bencher: Bencher, diameter_px: u32) {
    // A wide photo, so that the widest lens blurs it as much as is asked for.
    let prepared = posts(5000);
    bencher.bench(|| render(&prepared, diameter_px as f32));
}
