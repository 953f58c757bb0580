//! Thin parts that hang on nothing: birds in a sky, foam, letters.
//!
//! A net draws them as it draws leaves and twigs. But a small thing in the air before nothing is far or no thing at all: it
//! stays with what lies behind it, sharp as that is. What hangs on a stem, or is cut off by the picture's edge, is kept.

use super::speckles::surfaces;
use crate::field::morphology::square;
use crate::job::{Cancel, Cancelled};

/// Pixels with less of a step than this belong to no part.
const LEAST_PX: f32 = 0.04;
/// A longer part is a stalk, a wire or a bar, whose ends may be hidden.
const LONG: f32 = 20.0;
/// What a part hangs on lies within these pixels of it, and is nearer than what lies behind by this share of its step.
const BESIDE: usize = 4;
const HELD: f32 = 0.3;

/// A picture's ray depths `[y, x]` where thin parts are to be put back.
pub(super) struct Ground<'a> {
    pub(super) size: [usize; 2],
    /// Without the parts.
    pub(super) map: &'a [f32],
    /// What the parts stand out of.
    pub(super) behind: &'a [f32],
    /// Px of this picture for each of those that lengths and steps are told in.
    pub(super) px: f32,
}

impl Ground<'_> {
    /// Takes the step from parts that hang on nothing.
    pub(super) fn let_go(&self, step_px: &mut [f32], cancel: &Cancel) -> Result<(), Cancelled> {
        let stands_out: Vec<bool> = step_px.iter().map(|step| *step > LEAST_PX * self.px).collect();
        let mut loose = Vec::new();
        let joined = |a: usize, b: usize| stands_out[a] && stands_out[b];
        surfaces(self.size, joined, cancel, |part| {
            if stands_out[part[0]] && self.is_short(part) && !self.is_held(part, step_px) {
                loose.extend_from_slice(part);
            }
        })?;
        loose.into_iter().for_each(|i| step_px[i] = 0.0);
        Ok(())
    }

    /// Whether a part lies within a small square, all of it in the picture.
    fn is_short(&self, part: &[usize]) -> bool {
        let [w, h] = self.size;
        [(w, 1), (h, w)].into_iter().all(|(side, stride)| {
            let at = || part.iter().map(|i| i / stride % side);
            let (first, last) = (at().min().unwrap_or(0), at().max().unwrap_or(0));
            first > 0 && last + 1 < side && ((last + 1 - first) as f32) < LONG * self.px
        })
    }

    /// Whether something beside a part is about as near as it.
    fn is_held(&self, part: &[usize], step_px: &[f32]) -> bool {
        let nearest = part.iter().map(|&i| self.behind[i] + step_px[i]).fold(f32::MIN, f32::max);
        let behind = part.iter().map(|&i| self.behind[i]).sum::<f32>() / part.len() as f32;
        let holds = behind + HELD * (nearest - behind);
        part.iter().any(|&i| square(self.size, i, BESIDE).any(|i| self.map[i] > holds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [60, 40];

    /// The steps that are left of a part before a far side of 0 and a thing of 1, each told by where it is.
    fn left(part: impl Fn(usize, usize) -> bool, thing: impl Fn(usize, usize) -> bool) -> usize {
        let map = |of: &dyn Fn(usize, usize) -> bool| -> Vec<f32> {
            (0..SIZE[0] * SIZE[1]).map(|i| f32::from(of(i % SIZE[0], i / SIZE[0]))).collect()
        };
        let (ground, mut step_px) = (map(&thing), map(&part));
        let ground = Ground { size: SIZE, map: &ground, behind: &vec![0.0; ground.len()], px: 1.0 };
        ground.let_go(&mut step_px, &Cancel::default()).unwrap();
        step_px.iter().filter(|step| **step > 0.0).count()
    }

    #[test]
    fn a_bird_stays_in_the_sky_and_a_leaf_on_its_stem() {
        let bird = |x: usize, y: usize| (20..25).contains(&x) && (10..12).contains(&y);
        assert_eq!(left(bird, |_, _| false), 0);
        assert_eq!(left(bird, |x, _| x > 40), 0, "what is near elsewhere does not hold it");
        assert_eq!(left(bird, |x, y| x > 24 && y > 10), 10);
    }

    #[test]
    fn a_wire_and_what_the_picture_cuts_off_are_kept() {
        assert_eq!(left(|x, y| (10..40).contains(&x) && y == 10, |_, _| false), 30);
        assert_eq!(left(|x, y| x < 5 && y == 10, |_, _| false), 5);
        assert_eq!(left(|x, y| x == 20 && y > 34, |_, _| false), 5);
    }
}
