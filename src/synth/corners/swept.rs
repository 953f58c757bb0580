//! The views between four without a net.
//!
//! Depth is measured at each corner from all four ([`sweep`]) and lifted to the view that is wanted. Of the depths that the
//! corners tell there, the nearest counts that at least two of them confirm. Each corner that sees the ray's end then gives
//! its colour, the nearer corner more of it.

use std::sync::Arc;

use glam::{Vec3, Vec4, Vec4Swizzles};
use rayon::prelude::*;

use super::given_at;
use crate::field::{DisparityMap, LightField, RayDepths, Size, View, ViewGrid, ViewOffset, ramp, sides};
use crate::job::Job;
use crate::synth::lift::lift_view;
use crate::synth::{Signed, SynthError, lambertian, sweep};

/// Most disparity from one corner to the next, as a share of the width: ± 2.5 px a step at 540, seven steps.
const WIDEST_SHARE: f32 = 7.0 * 2.5 / 540.0;
/// Difference of disparity between corners, px, from which a corner begins to see something else, and surely does.
const APART_PX: [f32; 2] = [1.0, 2.5];
/// Corners that must see a surface for it to count.
const CONFIRMED: f32 = 1.5;
/// Least brightness (0 … 2) that a corner is brightened from.
const DARKEST: f32 = 0.01;
/// What a corner that does not see a ray's end still counts, where none does.
const LEAST: f32 = 1e-4;

/// The paper's grid of views, its corners given: upper left, upper right, lower left, lower right, all of one size.
///
/// # Errors
/// Cancelled; views of several sizes, or not four.
pub fn between(corners: &[Arc<View>], job: &Job) -> Result<(LightField, RayDepths), SynthError> {
    let (grid, four) = (ViewGrid::PAPER, ViewGrid::new(2, 2)?);
    let given = LightField::new(four, corners.to_vec())?;
    let maps: Vec<DisparityMap> =
        four.views().map(|at| sweep::view_map(&given, at, WIDEST_SHARE, job)).collect::<Result<_, _>>()?;
    let pictures: Vec<Signed> = corners.iter().map(|view| Signed::from_view(view)).collect();
    let means = pictures.iter().map(mean).collect();
    let four = Four { size: given.size(), maps, pictures, means };
    let steps = (grid.cols() - 1) as f32;
    let made = grid.views().collect::<Vec<_>>().into_par_iter().map(|at| {
        job.check()?;
        let place = [f32::from(at.u), f32::from(at.v)].map(|step| step / steps);
        let (colours, mut depth) = four.seen_from(place);
        depth.iter_mut().for_each(|d| *d /= steps);
        let view =
            given_at(grid, at).map_or_else(|| View::new(four.size, colours).map(Arc::new), |c| Ok(corners[c].clone()));
        Ok((view?, depth))
    });
    let made: Vec<(Arc<View>, Vec<f32>)> = made.collect::<Result<_, SynthError>>()?;
    let (views, depths): (Vec<_>, Vec<_>) = made.into_iter().unzip();
    Ok((LightField::new(grid, views)?, RayDepths::new(grid, four.size, depths.concat())?))
}

/// The corners, and what each knows of depth: px from one corner to the next.
struct Four {
    size: Size,
    maps: Vec<DisparityMap>,
    pictures: Vec<Signed>,
    /// How bright each picture is: views at a plenoptic camera's rim are darker.
    means: Vec<Vec3>,
}

/// Mean of a picture's channels, 0 … 2.
fn mean(picture: &Signed) -> Vec3 {
    let sum: Vec3 = picture.pixels().iter().map(|pixel| pixel.xyz() + 1.0).sum();
    (sum / picture.pixels().len() as f32).max(Vec3::splat(DARKEST))
}

impl Four {
    /// Colours (RGBA) and depth, px from one corner to the next, at a place: 0 … 1 to the right and down.
    fn seen_from(&self, [right, down]: [f32; 2]) -> (Vec<u8>, Vec<f32>) {
        let [w, h] = sides(self.size);
        let offsets =
            [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| ViewOffset { du: right - u, dv: down - v });
        let shares = offsets.map(|o| (1.0 - o.du.abs()) * (1.0 - o.dv.abs()) + LEAST);
        let lifted: Vec<Vec<f32>> = self
            .maps
            .iter()
            .zip(offsets)
            .map(|(map, offset)| {
                let mut out = vec![0.0; w * h];
                lift_view(map, offset, &mut out);
                out
            })
            .collect();
        let bright = (0..4).map(|c| self.means[c] * shares[c]).sum::<Vec3>() / shares.iter().sum::<f32>();
        let gains = [0, 1, 2, 3].map(|c| (bright / self.means[c]).extend(1.0));
        let of = |i: usize| {
            let pixel = [(i % w) as f32, (i / w) as f32];
            let (d, sees) = self.chosen([0, 1, 2, 3].map(|c| lifted[c][i]), pixel, &offsets);
            let (mut sum, mut all) = (Vec4::ZERO, 0.0);
            for c in 0..4 {
                let share = shares[c] * sees[c].max(LEAST);
                let seen = self.pictures[c].tap(pixel[0] + offsets[c].du * d, pixel[1] + offsets[c].dv * d);
                sum += ((seen + Vec4::ONE) * gains[c] - Vec4::ONE) * share;
                all += share;
            }
            let [r, g, b] = lambertian::encode(sum / all);
            ([r, g, b, 255], d)
        };
        let (rgba, depth): (Vec<[u8; 4]>, Vec<f32>) = (0..w * h).map(of).unzip();
        (rgba.into_flattened(), depth)
    }

