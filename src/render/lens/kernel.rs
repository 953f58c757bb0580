//! Lens kernels: the shape of a blurred point, as spans of rows with fractional coverage at the rim.
//!
//! A point's light is spread over a few spans; a span is two steps in a table of differences, so a kernel costs twice
//! its rows, whatever its area. Every kernel adds up to 1 exactly: light is neither made nor lost.

use std::f32::consts::PI;
use std::sync::OnceLock;

use crate::field::{Glass, LensShape};

/// Sub-rows by which shapes other than the disc are measured.
const SUB_ROWS: usize = 4;
/// Light that spherical aberration brings from the middle of a disc to its rim at most, as a part of all.
const MOST_SPHERICAL: f32 = 0.8;
/// A disc of uneven light is a sum of even ones, so many pixels of diameter apart, and so many at most.
const RING_PX: f32 = 1.5;
const MOST_RINGS: usize = 24;
/// Part of the diameter that is the finest in a picture's opening: fine rays and holes may be softened in wide, even parts.
const PICTURE_FINEST: f32 = 0.4;
/// Corners of the polygon that stands for a rounded opening.
const CORNERS: usize = 180;

/// One span of a kernel, as two steps of two differences each.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Row, from the point.
    pub dy: i32,
    /// Column where the span begins, from the point, and the steps there and in the next column.
    pub begin: (i32, [f32; 2]),
    /// Column where it ends, and the steps down.
    pub end: (i32, [f32; 2]),
}

impl Span {
    /// From `left` to `right` in pixels from the point's centre; `weight` is the value inside.
    fn new(dy: i32, left: f32, right: f32, weight: f32) -> Self {
        let step = |at: f32| {
            let column = (at + 0.5).floor();
            let part = column + 0.5 - at;
            (column as i32, [weight * part, weight * (1.0 - part)])
        };
        Self { dy, begin: step(left), end: step(right) }
    }

    /// The same with more or less light.
    pub(super) fn times(&self, times: f32) -> Self {
        let scaled = |(at, parts): (i32, [f32; 2])| (at, parts.map(|part| part * times));
        Self { dy: self.dy, begin: scaled(self.begin), end: scaled(self.end) }
    }

    /// The same light on a part of the width.
    fn narrowed(&self, part: f32) -> Self {
        let weight = self.begin.1[0] + self.begin.1[1];
        let place = |(column, [first, _]): (i32, [f32; 2])| column as f32 + 0.5 - first / weight;
        if weight == 0.0 {
            return *self;
        }
        Self::new(self.dy, place(self.begin) * part, place(self.end) * part, weight / part)
    }
}

/// A blurred point of one diameter, its spans in order of rows.
#[derive(Clone, Debug, Default)]
pub struct Kernel {
    /// The spans.
    pub spans: Vec<Span>,
    /// Columns and rows that the spans reach, with the one after the last.
    pub reach: i32,
}

impl Kernel {
    pub(super) fn of(spans: Vec<Span>) -> Self {
        let reach = spans.iter().map(|s| (-s.begin.0).max(s.end.0 + 1).max(s.dy.abs() + 1)).max().unwrap_or(0);
        Self { spans, reach }
    }

    /// A disc of any diameter: each row has the width that the disc has there on average.
    pub fn disc(diameter_px: f32) -> Self {
        let mut spans = Vec::new();
        push_disc(&mut spans, diameter_px / 2.0, 1.0 / (PI * (diameter_px / 2.0).powi(2)));
        Self::of(spans)
    }

    /// The lens's shape at a diameter; `flipped` for points beyond the focal plane, whose blades stand on their head.
    /// `place` is the point's place in the picture, −1 … 1 in both axes (for the cat's eye).
    pub fn new(shape: &LensShape, diameter_px: f32, flipped: bool, place: [f32; 2]) -> Self {
        let radius = diameter_px / 2.0;
        match *shape {
            LensShape::Disc => Self::disc(diameter_px),
            LensShape::Square => {
                Self::outline(&[[radius, radius], [-radius, radius], [-radius, -radius], [radius, -radius]])
            }
            LensShape::Ring { inner } => Self::ring(radius, inner.clamp(0.0, 0.9)),
            LensShape::Blades { count, rotation_deg, roundness } => {
                let turn = rotation_deg.to_radians() + if flipped { PI } else { 0.0 };
                Self::outline(&blades(radius, LensShape::blades(count), turn, roundness.clamp(0.0, 1.0)))
            }
            LensShape::CatEye { strength } => {
                let side = if flipped { -1.0 } else { 1.0 };
                Self::outline(&cat_eye(radius, place.map(|p| side * p * strength.clamp(0.0, 1.0))))
            }
            LensShape::Picture(ref opening) => Self::of_opening(opening, &Glass::PLAIN, 0.0, diameter_px, flipped),
        }
    }

