//! Twelve crops at 1:1 of edges that are hard for a lens of software, beside what a lens would have seen.
//! `cargo bench --bench crops` prints the table of `docs/edges.md` and writes the pictures into `target/crops`.
//!
//! The scenes are painted surfaces one behind the other, on a photo of 12 megapixels. The true picture adds what many eyes
//! on the lens see. The renderer gets the photo, and the scene's depth made as imperfect as nets make it: coarse,
//! without its thin parts, beside its place by two pixels of the map, and wrong in specks over 5 % of it.

#[path = "../tests/common/chance.rs"]
mod chance;
#[path = "crops/scenes.rs"]
mod scenes;
#[path = "crops/sprite.rs"]
mod sprite;

use std::path::Path;
use std::sync::Arc;

use plenoscope::field::color::srgb8_from_linear;
use plenoscope::field::{DisparityMap, FocalPlane, Lens, Photo, Picture, View};
use plenoscope::job::{Cancel, Job};
use plenoscope::render::lens::{Region, Rgbd};
use plenoscope::synth::upsample;
use rayon::prelude::*;

use chance::hash;
use scenes::Scene;

/// The photo, and what of it each scene takes: four beside each other, three of them below each other.
const PHOTO: [u32; 2] = [4000, 3000];
const CELL: u32 = 1000;
/// Side of a crop, pixels.
const CROP: u32 = 384;
const MAP: [u32; 2] = [540, 405];
/// What a net works at, and the window of photo pixels that each of its values is the median of.
const NET: [u32; 2] = [180, 135];
const WINDOW_PX: f32 = 36.0;
/// How far beside its place the depth is, in pixels of the map.
const OFF_PX: [f32; 2] = [2.0, -1.0];
/// A camera's softness: side of the square that a pixel sees.
const SOFT_PX: f32 = 1.5;
/// Rows and columns of eyes on the lens.
const EYES: i32 = 25;
/// Side of the blocks of which the worst is told.
const BLOCK: usize = 16;

#[allow(clippy::print_stdout, reason = "a table belongs on stdout")]
fn main() {
    let scenes = scenes::all();
    let photo = photo(&scenes);
    let job = Job { cancel: &Cancel::default(), sink: &() };
    let prepare = |map: DisparityMap| {
        Rgbd::new(Arc::clone(&photo), map).expect("a scene").prepare(PHOTO, job.cancel).expect("nobody stops it")
    };
    let (exact, imperfect) = (true_map(&scenes), imperfect_map(&scenes, &photo, &job));
    let prepared = [exact, imperfect].map(prepare);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/crops");
    std::fs::create_dir_all(&folder).expect("a folder for the crops");
    println!("| crop | true map, dB | imperfect map, dB | its worst block, steps |\n|---|---|---|---|");
    let mut sums = [0.0; 3];
    for (n, scene) in scenes.iter().enumerate() {
        let corner = [n as u32 % 4, n as u32 / 4].map(|at| at * CELL + (CELL - CROP) / 2);
        let focus = FocalPlane { disparity_px: scene.focus_px, ..FocalPlane::default() };
        let lens = Lens { focus, ..Lens::default() };
        let region = Region { at: corner, size: [CROP; 2] };
        let truth = truth(scene, &lens);
        let [best, ours] = [0, 1].map(|map| prepared[map].render(&lens, region, &job).expect("nobody stops it"));
        let errors = [&best, &ours].map(|picture| errors(picture, &truth));
        let figures = [errors[0].0, errors[1].0, errors[1].1];
        println!("| {} | {:.1} | {:.1} | {:.1} |", scene.name, figures[0], figures[1], figures[2]);
        sums = [0, 1, 2].map(|i| sums[i] + figures[i] / scenes.len() as f32);
        let before = crop(&photo, corner);
        save(&folder.join(format!("{}.png", scene.name)), &[before, ours, truth, best]);
    }
    println!("| mean | {:.1} | {:.1} | {:.1} |", sums[0], sums[1], sums[2]);
    println!("Pictures: photo, ours, truth, ours of the true map: {}", folder.display());
}

/// The colour that a ray from `eye` sees, and its surface's disparity. `at`: from the scene's middle, photo pixels.
fn seen(scene: &Scene, at: [f32; 2], eye: [f32; 2], focus_px: f32) -> ([f32; 3], f32) {
    let scale = PHOTO[0] as f32 / MAP[0] as f32;
    let on = |disparity: f32| [0, 1].map(|axis| at[axis] + eye[axis] * (disparity - focus_px) * scale);
    let sees = |layer: &scenes::Layer| Some((layer.sprite.at(on(layer.disparity_px))?, layer.disparity_px));
    scene.layers.iter().find_map(sees).expect("the last surface is everywhere")
}

