//! Values between pixels, and between 0 and 1.

use std::ops::{Add, Mul, Sub};

/// The value at a place between pixels, `at` giving that of a pixel `y · width + x`: coordinates are clamped to the
/// picture, then it is linear in x and in y.
#[inline]
pub fn bilinear<T>([w, h]: [usize; 2], x: f32, y: f32, at: impl Fn(usize) -> T) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
{
    let (x, y) = (x.clamp(0.0, (w - 1) as f32), y.clamp(0.0, (h - 1) as f32));
    let (x0, y0) = (x as usize, y as usize);
    let (x1, y1) = ((x0 + 1).min(w - 1), (y0 + 1).min(h - 1));
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    let along = |row: usize| at(row * w + x0) + (at(row * w + x1) - at(row * w + x0)) * fx;
    let (above, below) = (along(y0), along(y1));
    above + (below - above) * fy
}

/// Smooth step from 0 at `from` to 1 at `to`.
#[inline]
pub fn ramp(from: f32, to: f32, value: f32) -> f32 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::bilinear;

    #[test]
    fn pixels_are_exact_and_edges_go_on() {
        let values = [0.0, 1.0, 2.0, 10.0, 11.0, 12.0];
        let at = |x, y| bilinear([3, 2], x, y, |i| values[i]);
        assert_eq!((at(2.0, 1.0), at(1.5, 0.0), at(1.0, 0.5), at(0.5, 0.25)), (12.0, 1.5, 6.0, 3.0));
        assert_eq!((at(-5.0, -5.0), at(9.0, 9.0)), (0.0, 12.0));
    }
}