    /// As [`new`](Self::new), with a lens's faults.
    ///
    /// Spherical aberration gives the disc the light `1 + a·(2r² − 1)` at a part `r` of its radius. That is a sum of even
    /// discs: one of the whole radius with `1 + a` of the light, and one of each part `t` of it with `−4a·t³ dt`. The same
    /// holds for every opening that its smaller self lies within; a mirror lens, whose hole would be filled, has none.
    pub fn through(glass: &Glass, shape: &LensShape, diameter_px: f32, flipped: bool, place: [f32; 2]) -> Self {
        let side = if flipped { 1.0 } else { -1.0 };
        let light = side * MOST_SPHERICAL * glass.spherical.clamp(-1.0, 1.0);
        if let LensShape::Picture(opening) = shape {
            return Self::of_opening(opening, glass, light, diameter_px, flipped);
        }
        let has_hole = matches!(shape, LensShape::Ring { .. });
        let rings = if has_hole { 0 } else { ((diameter_px / RING_PX) as usize).min(MOST_RINGS) };
        let mut kernel = Self::new(shape, diameter_px, flipped, place);
        if light != 0.0 && rings > 1 {
            let mut spans = Vec::new();
            let mut add = |kernel: &Self, times: f32| spans.extend(kernel.spans.iter().map(|span| span.times(times)));
            let part = |ring: usize| (ring as f32 + 0.5) / rings as f32;
            let share = |ring: usize| -4.0 * light * part(ring).powi(3) / rings as f32;
            add(&kernel, 1.0 - (0..rings).map(share).sum::<f32>());
            for ring in 0..rings {
                add(&Self::new(shape, diameter_px * part(ring), flipped, place), share(ring));
            }
            spans.sort_by_key(|span: &Span| span.dy);
            kernel = Self::of(spans);
        }
        if glass.anamorphic > 0.0 {
            kernel = Self::of(kernel.spans.iter().map(|span| span.narrowed(glass.narrow())).collect());
        }
        kernel
    }

    fn ring(radius: f32, inner: f32) -> Self {
        let light = 1.0 / (PI * radius * radius * (1.0 - inner * inner));
        let mut spans = Vec::new();
        push_disc(&mut spans, radius, light);
        if radius * inner > 0.5 {
            push_disc(&mut spans, radius * inner, -light);
            spans.sort_by_key(|span| span.dy);
        } else {
            return Self::disc(radius * 2.0);
        }
        Self::of(spans)
    }

    /// A convex opening by its corners.
    fn outline(corners: &[[f32; 2]]) -> Self {
        let reach = corners.iter().map(|c| c[1].abs()).fold(0.0, f32::max);
        let rows = (reach + 0.5).ceil() as i32;
        let mut spans = Vec::new();
        let mut area = 0.0;
        for dy in -rows..=rows {
            let subs: Vec<[f32; 2]> = (0..SUB_ROWS)
                .filter_map(|i| chord(corners, dy as f32 - 0.5 + (i as f32 + 0.5) / SUB_ROWS as f32))
                .collect();
            if subs.is_empty() {
                continue;
            }
            let count = subs.len() as f32;
            let mean = |side: usize| subs.iter().map(|s| s[side]).sum::<f32>() / count;
            let (left, right, share) = (mean(0), mean(1), count / SUB_ROWS as f32);
            area += (right - left) * share;
            spans.push((dy, left, right, share));
        }
        if area <= 0.0 {
            return Self::point();
        }
        Self::of(spans.into_iter().map(|(dy, l, r, share)| Span::new(dy, l, r, share / area)).collect())
    }

    /// No blur.
    fn point() -> Self {
        Self::of(vec![Span::new(0, -0.5, 0.5, 1.0)])
    }
}

