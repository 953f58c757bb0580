//! Two or three subjects that are all to be sharp: the plane through them (Scheimpflug), or the band of depths that holds
//! them where no plane does, and the widest aperture at which they stay sharp.
//!
//! With places `p` in widths of the picture and disparities `d`, the plane `d = c + g·p` of least squares and least slope
//! is solved from `(Σ pᵢpᵢᵀ)·g = Σ pᵢdᵢ` about their mean; directions in which the places do not spread have no slope.
//! So one place is a click, two are a plane that leans along the line between them, three are the plane through them.

use serde::{Deserialize, Serialize};

use super::focus;
use crate::field::{DisparityMap, FNumber, FocalPlane, Lens};

/// Places that are to be sharp together: one to three, x and y from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f32; 2]>", into = "Vec<[f32; 2]>")]
pub struct Places {
    at: [[f32; 2]; Places::MOST],
    count: u8,
}

impl Places {
    /// As many as a plane goes through.
    pub const MOST: usize = 3;

    /// The places.
    pub fn all(&self) -> &[[f32; 2]] {
        &self.at[..self.count.into()]
    }

    /// The same with one more; beyond three it takes the place of the nearest.
    #[must_use]
    pub fn with(mut self, place: [f32; 2]) -> Self {
        if usize::from(self.count) < Self::MOST {
            self.count += 1;
            return self.moved(self.all().len() - 1, place);
        }
        let far = |at: &[f32; 2]| (at[0] - place[0]).powi(2) + (at[1] - place[1]).powi(2);
        let nearest = (0..Self::MOST).min_by(|a, b| far(&self.at[*a]).total_cmp(&far(&self.at[*b])));
        self.moved(nearest.unwrap_or(0), place)
    }

    /// The same with one of them elsewhere.
    #[must_use]
    pub fn moved(mut self, index: usize, place: [f32; 2]) -> Self {
        if index < self.count.into() {
            self.at[index] = place.map(|share| share.clamp(0.0, 1.0));
        }
        self
    }

    /// The same without one of them; none where it was the last.
    pub fn without(self, index: usize) -> Option<Self> {
        let left: Vec<_> = self.all().iter().enumerate().filter(|(i, _)| *i != index).map(|(_, at)| *at).collect();
        left.try_into().ok()
    }
}

impl From<[f32; 2]> for Places {
    fn from(place: [f32; 2]) -> Self {
        Self { at: [place; Self::MOST], count: 1 }
    }
}

impl TryFrom<Vec<[f32; 2]>> for Places {
    type Error = &'static str;

    fn try_from(all: Vec<[f32; 2]>) -> Result<Self, Self::Error> {
        let is_inside = |place: &[f32; 2]| place.iter().all(|share| (0.0..=1.0).contains(share));
        match all.split_first() {
            Some((first, rest)) if all.len() <= Self::MOST && all.iter().all(is_inside) => {
                Ok(rest.iter().fold(Self::from(*first), |places, place| places.with(*place)))
            }
            _ => Err("one to three places from 0 to 1 are wanted"),
        }
    }
}

impl From<Places> for Vec<[f32; 2]> {
    fn from(places: Places) -> Self {
        places.all().to_vec()
    }
}

/// What keeps places sharp, in pixels of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solved {
    /// What is sharp.
    pub plane: FocalPlane,
    /// The band around it that is sharp too: nothing where a plane goes through all places.
    pub keep_px: [f32; 2],
}

impl Solved {
    /// Whether a plane does it alone.
    pub fn is_plane(&self) -> bool {
        self.keep_px == [0.0; 2]
    }
}

/// A plane may miss a place by this much, as a share of the width: less than maps tell.
const MISS: f32 = 0.005 / 540.0;
/// Steepest plane from edge to edge, as a share of the width at strength 1; a steeper one would be sharp in a line alone.
const STEEPEST: f32 = 6.0 / 540.0;
/// Places that spread less than this part of their spread along the other direction lie on a line.
const ON_A_LINE: f32 = 1e-6;

