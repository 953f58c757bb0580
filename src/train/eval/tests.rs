//! The measures on scenes whose answers are known.

use plenoscope::field::RelativeDepth;
use plenoscope::io::{self, DepthKind, EmbeddedDepth, Opened};
use plenoscope::job::{Cancel, Job};

use super::metrics::{correlation, l1, percentiles, psnr, spearman, ssim, within_rows};
use super::*;
use crate::rng::Rng;
use crate::scenes::raster::Raster;
use crate::scenes::{REFERENCE, steps};

/// Soft random texture.
fn texture(size: [usize; 2], seed: u64) -> Rgb {
    let mut rng = Rng::new(seed, 0);
    let mut picture = Raster::from_fn(size, |_, _| [0; 3].map(|_: i32| rng.unit()));
    picture.blur(1.5);
    picture.map(|p| p.map(|c| ((c - 0.5) * 4.0 + 0.5).clamp(0.0, 1.0)))
}

/// A light field of one plane.
fn plane_field(disparity: f32) -> TrueField {
    let reference = texture([72, 56], 1);
    let view = |layer| {
        let (du, dv) = steps(layer);
        warp::plane(&reference, disparity, du, dv)
    };
    TrueField { name: "plane".into(), size: [72, 56], views: (0..64).map(view).collect(), depths: Vec::new() }
}

#[test]
fn equal_pictures_have_no_difference_and_noise_lowers_every_measure() {
    let a = texture([40, 30], 2);
    let mut rng = Rng::new(3, 0);
    let b = a.map(|p| p.map(|c| c + 0.05 * rng.normals()[0]));
    assert_eq!(l1(&a, &a), 0.0);
    assert_eq!(psnr(&a, &a), 100.0);
    assert!((ssim(&a, &a) - 1.0).abs() < 1e-5);
    // Mean absolute deviation of a normal: σ·√(2/π); PSNR: −20·log10 σ.
    assert!((l1(&a, &b) - 0.05 * 0.798).abs() < 0.003, "{}", l1(&a, &b));
    assert!((psnr(&a, &b) - 26.02).abs() < 0.3, "{}", psnr(&a, &b));
    assert!(ssim(&a, &b) < 0.99);
}

#[test]
fn a_shift_of_grey_gives_the_ssim_of_its_formula() {
    let a = Raster { size: [20, 20], px: vec![[0.5f32; 3]; 400] };
    let b = a.map(|p| p.map(|c| c + 0.1));
    let want = (2.0 * 0.5 * 0.6 + 1e-4) / (0.25 + 0.36 + 1e-4);
    assert!((ssim(&a, &b) - want).abs() < 1e-4);
}

#[test]
fn correlations_know_order_and_rows() {
    let a: Vec<f32> = (0..200).map(|i| i as f32).collect();
    let b: Vec<f32> = a.iter().map(|v| v.powi(3)).collect();
    assert!((spearman(&a, &b) - 1.0).abs() < 1e-5);
    assert!(spearman(&a, &b.iter().map(|v| -v).collect::<Vec<_>>()) < -0.999);
    assert_eq!(correlation([(1.0, 2.0), (1.0, 3.0)].into_iter()), 0.0);
    // The same within rows, opposite between them.
    let map = |sign: f32| (0..200).map(|i| (i % 20) as f32 + sign * 100.0 * (i / 20) as f32).collect::<Vec<_>>();
    assert!((within_rows(&map(1.0), &map(-1.0), 20) - 1.0).abs() < 1e-5);
    assert!(spearman(&map(1.0), &map(-1.0)) < -0.9);
}

#[test]
fn the_sweep_finds_the_plane_of_a_plane() {
    let field = plane_field(0.4);
    let swept = sweep::reference_depth(&field);
    let inner = |i: usize| (10..62).contains(&(i % 72)) && (10..46).contains(&(i / 72));
    for i in (0..swept.disparity_px.len()).filter(|&i| inner(i)) {
        assert!((swept.disparity_px[i] - 0.4).abs() < 0.03, "{}", swept.disparity_px[i]);
        assert!(swept.known[i]);
    }
    assert!(l1(&sweep::picture(&field, 0), &field.views[0]) < 1e-3);
}

#[test]
fn a_box_of_seven_is_a_mean_of_what_there_is() {
    let size = [12, 9];
    let ramp: Vec<f32> = (0..108).map(|i| (i % 12) as f32).collect();
    let out = sweep::box_7(&ramp, size);
    assert!((out[4 * 12 + 6] - 6.0).abs() < 1e-5);
    assert!((out[0] - 1.5).abs() < 1e-5);
}