/// The rows of a disc, with `light` inside.
fn push_disc(spans: &mut Vec<Span>, radius: f32, light: f32) {
    // Area under the half chord from the middle to y.
    let area = |y: f32| {
        let y = y.clamp(-radius, radius);
        0.5 * (y * (radius * radius - y * y).max(0.0).sqrt() + radius * radius * (y / radius).clamp(-1.0, 1.0).asin())
    };
    let rows = (radius + 0.5).ceil() as i32;
    for dy in -rows..=rows {
        let top = (dy as f32 - 0.5).max(-radius);
        let bottom = (dy as f32 + 0.5).min(radius);
        let share = bottom - top;
        if share > 1e-4 {
            let half = (area(bottom) - area(top)) / share;
            spans.push(Span::new(dy, -half, half, light * share));
        }
    }
}

/// Where a row crosses a convex outline.
fn chord(corners: &[[f32; 2]], y: f32) -> Option<[f32; 2]> {
    let mut span: Option<[f32; 2]> = None;
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        if (a[1] <= y) != (b[1] <= y) {
            let x = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
            let [left, right] = span.unwrap_or([x, x]);
            span = Some([left.min(x), right.max(x)]);
        }
    }
    span.filter(|[left, right]| right > left)
}

/// Straight blades between corners on the rim, bent outward by the roundness.
fn blades(radius: f32, count: u8, turn: f32, roundness: f32) -> Vec<[f32; 2]> {
    let sector = 2.0 * PI / f32::from(count);
    let corner = |i: usize| {
        let angle = i as f32 / CORNERS as f32 * 2.0 * PI;
        let straight = (sector / 2.0).cos() / (angle.rem_euclid(sector) - sector / 2.0).cos();
        let reach = radius * (straight + (1.0 - straight) * roundness);
        [reach * (angle + turn - PI / 2.0).cos(), reach * (angle + turn - PI / 2.0).sin()]
    };
    (0..CORNERS).map(corner).collect()
}

/// A disc cut by the barrel's, which stands off towards the middle by up to one radius.
fn cat_eye(radius: f32, off: [f32; 2]) -> Vec<[f32; 2]> {
    let corner = |i: usize| {
        let angle = i as f32 / CORNERS as f32 * 2.0 * PI;
        let [dx, dy] = [angle.cos(), angle.sin()];
        // Ray from the middle of the overlap, so that both discs are left once.
        let middle = off.map(|o| -o * radius / 2.0);
        let reach = |center: [f32; 2]| {
            let from = [middle[0] - center[0], middle[1] - center[1]];
            let along = from[0] * dx + from[1] * dy;
            let apart = from[0] * from[0] + from[1] * from[1] - radius * radius;
            -along + (along * along - apart).max(0.0).sqrt()
        };
        let far = reach([0.0, 0.0]).min(reach([-off[0] * radius, -off[1] * radius]));
        [middle[0] + far * dx, middle[1] + far * dy]
    };
    (0..CORNERS).map(corner).collect()
}

/// Index of the table's diameter nearest to one: steps of 1/16 px, from 8 px on of 1/8, from 32 px on of 1/4.
pub fn index_of(diameter_px: f32) -> usize {
    let c = diameter_px;
    let steps = if c < 8.0 {
        c * 16.0
    } else if c < 32.0 {
        128.0 + (c - 8.0) * 8.0
    } else {
        320.0 + (c - 32.0) * 4.0
    };
    (steps + 0.5) as usize
}

/// The diameter at an index.
pub fn diameter_at(index: usize) -> f32 {
    let i = index as f32;
    if index < 128 {
        i / 16.0
    } else if index < 320 {
        8.0 + (i - 128.0) / 8.0
    } else {
        32.0 + (i - 320.0) / 4.0
    }
}

/// Places per axis at which a cat's eye is shaped anew.
pub const PLACES: usize = 48;

/// All kernels of a lens, made when first needed.
pub struct Kernels {
    shape: LensShape,
    glass: Glass,
    size: [f32; 2],
    per_place: usize,
    table: Vec<OnceLock<Kernel>>,
}

impl Kernels {
    /// Kernels up to a diameter, for a picture of a size.
    pub fn new(shape: LensShape, glass: Glass, largest_px: f32, size: [u32; 2]) -> Self {
        let shape = match shape {
            // A swirl is cut by the barrel too.
            LensShape::Disc if glass.swirl > 0.0 => LensShape::CatEye { strength: glass.swirl },
            LensShape::CatEye { strength } => LensShape::CatEye { strength: strength.max(glass.swirl) },
            other => other,
        };
        let shape = match shape {
            LensShape::CatEye { strength } if strength <= 0.0 => LensShape::Disc,
            other => other,
        };
        let places = if matches!(shape, LensShape::CatEye { .. }) { PLACES * PLACES } else { 1 };
        let per_place = 2 * (index_of(largest_px) + 2);
        let table = std::iter::repeat_with(OnceLock::new).take(places * per_place).collect();
        Self { shape, glass, size: size.map(|s| s as f32), per_place, table }
    }