/// The plane or the band that keeps places sharp; the map is of a strength.
pub fn solve(map: &DisparityMap, places: &Places, strength: f32) -> Solved {
    let [width, height] = map.size().map(|side| side as f32);
    let shape = height / width;
    let of = |at: &[f32; 2]| Point { at: [at[0] - 0.5, (at[1] - 0.5) * shape], d: focus::disparity_at(map, *at) };
    let points: Vec<Point> = places.all().iter().map(of).collect();
    let (slope, middle) = plane(&points);
    let tilt_px = [slope[0], slope[1] * shape];
    let misses = |p: &Point| (p.d - middle - slope[0] * p.at[0] - slope[1] * p.at[1]).abs() > MISS * width * strength;
    let is_steep = tilt_px.iter().any(|px| px.abs() > STEEPEST * width * strength);
    if !is_steep && !points.iter().any(misses) {
        return Solved { plane: FocalPlane { disparity_px: middle, tilt_px }, keep_px: [0.0; 2] };
    }
    let far = points.iter().map(|p| p.d).fold(f32::INFINITY, f32::min);
    let near = points.iter().map(|p| p.d).fold(f32::NEG_INFINITY, f32::max);
    let (disparity_px, half) = ((far + near) / 2.0, (near - far) / 2.0);
    Solved { plane: FocalPlane { disparity_px, tilt_px: [0.0; 2] }, keep_px: [-half, half] }
}

/// A place from the picture's middle in widths, and its disparity.
struct Point {
    at: [f32; 2],
    d: f32,
}

/// Slope of the plane of least squares and least slope, and its disparity in the picture's middle.
fn plane(points: &[Point]) -> ([f32; 2], f32) {
    let mean = |of: &dyn Fn(&Point) -> f32| points.iter().map(of).sum::<f32>() / points.len().max(1) as f32;
    let (x, y, d) = (mean(&|p| p.at[0]), mean(&|p| p.at[1]), mean(&|p| p.d));
    let sum = |of: &dyn Fn(f64, f64, f64) -> f64| -> f64 {
        points.iter().map(|p| of((p.at[0] - x).into(), (p.at[1] - y).into(), (p.d - d).into())).sum()
    };
    let (xx, xy, yy) = (sum(&|x, _, _| x * x), sum(&|x, y, _| x * y), sum(&|_, y, _| y * y));
    let (xd, yd) = (sum(&|x, _, d| x * d), sum(&|_, y, d| y * d));
    // Main axes of the spread of places; an axis without spread has no slope.
    let (half, apart) = ((xx + yy) / 2.0, (((xx - yy) / 2.0).powi(2) + xy * xy).sqrt());
    let turn = 0.5 * (2.0 * xy).atan2(xx - yy);
    let axes = [(half + apart, [turn.cos(), turn.sin()]), (half - apart, [-turn.sin(), turn.cos()])];
    let mut slope = [0.0; 2];
    for (spread, axis) in axes {
        if spread > f64::from(ON_A_LINE) * (half + apart) && spread > 0.0 {
            let along = (axis[0] * xd + axis[1] * yd) / spread;
            (0..2).for_each(|i| slope[i] += (along * axis[i]) as f32);
        }
    }
    (slope, d - slope[0] * x - slope[1] * y)
}

/// Blur that nobody sees: a part of a pixel of the picture that is written.
pub const SHARP_PX: f32 = 1.0;
/// How far around a place its subject is looked at, as a share of the width; and what is another surface there, as a share
/// of the width at strength 1.
const SUBJECT: f32 = 0.01;
const OTHER: f32 = 0.2 / 540.0;
/// Part of a subject that has to be sharp: at its rim a map is often soft.
const MOST_OF_IT: f32 = 0.5;

/// The widest aperture at which the subjects at these places are blurred by no more than [`SHARP_PX`] pixels of a picture of
/// a width. The lens is in pixels of the map, which is of a strength.
pub fn widest(map: &DisparityMap, lens: &Lens, places: &Places, picture_width: u32, strength: f32) -> FNumber {
    let worst = places.all().iter().map(|place| relief(map, lens, *place, strength)).fold(0.0, f32::max);
    let per_view = worst * picture_width as f32 / map.size()[0] as f32;
    if per_view > 0.0 { FNumber::adding(SHARP_PX / per_view) } else { FNumber::WIDEST }
}