#[test]
fn the_truth_closes_the_gap_and_a_plane_closes_nothing() {
    // Left half near, right half far, without any edge in between that could hide something: a slope.
    let reference = texture([96, 64], 5);
    let depth = |x: f32| 0.8 * (x / 95.0 - 0.5);
    let truth = |layer: usize| -> Vec<f32> {
        let (du, _) = steps(layer);
        // d = D(x + u·d) of a slope, solved.
        (0..96 * 64).map(|i| depth((i % 96) as f32) / (1.0 - du * 0.8 / 95.0)).collect()
    };
    let view = |layer| {
        let (du, dv) = steps(layer);
        warp::lambertian(&reference, &truth(layer), du, dv)
    };
    let field =
        TrueField { name: "slope".into(), size: [96, 64], views: (0..64).map(view).collect(), depths: Vec::new() };
    let right =
        |_: &Rgb| Ok(Prediction { disparity_px: (0..64).flat_map(truth).collect(), corrected: None, gain: 1.0 });
    let found = light_field::evaluate(&field, &right).unwrap().figures;
    assert!(found.corners.predicted < 1e-5 && found.lambertian.l1_01 < 1e-5, "{:?}", found.corners);
    assert!(found.corners.closed > 0.99 && found.depth_correlation > 0.98, "{found:?}");
    assert_eq!(found.corners.fit_scale_shift, [1.0, 0.0]);
    assert!((0.8..1.0).contains(&found.corners.swept_depth_closed), "{:?}", found.corners);
    assert!(found.truth.is_none());
    let field = TrueField { depths: (0..64).map(|layer| (layer, truth(layer))).collect(), ..field };
    let shifted = |_: &Rgb| {
        Ok(Prediction {
            disparity_px: (0..64).flat_map(truth).map(|d| 2.0 * d + 0.25).collect(),
            corrected: None,
            gain: 1.0,
        })
    };
    let known = light_field::evaluate(&field, &shifted).unwrap().figures.truth.unwrap();
    assert!(known.correlation > 0.999 && known.fit_mae_px < 1e-5 && known.views == 64, "{known:?}");
    assert!((known.mae_px - 0.3).abs() < 0.1, "{known:?}");
    // What a shallow scale takes away, the fit gives back.
    let closed = |gain: f32| {
        let disparity_px = (0..64).flat_map(truth).map(|d| 0.1 * d).collect::<Vec<_>>();
        let shallow = |_: &Rgb| Ok(Prediction { disparity_px: disparity_px.clone(), corrected: None, gain });
        light_field::evaluate(&field, &shallow).unwrap().figures.corners.closed
    };
    assert!(closed(0.1) > 0.99 && closed(1.0) < 0.5, "{} {}", closed(0.1), closed(1.0));
    let flat = |_: &Rgb| Ok(Prediction::tied(&vec![0.0; 96 * 64]));
    let found = light_field::evaluate(&field, &flat).unwrap().figures;
    assert!(found.corners.closed.abs() < 1e-3 && found.depth_correlation == 0.0, "{:?}", found.corners);
    assert!((found.full.l1_01 - found.zero.l1_01).abs() < 1e-7);
    assert!(found.full.l1_by_u[4] < found.full.l1_by_u[0]);
}

#[test]
fn a_wrong_scale_and_shift_are_fitted_away() {
    let field = plane_field(0.3);
    let predictor = |_: &Rgb| Ok(Prediction::tied(&vec![0.5; 72 * 56]));
    let found = light_field::evaluate(&field, &predictor).unwrap().figures;
    assert!(found.corners.fit < 1e-4 && found.corners.predicted > 0.01, "{:?}", found.corners);
}

#[test]
fn subjects_in_front_and_edges_are_told() {
    let size = [80, 60];
    let inside = |x: usize, y: usize| (25..55).contains(&x) && (20..40).contains(&y);
    let mask = Raster::from_fn(size, |x, y| if inside(x, y) { 255u8 } else { 0 });
    let near = Raster::from_fn(size, |x, y| if inside(x, y) { 0.2f32 } else { -0.3 });
    assert!((photos::step(&mask, &near.px).unwrap() - 0.5).abs() < 1e-6);
    assert!(photos::aligned(&mask, &near.px).unwrap() > 0.95);
    // A depth edge that is 6 px off, and one that falls the wrong way.
    let off = Raster::from_fn(size, |x, y| if (19..61).contains(&x) && (14..46).contains(&y) { 0.2f32 } else { -0.3 });
    assert!(photos::aligned(&mask, &off.px).unwrap() < 0.2);
    let inverse: Vec<f32> = near.px.iter().map(|d| -d).collect();
    assert_eq!(photos::aligned(&mask, &inverse), Some(0.0));
    assert!(photos::step(&mask, &inverse).unwrap() < 0.0);
}

