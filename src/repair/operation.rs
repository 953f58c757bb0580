//! What is done to a thing.

use super::Operation;
use super::fit::{self, Point};
use super::mask::Mask;
use super::mender::Mender;
use super::reach::{neighbours, walk};

/// A step of less than this part of the range is none: a thing stands where its foot and the ground are this near.
const MEETS: f32 = 0.06;
/// Pixels beside a rim whose depth and colour may be those of both sides.
const MIXED: usize = 2;
/// How far around a thing the ground is looked for, as a share of the longer side.
const AROUND: f32 = 0.08;
/// A plane passes through what is this near to it, as a part of the range.
const ON_PLANE: f32 = 0.03;
/// A foot this wide, as a part of the thing, tells which way the thing faces; a smaller one does not.
const WIDE_FOOT: f32 = 0.6;
/// Part of a thing's height in which its foot is looked for where it meets no ground.
const FOOT: f32 = 0.1;
/// Colours beside each other that differ by this are hardly of one thing.
const SAME: f32 = 0.06;
/// Steps to a neighbour that are none, and that are one for sure, as parts of the range.
const NO_STEP: [f32; 2] = [0.03, 0.08];
/// Rim that is farther from the click than this, as a share of the longer side, counts less than half.
const CLOSE: f32 = 0.06;
/// Places of a neighbour that its depth is taken from.
const TAKEN: usize = 96;

/// Does it. `clicked` is the pixel that a thing was named by.
pub(super) fn perform(mender: &mut Mender, mask: &Mask, clicked: Option<usize>, what: Operation) {
    let values: Vec<f32> = mask.pixels().map(|i| mender.disparity_px()[i]).collect();
    let Some(middle) = fit::median(values) else { return };
    let width = mender.sides()[0];
    match what {
        Operation::Nearer(by) => add(mender, mask, by),
        Operation::Farther(by) => add(mender, mask, -by),
        Operation::Flatten => put(mender, mask, |_| middle),
        Operation::To(to) => {
            let from = clicked.map_or(middle, |i| at_click(mender, mask, i));
            add(mender, mask, to - from / width as f32);
        }
        Operation::Stand => {
            if let Some([a, b]) = foot(mender, mask) {
                put(mender, mask, |i| a + b * (i % width) as f32);
            }
        }
        Operation::Lie => {
            if let Some(plane) = ground(mender, mask) {
                put(mender, mask, |i| plane.at((i % width) as f32, (i / width) as f32));
            }
        }
        Operation::Join => join(mender, mask, clicked, middle),
    }
}

fn put(mender: &mut Mender, mask: &Mask, value: impl Fn(usize) -> f32) {
    let values = mender.values_mut();
    mask.pixels().for_each(|i| values[i] = value(i));
}

/// Adds a share of the width.
fn add(mender: &mut Mender, mask: &Mask, by: f32) {
    let by_px = mender.px(by);
    let values = mender.values_mut();
    mask.pixels().for_each(|i| values[i] += by_px);
}

/// The disparity at a click: the median of what of the thing lies around it.
fn at_click(mender: &Mender, mask: &Mask, clicked: usize) -> f32 {
    let mut near = vec![f32::INFINITY; mender.disparity_px().len()];
    let around = walk(mender.sides(), &mut near, [clicked], (0.006 * mender.long_px()).max(1.5), |_, _, px| px);
    let own = mender.disparity_px()[clicked];
    fit::median(around.into_iter().filter(|i| mask.has(*i)).map(|i| mender.disparity_px()[i]).collect()).unwrap_or(own)
}

/// The line of a thing's foot, `d = a + b · x`: where its lower rim goes over into the ground without a step. A thing
/// that does so nowhere stands on what is below its lowest part.
fn foot(mender: &Mender, mask: &Mask) -> Option<[f32; 2]> {
    let ([w, h], map) = (mender.sides(), mender.disparity_px());
    let mut lowest: Vec<Option<usize>> = vec![None; w];
    mask.pixels().for_each(|i| lowest[i % w] = Some(i / w));
    let columns: Vec<(usize, usize)> = lowest.iter().enumerate().filter_map(|(x, y)| y.map(|y| (x, y))).collect();
    let below = |(x, y): (usize, usize)| map[(y + MIXED + 1).min(h - 1) * w + x];
    let above = |(x, y): (usize, usize)| map[y.saturating_sub(MIXED) * w + x];
    let meets = |at: &(usize, usize)| (below(*at) - above(*at)).abs() < MEETS * mender.range_px();
    let standing: Vec<(usize, usize)> = columns.iter().copied().filter(meets).collect();
    let bottom = columns.iter().map(|(_, y)| *y).max()?;
    let top = mask.pixels().next()? / w;
    let from = bottom - ((bottom - top) as f32 * FOOT) as usize;
    let feet = match standing.len() * 5 >= columns.len() {
        true => standing,
        false => columns.iter().copied().filter(|(_, y)| *y >= from).collect(),
    };
    let wide = feet.last()?.0 - feet.first()?.0 + 1;
    let is_level = (wide as f32) < WIDE_FOOT * columns.len() as f32;
    let points: Vec<(f32, f32)> = feet.iter().map(|at| (at.0 as f32, below(*at))).collect();
    fit::line(&points, is_level)
}

