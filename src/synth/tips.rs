//! Tips that a small map gives to what lies behind them: petals' ends, strands, twigs, thinner than its pixels.
//!
//! In the photo such a place stands out from the far side that it was given to. Beside each step of depth two distances are
//! found for the pixels of the far side: how uneven the evenest path is that joins them with the far side farther out, and
//! with the near side (minimum barrier distance, Zhang et al. 2015). What only the near side reaches evenly, and what stands
//! out from most around it, is the near side's, with the depth at the path's beginning.

use rayon::prelude::*;

use crate::field::morphology::extremes;
use crate::field::{View, sides};
use crate::job::{Cancel, Cancelled};

/// How far a tip reaches out, as a share of the long side.
const REACH_SHARE: f32 = 0.03;
/// Least step of depth, as a part of the map's usual range.
const LEAST_STEP: f32 = 0.25;
/// Pixels of the near side's rim whose colours may be the far side's.
const RIM_PX: f32 = 2.0;
/// How wide the strip is that paths from the far side begin in, pixels.
const STRIP_PX: f32 = 3.0;
/// Least barrier from the far side, sum of three channels, 0 … 3.
const LEAST_BARRIER: f32 = 0.12;
/// The barrier from the far side is at least so many times that from the near side, and that of its surroundings.
const NEARER: f32 = 2.0;
const STANDS_OUT: f32 = 3.0;
/// Barriers above this count as this in the mean of the surroundings.
const MOST_BARRIER: f32 = 1.5;
/// Sweeps over the picture, there and back in turn.
const SWEEPS: usize = 4;
/// Share of the map that may lie beyond either end of its usual range.
const TAIL: f32 = 0.02;

/// Gives tips to the near side, in a map `[y, x]` of the guide's size.
pub(super) fn grow(map: &mut [f32], guide: &View, cancel: &Cancel) -> Result<(), Cancelled> {
    let size = sides(guide.size());
    let reach = REACH_SHARE * size[0].max(size[1]) as f32;
    let around = reach as usize;
    let [high, low] = [f32::max, f32::min].map(|most| extremes(map, size, around, most));
    let least = LEAST_STEP * usual_range(map);
    let is_band = |i: usize| high[i] - low[i] > least;
    let near: Vec<bool> = (0..map.len()).map(|i| is_band(i) && map[i] > (high[i] + low[i]) / 2.0).collect();
    let far: Vec<bool> = (0..map.len()).map(|i| is_band(i) && !near[i]).collect();
    if !near.contains(&true) || !far.contains(&true) {
        return Ok(());
    }
    cancel.check()?;
    let [to_near, to_far] = [&near, &far].map(|side| distances(side, size));
    let ring: Vec<bool> = (0..map.len()).map(|i| far[i] && to_near[i] < reach).collect();
    let is_strip = |i: usize| !near[i] && (reach..reach + STRIP_PX).contains(&to_near[i]);
    let is_inside = |i: usize| near[i] && (RIM_PX..reach).contains(&to_far[i]);
    let is_way = |i: usize| ring[i] || (near[i] && to_far[i] < reach);
    let from_far = Paths::new(guide, map, is_strip, is_way).swept(guide, cancel)?;
    let from_near = Paths::new(guide, map, is_inside, |i| is_way(i) && !is_inside(i)).swept(guide, cancel)?;
    let usual = from_far.usual(&ring, size, 2 * around);
    for i in (0..map.len()).filter(|&i| ring[i]) {
        let barrier = from_far.barrier(i);
        let is_told = barrier < f32::MAX && barrier > LEAST_BARRIER && barrier > STANDS_OUT * usual[i];
        if is_told && barrier > NEARER * from_near.barrier(i) {
            map[i] = from_near.begins_at(i);
        }
    }
    Ok(())
}

fn usual_range(map: &[f32]) -> f32 {
    let mut sorted: Vec<f32> = map.iter().copied().step_by(7).collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let at = |share: f32| sorted[((sorted.len() - 1) as f32 * share) as usize];
    at(1.0 - TAIL) - at(TAIL)
}

