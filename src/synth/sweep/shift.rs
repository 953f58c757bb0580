//! Pictures moved by fractions of a pixel, without the blur of linear sampling.
//!
//! A shift is a ramp of phase in the Fourier domain (Jeon et al. 2015). Its equal among pixels is the sinc; cut to six taps
//! by Lanczos' window it does the same without running over the picture's edge into the opposite one.

/// Taps along one axis.
const TAPS: usize = 6;
/// Taps before the pixel that a place lies in.
const BEFORE: usize = 2;
/// Pixels that a plane needs around it beyond the whole pixels of a shift.
pub(super) const MARGIN: usize = TAPS - BEFORE;

/// A plane of values with its edge pixels repeated all round.
pub(super) struct Padded {
    values: Vec<f32>,
    width: usize,
    stride: usize,
    margin: usize,
}

impl Padded {
    /// A plane `[y, x]` with so many pixels around it.
    pub(super) fn new(plane: &[f32], [w, h]: [usize; 2], margin: usize) -> Self {
        let stride = w + 2 * margin;
        let mut values = Vec::with_capacity(stride * (h + 2 * margin));
        for y in 0..h + 2 * margin {
            let row = &plane[y.saturating_sub(margin).min(h - 1) * w..][..w];
            values.extend((0..stride).map(|x| row[x.saturating_sub(margin).min(w - 1)]));
        }
        Self { values, width: w, stride, margin }
    }

    /// Values of a row.
    pub(super) fn stride(&self) -> usize {
        self.stride
    }
}

/// A move to the right and down: what lies there comes here.
pub(super) struct Shift {
    whole: [isize; 2],
    taps: [[f32; TAPS]; 2],
}

impl Shift {
    /// By `dx` and `dy` pixels.
    pub(super) fn new(dx: f32, dy: f32) -> Self {
        let taps = [dx, dy].map(|d| taps(d - d.floor()));
        Self { whole: [dx, dy].map(|d| d.floor() as isize), taps }
    }

    /// Row `y` of the moved plane; `between` has room for a row of the padded one.
    pub(super) fn row(&self, plane: &Padded, y: usize, between: &mut [f32], out: &mut [f32]) {
        let at = |whole: isize, i: usize, tap: usize| (plane.margin + i + tap - BEFORE).wrapping_add_signed(whole);
        between.fill(0.0);
        for (tap, weight) in self.taps[1].iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            let from = &plane.values[at(self.whole[1], y, tap) * plane.stride..][..plane.stride];
            between.iter_mut().zip(from).for_each(|(b, f)| *b += weight * f);
        }
        out.fill(0.0);
        for (tap, weight) in self.taps[0].iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            let from = &between[at(self.whole[0], 0, tap)..][..plane.width];
            out.iter_mut().zip(from).for_each(|(o, f)| *o += weight * f);
        }
    }
}

/// Weights of the taps for a place `fraction` of a pixel, 0 … 1, behind its own.
fn taps(fraction: f32) -> [f32; TAPS] {
    let lanczos = |x: f32| {
        let (t, window) = (std::f32::consts::PI * x, std::f32::consts::PI * x / MARGIN.min(BEFORE + 1) as f32);
        if x.abs() < 1e-4 { 1.0 } else { t.sin() / t * (window.sin() / window) }
    };
    if fraction < 1e-4 {
        return std::array::from_fn(|tap| f32::from(u8::from(tap == BEFORE)));
    }
    let weights: [f32; TAPS] = std::array::from_fn(|tap| lanczos(tap as f32 - BEFORE as f32 - fraction));
    let sum: f32 = weights.iter().sum();
    weights.map(|weight| weight / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shift_is_the_ramp_of_phase_that_it_stands_for() {
        // Waves that a picture holds, each moved by its phase.
        let wave = |x: f32, y: f32| (0.7 * x + 0.2).sin() + 0.5 * (1.4 * x - 0.9 * y).cos() + 0.3 * (1.1 * y).sin();
        let size = [40, 30];
        let plane: Vec<f32> = (0..1200).map(|i| wave((i % 40) as f32, (i / 40) as f32)).collect();
        let padded = Padded::new(&plane, size, 8);
        let (mut between, mut row) = (vec![0.0; padded.stride()], vec![0.0; 40]);
        let worst = |dx: f32, dy: f32, between: &mut [f32], row: &mut [f32]| {
            Shift::new(dx, dy).row(&padded, 15, between, row);
            (8..32).map(|x| (row[x] - wave(x as f32 + dx, 15.0 + dy)).abs()).fold(0.0, f32::max)
        };
        for (dx, dy) in [(0.5, 0.0), (-0.25, 0.75), (2.4, -3.6), (-3.9, 1.1)] {
            let error = worst(dx, dy, &mut between, &mut row);
            assert!(error < 0.03, "moved by {dx}, {dy}: {error}, where linear sampling is off by 0.15");
        }
        assert_eq!(worst(-2.0, 3.0, &mut between, &mut row), 0.0, "whole pixels are exact");
        let flat = Padded::new(&[0.3; 1200], size, 8);
        Shift::new(0.37, -0.21).row(&flat, 0, &mut between, &mut row);
        assert!(row.iter().all(|v| (v - 0.3).abs() < 1e-6), "even light stays even, at the edge too");
    }
}
