//! Inverse depth of the reference frame: planes swept through the posed frames.
//!
//! At each plane the frames are brought over the reference frame. Patches are compared by their brightness after the
//! frames' exposures are matched, by the same without its local mean and contrast, and by colour. The better half of the
//! frames counts: behind an edge the others see something else, and what moves is elsewhere in them.

use glam::{DVec2, DVec3, Vec4};
use rayon::prelude::*;

use super::BurstError;
use super::camera::{Focal, Pose, pixel_of_place, place_of_pixel};
use crate::field::{Raster, Size, View, ramp, sides};
use crate::job::{Job, Stage};
use crate::semiglobal::{Changes, Volume, lowest};

/// Shift between two planes in the frame that moved most, in pixels.
const PLANE_PX: f64 = 0.5;
/// Planes at least and at most.
const PLANES: [usize; 2] = [24, 160];
/// Half the side of the window whose mean and contrast are taken out.
const LOCAL: usize = 3;
/// Contrast (0 … 1) below which it is noise.
const NOISE: f32 = 0.03;
/// Weights of the local pattern, brightness and colours.
const WEIGHTS: [f32; 3] = [0.16, 1.2, 1.6];
/// A difference beyond this is no worse than this.
const WORST: f32 = 0.4;
/// Cost of what no frame sees.
const UNSEEN: f32 = 0.5 * WORST;
/// What a change by one plane costs, and a larger one at an edge and on even colour. Costs of a plane reach 1000.
const NEXT: i16 = 24;
const CHANGED: [i16; 2] = [60, 420];
/// Difference of brightness, 0 … 1, at which a large change costs half as much.
const EDGE: f32 = 0.03;
/// Most frames that are swept.
const MOST_FRAMES: usize = 10;
/// By how much other planes are worse, as a sum over eight paths, where nothing and everything tells.
const TELLING: [f32; 2] = [40.0, 250.0];
/// Planes from the best one on which a plane is another.
const OTHER_PLANE: usize = 3;
/// Usual differences between frames and the reference frame from which on a difference is one of things.
const TOO_MUCH: f32 = 2.0;
/// Least usual difference: what a still and noiseless picture has.
const USUAL_COST: f32 = 0.012;
/// Shares of the frames that see something that moves, and that may see something still.
const AGREEING: [f32; 2] = [0.25, 0.45];
/// Half the side of the window over which a surface is smoothed, how often, and planes that lie on one surface.
const AROUND: usize = 4;
const SMOOTHED: usize = 2;
const SAME_SURFACE: f32 = 2.0;

/// A frame that was brought to the reference frame's exposure, at the size at which it is used.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Its picture.
    pub view: View,
    /// Where it was taken.
    pub pose: Pose,
}

/// Inverse depth of every pixel, in inverse baselines, and how sure it is, 0 … 1.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Inverse depths.
    pub inverse_depth: Raster<f32>,
    /// Certainties.
    pub certain: Raster<f32>,
}

/// What patches are compared by.
fn signs(view: &View) -> Raster<Vec4> {
    let [w, h] = sides(view.size());
    let rgb = |x: usize, y: usize| {
        let [r, g, b, _] = view.pixel(x as u32, y as u32);
        [r, g, b].map(|c| f32::from(c) / 255.0)
    };
    let luma = Raster::par_from_fn(view.size(), |x, y| {
        let [r, g, b] = rgb(x, y);
        0.3 * r + 0.6 * g + 0.1 * b
    });
    let window = |i: usize, n: usize| i.saturating_sub(LOCAL)..(i + LOCAL + 1).min(n);
    let across = Raster::par_from_fn(view.size(), |x, y| {
        window(x, w).map(|x| luma.at(x, y)).fold([0.0, 0.0, 0.0], |[n, s, q], v| [n + 1.0, s + v, q + v * v])
    });
    let [pattern, brightness, colour] = WEIGHTS;
    Raster::par_from_fn(view.size(), |x, y| {
        let [n, s, q] = window(y, h).map(|y| across.at(x, y)).fold([0.0f32; 3], |a, b| [0, 1, 2].map(|i| a[i] + b[i]));
        let (mean, own) = (s / n, luma.at(x, y));
        let contrast = (q / n - mean * mean).max(0.0).sqrt();
        let [r, _, b] = rgb(x, y);
        Vec4::new(pattern * (own - mean) / (contrast + NOISE), brightness * own, colour * (r - own), colour * (b - own))
    })
}