/// The distance of each pixel to the nearest that is set, in pixels: straight and slanted steps.
fn distances(is_set: &[bool], [w, h]: [usize; 2]) -> Vec<f32> {
    let mut all: Vec<f32> = is_set.iter().map(|&is_set| if is_set { 0.0 } else { f32::MAX }).collect();
    let mut step = |i: usize, from: usize, length: f32| all[i] = all[i].min(all[from] + length);
    for i in 0..w * h {
        let x = i % w;
        for (is_there, back, length) in sooner(x, i / w, w) {
            if is_there {
                step(i, i - back, length);
            }
        }
    }
    for i in (0..w * h).rev() {
        let x = i % w;
        for (is_there, on, length) in sooner(w - 1 - x, h - 1 - i / w, w) {
            if is_there {
                step(i, i + on, length);
            }
        }
    }
    all
}

/// The four neighbours that come sooner in a sweep: whether they are there, how far back, and how far away. `x` and `y` count
/// from where the sweep begins.
fn sooner(x: usize, y: usize, w: usize) -> [(bool, usize, f32); 4] {
    use std::f32::consts::SQRT_2;
    [(x > 0, 1, 1.0), (y > 0, w, 1.0), (x > 0 && y > 0, w + 1, SQRT_2), (x + 1 < w && y > 0, w - 1, SQRT_2)]
}

/// The evenest path to a pixel that is known so far.
#[derive(Clone, Copy)]
struct Path {
    /// Sum over the channels of the largest difference on the way, of 255.
    barrier: u16,
    /// Channels stay between these.
    low: [u8; 3],
    high: [u8; 3],
    /// The map's value at the path's beginning.
    value: f32,
}

/// Paths to all pixels, and where they may go.
struct Paths {
    all: Vec<Path>,
    way: Vec<usize>,
    width: usize,
}

impl Paths {
    fn new(guide: &View, map: &[f32], begins: impl Fn(usize) -> bool, is_way: impl Fn(usize) -> bool) -> Self {
        let path = |i: usize| {
            let [r, g, b, _] = guide.pixels()[i];
            let barrier = if begins(i) { 0 } else { u16::MAX };
            Path { barrier, low: [r, g, b], high: [r, g, b], value: map[i] }
        };
        let width = guide.size()[0] as usize;
        Self { all: (0..map.len()).map(path).collect(), way: (0..map.len()).filter(|&i| is_way(i)).collect(), width }
    }

    fn swept(mut self, guide: &View, cancel: &Cancel) -> Result<Self, Cancelled> {
        let (w, h) = (self.width, self.all.len() / self.width);
        let way = std::mem::take(&mut self.way);
        for sweep in 0..SWEEPS {
            cancel.check()?;
            if sweep % 2 == 0 {
                for &i in &way {
                    let near = sooner(i % w, i / w, w).into_iter().filter(|(is_there, ..)| *is_there);
                    near.for_each(|(_, back, _)| self.step(guide, i, i - back));
                }
            } else {
                for &i in way.iter().rev() {
                    let near = sooner(w - 1 - i % w, h - 1 - i / w, w).into_iter().filter(|(is_there, ..)| *is_there);
                    near.for_each(|(_, on, _)| self.step(guide, i, i + on));
                }
            }
        }
        Ok(self)
    }

    /// Goes on with the path of a neighbour, where that is evener.
    fn step(&mut self, guide: &View, to: usize, from: usize) {
        let (before, own) = (self.all[from], guide.pixels()[to]);
        if before.barrier >= self.all[to].barrier {
            return;
        }
        let low = [0, 1, 2].map(|c| before.low[c].min(own[c]));
        let high = [0, 1, 2].map(|c| before.high[c].max(own[c]));
        let barrier = (0..3).map(|c| u16::from(high[c] - low[c])).sum();
        if barrier < self.all[to].barrier {
            self.all[to] = Path { barrier, low, high, value: before.value };
        }
    }

    /// How uneven the evenest path to a pixel is, 0 … 3; more than all numbers where there is none.
    fn barrier(&self, i: usize) -> f32 {
        let barrier = self.all[i].barrier;
        if barrier == u16::MAX { f32::MAX } else { f32::from(barrier) / 255.0 }
    }

    /// The map's value where that path begins.
    fn begins_at(&self, i: usize) -> f32 {
        self.all[i].value
    }

