//! The pixels of a thing: without holes, and out to the photo's edge.

use super::guide::{Guide, apart};
use super::reach::neighbours;
use crate::field::morphology::square;

/// Holes smaller than this part of the thing are specks of it.
const SPECK: f32 = 0.03;
/// Pixels by which a thing may grow onto the mixed colours of its rim.
const RIM: usize = 2;
/// How far around a rim's pixel both sides' colours are looked at, in pixels.
const AROUND: usize = 3;

/// The pixels of a thing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    sides: [usize; 2],
    inside: Vec<bool>,
}

impl Mask {
    pub(super) fn new(sides: [usize; 2], inside: impl Fn(usize) -> bool) -> Self {
        Self { sides, inside: (0..sides[0] * sides[1]).map(inside).collect() }
    }

    /// Columns and rows.
    pub fn sides(&self) -> [usize; 2] {
        self.sides
    }

    /// Whether a pixel, `y · width + x`, belongs to it.
    #[inline]
    pub fn has(&self, i: usize) -> bool {
        self.inside[i]
    }

    /// The numbers of its pixels, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = usize> {
        self.inside.iter().enumerate().filter_map(|(i, inside)| inside.then_some(i))
    }

    /// How many pixels it has.
    pub fn count(&self) -> usize {
        self.pixels().count()
    }

    /// Whether a pixel of it has a neighbour outside.
    pub fn is_rim(&self, i: usize) -> bool {
        self.inside[i] && neighbours(self.sides, i).any(|(next, _)| !self.inside[next])
    }

    /// Takes in the holes that are small.
    pub(super) fn without_specks(mut self) -> Self {
        let most = (self.count() as f32 * SPECK) as usize;
        let mut is_seen = self.inside.clone();
        for start in 0..self.inside.len() {
            if is_seen[start] {
                continue;
            }
            let part = self.part_outside(start, &mut is_seen);
            if part.len() <= most && !part.iter().any(|i| self.is_at_edge(*i)) {
                part.into_iter().for_each(|i| self.inside[i] = true);
            }
        }
        self
    }

    /// What hangs together with a pixel outside.
    fn part_outside(&self, start: usize, is_seen: &mut [bool]) -> Vec<usize> {
        let mut part = vec![start];
        is_seen[start] = true;
        let mut next = 0;
        while next < part.len() {
            for (i, px) in neighbours(self.sides, part[next]) {
                if px == 1.0 && !is_seen[i] {
                    is_seen[i] = true;
                    part.push(i);
                }
            }
            next += 1;
        }
        part
    }

    fn is_at_edge(&self, i: usize) -> bool {
        let ([w, h], x, y) = (self.sides, i % self.sides[0], i / self.sides[0]);
        x == 0 || y == 0 || x + 1 == w || y + 1 == h
    }

    /// Grows onto the pixels of the rim whose colour is more that of the inside than that of the outside.
    pub(super) fn out_to_edge(mut self, guide: &Guide) -> Self {
        for _ in 0..RIM {
            let is_mine = |i: &usize| {
                let own = guide.colour(*i);
                let side = |wanted: bool| {
                    guide.mean(square(self.sides, *i, AROUND).filter(|j| *j != *i && self.inside[*j] == wanted))
                };
                matches!((side(true), side(false)), (Some(a), Some(b)) if apart(own, a) < apart(own, b))
            };
            let is_beside = |i: &usize| !self.inside[*i] && neighbours(self.sides, *i).any(|(n, _)| self.inside[n]);
            let more: Vec<usize> = (0..self.inside.len()).filter(is_beside).filter(is_mine).collect();
            more.into_iter().for_each(|i| self.inside[i] = true);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn specks_are_taken_in_and_what_reaches_the_edge_is_not() {
        // A square with a speck, a large hole and a notch at the picture's edge.
        let hole = |x: usize, y: usize| (10..20).contains(&x) && (10..20).contains(&y);
        let inside = |i: usize| {
            let (x, y) = (i % 40, i / 40);
            !((x, y) == (5, 5) || hole(x, y) || x == 39)
        };
        let mask = Mask::new([40, 40], inside).without_specks();
        assert!(mask.has(5 * 40 + 5) && !mask.has(15 * 40 + 15) && !mask.has(39));
        assert_eq!(mask.count(), 1600 - 100 - 40);
    }
}