fn photo(scenes: &[Scene]) -> Arc<Photo> {
    const TAPS: i32 = 4;
    let row = |y: u32| -> Vec<u8> {
        let pixel = |x: u32| {
            let (scene, at) = local(scenes, [x as f32, y as f32]);
            let mut sum = [0.0; 3];
            for tap in 0..TAPS * TAPS {
                let by = [tap % TAPS, tap / TAPS].map(|n| ((n as f32 + 0.5) / TAPS as f32 - 0.5) * SOFT_PX);
                let (light, _) = seen(scene, [at[0] + by[0], at[1] + by[1]], [0.0; 2], 0.0);
                sum = [0, 1, 2].map(|c| sum[c] + light[c] / (TAPS * TAPS) as f32);
            }
            let [r, g, b] = sum.map(srgb8_from_linear);
            [r, g, b, 255]
        };
        (0..PHOTO[0]).flat_map(pixel).collect()
    };
    let rows: Vec<Vec<u8>> = (0..PHOTO[1]).into_par_iter().map(row).collect();
    Arc::new(Photo::from_srgb8(PHOTO, rows.concat()).expect("a photo"))
}

/// The scene at a place of the photo, and where that is from the scene's middle.
fn local(scenes: &[Scene], at: [f32; 2]) -> (&Scene, [f32; 2]) {
    let cell = [0, 1].map(|axis| (at[axis].max(0.0) as u32 / CELL).min(PHOTO[axis] / CELL - 1));
    let middle = cell.map(|cell| (cell * CELL + CELL / 2) as f32);
    (&scenes[(cell[1] * 4 + cell[0]) as usize], [at[0] - middle[0], at[1] - middle[1]])
}

fn depth(scenes: &[Scene], at: [f32; 2]) -> f32 {
    let (scene, at) = local(scenes, at);
    seen(scene, at, [0.0; 2], 0.0).1
}

fn map_of(size: [u32; 2], value: impl Fn([f32; 2]) -> f32 + Sync) -> DisparityMap {
    let scale = PHOTO[0] as f32 / size[0] as f32;
    let place = |i: u32| [i % size[0], i / size[0]].map(|at| (at as f32 + 0.5) * scale - 0.5);
    let values = (0..size[0] * size[1]).into_par_iter().map(|i| value(place(i)));
    DisparityMap::new(size, values.collect()).expect("a map")
}

fn true_map(scenes: &[Scene]) -> DisparityMap {
    map_of(MAP, |at| depth(scenes, at))
}

/// The map that a net would give.
fn imperfect_map(scenes: &[Scene], photo: &Photo, job: &Job) -> DisparityMap {
    let scale = PHOTO[0] as f32 / MAP[0] as f32;
    let coarse = map_of(NET, |at| {
        const TAPS: i32 = 9;
        let tap = |n: i32| [n % TAPS, n / TAPS].map(|n| ((n as f32 + 0.5) / TAPS as f32 - 0.5) * WINDOW_PX);
        let place = |by: [f32; 2]| [0, 1].map(|axis| at[axis] + by[axis] - OFF_PX[axis] * scale);
        let mut depths: Vec<f32> = (0..TAPS * TAPS).map(|n| depth(scenes, place(tap(n)))).collect();
        let middle = depths.len() / 2;
        *depths.select_nth_unstable_by(middle, f32::total_cmp).1
    });
    // As wide as a net's own map, and in its pixels.
    let coarse =
        DisparityMap::new(NET, coarse.disparity_px().iter().map(|d| d * NET[0] as f32 / MAP[0] as f32).collect());
    let guided = upsample::to_guide(&coarse.expect("a map"), &reduced(photo), job).expect("nobody stops it");
    let speck = |x: i32, y: i32, seed| hash(x / 2, y / 2, seed);
    let value = |(i, d): (usize, &f32)| {
        let (x, y) = (i as i32 % MAP[0] as i32, i as i32 / MAP[0] as i32);
        if speck(x, y, 11) < 0.05 { d + 0.6 * (speck(x, y, 12) - 0.5) } else { *d }
    };
    DisparityMap::new(MAP, guided.disparity_px().iter().enumerate().map(value).collect()).expect("a map")
}

