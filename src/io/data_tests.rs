//! Real files of other people, outside the repository: run where `PLENOSCOPE_DATA` says where they lie.

use std::path::{Path, PathBuf};

use super::*;
use crate::field::{ViewGrid, ViewIndex};
use crate::io::formats::layout;
use crate::job::{Cancel, Job};
use crate::synth::sweep;

/// Where they lie.
pub(crate) fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("PLENOSCOPE_DATA").map(PathBuf::from);
    if folder.is_none() {
        // A skipped test says so.
        std::io::Write::write_all(&mut std::io::stderr(), b"skipped: PLENOSCOPE_DATA is not set\n").unwrap();
    }
    folder
}

fn open_file(path: &Path) -> Opened {
    let cancel = Cancel::default();
    open(path, &Job { cancel: &cancel, sink: &() }).unwrap()
}

fn photo(path: &Path) -> PhotoFile {
    match open_file(path) {
        Opened::Photo(file) => *file,
        Opened::LightField(_) => panic!("{} is a photo", path.display()),
    }
}

fn light_field(path: &Path) -> LightFieldFile {
    match open_file(path) {
        Opened::LightField(file) => *file,
        Opened::Photo(_) => panic!("{} is a light field", path.display()),
    }
}

/// Mean inverse depth in a box of the picture, in shares of its sides.
fn mean(depth: &EmbeddedDepth, [x0, y0, x1, y1]: [f32; 4]) -> f32 {
    let [w, h] = depth.map.size().map(|side| side as f32);
    let (xs, ys) = ((x0 * w) as usize..(x1 * w) as usize, (y0 * h) as usize..(y1 * h) as usize);
    let count = (xs.len() * ys.len()) as f32;
    let row = |y: usize| depth.map.nearness()[y * w as usize..][xs.clone()].iter().sum::<f32>();
    ys.map(row).sum::<f32>() / count
}

#[test]
fn every_photo_opens() {
    let Some(data) = data() else { return };
    for path in folder::pictures(&data.join("photos")).unwrap() {
        let file = photo(&path);
        let [w, h] = file.photo.size();
        assert!(w > 100 && h > 100, "{}: {:?}", path.display(), file.info);
    }
}

#[test]
fn phone_depth_has_the_right_sign_and_stands_upright() {
    let Some(data) = data() else { return };
    let dahlia = photo(&data.join("photos/flower_dahlia_gdepth_xmp.jpg"));
    let depth = dahlia.depth.unwrap();
    assert_eq!(depth.kind, DepthKind::Gdepth);
    let (flower, wall) = (mean(&depth, [0.2, 0.5, 0.4, 0.6]), mean(&depth, [0.1, 0.0, 0.9, 0.1]));
    assert!(flower > 1.5 * wall, "{flower} and {wall}");
    assert!(dahlia.info.notes.iter().any(|(_, note)| note.contains("all-in-focus")));

    let muscari = photo(&data.join("photos/flower_muscari_lensblur.jpg")).depth.unwrap();
    assert_eq!(muscari.kind, DepthKind::SideFile);
    assert!(mean(&muscari, [0.35, 0.77, 0.43, 0.83]) > mean(&muscari, [0.1, 0.0, 0.9, 0.1]) + 0.3);

    let pug = photo(&data.join("photos/pet_pug_iphone13pro_portraitdepth.heic"));
    let depth = pug.depth.unwrap();
    assert_eq!(depth.kind, DepthKind::ApplePortrait);
    let shape = |[w, h]: [u32; 2]| f64::from(w) / f64::from(h);
    assert!(
        (shape(depth.map.size()) / shape(pug.photo.size()) - 1.0).abs() < 0.02,
        "{:?} {:?}",
        depth.map.size(),
        pug.photo.size()
    );
}

#[test]
fn a_spatial_photo_gives_depth_by_matching() {
    let Some(data) = data() else { return };
    let pot = photo(&data.join("photos/plant_pot_spatial_stereo_visionpro.heic"));
    assert_eq!(pot.depth.unwrap().kind, DepthKind::SpatialPair, "{:?}", pot.warnings);
}

#[test]
fn all_light_fields_open_as_they_lie() {
    let Some(data) = data() else { return };
    let mut count = 0;
    for entry in std::fs::read_dir(data.join("lightfields")).unwrap() {
        let path = entry.unwrap().path();
        let file = light_field(&path);
        count += 1;
        assert_eq!(file.field.grid(), ViewGrid::PAPER, "{}", path.display());
        assert!(file.warnings.is_empty(), "{:?}", file.warnings);
        assert!(
            layout::better_than_stored(&file.field).is_none(),
            "{}: {:?}",
            path.display(),
            layout::guess(&file.field)
        );
    }
    assert_eq!(count, 8);
}