/// A frame's signs, and how places of the reference frame come to lie in it, in pixels.
struct Swept {
    signs: Raster<Vec4>,
    pose: Pose,
}

/// Measures the reference frame. All pictures have the same size; inverse depths are looked for in `range`.
///
/// # Errors
/// Stopped.
pub fn measure(
    reference: &View,
    frames: &[Frame],
    focal: Focal,
    range: [f64; 2],
    job: &Job,
) -> Result<Measured, BurstError> {
    let size = reference.size();
    let chosen = spread(frames);
    let swept: Vec<Swept> =
        chosen.iter().map(|i| Swept { signs: signs(&frames[*i].view), pose: frames[*i].pose }).collect();
    let planes = planes(&swept, size, focal, range);
    let own = signs(reference);
    let mut volume = Volume {
        sides: sides(size),
        labels: planes.len(),
        costs: vec![0; sides(size).iter().product::<usize>() * planes.len()],
    };
    let batch = 2 * rayon::current_num_threads().max(1);
    for (round, some) in planes.chunks(batch).enumerate() {
        job.advance(Stage::Sweep, (round * batch) as u32, planes.len() as u32 + 8)?;
        let made: Vec<Vec<i16>> = some.par_iter().map(|rho| plane_cost(&own, &swept, focal, *rho)).collect();
        let first = round * batch;
        volume.costs.par_chunks_exact_mut(planes.len()).enumerate().for_each(|(pixel, costs)| {
            made.iter().enumerate().for_each(|(i, plane)| costs[first + i] = plane[pixel]);
        });
    }
    job.advance(Stage::Sweep, planes.len() as u32, planes.len() as u32 + 8)?;
    let luma: Vec<f32> = own.pixels().iter().map(|sign| sign.y / WEIGHTS[1]).collect();
    let other = |a: usize, b: usize| {
        let step = (luma[a] - luma[b]).abs() / EDGE;
        (f32::from(CHANGED[1]) / (1.0 + step)).max(f32::from(CHANGED[0])) as i16
    };
    let heard = volume.heard(&Changes { next: NEXT, other }, job.cancel)?;
    let mut measured = best(&heard.costs, &planes, size);
    let agree = agreement(&own, &swept, focal, &measured.inverse_depth);
    measured.certain.pixels_mut().iter_mut().zip(agree).for_each(|(certain, agree)| *certain *= agree);
    job.advance(Stage::Sweep, planes.len() as u32 + 8, planes.len() as u32 + 8)?;
    Ok(measured)
}

/// Frames that stand far apart from each other, as many as are swept.
fn spread(frames: &[Frame]) -> Vec<usize> {
    let centre = |i: usize| frames[i].pose.centre();
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < frames.len().min(MOST_FRAMES) {
        let from_chosen = |i: usize| {
            let others = chosen.iter().map(|j| centre(*j)).chain([DVec3::ZERO]);
            others.map(|other| other.distance(centre(i))).fold(f64::INFINITY, f64::min)
        };
        let rest = (0..frames.len()).filter(|i| !chosen.contains(i));
        chosen.extend(rest.max_by(|a, b| from_chosen(*a).total_cmp(&from_chosen(*b))));
    }
    chosen
}

fn planes(swept: &[Swept], size: Size, focal: Focal, [far, near]: [f64; 2]) -> Vec<f64> {
    let corner = place_of_pixel(size, 0.0, 0.0) * 0.7;
    let places = [DVec2::ZERO, corner, -corner, DVec2::new(corner.x, -corner.y), DVec2::new(-corner.x, corner.y)];
    let long = f64::from(size[0].max(size[1]));
    let moved = |pose: &Pose, at: DVec2| (focal.seen(pose, at, near) - focal.seen(pose, at, far)).length() * long;
    let most = swept.iter().flat_map(|frame| places.map(|at| moved(&frame.pose, at))).fold(0.0, f64::max);
    let count = ((most / PLANE_PX).ceil() as usize + 1).clamp(PLANES[0], PLANES[1]);
    (0..count).map(|i| far + (near - far) * i as f64 / (count - 1) as f64).collect()
}

