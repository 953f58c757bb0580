//! Which of near and far is which: places alone do not tell, but what hides what does.
//!
//! With near and far exchanged and the camera on the other side, every point is seen where it was. Where two points of the
//! reference frame come to lie on each other in another frame, the nearer one is seen there.

use glam::DVec2;

use super::camera::{Focal, pixel_of_place, place_of_pixel};
use super::sweep::{Frame, Measured};
use crate::field::{View, sides};

/// Two points lie apart when a frame moves them apart by so many pixels.
const APART_PX: f64 = 1.2;
/// Inverse depths of one surface differ by less than this part of the range over some pixels.
const SAME_SURFACE: f32 = 0.06;
/// Differences of colour (sum of three channels, 0 … 255) from which on one explains a pixel and the other does not.
const EXPLAINS: i32 = 40;
/// Votes that tell something, and how many times more there must be on one side.
const FEWEST: u32 = 25;
const MAJORITY: u32 = 2;
/// Pixels beside an edge that may belong to its other side: one in so many of the long side.
const BESIDE: usize = 180;

/// Whether near and far are to be exchanged; none where too little is hidden to tell.
pub fn is_inside_out(reference: &View, measured: &Measured, frames: &[Frame], focal: Focal) -> Option<bool> {
    let voters = voters(measured);
    let all = frames.iter().map(|frame| votes(reference, measured, &voters, frame, focal));
    let [pro, contra] = all.fold([0, 0], |[a, b], [pro, contra]| [a + pro, b + contra]);
    let is_clear = pro + contra > FEWEST && pro.max(contra) > MAJORITY * pro.min(contra);
    is_clear.then_some(contra > pro)
}

/// Pixels that are sure, and whose neighbours lie on the same surface.
fn voters(measured: &Measured) -> Vec<bool> {
    let (rho, [w, h]) = (&measured.inverse_depth, measured.inverse_depth.sides());
    let [low, high] = rho.pixels().iter().fold([f32::MAX, f32::MIN], |[a, b], v| [a.min(*v), b.max(*v)]);
    let reach = (w.max(h) / BESIDE).max(1);
    let of = |i: usize| {
        let (x, y) = (i % w, i / w);
        let own = rho.at(x, y);
        let beside = [
            (x.saturating_sub(reach), y),
            ((x + reach).min(w - 1), y),
            (x, y.saturating_sub(reach)),
            (x, (y + reach).min(h - 1)),
        ];
        let is_even = beside.iter().all(|(x, y)| (rho.at(*x, *y) - own).abs() < SAME_SURFACE * (high - low));
        is_even && measured.certain.at(x, y) > 0.5
    };
    (0..w * h).map(of).collect()
}

/// Votes of a frame for near being near, and against.
fn votes(reference: &View, measured: &Measured, voters: &[bool], frame: &Frame, focal: Focal) -> [u32; 2] {
    let (size, [w, h]) = (reference.size(), sides(reference.size()));
    let rho = measured.inverse_depth.pixels();
    let moved = |i: usize| {
        let at = place_of_pixel(size, (i % w) as f64, (i / w) as f64);
        let to = pixel_of_place(size, focal.seen(&frame.pose, at, rho[i].into()));
        (to, to - pixel_of_place(size, focal.seen(&frame.pose, at, 0.0)))
    };
    let colour = |view: &View, i: usize| view.pixels()[i].map(i32::from);
    let apart = |a: [i32; 4], b: [i32; 4]| (0..3).map(|c| (a[c] - b[c]).abs()).sum::<i32>();
    let mut there: Vec<Option<(usize, DVec2)>> = vec![None; w * h];
    let mut votes = [0, 0];
    for i in (0..w * h).filter(|i| voters[*i]) {
        let (to, parallax) = moved(i);
        let (x, y) = (to.x.round(), to.y.round());
        if x < 0.0 || y < 0.0 || x >= w as f64 || y >= h as f64 {
            continue;
        }
        let at = y as usize * w + x as usize;
        if let Some((other, _)) = there[at].filter(|(_, its)| (*its - parallax).length() > APART_PX) {
            let [near, far] = if rho[i] > rho[other] { [i, other] } else { [other, i] };
            let seen = colour(&frame.view, at);
            let difference = apart(seen, colour(reference, far)) - apart(seen, colour(reference, near));
            votes[0] += u32::from(difference > EXPLAINS);
            votes[1] += u32::from(difference < -EXPLAINS);
        }
        there[at] = Some((i, parallax));
    }
    votes
}
