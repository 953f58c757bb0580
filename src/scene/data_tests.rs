//! Recorded light fields as bursts, outside the repository: run where `PLENOSCOPE_DATA` says where they lie.

use std::path::PathBuf;
use std::sync::Arc;

use super::Subject;
use crate::burst::{self, Step, made::fit};
use crate::field::{DisparityMap, LightField, Photo, View, ViewGrid, ViewIndex};
use crate::io::data_tests::data;
use crate::job::{Cancel, Job};
use crate::synth::{SynthParams, reference_view, sweep, synthesize_bared};

/// Views as a hand may have seen them.
const PATH: [[u8; 2]; 5] = [[1, 2], [2, 6], [5, 7], [6, 1], [7, 5]];

/// Mean difference of the views that the burst was not given, 0 … 1.
fn apart(made: &LightField, truth: &LightField) -> f64 {
    let grid = truth.grid();
    let is_held_back = |at: &ViewIndex| *at != grid.reference() && !PATH.contains(&[at.v, at.u]);
    let of = |a: &View, b: &View| {
        let sum: u64 = a.rgba().iter().zip(b.rgba()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
        sum as f64 / (255.0 * 0.75 * a.rgba().len() as f64)
    };
    let all: Vec<f64> = grid.views().filter(is_held_back).map(|at| of(made.view(at), truth.view(at))).collect();
    all.iter().sum::<f64>() / all.len() as f64
}

/// Errors of six views as a burst, and of the depth swept from all views with their positions known.
fn errors(folder: PathBuf) -> [f64; 2] {
    let job = Job { cancel: &Cancel::default(), sink: &() };
    let subject = Subject::open(&folder, &job).unwrap();
    let truth = &subject.recorded().unwrap().shown;
    assert_eq!(truth.grid(), ViewGrid::PAPER);
    let photo = Photo::from_srgb8(truth.size(), truth.reference().rgba().to_vec()).unwrap();
    let params = SynthParams::default();
    let warped = |map: &DisparityMap| synthesize_bared(&photo, map, &params, &job).unwrap();

    let swept = sweep::ray_depths(truth, &job).unwrap().reference_map();
    let frames = PATH.map(|[v, u]| View::clone(truth.view(ViewIndex { v, u })));
    let reference = reference_view(&photo, burst::FRAME_LONG_SIDE, &job).unwrap();
    let solved = Arc::new(burst::solve(&reference, &frames, None, &job).unwrap());
    let solved = solved.with_sides_of(&swept).unwrap();
    assert_eq!(solved.frames.len(), PATH.len(), "{}: every view fits", folder.display());

    // The size of a step and the plane of disparity 0 are free: those of the recorded views.
    let ([width, _], unit) = (truth.size(), solved.step(Some(1.0)).0);
    let map = solved.map(truth.reference(), None, unit, &job).unwrap();
    let [gain, shift] = fit(map.disparity_px(), swept.disparity_px()).map(f64::from);
    let focus = unit.focus - shift / (gain * unit.gain * f64::from(width));
    let step = Step { focus, ..unit.times(gain) };
    let map = solved.map(truth.reference(), None, step, &job).unwrap();
    let made = warped(&map);
    let (seen, _) = solved.seen((&made.field, &made.depths), step, &job).unwrap();
    [apart(&seen, truth), apart(&warped(&swept).field, truth)]
}

#[test]
fn six_views_of_a_light_field_tell_nearly_as_much_as_all_with_their_positions() {
    let Some(data) = data() else { return };
    for name in ["dino_illum", "knights_256"] {
        let [burst, swept] = errors(data.join("lightfields").join(name));
        assert!(burst < 1.3 * swept, "{name}: {burst} and {swept}");
    }
}

#[test]
#[ignore = "takes a dozen seconds more"]
fn six_views_of_flowers_do_too() {
    let Some(data) = data() else { return };
    for name in ["daisies_illum", "leaves_f01"] {
        let [burst, swept] = errors(data.join("lightfields").join(name));
        assert!(burst < 1.3 * swept, "{name}: {burst} and {swept}");
    }
}