/// How badly the better half of the frames agrees with the reference frame at a plane, 0 … 1000.
fn plane_cost(own: &Raster<Vec4>, swept: &[Swept], focal: Focal, rho: f64) -> Vec<i16> {
    let size = own.size();
    let all: Vec<Vec<f32>> =
        swept.iter().map(|frame| averaged(&frame_cost(own, frame, focal, rho), sides(size))).collect();
    let half = all.len().div_ceil(2);
    let mut kept = [f32::INFINITY; MOST_FRAMES];
    let of = |i: usize| {
        let count = all.len();
        kept[..count].iter_mut().zip(&all).for_each(|(to, costs)| *to = costs[i]);
        // Few enough for the plainest sort.
        for a in 1..count {
            let (mut b, value) = (a, kept[a]);
            while b > 0 && kept[b - 1] > value {
                kept[b] = kept[b - 1];
                b -= 1;
            }
            kept[b] = value;
        }
        let (sum, seen) =
            kept[..half].iter().filter(|cost| cost.is_finite()).fold((0.0, 0.0), |(s, n), c| (s + c, n + 1.0));
        let cost = if seen > 0.0 { sum / seen } else { UNSEEN };
        (cost / WORST * 1000.0) as i16
    };
    (0..own.pixels().len()).map(of).collect()
}

/// Differences of one frame from the reference frame at a plane; infinite beside the frame.
fn frame_cost(own: &Raster<Vec4>, frame: &Swept, focal: Focal, rho: f64) -> Vec<f32> {
    let (size, [w, h]) = (own.size(), own.sides());
    let long = f64::from(size[0].max(size[1]));
    let (right, below) = (w as f32 - 0.5, h as f32 - 0.5);
    let mut costs = Vec::with_capacity(w * h);
    for y in 0..h {
        let at = place_of_pixel(size, 0.0, y as f64);
        let first = frame.pose.transform(focal.ray(at), at.y, rho);
        let next = frame.pose.transform(focal.ray(at + DVec2::new(1.0 / long, 0.0)), at.y, rho);
        let zoom = (focal.0 * long) as f32;
        let (first, step) = (first.as_vec3(), (next - first).as_vec3());
        let middle = pixel_of_place(size, DVec2::ZERO).as_vec2();
        for (x, own) in own.pixels()[y * w..(y + 1) * w].iter().enumerate() {
            let point = first + step * x as f32;
            let scale = zoom / point.z.max(1e-3);
            let (px, py) = (point.x * scale + middle.x, point.y * scale + middle.y);
            let inside = px > -0.5 && py > -0.5 && px < right && py < below;
            costs.push(match inside {
                true => (frame.signs.tap(px, py) - own).abs().element_sum().min(WORST),
                false => f32::INFINITY,
            });
        }
    }
    costs
}

/// How much of the frames agrees with the reference frame about its surfaces: 0 where they are something that moves … 1.
fn agreement(own: &Raster<Vec4>, swept: &[Swept], focal: Focal, inverse_depth: &Raster<f32>) -> Vec<f32> {
    let (size, [w, h]) = (own.size(), own.sides());
    let (right, below) = (w as f64 - 0.5, h as f64 - 0.5);
    let costs = swept.par_iter().map(|frame| {
        let cost = |i: usize| {
            let at = place_of_pixel(size, (i % w) as f64, (i / w) as f64);
            let to = pixel_of_place(size, focal.seen(&frame.pose, at, inverse_depth.pixels()[i].into()));
            let inside = to.x > -0.5 && to.y > -0.5 && to.x < right && to.y < below;
            let apart = || (frame.signs.tap(to.x as f32, to.y as f32) - own.pixels()[i]).abs().element_sum().min(WORST);
            if inside { apart() } else { f32::INFINITY }
        };
        averaged(&(0..w * h).map(cost).collect::<Vec<_>>(), [w, h])
    });
    let costs: Vec<Vec<f32>> = costs.collect();
    let mut all: Vec<f32> =
        costs.iter().flat_map(|costs| costs.iter().step_by(7)).copied().filter(|c| c.is_finite()).collect();
    let middle = all.len() / 2;
    let usual = if all.is_empty() { WORST } else { *all.select_nth_unstable_by(middle, f32::total_cmp).1 };
    let limit = TOO_MUCH * usual.max(USUAL_COST);
    let share = |i: usize| {
        let seen = costs.iter().map(|costs| costs[i]).filter(|cost| cost.is_finite());
        let (agree, all) =
            seen.fold((0.0, 0.0), |(agree, all), cost| (agree + f32::from(u8::from(cost < limit)), all + 1.0));
        // A little less than half of the frames may see something else behind an edge.
        if all > 0.0 { ramp(AGREEING[0], AGREEING[1], agree / all) } else { 0.0 }
    };
    (0..w * h).map(share).collect()
}

