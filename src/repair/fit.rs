//! Lines and planes through measured disparities, of which many are wrong.

/// Planes that are tried.
const TRIES: u32 = 300;
/// At most so many points give a line: all pairs are looked at.
const MOST: usize = 64;

/// A measured place: x and y in pixels, the disparity, and how much it counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub x: f32,
    pub y: f32,
    pub d: f32,
    pub weight: f32,
}

/// `d = at[0] + at[1] · x + at[2] · y`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane(pub [f32; 3]);

impl Plane {
    pub(super) fn at(self, x: f32, y: f32) -> f32 {
        let [a, b, c] = self.0;
        a + b * x + c * y
    }
}

/// The value in the middle.
pub(super) fn median(mut values: Vec<f32>) -> Option<f32> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// At most `most` of them, evenly.
pub(super) fn thinned<T: Copy>(all: &[T], most: usize) -> Vec<T> {
    all.iter().step_by(all.len().div_ceil(most).max(1)).copied().collect()
}

/// The line `d = a + b · x` of the median slope between all pairs (Theil 1950, Sen 1968). `is_level`: its slope is 0.
pub(super) fn line(points: &[(f32, f32)], is_level: bool) -> Option<[f32; 2]> {
    let points = thinned(points, MOST);
    let pairs = || points.iter().enumerate().flat_map(|(i, a)| points[..i].iter().map(move |b| (a, b)));
    let slopes = pairs().filter(|(a, b)| a.0 != b.0).map(|(a, b)| (a.1 - b.1) / (a.0 - b.0)).collect();
    let slope = if is_level { 0.0 } else { median(slopes).unwrap_or(0.0) };
    let start = median(points.iter().map(|(x, d)| d - slope * x).collect())?;
    Some([start, slope])
}

/// The plane that most of the points lie on, within `apart`: of many through three points the best (Fischler and Bolles
/// 1981), then least squares over those on it. `fits` says which planes can be.
pub(super) fn plane(points: &[Point], apart: f32, fits: impl Fn(Plane) -> bool) -> Option<Plane> {
    let mut dice = Dice(0x2545_F491);
    let score = |plane: Plane| -> f32 {
        let miss = |p: &Point| p.weight * ((plane.at(p.x, p.y) - p.d).abs() / apart).min(1.0);
        points.iter().map(miss).sum()
    };
    let mut best: Option<(f32, Plane)> = None;
    for _ in 0..TRIES {
        let three = [0; 3].map(|_: u32| points.get(dice.below(points.len())));
        let [Some(a), Some(b), Some(c)] = three else { return None };
        let Some(plane) = through(&[*a, *b, *c]).filter(|plane| fits(*plane)) else { continue };
        let missed = score(plane);
        if best.is_none_or(|(least, _)| missed < least) {
            best = Some((missed, plane));
        }
    }
    let (_, found) = best?;
    let on_it: Vec<Point> = points.iter().filter(|p| (found.at(p.x, p.y) - p.d).abs() < apart).copied().collect();
    through(&on_it).filter(|plane| fits(*plane)).or(Some(found))
}

/// Least squares; none where the points do not span a plane.
fn through(points: &[Point]) -> Option<Plane> {
    let count = points.len() as f32;
    let mean = |of: fn(&Point) -> f32| points.iter().map(of).sum::<f32>() / count;
    let (mx, my, md) = (mean(|p| p.x), mean(|p| p.y), mean(|p| p.d));
    let sum = |of: &dyn Fn(f32, f32, f32) -> f32| points.iter().map(|p| of(p.x - mx, p.y - my, p.d - md)).sum::<f32>();
    let (xx, xy, yy) = (sum(&|x, _, _| x * x), sum(&|x, y, _| x * y), sum(&|_, y, _| y * y));
    let (xd, yd) = (sum(&|x, _, d| x * d), sum(&|_, y, d| y * d));
    let det = xx * yy - xy * xy;
    let (b, c) = ((xd * yy - yd * xy) / det, (yd * xx - xd * xy) / det);
    (det > 1e-3 && b.is_finite() && c.is_finite()).then_some(Plane([md - b * mx - c * my, b, c]))
}

/// The same numbers at every run.
struct Dice(u32);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 as usize % end.max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_and_a_plane_are_found_among_points_that_lie_elsewhere() {
        let points: Vec<(f32, f32)> =
            (0..40).map(|i| (i as f32, if i % 3 == 0 { 9.0 } else { 2.0 + 0.5 * i as f32 })).collect();
        let [a, b] = line(&points, false).unwrap();
        assert!((a - 2.0).abs() < 0.3 && (b - 0.5).abs() < 0.02, "{a} {b}");
        assert_eq!(line(&points, true).unwrap()[1], 0.0);
        let at = |i: usize| {
            let (x, y) = ((i % 20) as f32, (i / 20) as f32);
            let d = if i % 5 < 2 { -3.0 } else { 1.0 - 0.1 * x + 0.2 * y };
            Point { x, y, d, weight: 1.0 }
        };
        let found = plane(&(0..400).map(at).collect::<Vec<_>>(), 0.05, |_| true).unwrap();
        assert!((found.at(10.0, 10.0) - 2.0).abs() < 0.02, "{found:?}");
        assert!(plane(&[], 0.05, |_| true).is_none() && line(&[], false).is_none());
    }
}
