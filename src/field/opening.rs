//! A picture as the opening of a lens: how much light passes where.

use std::sync::Arc;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

use super::{Size, sides};

/// Side of an opening that is made here, in cells.
const SIDE: u8 = 64;
/// The largest side that a recipe may bring.
const MOST_SIDE: u8 = 128;
/// What is darker than this part of the brightest is closed: the grain of a scanned black.
const CLOSED: f32 = 0.03;

/// How much light passes a lens, as a square picture. Its light is centred, so that a wider lens moves nothing; what is
/// farthest from the middle and open lies on the lens's rim. Copies share their memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct Opening {
    side: u8,
    light: Arc<[u8]>,
}

/// As it stands in a recipe.
#[derive(Clone, Serialize, Deserialize)]
struct Stored {
    side: u8,
    /// `[y, x]`, a byte each, as base64.
    light: String,
}

impl Opening {
    /// From a picture, `[y, x]`: 0 lets nothing through, the brightest value all. None where it is black everywhere.
    pub fn of_picture(size: Size, light: &[f32]) -> Option<Self> {
        let brightest = light.iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
        let passes = |v: &f32| if *v > CLOSED * brightest { v / brightest } else { 0.0 };
        let light: Vec<f32> = if brightest > 0.0 { light.iter().map(passes).collect() } else { return None };
        let (middle, reach) = middle_and_reach(sides(size)[0], &light);
        let sums = Integral::new(sides(size), |x, y| light[y * sides(size)[0] + x].into());
        let step = 2.0 * reach / f64::from(SIDE);
        let cell = |i: usize, middle: f64| [0, 1].map(|end| middle - reach + (i + end) as f64 * step);
        let square = || (0..usize::from(SIDE)).flat_map(|y| (0..usize::from(SIDE)).map(move |x| (x, y)));
        let light: Vec<f64> = square().map(|(x, y)| sums.over(cell(x, middle[0]), cell(y, middle[1]))).collect();
        let most = light.iter().copied().fold(0.0, f64::max);
        Self::new(SIDE, light.iter().map(|v| (v / most * 255.0).round() as u8).collect())
    }

    /// `[y, x]` of a side; none where that cannot be an opening.
    fn new(side: u8, light: Vec<u8>) -> Option<Self> {
        let fits = (1..=MOST_SIDE).contains(&side) && light.len() == usize::from(side).pow(2);
        (fits && light.iter().any(|v| *v > 0)).then(|| Self { side, light: light.into() })
    }

    /// Cells of a side.
    pub fn side(&self) -> usize {
        self.side.into()
    }

    /// How much light passes a cell, 0 … 1; x from the left, y from above, as the lens is seen from behind the camera.
    pub fn cell(&self, x: usize, y: usize) -> f32 {
        f32::from(self.light[y * self.side() + x]) / 255.0
    }

    /// The same at a place of the lens, −1 … 1 in both axes.
    pub fn at(&self, place: [f32; 2]) -> f32 {
        let cell = |at: f32| (((at + 1.0) / 2.0 * f32::from(self.side)) as usize).min(self.side() - 1);
        self.cell(cell(place[0]), cell(place[1]))
    }
}

impl TryFrom<Stored> for Opening {
    type Error = &'static str;

    fn try_from(Stored { side, light }: Stored) -> Result<Self, Self::Error> {
        let light = STANDARD.decode(light).map_err(|_no_base64| "the light of its opening is not base64")?;
        Self::new(side, light).ok_or("its opening is closed, or has not as much light as its side asks for")
    }
}

impl From<Opening> for Stored {
    fn from(opening: Opening) -> Self {
        Self { side: opening.side, light: STANDARD.encode(&opening.light) }
    }
}

/// The middle of all light in pixels from the upper left corner, and how far from there light is.
fn middle_and_reach(width: usize, light: &[f32]) -> ([f64; 2], f64) {
    let open =
        || light.iter().enumerate().filter(|(_, v)| **v > 0.0).map(|(i, v)| ([i % width, i / width], f64::from(*v)));
    let sum: f64 = open().map(|(_, v)| v).sum();
    let middle = [0, 1].map(|axis| open().map(|(at, v)| (at[axis] as f64 + 0.5) * v).sum::<f64>() / sum);
    let corner = |at: usize, middle: f64| (at as f64 - middle).abs().max((at as f64 + 1.0 - middle).abs());
    let reach = open().map(|(at, _)| corner(at[0], middle[0]).hypot(corner(at[1], middle[1]))).fold(0.0, f64::max);
    (middle, reach)
}