    /// Part of the diameter that is the finest in the lens's shape: 1, less for a ring's wall, a picture and narrow discs.
    pub fn finest(&self) -> f32 {
        let wall = match self.shape {
            LensShape::Ring { inner } => 1.0 - inner.clamp(0.0, 0.9),
            LensShape::Picture(_) => PICTURE_FINEST,
            _ => 1.0,
        };
        wall * self.glass.narrow()
    }

    /// The kernel for a point at `(x, y)` of the picture.
    #[inline]
    pub fn get(&self, index: usize, flipped: bool, x: i32, y: i32) -> &Kernel {
        let cat_eye = matches!(self.shape, LensShape::CatEye { .. });
        let cell = |at: i32, side: f32| ((at as f32 / side * PLACES as f32) as usize).min(PLACES - 1);
        let [px, py] = if cat_eye { [cell(x, self.size[0]), cell(y, self.size[1])] } else { [0, 0] };
        // A cat's eye changes slowly: every fourth diameter will do.
        let index = if cat_eye && index > 32 { index & !3 } else { index };
        let at = (py * PLACES + px) * self.per_place + (2 * index + usize::from(flipped)).min(self.per_place - 1);
        self.table[at].get_or_init(|| {
            let middle = |cell: usize, side: f32| (2.0 * (cell as f32 + 0.5) / PLACES as f32 - 1.0) * side;
            let diagonal = self.size[0].hypot(self.size[1]);
            let place = [middle(px, self.size[0] / diagonal), middle(py, self.size[1] / diagonal)];
            let diameter = diameter_at(index);
            if diameter < 0.05 {
                Kernel::point()
            } else {
                Kernel::through(&self.glass, &self.shape, diameter, flipped, place)
            }
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::opening;
    use super::*;

    /// The kernel drawn into a square of pixels.
    pub fn drawn(kernel: &Kernel, half: i32) -> Vec<Vec<f32>> {
        let side = (2 * half + 1) as usize;
        let mut rows = vec![vec![0.0; side + 2]; side];
        for span in &kernel.spans {
            let row = &mut rows[(span.dy + half) as usize];
            for (sign, (column, parts)) in [(1.0, span.begin), (-1.0, span.end)] {
                row[(column + half) as usize] += sign * parts[0];
                row[(column + half + 1) as usize] += sign * parts[1];
            }
        }
        for row in &mut rows {
            for x in 1..row.len() {
                row[x] += row[x - 1];
            }
        }
        rows
    }

    fn all_shapes() -> [LensShape; 7] {
        [
            opening::tests::letter(),
            LensShape::Disc,
            LensShape::Square,
            LensShape::Blades { count: 5, rotation_deg: 10.0, roundness: 0.0 },
            LensShape::Blades { count: 8, rotation_deg: 0.0, roundness: 0.5 },
            LensShape::Ring { inner: 0.4 },
            LensShape::CatEye { strength: 0.8 },
        ]
    }

    #[test]
    fn every_kernel_adds_up_to_one_and_is_never_negative() {
        for shape in all_shapes() {
            for diameter in [0.1, 1.0, 2.3, 3.0, 7.9, 20.5, 61.0] {
                let kernel = Kernel::new(&shape, diameter, false, [0.6, -0.6]);
                let rows = drawn(&kernel, 40);
                let sum: f32 = rows.iter().flatten().sum();
                assert!((sum - 1.0).abs() < 1e-3, "{shape:?} {diameter}: {sum}");
                assert!(rows.iter().flatten().all(|&v| v > -1e-4), "{shape:?} {diameter}");
            }
        }
    }

    /// Many faults of all kinds.
    fn faults() -> impl Iterator<Item = Glass> {
        let all = [-1.0, -0.4, 0.0, 0.5, 1.0];
        let of = move |i: usize| Glass { spherical: all[i % 5], anamorphic: all[2 + i % 3], ..Glass::PLAIN };
        (0..15).map(of)
    }

    #[test]
    fn faults_make_no_light_and_lose_none() {
        for (shape, glass) in all_shapes().iter().flat_map(|shape| faults().map(move |glass| (shape, glass))) {
            for diameter in [0.1, 2.3, 7.9, 20.5, 61.0] {
                let rows = drawn(&Kernel::through(&glass, shape, diameter, true, [0.6, -0.6]), 40);
                let sum: f32 = rows.iter().flatten().sum();
                assert!((sum - 1.0).abs() < 2e-3, "{shape:?} {glass:?} {diameter}: {sum}");
                let even = 4.0 / (PI * diameter * diameter).max(1.0);
                let least = rows.iter().flatten().copied().fold(f32::MAX, f32::min);
                assert!(least > -0.05 * even, "{shape:?} {glass:?} {diameter}: {least} of {even}");
            }
        }
    }

    #[test]
    fn anamorphic_discs_are_as_tall_as_round_ones_and_as_much_narrower_as_asked() {
        for (anamorphic, diameter) in [(0.33, 30.0f32), (1.0, 30.0), (1.0, 61.0)] {
            let glass = Glass { anamorphic, ..Glass::PLAIN };
            let rows = drawn(&Kernel::through(&glass, &LensShape::Disc, diameter, false, [0.0; 2]), 40);
            let inside = rows[40][40];
            let across: f32 = rows[40].iter().sum::<f32>() / inside;
            let down: f32 = rows.iter().map(|row| row[40]).sum::<f32>() / inside;
            assert!((down - diameter).abs() < 0.6, "{anamorphic}: {down}");
            assert!((across - diameter / (1.0 + anamorphic)).abs() < 0.6, "{anamorphic}: {across}");
        }
    }

    #[test]
    fn spherical_aberration_brightens_the_rim_behind_the_focus_and_the_middle_before_it() {
        for spherical in [-1.0, -0.5, 0.5, 1.0] {
            for flipped in [false, true] {
                let glass = Glass { spherical, ..Glass::PLAIN };
                let rows = drawn(&Kernel::through(&glass, &LensShape::Disc, 60.0, flipped, [0.0; 2]), 40);
                let light = if flipped { spherical } else { -spherical } * MOST_SPHERICAL;
                let even = 4.0 / (PI * 60.0 * 60.0);
                for part in [0.1f32, 0.5, 0.8] {
                    let got = rows[40][40 + (part * 30.0) as usize] / even;
                    let at = (part * 30.0).floor() / 30.0;
                    let want = 1.0 + light * (2.0 * at * at - 1.0);
                    assert!((got - want).abs() < 0.09, "{spherical} {flipped} at {part}: {got} for {want}");
                }
            }
        }
    }

    #[test]
    fn a_disc_is_even_inside_and_as_wide_as_asked() {
        for diameter in [3.0f32, 10.0, 33.3, 77.0] {
            let rows = drawn(&Kernel::disc(diameter), 40);
            let inside = 4.0 / (PI * diameter * diameter);
            let across: f32 = rows[40].iter().sum::<f32>() / inside;
            let down: f32 = rows.iter().map(|row| row[40]).sum::<f32>() / inside;
            assert!((across - diameter).abs() < 0.5 && (down - diameter).abs() < 0.5, "{diameter}: {across} {down}");
        }
    }

    #[test]
    fn odd_blades_stand_on_their_head_beyond_the_focal_plane() {
        let shape = LensShape::Blades { count: 5, rotation_deg: 0.0, roundness: 0.0 };
        let near = drawn(&Kernel::new(&shape, 30.0, false, [0.0; 2]), 20);
        let far = drawn(&Kernel::new(&shape, 30.0, true, [0.0; 2]), 20);
        let rows = |picture: &[Vec<f32>]| picture.iter().map(|r| r.iter().sum::<f32>()).collect::<Vec<_>>();
        let upside_down: Vec<f32> = rows(&far).into_iter().rev().collect();
        let apart = |other: &[f32]| rows(&near).iter().zip(other).map(|(a, b)| (a - b).abs()).sum::<f32>();
        assert!(apart(&upside_down) < 0.02, "{}", apart(&upside_down));
        assert!(apart(&rows(&far)) > 0.1);
    }

    #[test]
    fn the_table_is_finer_than_what_can_be_seen() {
        for i in 0..4000 {
            let diameter = i as f32 * 0.1;
            assert!((diameter_at(index_of(diameter)) - diameter).abs() <= 0.126);
        }
    }
}
