//! How much each part of a picture stands out from what lies along its border.
//!
//! A thing that no path of nearly even colour joins with the border is seldom background. How uneven the evenest path is, is
//! its minimum barrier distance (Zhang et al. 2015), here of each colour channel by itself, found in two sweeps over a
//! small copy of the picture.

use std::borrow::Cow;

use crate::field::Size;

/// Cells in each direction, and points of the picture in each of them, in each direction.
const SIDE: usize = 48;
const POINTS: usize = 3;
/// The share of cells that may stand out more than what counts as full.
const FULL_TAIL: f32 = 0.02;
/// Least distance that counts as full, the sum of three channels from 0 to 1: less is noise.
const LEAST_FULL: f32 = 0.1;

/// How much each part of a picture stands out, 0 … 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Salience {
    cells: Vec<f32>,
}

impl Salience {
    /// That of a picture which is not known: nothing stands out.
    pub fn even() -> Self {
        Self { cells: vec![0.0; SIDE * SIDE] }
    }

    /// That of a picture; `row` gives a row's RGBA in sRGB of 8 bits.
    pub fn of<'a>([width, height]: Size, row: impl Fn(usize) -> Cow<'a, [u8]>) -> Self {
        // Point i of a line of so many pixels.
        let place = |i: usize, side: u32| (2 * i + 1) * side as usize / (2 * SIDE * POINTS);
        let mut channels = [(); 3].map(|()| vec![0.0; SIDE * SIDE]);
        for j in 0..SIDE * POINTS {
            let row = row(place(j, height));
            for i in 0..SIDE * POINTS {
                let at = 4 * place(i, width);
                let cell = j / POINTS * SIDE + i / POINTS;
                for (channel, value) in channels.iter_mut().zip(&row[at..]) {
                    channel[cell] += f32::from(*value) / (255 * POINTS * POINTS) as f32;
                }
            }
        }
        let mut cells = vec![0.0; SIDE * SIDE];
        for channel in &channels {
            cells.iter_mut().zip(barriers(channel)).for_each(|(cell, barrier)| *cell += barrier);
        }
        let mut sorted = cells.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let full = sorted[((1.0 - FULL_TAIL) * (sorted.len() - 1) as f32) as usize].max(LEAST_FULL);
        cells.iter_mut().for_each(|cell| *cell = (*cell / full).min(1.0));
        Self { cells }
    }

    /// That of a place, x and y from 0 to 1.
    pub fn at(&self, place: [f32; 2]) -> f32 {
        let [x, y] = place.map(|at| ((at * SIDE as f32) as usize).min(SIDE - 1));
        self.cells[y * SIDE + x]
    }
}

/// The best path to a cell that is known so far: its largest difference, and between which values it stays.
#[derive(Clone, Copy)]
struct Path {
    barrier: f32,
    low: f32,
    high: f32,
}

/// For each cell the least difference that a path from the border must overcome.
fn barriers(values: &[f32]) -> Vec<f32> {
    let is_border = |i: usize| [i % SIDE, i / SIDE].iter().any(|at| [0, SIDE - 1].contains(at));
    let start = |(i, &value): (usize, &f32)| Path {
        barrier: if is_border(i) { 0.0 } else { f32::MAX },
        low: value,
        high: value,
    };
    let mut paths: Vec<Path> = values.iter().enumerate().map(start).collect();
    let inner = || (1..SIDE - 1).flat_map(|y| (1..SIDE - 1).map(move |x| y * SIDE + x));
    for i in inner() {
        [i - 1, i - SIDE].into_iter().for_each(|from| step(&mut paths, values[i], from, i));
    }
    for i in inner().rev() {
        [i + 1, i + SIDE].into_iter().for_each(|from| step(&mut paths, values[i], from, i));
    }
    paths.into_iter().map(|path| path.barrier).collect()
}

/// Goes on with the path of a neighbour, where that is evener.
fn step(paths: &mut [Path], value: f32, from: usize, to: usize) {
    let [low, high] = [paths[from].low.min(value), paths[from].high.max(value)];
    if high - low < paths[to].barrier {
        paths[to] = Path { barrier: high - low, low, high };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(color: impl Fn(f32, f32) -> [u8; 3]) -> Salience {
        let row = |y: usize| {
            let pixel = |x: usize| {
                let [r, g, b] = color(x as f32 / 160.0, y as f32 / 120.0);
                [r, g, b, 255]
            };
            Cow::Owned((0..160).flat_map(pixel).collect())
        };
        Salience::of([160, 120], row)
    }

    #[test]
    fn what_is_closed_in_stands_out_and_what_reaches_the_border_does_not() {
        let scene = of(|x, y| match () {
            () if (x - 0.4).hypot(y - 0.5) < 0.15 => [200, 60, 60],
            () if x > 0.8 => [60, 60, 200],
            () => [90, (100.0 + 60.0 * y) as u8, 80],
        });
        assert!(scene.at([0.4, 0.5]) > 0.9, "{}", scene.at([0.4, 0.5]));
        for place in [[0.9, 0.5], [0.1, 0.9], [0.65, 0.3], [0.0, 0.0], [1.0, 1.0]] {
            assert!(scene.at(place) < 0.2, "{place:?}: {}", scene.at(place));
        }
    }

    #[test]
    fn noise_does_not_stand_out() {
        let noise = of(|x, y| [120 + ((x * 1777.0 + y * 3571.0) as u8 % 5); 3]);
        assert!(noise.cells.iter().all(|cell| *cell < 0.5));
        assert!(Salience::even().cells.iter().all(|cell| *cell == 0.0));
    }
}