/// Sums of a picture's cells, for the sum over any upright rectangle.
pub(crate) struct Integral {
    size: [usize; 2],
    /// `[y, x]`, what is above and left of each corner.
    sums: Vec<f64>,
}

impl Integral {
    /// Of a picture of `[width, height]` cells.
    pub(crate) fn new(size: [usize; 2], cell: impl Fn(usize, usize) -> f64) -> Self {
        let wide = size[0] + 1;
        let mut sums = vec![0.0; wide * (size[1] + 1)];
        for y in 0..size[1] {
            let mut row = 0.0;
            for x in 0..size[0] {
                row += cell(x, y);
                sums[(y + 1) * wide + x + 1] = sums[y * wide + x + 1] + row;
            }
        }
        Self { size, sums }
    }

    /// The sum over columns and rows, parts of cells by their share; outside there is nothing.
    pub(crate) fn over(&self, [left, right]: [f64; 2], [top, bottom]: [f64; 2]) -> f64 {
        self.before(right, bottom) - self.before(left, bottom) - self.before(right, top) + self.before(left, top)
    }

    fn before(&self, x: f64, y: f64) -> f64 {
        let split = |at: f64, side: usize| {
            let at = at.clamp(0.0, side as f64);
            let cell = (at as usize).min(side - 1);
            (cell, at - cell as f64)
        };
        let ((x, tx), (y, ty)) = (split(x, self.size[0]), split(y, self.size[1]));
        let at = |x: usize, y: usize| self.sums[y * (self.size[0] + 1) + x];
        let row = |y: usize| at(x, y) + tx * (at(x + 1, y) - at(x, y));
        row(y) + ty * (row(y + 1) - row(y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(size: Size, open: impl Fn(u32, u32) -> bool) -> Option<Opening> {
        let all = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
        Opening::of_picture(size, &all.map(|(x, y)| f32::from(open(x, y))).collect::<Vec<_>>())
    }

    #[test]
    fn light_is_centred_and_reaches_the_rim_wherever_it_was_drawn() {
        // A triangle in a corner of a wide sheet.
        let opening = drawn([400, 200], |x, y| x < 90 && y > 120 && x + y < 230).unwrap();
        let cells = || (0..64usize).flat_map(|y| (0..64usize).map(move |x| (x, y)));
        let place = |x: usize, y: usize| [x, y].map(|i| (i as f32 + 0.5) / 32.0 - 1.0);
        let sum: f32 = cells().map(|(x, y)| opening.cell(x, y)).sum();
        for axis in [0, 1] {
            let middle = cells().map(|(x, y)| opening.cell(x, y) * place(x, y)[axis]).sum::<f32>() / sum;
            assert!(middle.abs() < 0.005, "axis {axis}: {middle}");
        }
        let open = cells().filter(|(x, y)| opening.cell(*x, *y) > 0.2);
        let reach = open.map(|(x, y)| place(x, y)[0].hypot(place(x, y)[1])).fold(0.0, f32::max);
        assert!((0.95..1.01).contains(&reach), "{reach}");
    }

    #[test]
    fn what_lets_no_light_through_is_no_opening() {
        assert_eq!(drawn([9, 9], |_, _| false), None);
        assert_eq!(Opening::of_picture([2, 1], &[f32::NAN, 0.0]), None);
        assert!(drawn([1, 1], |_, _| true).is_some());
    }

    #[test]
    fn a_recipe_brings_it_back_and_brings_no_other() {
        let opening = drawn([30, 20], |x, y| x > y).unwrap();
        let text = serde_json::to_string(&opening).unwrap();
        assert!(text.len() < 6000);
        assert_eq!(serde_json::from_str::<Opening>(&text).unwrap(), opening);
        for wrong in [r#"{"side":2,"light":"AAAA"}"#, r#"{"side":2,"light":"AAAAAA=="}"#, r#"{"side":1,"light":"?"}"#] {
            assert!(serde_json::from_str::<Opening>(wrong).is_err(), "{wrong}");
        }
    }
}
