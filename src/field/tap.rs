//! Values between pixels, and between 0 and 1.

use glam::{Vec3, Vec4};

/// What lies on a line between two of its kind.
pub trait Mix: Copy {
    /// `self` at 0, `other` at 1.
    fn mix(self, other: Self, t: f32) -> Self;
}

impl Mix for f32 {
    #[inline]
    fn mix(self, other: Self, t: f32) -> Self {
        self + (other - self) * t
    }
}

impl Mix for Vec3 {
    #[inline]
    fn mix(self, other: Self, t: f32) -> Self {
        self + (other - self) * t
    }
}

impl Mix for Vec4 {
    #[inline]
    fn mix(self, other: Self, t: f32) -> Self {
        self + (other - self) * t
    }
}

impl<const N: usize> Mix for [f32; N] {
    #[inline]
    fn mix(self, other: Self, t: f32) -> Self {
        std::array::from_fn(|c| self[c].mix(other[c], t))
    }
}

/// A place between four pixels of a picture of `[w, h]`: the numbers `y · w + x` of both above and both below, and how
/// far it is to the right and down, 0 … 1. Coordinates are clamped to the picture.
#[inline]
pub fn corners([w, h]: [usize; 2], x: f32, y: f32) -> ([usize; 4], [f32; 2]) {
    let (x, y) = (x.clamp(0.0, (w - 1) as f32), y.clamp(0.0, (h - 1) as f32));
    let (x0, y0) = (x as usize, y as usize);
    let (x1, y1) = ((x0 + 1).min(w - 1), (y0 + 1).min(h - 1));
    ([y0 * w + x0, y0 * w + x1, y1 * w + x0, y1 * w + x1], [x - x0 as f32, y - y0 as f32])
}

/// The value between four: linear in x, then in y.
#[inline]
pub fn between<T: Mix>([a, b, c, d]: [T; 4], [fx, fy]: [f32; 2]) -> T {
    a.mix(b, fx).mix(c.mix(d, fx), fy)
}

/// The value at a place between pixels, `at` giving that of a pixel `y · width + x`: coordinates are clamped to the
/// picture, then it is linear in x and in y.
#[inline]
pub fn bilinear<T: Mix>(sides: [usize; 2], x: f32, y: f32, at: impl Fn(usize) -> T) -> T {
    let (corners, shares) = corners(sides, x, y);
    between(corners.map(at), shares)
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
