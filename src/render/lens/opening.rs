//! Kernels drawn from a picture: what a lens spreads a point to whose opening is a picture of one's own.

use super::kernel::{Kernel, Span};
use crate::field::{Glass, Integral, Opening};

/// Steps of light along a row that are smaller than this part of the brightest are put off to the next.
const LEAST_STEP: f64 = 1.0 / 512.0;

impl Kernel {
    /// A picture's opening at a diameter, with a lens's faults. Points beyond the focal plane (`is_far`) show it as it
    /// is, those before it on its head. `light`: how much brighter than even spherical aberration makes the rim.
    pub(super) fn of_opening(opening: &Opening, glass: &Glass, light: f32, diameter_px: f32, is_far: bool) -> Self {
        let side = opening.side();
        let place = |i: usize| (i as f64 + 0.5) / side as f64 * 2.0 - 1.0;
        let even = |x: usize, y: usize| 2.0 * (place(x).powi(2) + place(y).powi(2)) - 1.0;
        let cell = |x, y| f64::from(opening.cell(x, y)) * (1.0 + f64::from(light) * even(x, y)).max(0.0);
        let sums = Integral::new([side; 2], cell);
        let radius = f64::from(diameter_px) / 2.0;
        let turn = if is_far { 1.0 } else { -1.0 };
        // Cells of the picture that a pixel of the point's image covers.
        let cells = |pixel: i32, radius: f64| {
            let end = |side_of: f64| ((f64::from(pixel) + side_of) / radius * turn + 1.0) / 2.0 * side as f64;
            let [a, b] = [end(-0.5), end(0.5)];
            [a.min(b), a.max(b)]
        };
        let across = radius * f64::from(glass.narrow());
        let [half_width, half_height] = [across, radius].map(|r| (r + 0.5).ceil() as i32);
        let rows: Vec<Vec<f64>> = (-half_height..=half_height)
            .map(|dy| (-half_width..=half_width).map(|dx| sums.over(cells(dx, across), cells(dy, radius))).collect())
            .collect();
        let most = rows.iter().flatten().copied().fold(0.0, f64::max);
        let mut spans = Vec::new();
        let mut sum = 0.0;
        for (dy, row) in (-half_height..).zip(&rows) {
            let steps = steps(row, LEAST_STEP * most);
            // A step at column c goes on to the row's end.
            sum += steps.iter().map(|(at, step)| step * (row.len() - at) as f64).sum::<f64>();
            push(&mut spans, dy, half_width, &steps);
        }
        let share = 1.0 / sum as f32;
        Self::of(spans.iter().map(|span: &Span| span.times(share)).collect())
    }
}

/// Where a row's light changes, and by how much; all steps add up to nothing.
fn steps(row: &[f64], least: f64) -> Vec<(usize, f64)> {
    let mut now = 0.0;
    let mut steps = Vec::new();
    for (at, &value) in row.iter().chain(&[0.0]).enumerate() {
        if (value - now).abs() > if value == 0.0 { 0.0 } else { least } {
            steps.push((at, value - now));
            now = value;
        }
    }
    steps
}