/// The plane of what lies around a thing and below its top; the ground is nearer the lower it is seen.
fn ground(mender: &Mender, mask: &Mask) -> Option<fit::Plane> {
    let w = mender.sides()[0];
    let rows = || mask.pixels().map(|i| i / w);
    let (top, bottom) = (rows().min()?, rows().max()?);
    let mut away = vec![f32::INFINITY; mender.disparity_px().len()];
    let reach = AROUND * mender.long_px() + MIXED as f32;
    let around = walk(mender.sides(), &mut away, mask.pixels().filter(|i| mask.is_rim(*i)), reach, |_, _, px| px);
    let is_ground = |i: &usize| !mask.has(*i) && away[*i] > MIXED as f32 && i / w >= top;
    let point = |i: usize| {
        let (x, y) = ((i % w) as f32, (i / w) as f32);
        // Beside a thing's top there may be what stands behind it.
        let weight = if i / w > (top + bottom) / 2 { 1.0 } else { 0.4 };
        Point { x, y, d: mender.disparity_px()[i], weight }
    };
    let points: Vec<Point> = around.into_iter().filter(is_ground).map(point).collect();
    fit::plane(&fit::thinned(&points, 2000), ON_PLANE * mender.range_px(), |plane| plane.0[2] >= 0.0)
}

/// A place of a neighbour: where it is, its disparity, and how much it is of the same thing.
struct Neighbour {
    at: [f32; 2],
    disparity_px: f32,
    share: f32,
}

/// The thing takes the depth of the neighbour that goes on in the same colours at another depth; where two do, that of
/// the one beside the click. Of each of its pixels
/// the near places of the neighbour count most.
fn join(mender: &mut Mender, mask: &Mask, clicked: Option<usize>, middle: f32) {
    let mut found = beside(mender, mask, middle);
    let best = found.iter().map(|place| place.share).fold(0.0, f32::max);
    found.retain(|place| place.share > 0.25 * best);
    // One neighbour, not two on either side.
    let most = 0.25 * mender.range_px();
    let Some(disparity_px) = meant(mender, &found, clicked, most) else { return };
    found.retain(|place| (place.disparity_px - disparity_px).abs() < most);
    let every = found.len().div_ceil(TAKEN).max(1);
    let taken: Vec<Neighbour> = found.into_iter().step_by(every).collect();
    let width = mender.sides()[0];
    put(mender, mask, |i| {
        let (mut sum, mut total) = (0.0, 0.0);
        for place in &taken {
            let (dx, dy) = ((i % width) as f32 - place.at[0], (i / width) as f32 - place.at[1]);
            let weight = place.share / (dx * dx + dy * dy + 1.0);
            sum += weight * place.disparity_px;
            total += weight;
        }
        if total > 0.0 { sum / total } else { disparity_px }
    });
}

/// The depth of the neighbour that is meant: the one that the thing has most rim in common with, beside the click more
/// than elsewhere. Depths less than `most` apart are of one neighbour.
fn meant(mender: &Mender, found: &[Neighbour], clicked: Option<usize>, most: f32) -> Option<f32> {
    let width = mender.sides()[0];
    let close = (CLOSE * mender.long_px()).powi(2);
    let weight = |place: &Neighbour| {
        let away = clicked
            .map_or(0.0, |i| ((i % width) as f32 - place.at[0]).powi(2) + ((i / width) as f32 - place.at[1]).powi(2));
        place.share / (1.0 + away / close)
    };
    let some: Vec<(f32, f32)> =
        found.iter().step_by(found.len().div_ceil(4 * TAKEN).max(1)).map(|p| (p.disparity_px, weight(p))).collect();
    let around = |at: f32| some.iter().filter(move |(d, _)| (d - at).abs() < most / 2.0);
    let common = |at: f32| around(at).map(|(_, weight)| weight).sum::<f32>();
    let (middle, _) = some.iter().copied().max_by(|a, b| common(a.0).total_cmp(&common(b.0)))?;
    fit::median(around(middle).map(|(d, _)| *d).collect())
}

/// What lies beside a thing at another depth.
fn beside(mender: &Mender, mask: &Mask, middle: f32) -> Vec<Neighbour> {
    let (sides, map) = (mender.sides(), mender.disparity_px());
    let mut away = vec![f32::INFINITY; map.len()];
    let rim: Vec<usize> = mask.pixels().filter(|i| mask.is_rim(*i)).collect();
    let around = walk(sides, &mut away, rim.iter().copied(), MIXED as f32 + 2.0, |_, _, px| px);
    let share = |i: usize| {
        let inside = inner(mender, mask, i);
        let colour = inside.map_or(1.0, |inside| super::guide::apart(inside, mender.guide().colour(i)));
        let step = (map[i] - middle).abs() / mender.range_px();
        (-(colour / SAME).powi(2)).exp() * crate::field::ramp(NO_STEP[0], NO_STEP[1], step)
    };
    let places = around.into_iter().filter(|i| !mask.has(*i) && away[*i] > MIXED as f32);
    let neighbour = |i: usize| Neighbour {
        at: [(i % sides[0]) as f32, (i / sides[0]) as f32],
        disparity_px: map[i],
        share: share(i),
    };
    places.map(neighbour).filter(|place| place.share > 1e-4).collect()
}

/// The colour of the thing near a place beside it.
fn inner(mender: &Mender, mask: &Mask, i: usize) -> Option<[f32; 3]> {
    let mut near = vec![i];
    for _ in 0..MIXED + 3 {
        let mut next: Vec<usize> =
            near.iter().flat_map(|i| neighbours(mender.sides(), *i)).map(|(next, _)| next).collect();
        next.sort_unstable();
        next.dedup();
        near = next;
    }
    mender.guide().mean(near.into_iter().filter(|i| mask.has(*i) && !mask.is_rim(*i)))
}