/// Means over three by three; infinite ones stay.
fn averaged(costs: &[f32], [w, h]: [usize; 2]) -> Vec<f32> {
    let mut across = vec![0.0; costs.len()];
    for (row, out) in costs.chunks_exact(w).zip(across.chunks_exact_mut(w)) {
        for x in 0..w {
            out[x] = row[x.saturating_sub(1)] + row[x] + row[(x + 1).min(w - 1)];
        }
    }
    let row = |y: usize| &across[y * w..(y + 1) * w];
    let mut out = Vec::with_capacity(costs.len());
    for y in 0..h {
        let rows = row(y.saturating_sub(1)).iter().zip(row(y)).zip(row((y + 1).min(h - 1)));
        out.extend(rows.map(|((a, b), c)| (a + b + c) / 9.0));
    }
    out
}

/// What is found of a pixel.
struct Found {
    /// Its plane, with a fraction.
    plane: f32,
    /// By how much other planes are worse.
    margin: f32,
}

impl Found {
    fn of(sums: &[i16]) -> Self {
        let n = sums.len();
        let (at, shift) = lowest(sums);
        let apart = |i: &usize| i.abs_diff(at) > OTHER_PLANE.max(n / 16);
        let other = (0..n).filter(apart).map(|i| sums[i]).min().unwrap_or(sums[at]);
        Self { plane: at as f32 + shift, margin: f32::from(other - sums[at]) }
    }
}

/// The plane of least sum of each pixel, between planes by a parabola, and how sure it is.
fn best(sums: &[i16], planes: &[f64], size: Size) -> Measured {
    let n = planes.len();
    let found: Vec<Found> = sums.par_chunks_exact(n).map(Found::of).collect();
    let certain: Vec<f32> = found.iter().map(|found| ramp(TELLING[0], TELLING[1], found.margin)).collect();
    let [w, _] = sides(size);
    let certain = Raster::from_fn(size, |x, y| certain[y * w + x]);
    let mut plane = Raster::from_fn(size, |x, y| found[y * w + x].plane);
    for _ in 0..SMOOTHED {
        plane = smoothed(&plane, &certain);
    }
    let step = (planes[n - 1] - planes[0]) / (n - 1) as f64;
    Measured { inverse_depth: plane.map(|plane| (planes[0] + step * f64::from(plane)) as f32), certain }
}

/// Means over what lies on the same surface around each pixel.
fn smoothed(plane: &Raster<f32>, certain: &Raster<f32>) -> Raster<f32> {
    let [w, h] = plane.sides();
    let window = |i: usize, n: usize| i.saturating_sub(AROUND)..(i + AROUND + 1).min(n);
    Raster::par_from_fn(plane.size(), |x, y| {
        let own = plane.at(x, y);
        let (mut sum, mut all) = (own * 0.05, 0.05);
        for y in window(y, h) {
            for x in window(x, w) {
                let weight =
                    (1.0 - ((plane.at(x, y) - own) / SAME_SURFACE).powi(2)).max(0.0) * (0.02 + certain.at(x, y));
                sum += plane.at(x, y) * weight;
                all += weight;
            }
        }
        sum / all
    })
}