/// The steps of a row as spans: each holds two pairs of neighbouring columns.
fn push(spans: &mut Vec<Span>, dy: i32, half_width: i32, steps: &[(usize, f64)]) {
    let mut pairs: Vec<(i32, [f32; 2])> = Vec::new();
    for &(at, step) in steps {
        let column = at as i32 - half_width;
        match pairs.last_mut() {
            Some((last, parts)) if *last + 1 == column => parts[1] = step as f32,
            _ => pairs.push((column, [step as f32, 0.0])),
        }
    }
    for both in pairs.chunks(2) {
        let begin = both[0];
        let (column, parts) = both.get(1).copied().unwrap_or((begin.0 + 1, [0.0; 2]));
        spans.push(Span { dy, begin, end: (column, parts.map(|part| -part)) });
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::kernel::tests::drawn;
    use super::*;
    use crate::field::LensShape;

    fn picture(size: [u32; 2], open: impl Fn(f32, f32) -> f32) -> LensShape {
        let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x as f32 + 0.5, y as f32 + 0.5)));
        LensShape::Picture(Opening::of_picture(size, &all.map(|(x, y)| open(x, y)).collect::<Vec<_>>()).unwrap())
    }

    /// The letter L, which is the same no other way round.
    pub fn letter() -> LensShape {
        picture([200, 300], |x, y| f32::from(x < 50.0 || y > 250.0))
    }

    fn of(shape: &LensShape, diameter_px: f32, is_far: bool) -> Kernel {
        Kernel::new(shape, diameter_px, is_far, [0.0; 2])
    }

    #[test]
    fn a_point_behind_the_focus_shows_the_picture_and_one_before_it_the_same_on_its_head() {
        let shape = letter();
        let LensShape::Picture(opening) = &shape else { unreachable!() };
        for diameter in [24.0f32, 61.0] {
            let half = 40;
            let far = drawn(&of(&shape, diameter, true), half);
            let near = drawn(&of(&shape, diameter, false), half);
            let most = far.iter().flatten().copied().fold(0.0, f32::max);
            let mut wrong = 0;
            for y in -half..=half {
                for x in -half..=half {
                    let got = |rows: &[Vec<f32>], x: i32, y: i32| rows[(y + half) as usize][(x + half) as usize] / most;
                    let place = [x, y].map(|at| at as f32 / (diameter / 2.0));
                    let want = if place[0].abs().max(place[1].abs()) < 1.0 { opening.at(place) } else { 0.0 };
                    wrong += i32::from((got(&far, x, y) - want).abs() > 0.5);
                    assert!((got(&far, x, y) - got(&near, -x, -y)).abs() < 0.01, "{x} {y}");
                }
            }
            // Pixels that its rim goes through may differ.
            assert!((wrong as f32) < diameter / 3.0, "{diameter}: {wrong} pixels");
        }
    }

    #[test]
    fn its_light_is_all_there_and_in_the_middle() {
        let grey = picture([40, 50], |x, y| (x / 40.0 * (0.6 + 0.4 * (y * 0.7).sin())).max(0.0));
        for shape in [letter(), grey] {
            for diameter in [0.4f32, 1.7, 6.0, 24.3, 70.0] {
                for is_far in [false, true] {
                    let rows = drawn(&of(&shape, diameter, is_far), 40);
                    let sum: f32 = rows.iter().flatten().sum();
                    assert!((sum - 1.0).abs() < 1e-4, "{diameter}: {sum}");
                    let all = || {
                        rows.iter()
                            .enumerate()
                            .flat_map(|(y, row)| row.iter().enumerate().map(move |(x, v)| (x, y, *v)))
                    };
                    let x: f32 = all().map(|(x, _, v)| (x as f32 - 40.0) * v).sum();
                    let y: f32 = all().map(|(_, y, v)| (y as f32 - 40.0) * v).sum();
                    // Smaller ones are a pixel or two, which cannot be off by less.
                    assert!(diameter < 5.0 || x.hypot(y) < 0.02 + 0.005 * diameter, "{diameter}: {x} {y}");
                }
            }
        }
    }

    #[test]
    fn the_picture_of_a_disc_is_a_disc_with_all_its_faults() {
        let disc = picture([300, 300], |x, y| f32::from((x - 150.0).hypot(y - 150.0) < 140.0));
        for (spherical, anamorphic) in [(0.0, 0.0), (0.8, 0.0), (-0.8, 0.5), (0.0, 1.0)] {
            let glass = Glass { spherical, anamorphic, ..Glass::PLAIN };
            for diameter in [21.0f32, 60.0] {
                let [got, want] = [&disc, &LensShape::Disc]
                    .map(|shape| drawn(&Kernel::through(&glass, shape, diameter, true, [0.0; 2]), 40));
                let apart: f32 = got.iter().flatten().zip(want.iter().flatten()).map(|(a, b)| (a - b).abs()).sum();
                assert!(apart < 0.08, "{glass:?} {diameter}: {apart} of the light is elsewhere");
            }
        }
    }

    #[test]
    fn even_parts_of_a_picture_cost_as_little_as_a_disc() {
        let disc = picture([300, 300], |x, y| f32::from((x - 150.0).hypot(y - 150.0) < 140.0));
        let [spans, rows] = [of(&disc, 60.0, false), Kernel::disc(60.0)].map(|kernel| kernel.spans.len());
        assert!(spans < 3 * rows, "{spans} spans for {rows} rows");
    }
}
