//! The whole way from a photo to a light field, on small random nets written in the test.
#![allow(clippy::unwrap_used, reason = "in a test a panic is the failure")]

#[path = "pipeline/edges.rs"]
mod edges;
#[path = "common/nets.rs"]
mod nets;
#[path = "pipeline/relative.rs"]
mod relative;

use std::path::Path;
use std::sync::Mutex;

use nets::Layer;
use plenoscope::field::{DisparityMap, Photo, RayDepths, RelativeDepth, View, ViewGrid, ViewIndex};
use plenoscope::job::{Cancel, Job, Progress, Sink, Stage};
use plenoscope::synth::cache::Cache;
use plenoscope::synth::range::Estimate;
use plenoscope::synth::{
    DepthSource, ModelError, ModelSource, Scale, SynthError, SynthParams, Synthesizer, lift, reference_view,
};

/// A photo with enough structure to tell left from right and up from down.
fn photo(width: u32, height: u32) -> Photo {
    let pixel = |i: u32| {
        let (x, y) = (i % width, i / width);
        [(x * 7 % 256) as u8, (y * 5 % 256) as u8, ((x / 8 + y / 8) % 2 * 200) as u8, 255]
    };
    Photo::from_srgb8([width, height], (0..width * height).flat_map(pixel).collect()).unwrap()
}

/// Writes a depth and an occlusion net with their manifests.
fn models(folder: &Path) -> ModelSource {
    nets::write_pair(folder, 1);
    ModelSource::Folder(folder.to_owned())
}

/// Keeps what it hears; stops the job at the first view beside the reference if asked to.
#[derive(Default)]
struct Recorder {
    heard: Mutex<Vec<Heard>>,
    stop_at_first_view: Option<Cancel>,
}

#[derive(Clone, Debug, PartialEq)]
enum Heard {
    Depths,
    View(ViewIndex),
    Stage(Stage),
}

impl Sink for Recorder {
    fn progress(&self, progress: Progress) {
        assert!(progress.done <= progress.total);
        self.heard.lock().unwrap().push(Heard::Stage(progress.stage));
    }
    fn depths(&self, _: &std::sync::Arc<RayDepths>) {
        self.heard.lock().unwrap().push(Heard::Depths);
    }
    fn view(&self, at: ViewIndex, _: &std::sync::Arc<View>) {
        let reference = at == ViewGrid::PAPER.reference();
        self.heard.lock().unwrap().push(Heard::View(at));
        if let Some(cancel) = self.stop_at_first_view.as_ref().filter(|_| !reference) {
            cancel.cancel();
        }
    }
}

#[test]
fn the_photo_comes_first_then_ray_depths_then_views_from_the_middle_then_corrected_ones() {
    let folder = tempfile::tempdir().unwrap();
    let synthesizer = Synthesizer::load(&models(folder.path())).unwrap();
    let (cancel, recorder) = (Cancel::default(), Recorder::default());
    let photo = photo(53, 37);
    let made =
        synthesizer.synthesize(&photo, &SynthParams::default(), &Job { cancel: &cancel, sink: &recorder }).unwrap();
    assert_eq!(made.field.size(), [53, 37]);
    assert_eq!(made.field.reference().rgba(), &photo.srgb8()[..], "the reference view is the photo");
    assert_eq!(made.models.len(), 2);
    let heard = recorder.heard.into_inner().unwrap();
    let views: Vec<ViewIndex> =
        heard.iter().filter_map(|h| if let Heard::View(at) = h { Some(*at) } else { None }).collect();
    let spiral = ViewGrid::PAPER.spiral();
    assert_eq!(views[0], spiral[0]);
    assert_eq!(views[1..65], spiral[..]);
    assert_eq!(views[65..], spiral[..]);
    let first = |what: &Heard| heard.iter().position(|h| h == what).unwrap();
    assert!(first(&Heard::View(spiral[0])) < first(&Heard::Depths));
    assert!(first(&Heard::Depths) < first(&Heard::View(spiral[1])));
    assert!(first(&Heard::Stage(Stage::Depth)) < first(&Heard::Stage(Stage::Warp)));
    assert!(first(&Heard::Stage(Stage::Warp)) < first(&Heard::Stage(Stage::Occlusion)));
}

