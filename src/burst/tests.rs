//! Made bursts whose cameras and depths are known.

use super::made::{Made, Taking, fit, truly_seen};
use super::*;
use crate::field::{nearest, sides, spearman};
use crate::job::Cancel;

fn solved(made: &Made) -> Result<Solved, BurstError> {
    let job = Job { cancel: &Cancel::default(), sink: &() };
    solve(&made.views[0], &made.views[1..], Some(28.0), &job)
}

/// Rank correlation with the truth, and the share within a part of its range, of what stands still.
fn judged(made: &Made, solved: &Solved) -> (f32, f32) {
    let (found, size) = (&solved.measured.inverse_depth, solved.measured.inverse_depth.size());
    let (truth, moves) = (nearest(made.inverse_depth.pixels(), made.inverse_depth.size(), size), made.moving(size));
    let still = |values: &[f32]| -> Vec<f32> {
        values.iter().zip(&moves).filter(|(_, moves)| !**moves).map(|(value, _)| *value).collect()
    };
    let (found, truth) = (still(found.pixels()), still(&truth));
    let [gain, shift] = fit(&found, &truth);
    let mut sorted = truth.clone();
    sorted.sort_by(f32::total_cmp);
    let range = sorted[sorted.len() * 199 / 200] - sorted[sorted.len() / 200];
    let close = |(a, b): &(&f32, &f32)| (gain * **a + shift - **b).abs() < 0.05 * range;
    let within = found.iter().zip(&truth).filter(close).count() as f32 / truth.len() as f32;
    (spearman(&found, &truth), within)
}

#[test]
fn cameras_and_depth_of_a_noisy_burst_are_those_it_was_taken_with() {
    let taking = Taking { seed: 2, size: [480, 360], frames: 7, ..Taking::default() };
    let made = Made::new(taking);
    let solved = solved(&made).unwrap();
    assert_eq!(solved.frames.len(), 6, "every frame fits");
    assert!(solved.posed.reprojection_px < 0.5, "{} px", solved.posed.reprojection_px);
    // Where the true cameras see the true points.
    let [w, _] = sides(taking.size);
    let mut off: Vec<f64> = Vec::new();
    for (frame, pose) in solved.posed.poses.iter().enumerate() {
        for (at, rho) in &solved.posed.points {
            let pixel = camera::pixel_of_place(taking.size, *at).round();
            let truth = made.inverse_depth.pixels()[pixel.y as usize * w + pixel.x as usize];
            let seen = truly_seen(&made, frame + 1, *at, truth.into());
            off.push((solved.posed.focal.seen(&pose.unwrap(), *at, *rho) - seen).length() * w as f64);
        }
    }
    assert!(start::median(&mut off) < 0.2, "{} px", start::median(&mut off));
    let (order, within) = judged(&made, &solved);
    assert!(order > 0.93 && within > 0.93, "{order} {within}");
    // What moves is not believed.
    let (size, certain) = (solved.measured.certain.size(), solved.measured.certain.pixels());
    let moves = made.moving(size);
    let mean = |of: bool| {
        let values: Vec<f32> = certain.iter().zip(&moves).filter(|(_, m)| **m == of).map(|(c, _)| *c).collect();
        values.iter().sum::<f32>() / values.len() as f32
    };
    assert!(mean(true) < 0.8 * mean(false), "{} and {}", mean(true), mean(false));
    // Frames have the reference photo's exposure.
    for frame in &solved.frames {
        let light =
            |view: &View| view.pixels().iter().map(|p| f64::from(p[1])).sum::<f64>() / view.pixels().len() as f64;
        let ratio = light(&frame.view) / light(&made.views[0]);
        assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    }
}

#[test]
fn two_frames_are_a_stereo_pair() {
    let taking = Taking { seed: 3, size: [480, 360], frames: 2, hand_m: 0.03, moving_m: 0.0, ..Taking::default() };
    let made = Made::new(taking);
    let (order, within) = judged(&made, &solved(&made).unwrap());
    assert!(order > 0.75 && within > 0.85, "{order} {within}");
}

#[test]
fn what_cannot_be_measured_is_told() {
    let taking = Taking { size: [320, 240], frames: 3, hand_m: 0.0, moving_m: 0.0, ..Taking::default() };
    let still = Made::new(Taking { turn: 0.0, rolling: 0.0, ..taking });
    assert!(matches!(solved(&still), Err(BurstError::Still)));
    let turned = Made::new(Taking { turn: 0.06, ..taking });
    assert!(matches!(solved(&turned), Err(BurstError::OnlyTurned)));
    let other = Made::new(Taking { seed: 9, ..taking });
    let job = Job { cancel: &Cancel::default(), sink: &() };
    assert!(matches!(solve(&still.views[0], &other.views[1..], None, &job), Err(BurstError::Unlike)));
    job.cancel.cancel();
    assert!(matches!(solve(&still.views[0], &other.views[1..], None, &job), Err(BurstError::Cancelled(_))));
}

#[test]
fn a_frame_of_another_scene_is_left_out() {
    let taking = Taking { size: [400, 300], frames: 4, ..Taking::default() };
    let mut made = Made::new(taking);
    made.views[2] = Made::new(Taking { seed: 5, frames: 1, ..taking }).views[0].clone();
    let solved = solved(&made).unwrap();
    let fits: Vec<bool> = solved.posed.poses.iter().map(Option::is_some).collect();
    assert_eq!(fits, [true, false, true]);
}
