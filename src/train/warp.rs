//! The rendering layer in plain Rust: bilinear sampling with clamped coordinates, and its derivative.

/// A bilinear sample position along one axis: `index` and the next pixel, the fraction between them, and whether the
/// position moves with its argument (0 where it is clamped).
#[derive(Clone, Copy)]
pub struct Tap {
    /// The pixel at or before the position; the next one exists.
    pub index: usize,
    /// 0 … 1 towards the next pixel.
    pub fraction: f32,
    /// Derivative of the clamped position: 1 inside, 0 outside.
    pub slope: f32,
}

/// The tap at `position` on an axis of `n ≥ 2` pixels.
#[inline]
pub fn tap(position: f32, n: usize) -> Tap {
    let end = (n - 1) as f32;
    let clamped = position.clamp(0.0, end);
    let index = (clamped as usize).min(n - 2);
    let slope = if (0.0..=end).contains(&position) { 1.0 } else { 0.0 };
    Tap { index, fraction: clamped - index as f32, slope }
}

/// A picture's sample at two taps with its derivatives: `(value, d/dx, d/dy)`.
#[inline]
pub fn sample(plane: &[f32], width: usize, x: Tap, y: Tap) -> (f32, f32, f32) {
    let at = y.index * width + x.index;
    let (a, b, c, d) = (plane[at], plane[at + 1], plane[at + width], plane[at + width + 1]);
    let (top, bottom) = (a + (b - a) * x.fraction, c + (d - c) * x.fraction);
    let dx = ((b - a) * (1.0 - y.fraction) + (d - c) * y.fraction) * x.slope;
    let dy = ((c - a) * (1.0 - x.fraction) + (d - b) * x.fraction) * y.slope;
    (top + (bottom - top) * y.fraction, dx, dy)
}

/// The four pixels of a sample and their weights, to scatter a gradient with.
#[inline]
pub fn weights(width: usize, x: Tap, y: Tap) -> [(usize, f32); 4] {
    let at = y.index * width + x.index;
    let (fx, fy) = (x.fraction, y.fraction);
    [(at, (1.0 - fx) * (1.0 - fy)), (at + 1, fx * (1.0 - fy)), (at + width, (1.0 - fx) * fy), (at + width + 1, fx * fy)]
}

/// By how much nearer the reference view's surface must be for what is behind it to count as hidden, px per view step.
const HIDDEN_PX: f32 = 0.15;

/// What the reference view knows of a ray's end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RayEnd {
    /// It sees it, or nobody knows how far away it is.
    Seen,
    /// It sees something nearer there.
    Hidden,
    /// It lies beside the picture.
    Outside,
}

/// Where pixel `i` of a view `(du, dv)` steps away ends, its ray depth being `d` and those of the reference view
/// `reference` `[y, x]`, `width` wide; px per view step.
pub fn ray_end(reference: &[f32], width: usize, i: usize, (du, dv): (f32, f32), d: f32) -> RayEnd {
    let height = reference.len() / width;
    let (x, y) = ((i % width) as f32 + du * d, (i / width) as f32 + dv * d);
    if d.is_nan() {
        return RayEnd::Seen;
    }
    if x < 0.0 || y < 0.0 || x > (width - 1) as f32 || y > (height - 1) as f32 {
        return RayEnd::Outside;
    }
    let corners = [(x.floor(), y.floor()), (x.ceil(), y.floor()), (x.floor(), y.ceil()), (x.ceil(), y.ceil())];
    let nearer = corners.iter().all(|&(x, y)| reference[y as usize * width + x as usize] - d > HIDDEN_PX);
    if nearer { RayEnd::Hidden } else { RayEnd::Seen }
}