    /// The nearest depth that enough corners confirm, else the one that most do; and how well each corner sees it.
    fn chosen(&self, told: [f32; 4], pixel: [f32; 2], offsets: &[ViewOffset; 4]) -> (f32, [f32; 4]) {
        let size = self.size;
        let sees = |d: f32| -> [f32; 4] {
            std::array::from_fn(|c| {
                let place = [pixel[0] + offsets[c].du * d, pixel[1] + offsets[c].dv * d];
                let [x, y] = [0, 1].map(|axis| place[axis].round().clamp(0.0, (size[axis] - 1) as f32) as u32);
                let there = self.maps[c].at(x, y);
                1.0 - ramp(APART_PX[0], APART_PX[1], (there - d).abs())
            })
        };
        let all = told.map(|d| (d, sees(d)));
        let worth = |(d, sees): &(f32, [f32; 4])| {
            let confirmed: f32 = sees.iter().sum();
            (confirmed.min(CONFIRMED), *d)
        };
        all.into_iter()
            .max_by(|a, b| {
                let (a, b) = (worth(a), worth(b));
                a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
            })
            .unwrap_or((0.0, [1.0; 4]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{ViewIndex, between as between_pixels};
    use crate::job::Cancel;

    const SIZE: [u32; 2] = [144, 108];

    /// Grains of 3 px that nowhere repeat.
    fn texture(x: f32, y: f32) -> f32 {
        let grain = |i: f32, j: f32| ((i * 12.9898 + j * 78.233).sin() * 437.585).rem_euclid(1.0);
        let (x, y) = (x / 3.0, y / 3.0);
        let ([i, j], shares) = ([x.floor(), y.floor()], [x - x.floor(), y - y.floor()]);
        between_pixels([grain(i, j), grain(i + 1.0, j), grain(i, j + 1.0), grain(i + 1.0, j + 1.0)], shares)
    }

    /// A textured near square before a textured far plane, seen from a place of the paper's grid.
    fn seen(at: ViewIndex) -> View {
        let o = ViewGrid::PAPER.offset(at);
        let pixel = |i: u32| {
            let (x, y) = ((i % SIZE[0]) as f32, (i / SIZE[0]) as f32);
            let (nx, ny) = (x + o.du * 0.5, y + o.dv * 0.5);
            let inside = (48.0..96.0).contains(&nx) && (36.0..72.0).contains(&ny);
            let value = if inside { texture(nx, ny) } else { texture(x - o.du * 0.3, y - o.dv * 0.3) };
            [(value * 255.0) as u8, (value * 200.0) as u8, if inside { 220 } else { 30 }, 255]
        };
        View::new(SIZE, (0..SIZE[0] * SIZE[1]).flat_map(pixel).collect()).unwrap()
    }

    #[test]
    fn views_between_four_are_nearer_to_the_truth_than_a_blend_of_them() {
        let cancel = Cancel::default();
        let given = [(0, 0), (0, 7), (7, 0), (7, 7)].map(|(v, u)| Arc::new(seen(ViewIndex { v, u })));
        let (field, depths) = between(&given, &Job { cancel: &cancel, sink: &() }).unwrap();
        assert_eq!(field.view(ViewIndex { v: 7, u: 0 }), &given[2], "what was given stays");
        let middle = ViewIndex { v: 3, u: 4 };
        let truth = seen(middle);
        let l1 = |at: &dyn Fn(usize) -> f32| {
            let off = truth.rgba().iter().enumerate().map(|(i, t)| (at(i) - f32::from(*t)).abs()).sum::<f32>();
            off / truth.rgba().len() as f32
        };
        let blend = |i: usize| given.iter().map(|view| f32::from(view.rgba()[i])).sum::<f32>() / 4.0;
        let (made, blended) = (l1(&|i| f32::from(field.view(middle).rgba()[i])), l1(&blend));
        assert!(made < 0.4 * blended, "{made} of 255, and {blended} blended");
        assert!((depths.at(middle, 72, 54) - 0.5).abs() < 0.05, "{}", depths.at(middle, 72, 54));
        assert!((depths.at(middle, 20, 90) + 0.3).abs() < 0.05, "{}", depths.at(middle, 20, 90));
    }

    #[test]
    fn corners_of_several_sizes_are_refused() {
        let cancel = Cancel::default();
        let of = |width: u32| Arc::new(View::new([width, 6], vec![90; width as usize * 24]).unwrap());
        let made = between(&[of(8), of(8), of(9), of(8)], &Job { cancel: &cancel, sink: &() });
        assert!(made.unwrap_err().to_string().contains("[9, 6]"));
    }
}
