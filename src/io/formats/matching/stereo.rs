//! Depth from both eyes of a stereo pair, whose rows lie level: semi-global matching of census transforms, so that exposure
//! may differ between the eyes. What only one eye sees is the far side's.

use super::{census, fit_width};
use crate::field::{Raster, RelativeDepth};
use crate::job::Cancel;
use crate::semiglobal::{Changes, Volume, lowest};

/// Width at which pairs are matched, and what of their height is at most.
const WIDTH: u32 = 512;
const HEIGHT: u32 = 768;
/// Shifts that are tried, as shares of the width: a spatial photo's pair may be shifted against itself.
const RANGE: [f32; 2] = [-0.08, 0.12];
/// Cost of a step of one pixel from place to place, and of a larger one where the picture is even: bits of the census.
const SMALL_STEP: i16 = 8;
const LARGE_STEP: f32 = 90.0;
/// A large step costs half as much where the picture's brightness changes by this.
const EDGE: f32 = 0.04;
/// Shifts that agree, both eyes' or two neighbours', differ by this at most, pixels.
const AGREE_PX: u8 = 1;
/// Pictures of which a smaller share agrees are no pair.
const LEAST_AGREED: f32 = 0.3;
/// Patches that agree with nothing around them and have fewer pixels are specks.
const SPECK: usize = 60;
/// What is not known.
const NONE: f32 = f32::NAN;

/// Shift of every pixel of `from` in `to`: `from(x) = to(x + sign · d)`, larger `d` is nearer. None where the pictures
/// do not match at all.
pub(crate) fn stereo(from: Raster<f32>, to: Raster<f32>, sign: f32) -> Option<RelativeDepth> {
    let [width, height] = from.size();
    let width = WIDTH.min((u64::from(HEIGHT) * u64::from(width) / u64::from(height)) as u32).max(1);
    let [from, to] = [from, to].map(|picture| fit_width(picture, width));
    if from.size() != to.size() {
        return None;
    }
    let mut map = Pair::new(from.sides()[0], sign as i32).agreed(&from, &to)?;
    let known = map.pixels().iter().filter(|d| !d.is_nan()).count();
    if (known as f32) < LEAST_AGREED * map.pixels().len() as f32 {
        return None;
    }
    drop_specks(&mut map);
    let map = median(&filled(&map));
    RelativeDepth::new(map.size(), map.into_pixels()).ok()
}

/// How two pictures may be shifted.
struct Pair {
    width: i32,
    sign: i32,
    first: i32,
    count: usize,
}

impl Pair {
    fn new(width: usize, sign: i32) -> Self {
        let [first, last] = RANGE.map(|share| (share * width as f32) as i32);
        Self { width: width as i32, sign, first, count: (last - first + 1) as usize }
    }

    /// The column so many pixels away, if the picture has it.
    fn column(&self, x: usize, away: i32) -> Option<usize> {
        let x = x as i32 + self.sign * away;
        (0..self.width).contains(&x).then_some(x as usize)
    }

    /// The best shift of each pixel, between whole ones; none where the other eye's best shift is another.
    fn agreed(&self, from: &Raster<f32>, to: &Raster<f32>) -> Option<Raster<f32>> {
        let costs = census::costs([from, to], self.count, |x, shift| self.column(x, self.first + shift as i32));
        let other = |a: usize, b: usize| {
            let apart = (from.pixels()[a] - from.pixels()[b]).abs();
            ((LARGE_STEP / (1.0 + apart / EDGE)) as i16).max(SMALL_STEP + 4)
        };
        let heard = costs.heard(&Changes { next: SMALL_STEP, other }, &Cancel::default()).ok()?;
        let others = Raster::par_from_fn(from.size(), |x, y| self.best_of_other(&heard, x, y));
        Some(Raster::par_from_fn(from.size(), |x, y| {
            let (shift, part) = lowest(heard.of(y * self.width as usize + x));
            let there = self.column(x, self.first + shift as i32);
            let agrees =
                there.is_some_and(|x| others.at(x, y).is_some_and(|other| other.abs_diff(shift) <= AGREE_PX.into()));
            if agrees { (self.first + shift as i32) as f32 + part } else { NONE }
        }))
    }