/// The photo at the map's size.
fn reduced(photo: &Photo) -> View {
    let rows = (0..MAP[1]).flat_map(|y| (0..MAP[0]).map(move |x| [x, y]));
    let scale = PHOTO[0] as f32 / MAP[0] as f32;
    let mean = |[x, y]: [u32; 2]| {
        let from = [x, y].map(|at| (at as f32 * scale) as u32);
        let pixel = |n: u32| ((from[1] + n / 7) * PHOTO[0] + from[0] + n % 7) as usize * 4;
        let channel = |c: usize| (0..49).map(|n| u32::from(photo.srgb8()[pixel(n) + c])).sum::<u32>() / 49;
        [channel(0) as u8, channel(1) as u8, channel(2) as u8, 255]
    };
    View::new(MAP, rows.flat_map(mean).collect()).expect("a view")
}

/// What a lens sees: the mean over eyes on its disc, each pixel with its own places for them.
fn truth(scene: &Scene, lens: &Lens) -> Picture {
    let radius = lens.f_number.added_views() / 2.0;
    let pixels: Vec<[f32; 3]> = (0..CROP * CROP)
        .into_par_iter()
        .map(|i| {
            let [x, y] = [i % CROP, i / CROP];
            let at = [x, y].map(|at| at as f32 - CROP as f32 / 2.0);
            let random = |n: i32, seed| hash((i as i32).wrapping_mul(977) + n, n, seed);
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for n in 0..EYES * EYES {
                let on = [n % EYES, n / EYES];
                let eye = [0, 1].map(|a| (on[a] as f32 + random(n, 3 + a as u32)) / EYES as f32 * 2.0 - 1.0);
                if eye[0].hypot(eye[1]) > 1.0 {
                    continue;
                }
                let by = [0, 1].map(|a| at[a] + (random(n, 5 + a as u32) - 0.5) * SOFT_PX);
                let (light, _) = seen(scene, by, eye.map(|e| e * radius), scene.focus_px);
                sum = [0, 1, 2].map(|c| sum[c] + light[c]);
                count += 1.0;
            }
            sum.map(|v| v / count)
        })
        .collect();
    Picture { size: [CROP; 2], rgb_linear: pixels.concat() }
}

/// Peak signal over the error in dB, and the root mean square of the worst block in steps of 8 bits.
fn errors(picture: &Picture, truth: &Picture) -> (f32, f32) {
    let stored = |picture: &Picture| -> Vec<f32> {
        picture.rgb_linear.iter().map(|v| f32::from(srgb8_from_linear(*v))).collect()
    };
    let (a, b) = (stored(picture), stored(truth));
    let side = CROP as usize / BLOCK;
    let mut blocks = vec![0.0f32; side * side];
    for (i, (a, b)) in a.iter().zip(&b).enumerate() {
        let (x, y) = (i / 3 % CROP as usize, i / 3 / CROP as usize);
        blocks[y / BLOCK * side + x / BLOCK] += (a - b).powi(2) / (3 * BLOCK * BLOCK) as f32;
    }
    let mean = blocks.iter().sum::<f32>() / blocks.len() as f32;
    (10.0 * (255.0f32.powi(2) / mean).log10(), blocks.iter().copied().fold(0.0, f32::max).sqrt())
}

fn crop(photo: &Photo, [left, top]: [u32; 2]) -> Picture {
    let linear = |v: u8| plenoscope::field::color::linear_from_srgb(f32::from(v) / 255.0);
    Picture::from_fn([CROP; 2], |x, y| {
        let at = ((top + y) * PHOTO[0] + left + x) as usize * 4;
        [0, 1, 2].map(|c| linear(photo.srgb8()[at + c]))
    })
}

/// Pictures beside each other as a PNG.
fn save(path: &Path, pictures: &[Picture]) {
    let side = CROP as usize;
    let bytes: Vec<Vec<u8>> = pictures.iter().map(Picture::to_srgb8).collect();
    let rows = (0..side).flat_map(|y| bytes.iter().map(move |picture| &picture[y * side * 4..(y + 1) * side * 4]));
    let all: Vec<u8> = rows.flatten().copied().collect();
    let file = std::fs::File::create(path).expect("a file");
    let mut encoder = png::Encoder::new(file, CROP * pictures.len() as u32, CROP);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&all)).expect("a picture");
}