/// How far most of a subject is from what is sharp, in pixels per view step of the map.
fn relief(map: &DisparityMap, lens: &Lens, place: [f32; 2], strength: f32) -> f32 {
    let [w, h] = map.size();
    let own = focus::disparity_at(map, place);
    let reach = (SUBJECT * w as f32) as i64;
    let around = |share: f32, side: u32| {
        let middle = ((share * side as f32) as i64).min(i64::from(side) - 1);
        ((middle - reach).max(0)..=(middle + reach).min(i64::from(side) - 1)).map(|at| at as u32)
    };
    let mut away: Vec<f32> = around(place[1], h)
        .flat_map(|y| around(place[0], w).map(move |x| (x, y, map.at(x, y))))
        .filter(|(.., d)| (d - own).abs() <= OTHER * w as f32 * strength)
        .map(|(x, y, d)| lens.defocus_px(d, (x as f32 + 0.5) / w as f32, (y as f32 + 0.5) / h as f32).abs())
        .collect();
    away.sort_by(f32::total_cmp);
    away.get((away.len() as f32 * MOST_OF_IT) as usize).or(away.last()).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Strength;
    use crate::scene::{Edit, Focus};

    fn map(disparity: impl Fn(f32, f32) -> f32) -> DisparityMap {
        let (w, h) = (540u32, 360u32);
        let at = |i: u32| [((i % w) as f32 + 0.5) / w as f32, ((i / w) as f32 + 0.5) / h as f32];
        DisparityMap::new([w, h], (0..w * h).map(at).map(|[x, y]| disparity(x, y)).collect()).unwrap()
    }

    fn places(all: &[[f32; 2]]) -> Places {
        all.to_vec().try_into().unwrap()
    }

    /// Discs of a disparity each before a far ground.
    fn things(all: &'static [([f32; 2], f32)]) -> DisparityMap {
        map(|x, y| {
            let is_in = |at: [f32; 2]| (x - at[0]).powi(2) + (y - at[1]).powi(2) < 0.03f32.powi(2);
            all.iter().find(|(at, _)| is_in(*at)).map_or(-1.5, |(_, d)| *d)
        })
    }

    fn blurs(map: &DisparityMap, all: &Places) -> Vec<f32> {
        let edit = Edit { focus: Focus::Through(*all), ..Edit::default() };
        let lens = edit.lens(map, Strength::AS_MADE);
        all.all().iter().map(|at| lens.defocus_px(focus::disparity_at(map, *at), at[0], at[1]).abs()).collect()
    }

    #[test]
    fn a_plane_goes_through_three_places_exactly() {
        for shift in 0..40 {
            // Many triangles, none of them thin.
            let turn = shift as f32 * 0.37;
            let at = |k: f32| {
                let angle = turn + k * 2.1;
                [0.5 + 0.3 * angle.cos(), 0.5 + (0.15 + 0.003 * shift as f32) * angle.sin()]
            };
            let all = places(&[at(0.0), at(1.0), at(2.0)]);
            let leaning = map(|x, y| 0.4 + 1.1 * (x - 0.5) * turn.sin() - 1.7 * (y - 0.5) * turn.cos());
            let solved = solve(&leaning, &all, 1.0);
            assert!(solved.is_plane() && (solved.plane.disparity_px - 0.4).abs() < 0.02, "{solved:?}");
            assert!((solved.plane.tilt_px[0] - 1.1 * turn.sin()).abs() < 0.05, "{solved:?}");
            assert!((solved.plane.tilt_px[1] + 1.7 * turn.cos()).abs() < 0.05, "{solved:?}");
            assert!(blurs(&leaning, &all).iter().all(|away| *away < 5e-3), "{:?}", blurs(&leaning, &all));
        }
    }

    #[test]
    fn two_places_lean_along_the_line_between_them_and_one_is_a_click() {
        let scene = things(&[([0.2, 0.5], 0.9), ([0.8, 0.5], -0.3)]);
        let both = places(&[[0.2, 0.5], [0.8, 0.5]]);
        let solved = solve(&scene, &both, 1.0);
        assert!(solved.is_plane() && solved.plane.tilt_px[1].abs() < 1e-5, "{solved:?}");
        assert!((solved.plane.tilt_px[0] + 2.0).abs() < 1e-4 && (solved.plane.disparity_px - 0.3).abs() < 1e-4);
        assert!(blurs(&scene, &both).iter().all(|away| *away < 1e-4));
        for focus in [Focus::At([0.2, 0.5]), Focus::Through([0.2, 0.5].into())] {
            let edit = Edit { focus, tilt: [1e-3, 0.0], ..Edit::default() };
            let lens = edit.lens(&scene, Strength::AS_MADE);
            let click = Edit { focus: Focus::At([0.2, 0.5]), ..edit.clone() }.lens(&scene, Strength::AS_MADE);
            assert_eq!(lens, click);
        }
    }

    #[test]
    fn where_no_plane_does_it_a_band_holds_all_of_them() {
        // Three on a line that are no line in depth, and two at one place of very different depth.
        let bent = things(&[([0.2, 0.5], 0.0), ([0.5, 0.5], 1.0), ([0.8, 0.5], 0.0)]);
        let close = things(&[([0.45, 0.5], -1.0), ([0.52, 0.5], 1.0)]);
        for (scene, all) in
            [(bent, places(&[[0.2, 0.5], [0.5, 0.5], [0.8, 0.5]])), (close, places(&[[0.45, 0.5], [0.52, 0.5]]))]
        {
            let solved = solve(&scene, &all, 1.0);
            assert!(!solved.is_plane() && solved.plane.tilt_px == [0.0; 2], "{solved:?}");
            assert_eq!(blurs(&scene, &all), vec![0.0; all.all().len()]);
        }
    }

    #[test]
    fn it_is_solved_alike_at_every_strength_and_width() {
        let scene = things(&[([0.2, 0.4], 0.9), ([0.8, 0.5], -0.3), ([0.5, 0.8], 0.2)]);
        let all = places(&[[0.2, 0.4], [0.8, 0.5], [0.5, 0.8]]);
        let (plain, deep) = (solve(&scene, &all, 1.0), solve(&scene.at_strength(Strength(2.0)), &all, 2.0));
        assert!((deep.plane.tilt_px[0] - 2.0 * plain.plane.tilt_px[0]).abs() < 1e-4);
        let small = solve(&scene.resized([270, 180]).unwrap(), &all, 1.0);
        assert!((2.0 * small.plane.tilt_px[1] - plain.plane.tilt_px[1]).abs() < 1e-3);
    }

    #[test]
    fn the_aperture_is_as_wide_as_the_subjects_relief_lets_it() {
        let flat = things(&[([0.2, 0.5], 0.9), ([0.8, 0.5], -0.3)]);
        let all = places(&[[0.2, 0.5], [0.8, 0.5]]);
        let lens = |map: &DisparityMap| {
            Edit { focus: Focus::Through(all), tilt: [0.0; 2], ..Edit::default() }.lens(map, Strength::AS_MADE)
        };
        let level = map(|_, y| if y < 2.0 { 0.4 } else { 0.0 });
        assert_eq!(widest(&level, &lens(&level), &all, 4000, 1.0), FNumber::WIDEST);
        let round = map(|x, _| 0.3 * (60.0 * x).sin());
        let f = widest(&round, &lens(&round), &all, 4000, 1.0);
        // What is found is sharp, and a stop wider is not.
        let blur = |f: FNumber, width: f32| {
            all.all().iter().map(|at| relief(&round, &lens(&round), *at, 1.0)).fold(0.0, f32::max) * width / 540.0
                * f.added_views()
        };
        assert!((blur(f, 4000.0) - SHARP_PX).abs() < 1e-3 && f.0 > FNumber::WIDEST.0 && f.0 < 28.0, "{f:?}");
        assert!(widest(&round, &lens(&round), &all, 1000, 1.0).0 < f.0, "a smaller picture hides more");
        assert!(widest(&flat, &lens(&flat), &all, 4000, 1.0).0 < 28.0);
    }

    #[test]
    fn places_are_added_moved_and_taken_away() {
        let one = Places::from([0.1, 0.1]);
        let three = one.with([0.9, 0.1]).with([0.5, 0.9]);
        assert_eq!(three.all(), [[0.1, 0.1], [0.9, 0.1], [0.5, 0.9]]);
        assert_eq!(three.with([0.6, 0.8]).all()[2], [0.6, 0.8], "a fourth takes the place of the nearest");
        assert_eq!(three.without(0).unwrap().all(), [[0.9, 0.1], [0.5, 0.9]]);
        assert_eq!(one.without(0), None);
        assert_eq!(three.moved(1, [2.0, -1.0]).all()[1], [1.0, 0.0]);
        for wrong in ["[]", "[[0,0],[0,0],[0,0],[0,0]]", "[[0,1.5]]", "[[0,null]]"] {
            assert!(serde_json::from_str::<Places>(wrong).is_err(), "{wrong}");
        }
        assert_eq!(serde_json::from_str::<Places>(&serde_json::to_string(&three).unwrap()).unwrap(), three);
    }
}