#[test]
fn a_job_that_is_stopped_at_its_first_view_gives_no_light_field() {
    let folder = tempfile::tempdir().unwrap();
    let synthesizer = Synthesizer::load(&models(folder.path())).unwrap();
    let cancel = Cancel::default();
    let recorder = Recorder { stop_at_first_view: Some(cancel.clone()), ..Recorder::default() };
    let params = SynthParams { threads: 1, ..SynthParams::default() };
    let result = synthesizer.synthesize(&photo(40, 30), &params, &Job { cancel: &cancel, sink: &recorder });
    assert!(matches!(result, Err(SynthError::Cancelled(_))));
    let heard = recorder.heard.into_inner().unwrap();
    assert!(!heard.contains(&Heard::Stage(Stage::Occlusion)), "the occlusion net was begun after the stop");
}

#[test]
fn a_disparity_map_takes_the_nets_place_with_the_sign_and_the_scale_of_the_convention() {
    let folder = tempfile::tempdir().unwrap();
    let synthesizer = Synthesizer::load(&models(folder.path())).unwrap();
    let photo = photo(60, 40);
    // 0.5 px at 30 px wide is 1 px at 60 px wide.
    let disparity = Some(DisparityMap::constant([30, 20], 0.5).into());
    let params = SynthParams { disparity, occlusion: false, ..SynthParams::default() };
    let cancel = Cancel::default();
    let made = synthesizer.synthesize(&photo, &params, &Job { cancel: &cancel, sink: &() }).unwrap();
    assert!(made.models.is_empty(), "no net took part");
    for at in ViewGrid::PAPER.views() {
        let o = ViewGrid::PAPER.offset(at);
        let (x, y) = (30, 20);
        let seen = made.field.reference().pixel((x as f32 + o.du) as u32, (y as f32 + o.dv) as u32);
        assert_eq!(made.field.view(at).pixel(x, y), seen, "view {at:?}");
    }
}

#[test]
fn the_scale_of_a_lytro_is_for_what_only_orders() {
    let (folder, kept) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let synthesizer = Synthesizer::load(&models(folder.path())).unwrap();
    let (cancel, cache) = (Cancel::default(), Cache::new(kept.path(), 1 << 30));
    let job = Job { cancel: &cancel, sink: &() };
    let near = RelativeDepth::new([60, 40], (0..2400).map(|i| 0.5 + i as f32 / 2400.0).collect()).unwrap();
    let order = SynthParams {
        source: DepthSource::Phone,
        phone: Some(Estimate::relative(near.clone()).into()),
        ..SynthParams::default()
    };
    let metres = SynthParams { phone: Some(Estimate::metric(near, None).into()), ..order.clone() };
    let given = SynthParams { disparity: Some(DisparityMap::constant([30, 20], 0.5).into()), ..SynthParams::default() };
    for (params, changes) in [(SynthParams::default(), true), (order, true), (metres, false), (given, false)] {
        let map = |scale| {
            let params = SynthParams { scale, ..params.clone() };
            synthesizer.depth_map(&photo(60, 40), &params, Some(&cache), &job).unwrap().0
        };
        let [deep, lytro] = [Scale::Deep, Scale::Lytro].map(map);
        let spread = |map: &DisparityMap| map.range_px()[1] - map.range_px()[0];
        let wanted = if changes { 0.3 } else { 1.0 } * spread(&deep);
        assert!((spread(&lytro) - wanted).abs() < 1e-4, "{} of {}", spread(&lytro), spread(&deep));
        let behind = lytro.disparity_px().iter().filter(|d| **d < 0.0).count();
        assert!(!changes || behind <= 600, "{behind} of 2400 pixels lie behind the focal plane");
    }
}

#[test]
fn a_light_field_from_the_cache_is_the_one_that_was_put_there() {
    let (folder, kept) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let synthesizer = Synthesizer::load(&models(folder.path())).unwrap();
    let cache = Cache::new(kept.path(), 1 << 30);
    let cancel = Cancel::default();
    let (params, job) = (SynthParams::default(), Job { cancel: &cancel, sink: &() });
    let made = synthesizer.synthesize_cached(&photo(50, 30), &params, Some(&cache), &job).unwrap();
    assert!(cache.size_bytes() > 0);
    let again = synthesizer.synthesize_cached(&photo(50, 30), &params, Some(&cache), &job).unwrap();
    assert_eq!((again.field, again.depths), (made.field, made.depths));
}