#[test]
fn ground_truth_of_the_benchmark_agrees_with_the_views_in_our_sign_only() {
    let Some(data) = data() else { return };
    let file = light_field(&data.join("hci_cotton"));
    assert_eq!((file.field.grid().rows(), file.field.size(), file.info.format), (9, [512, 512], "HCI 4-D benchmark"));
    assert_eq!(file.info.disparity_px, Some([-1.6, 1.5]));
    let truth = file.reference_disparity.as_ref().unwrap();
    let reference = file.field.reference();
    // view(v, u)[y − dv·D, x − du·D] is the point at (x, y) of the reference view.
    let error = |sign: f32| {
        let (mut sum, mut count) = (0.0, 0);
        for at in [ViewIndex { v: 4, u: 8 }, ViewIndex { v: 0, u: 4 }, ViewIndex { v: 8, u: 0 }] {
            let steps = file.field.grid().offset(at);
            for (x, y) in (40..472).step_by(3).flat_map(|x| (40..472).step_by(3).map(move |y| (x, y))) {
                let d = sign * truth.at(x, y);
                let to = |at: u32, step: f32| (at as f32 - step * d).round() as u32;
                let (seen, want) = (file.field.view(at).pixel(to(x, steps.du), to(y, steps.dv)), reference.pixel(x, y));
                sum += f64::from(seen[1].abs_diff(want[1]));
                count += 1;
            }
        }
        sum / f64::from(count)
    };
    let (ours, other) = (error(1.0), error(-1.0));
    assert!(ours * 4.0 < other, "{ours} and {other}");
}

fn percentiles(values: &[f32], shares: [f32; 2]) -> [f32; 2] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f32::total_cmp);
    shares.map(|share| sorted[((sorted.len() - 1) as f32 * share) as usize])
}

#[test]
fn swept_depths_have_the_range_that_is_recorded() {
    let Some(data) = data() else { return };
    let job = Job { cancel: &Cancel::default(), sink: &() };
    for entry in std::fs::read_dir(data.join("lightfields")).unwrap() {
        let path = entry.unwrap().path();
        let file = light_field(&path);
        let map = sweep::reference_map(&file.field, &job).unwrap();
        let [far, near] = percentiles(map.disparity_px(), [0.02, 0.98]);
        let [far_was, near_was] = file.info.disparity_px.unwrap();
        let both = near.min(near_was) - far.max(far_was);
        let any = near.max(near_was) - far.min(far_was);
        assert!(both > 0.7 * any, "{}: {far}…{near}, recorded {far_was}…{near_was}", path.display());
    }
}

#[test]
fn swept_depths_of_the_benchmark_agree_with_its_ground_truth() {
    let Some(data) = data() else { return };
    let file = light_field(&data.join("hci_cotton"));
    let map = sweep::reference_map(&file.field, &Job { cancel: &Cancel::default(), sink: &() }).unwrap();
    let truth = file.reference_disparity.unwrap();
    let errors: Vec<f32> = map.disparity_px().iter().zip(truth.disparity_px()).map(|(a, b)| (a - b).abs()).collect();
    let [middle, most] = percentiles(&errors, [0.5, 0.8]);
    assert!(middle < 0.04 && most < 0.1, "half of the errors are below {middle}, eight of ten below {most} px");
}

#[test]
fn a_real_grid_with_its_rows_turned_over_is_found_out() {
    let Some(data) = data() else { return };
    for name in ["hci_cotton", "lightfields/knights_256", "lightfields/lily_f01"] {
        let truth = light_field(&data.join(name)).field;
        for wrong in [
            layout::Layout { flip_v: true, ..Default::default() },
            layout::Layout { transposed: true, ..Default::default() },
        ] {
            let best = layout::better_than_stored(&wrong.apply(&truth));
            assert_eq!(best.map(|guess| guess.layout), Some(wrong), "{name}");
        }
    }
}

#[test]
fn real_photos_cut_off_are_refused_or_open_with_a_warning() {
    let Some(data) = data() else { return };
    for name in ["pet_pug_iphone13pro_portraitdepth.heic", "flower_dahlia_gdepth_xmp.jpg", "exif_orient6_portrait.jpg"]
    {
        let whole = std::fs::read(data.join("photos").join(name)).unwrap();
        for n in 0..20 {
            let cut = open_bytes(&whole[..whole.len() * n / 20], None);
            let told = cut.as_ref().is_ok_and(|opened| !opened.info().warnings.is_empty());
            assert!(cut.is_err() || told, "{name} cut at {n}/20");
        }
    }
}