#[test]
fn a_frame_of_wrong_depth_is_told() {
    let size = [90, 60];
    let slope = Raster::from_fn(size, |x, y| 0.01 * (x + y) as f32);
    assert!((photos::border_slope(&slope.px, size).unwrap() - 1.0).abs() < 1e-3);
    let inner = |x: usize, y: usize| (4..86).contains(&x) && (4..56).contains(&y);
    let framed = Raster::from_fn(size, |x, y| slope.at(x, y) + if inner(x, y) { 0.0 } else { 0.5 });
    assert!(photos::border_slope(&framed.px, size).unwrap() > 3.0);
    assert_eq!(photos::border_slope(&[0.0; 90 * 60], size), None);
}

#[test]
fn light_fields_are_read_around_their_reference_view() {
    let folder = tempfile::tempdir().unwrap();
    for v in 0..8 {
        for u in 0..8 {
            let grey = image::Rgb([10 * v as u8, 20 * u as u8, 7]);
            let path = folder.path().join(format!("view_{v}_{u}.png"));
            image::RgbImage::from_pixel(12, 10, grey).save(path).unwrap();
        }
    }
    let field = TrueField::open(folder.path()).unwrap();
    assert_eq!((field.size, field.views.len()), ([12, 10], 64));
    assert!((field.reference().px[0][1] - 80.0 / 255.0).abs() < 1e-6);
    assert_eq!(field.views[REFERENCE].px, field.reference().px);
    assert!(field.depths.is_empty());
}

#[test]
fn the_phones_order_is_compared_where_it_knows_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("photo.png");
    image::RgbImage::from_pixel(40, 20, image::Rgb([90, 120, 60])).save(&path).unwrap();
    let cancel = Cancel::default();
    let Opened::Photo(mut file) = io::open(&path, &Job { cancel: &cancel, sink: &() }).unwrap() else { panic!() };
    let to_the_right = |photo: &Rgb| {
        let [w, h] = photo.size;
        Ok(Prediction::tied(&(0..w * h).map(|i| (i % w) as f32).collect::<Vec<_>>()))
    };
    let text = phone::evaluate(&path, &file, &to_the_right).err().unwrap().to_string();
    assert!(text.contains("photo.png") && text.contains("expected"), "{text}");
    // Nearer to the right, in no even steps; unknown in the upper half, where it would be the other way round.
    let nearness = (0..200).map(|i| if i < 100 { f32::NAN } else { (i % 20) as f32 * (i % 20) as f32 }).collect();
    file.depth = Some(EmbeddedDepth {
        kind: DepthKind::Gdepth,
        map: RelativeDepth::new([20, 10], nearness).unwrap(),
        metric: false,
    });
    let (found, tiles) = phone::evaluate(&path, &file, &to_the_right).unwrap();
    assert!(found.spearman > 0.99 && found.rows_spearman.abs() < 1e-6, "{found:?}");
    assert_eq!((found.known, tiles.len()), (0.5, 3));
    let to_the_left = |photo: &Rgb| {
        to_the_right(photo).map(|p| Prediction::tied(&p.view(0, photo.px.len()).iter().map(|d| -d).collect::<Vec<_>>()))
    };
    assert!(phone::evaluate(&path, &file, &to_the_left).unwrap().0.spearman < -0.99);
}

#[test]
fn light_fields_that_do_not_fit_are_told_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("view_0_0.png");
    image::RgbImage::new(8, 8).save(&path).unwrap();
    let text = TrueField::open(&path).err().unwrap().to_string();
    assert!(text.contains("expected") && text.contains("view_0_0.png"), "{text}");
    let empty = tempfile::tempdir().unwrap();
    assert!(TrueField::open(empty.path()).is_err());
}

#[test]
fn percentiles_are_those_of_the_values_in_order() {
    for count in [1, 2, 7, 500] {
        let rng = &mut Rng::new(3, count as u64);
        let mut values: Vec<f32> = (0..count).map(|_| rng.range(-1.0, 1.0)).collect();
        let mut sorted = values.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let at = |share: f32| sorted[((count - 1) as f32 * share) as usize];
        assert_eq!(percentiles(&mut values, [0.02, 0.5, 0.65, 0.98]), [0.02, 0.5, 0.65, 0.98].map(at));
    }
}