#[test]
fn a_light_field_is_made_anew_when_a_manifest_says_otherwise() {
    let (folder, kept) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let source = models(folder.path());
    let cache = Cache::new(kept.path(), 1 << 30);
    let cancel = Cancel::default();
    let (params, job) = (SynthParams::default(), Job { cancel: &cancel, sink: &() });
    let made =
        || Synthesizer::load(&source).unwrap().synthesize_cached(&photo(50, 30), &params, Some(&cache), &job).unwrap();
    let before = made();
    let path = folder.path().join("depth/manifest.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("working_long_side = 32", "working_long_side = 16")).unwrap();
    let after = made();
    assert_eq!(before.models, after.models, "the same nets");
    assert_ne!(before.depths, after.depths);
}

#[test]
fn the_shipped_occlusion_net_leaves_a_wall_its_colours_whatever_the_ray_depths() {
    let synthesizer = Synthesizer::load(&ModelSource::Embedded).unwrap();
    let cancel = Cancel::default();
    let job = Job { cancel: &cancel, sink: &() };
    // A plastered wall, and something dark before its right half.
    let (w, h) = (120, 48);
    let grain = |i: u32| (i.wrapping_mul(2_654_435_761) >> 29) as u8;
    let wall = |i: u32| [186 + grain(i), 178 + grain(i), 166 + grain(i), 255];
    let pixel = |i: u32| if i % w < 72 { wall(i) } else { [60 + grain(i), 50, 45, 255] };
    let photo = Photo::from_srgb8([w, h], (0..w * h).flat_map(pixel).collect()).unwrap();
    for [far, near] in [[-0.4, 0.1], [-1.0, 0.1], [-1.9, 0.0], [-0.1, 1.6]] {
        let map = (0..w * h).map(|i| if i % w < 72 { far } else { near }).collect();
        let disparity = Some(DisparityMap::new([w, h], map).unwrap().into());
        let params = SynthParams { disparity, ..SynthParams::default() };
        let made = synthesizer.synthesize(&photo, &params, &job).unwrap();
        let mean = |at: ViewIndex, c: usize| {
            let places = (10..38).flat_map(|y| (12..52).map(move |x| (x, y)));
            places.map(|(x, y)| f32::from(made.field.view(at).pixel(x, y)[c])).sum::<f32>() / (28.0 * 40.0)
        };
        for at in ViewGrid::PAPER.views() {
            for c in 0..3 {
                let change = mean(at, c) - mean(ViewGrid::PAPER.reference(), c);
                assert!(change.abs() < 1.5, "ray depths {far} and {near}, view {at:?}, channel {c}: {change}");
            }
        }
    }
}

#[test]
fn odd_and_tiny_photos_become_light_fields_too() {
    let folder = tempfile::tempdir().unwrap();
    let synthesizer = Synthesizer::load(&models(folder.path())).unwrap();
    let (cancel, params) = (Cancel::default(), SynthParams { long_side: 64, ..SynthParams::default() });
    for (w, h) in [(1, 1), (1, 90), (301, 2), (33, 31)] {
        let photo = photo(w, h);
        let job = Job { cancel: &cancel, sink: &() };
        let made = synthesizer.synthesize(&photo, &params, &job).unwrap();
        assert_eq!(**made.field.reference(), reference_view(&photo, 64, &job).unwrap(), "{w}×{h}");
        let map = DisparityMap::new(made.depths.size(), made.depths.reference().to_vec()).unwrap();
        assert_eq!(lift::ray_depths(&map, ViewGrid::PAPER), *made.depths);
    }
}

#[test]
fn a_model_that_cannot_be_used_is_refused_in_one_sentence() {
    type Damage = fn(&Path);
    let cases: [(&str, Damage, &str); 6] = [
        ("no folder", |f| std::fs::remove_file(f.join("models.toml")).unwrap(), "cannot be read"),
        ("tampered", |f| std::fs::write(f.join("depth/model.onnx"), b"x").unwrap(), "checksum"),
        ("no ONNX", |f| nets::write_model(f, "depth", b"not a model", "ray-depth"), "damaged"),
        ("one view less", |f| nets::write_depth(f, &[Layer::conv2(3, 63)], 3), "answers"),
        ("NaN", |f| nets::write_depth(f, &[Layer::conv2(3, 64).with_nan()], 3), "finite"),
        (
            "occlusion net as depth net",
            |f| std::fs::write(f.join("models.toml"), "depth = \"occlusion\"").unwrap(),
            "task",
        ),
    ];
    for (name, damage, word) in cases {
        let folder = tempfile::tempdir().unwrap();
        let source = models(folder.path());
        damage(folder.path());
        let error: ModelError = Synthesizer::load(&source).err().unwrap_or_else(|| panic!("{name} was accepted"));
        let text = error.to_string();
        assert!(text.contains(word) && !text.contains('\n'), "{name}: {text}");
    }
}