    /// The best shift of a pixel of the other picture.
    fn best_of_other(&self, heard: &Volume<i16>, x: usize, y: usize) -> Option<usize> {
        let cost = |shift: usize| {
            let x = self.column(x, -(self.first + shift as i32))?;
            Some((heard.of(y * self.width as usize + x)[shift], shift))
        };
        (0..self.count).filter_map(cost).min().map(|(_, shift)| shift)
    }
}

/// Takes patches away that are too small to be true.
fn drop_specks(map: &mut Raster<f32>) {
    let mut is_seen: Vec<bool> = map.pixels().iter().map(|d| d.is_nan()).collect();
    for start in 0..is_seen.len() {
        if is_seen[start] {
            continue;
        }
        let patch = patch(map, start, &mut is_seen);
        if patch.len() < SPECK {
            patch.into_iter().for_each(|i| map.pixels_mut()[i] = NONE);
        }
    }
}

/// The pixels that a pixel leads to by neighbours whose shifts agree.
fn patch(map: &Raster<f32>, start: usize, is_seen: &mut [bool]) -> Vec<usize> {
    let mut found = vec![start];
    is_seen[start] = true;
    let mut next = 0;
    while let Some(&i) = found.get(next) {
        next += 1;
        for j in beside(map.sides(), i) {
            if !is_seen[j] && (map.pixels()[j] - map.pixels()[i]).abs() <= AGREE_PX.into() {
                is_seen[j] = true;
                found.push(j);
            }
        }
    }
    found
}

/// The four neighbours of a pixel.
fn beside([width, height]: [usize; 2], i: usize) -> impl Iterator<Item = usize> {
    let (x, y) = (i % width, i / width);
    let columns = [x.checked_sub(1), Some(x + 1).filter(|x| *x < width)].into_iter().flatten();
    let rows = [y.checked_sub(1), Some(y + 1).filter(|y| *y < height)].into_iter().flatten();
    columns.map(move |x| y * width + x).chain(rows.map(move |y| y * width + x))
}

/// What is not known is the second farthest of what is known around it in eight directions: the far side's, as the near side
/// hides it from one eye.
fn filled(map: &Raster<f32>) -> Raster<f32> {
    let [width, height] = map.size().map(|side| side as i32);
    let seen = |x: i32, y: i32, [dx, dy]: [i32; 2]| {
        let inside = |n: &i32| (0..width).contains(&(x + n * dx)) && (0..height).contains(&(y + n * dy));
        let values = (1..).take_while(inside).map(|n| map.at((x + n * dx) as usize, (y + n * dy) as usize));
        values.into_iter().find(|d| !d.is_nan())
    };
    let directions = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];
    Raster::par_from_fn(map.size(), |x, y| {
        let own = map.at(x, y);
        if !own.is_nan() {
            return own;
        }
        let mut around: Vec<f32> = directions.iter().filter_map(|d| seen(x as i32, y as i32, *d)).collect();
        around.sort_unstable_by(f32::total_cmp);
        around.get(1).or(around.first()).copied().unwrap_or_default()
    })
}

/// The middle value of 3×3 pixels; edges go on.
fn median(map: &Raster<f32>) -> Raster<f32> {
    let [width, height] = map.sides();
    let near = |at: usize, step: usize, size: usize| (at + step).saturating_sub(1).min(size - 1);
    Raster::par_from_fn(map.size(), |x, y| {
        let mut window: [f32; 9] = std::array::from_fn(|k| map.at(near(x, k % 3, width), near(y, k / 3, height)));
        *window.select_nth_unstable_by(4, f32::total_cmp).1
    })
}