    /// The mean barrier of the ring's pixels in a square about each pixel.
    fn usual(&self, ring: &[bool], [w, _]: [usize; 2], around: usize) -> Vec<f32> {
        let told = |i: usize| ring[i] && self.all[i].barrier < u16::MAX;
        let sum = |of: &(dyn Fn(usize) -> f32 + Sync)| {
            let values: Vec<f32> = (0..ring.len()).map(|i| if told(i) { of(i) } else { 0.0 }).collect();
            box_sums(&values, w, around)
        };
        let (barriers, counts) = (sum(&|i| self.barrier(i).min(MOST_BARRIER)), sum(&|_| 1.0));
        barriers.iter().zip(&counts).map(|(sum, count)| sum / count.max(1.0)).collect()
    }
}

/// Sums over the square of `2·around + 1` pixels about each pixel.
fn box_sums(values: &[f32], w: usize, around: usize) -> Vec<f32> {
    let h = values.len() / w;
    // Sums of all that lies to the left and above, in f64: differences of large sums.
    let mut before = vec![0.0f64; (w + 1) * (h + 1)];
    for y in 0..h {
        let mut row = 0.0;
        for x in 0..w {
            row += f64::from(values[y * w + x]);
            before[(y + 1) * (w + 1) + x + 1] = before[y * (w + 1) + x + 1] + row;
        }
    }
    let sum = |i: usize| {
        let (x, y) = (i % w, i / w);
        let ([l, t], [r, b]) =
            ([x, y].map(|at| at.saturating_sub(around)), [(x + around + 1).min(w), (y + around + 1).min(h)]);
        let at = |x: usize, y: usize| before[y * (w + 1) + x];
        (at(r, b) - at(l, b) - at(r, t) + at(l, t)) as f32
    };
    (0..values.len()).into_par_iter().map(sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [160, 120];

    /// A disc with a tip that is 2 px wide and reaches 4 px out of it, before a ground; and its map without the tip.
    fn scene(ground: impl Fn(usize, usize) -> [u8; 3]) -> (View, Vec<f32>, Vec<bool>) {
        let places = || (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
        let is_disc = |x: usize, y: usize| (x as f32 - 60.0).hypot(y as f32 - 60.0) < 25.0;
        let is_tip = |x: usize, y: usize| (59..61).contains(&y) && (60..89).contains(&x);
        let rgba = places().flat_map(|(x, y)| {
            let [r, g, b] = if is_disc(x, y) || is_tip(x, y) { [220, 190, 40] } else { ground(x, y) };
            [r, g, b, 255]
        });
        let guide = View::new(SIZE.map(|side| side as u32), rgba.collect()).unwrap();
        let map = places().map(|(x, y)| if is_disc(x, y) { 0.5 } else { -1.0 }).collect();
        let tip = places().map(|(x, y)| is_tip(x, y) && !is_disc(x, y)).collect();
        (guide, map, tip)
    }

    fn grown(guide: &View, map: &[f32]) -> Vec<f32> {
        let mut map = map.to_vec();
        grow(&mut map, guide, &Cancel::default()).unwrap();
        map
    }

    #[test]
    fn a_tip_that_the_map_misses_is_the_near_sides_with_its_depth() {
        let (guide, map, tip) = scene(|_, y| [90, 110, (150 + y / 2) as u8]);
        let after = grown(&guide, &map);
        for (i, is_tip) in tip.iter().enumerate() {
            let want = if *is_tip { 0.5 } else { map[i] };
            assert_eq!(after[i], want, "{}, {}", i % SIZE[0], i / SIZE[0]);
        }
    }

    #[test]
    fn a_ground_of_many_colours_and_a_map_without_steps_stay_as_they_are() {
        // Blots of the disc's own colour, and others: where much stands out, nothing does.
        let blots = |x: usize, y: usize| match (x / 2 + 3 * (y / 2)) % 3 {
            0 => [220, 190, 40],
            1 => [40, 60, 200],
            _ => [90, 160, 90],
        };
        let (guide, map, _) = scene(blots);
        assert_eq!(grown(&guide, &map), map);
        let slant: Vec<f32> = (0..map.len()).map(|i| (i % SIZE[0]) as f32 * 0.01).collect();
        assert_eq!(grown(&guide, &slant), slant);
        let flat = vec![0.3; map.len()];
        assert_eq!(grown(&guide, &flat), flat);
    }
}
