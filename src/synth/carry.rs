//! A map that was changed by hand, carried to the other views: only what the change reaches is made anew, and no net runs.
//!
//! Each view's map takes the difference of both maps, lifted to it ([`lift`](super::lift)). Colours of such rays, and of
//! those that end where the map was changed, come from the photo and its far side; all others stay as they are.

use std::sync::Arc;

use rayon::prelude::*;

use super::SynthError;
use super::far_side::FarSide;
use super::lift::lift_view;
use super::picture::Signed;
use crate::field::color::u8_from_signed;
use crate::field::{DisparityMap, LightField, RayDepths, Size, View, ViewGrid, ViewIndex, ViewOffset, sides};
use crate::job::Job;

/// Pixels beside a change that may show it: mixed colours, and what goes on behind an edge.
const BESIDE: usize = 6;
/// Pixels around a change from which the far side may take its colours.
const AROUND: usize = 64;

/// Where the colours of changed rays come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colours {
    /// A camera has seen them, whatever their depth: they stay.
    Recorded,
    /// The reference view, and behind its edges the far side.
    Photo,
}

/// A light field whose reference map was `from` and is now `to`, both of its size.
///
/// # Errors
/// Cancelled.
pub fn carried(
    (field, depths): (&Arc<LightField>, &Arc<RayDepths>),
    [from, to]: [&DisparityMap; 2],
    colours: Colours,
    job: &Job,
) -> Result<(Arc<LightField>, Arc<RayDepths>), SynthError> {
    let Some(change) = Change::new(depths.grid(), from, to) else { return Ok((Arc::clone(field), Arc::clone(depths))) };
    let grid = depths.grid();
    let photo = Signed::from_view(&change.cut_view(field.reference())?);
    let far = FarSide::new(
        &photo,
        &RayDepths::new(ViewGrid::new(1, 1)?, change.size(), change.to.clone().into_disparity_px())?,
    );
    let work = |at: ViewIndex| -> Result<(Vec<f32>, Arc<View>), SynthError> {
        job.check()?;
        let (map, view) = (depths.view(at), field.view(at));
        if at == grid.reference() {
            return Ok((to.disparity_px().to_vec(), Arc::clone(view)));
        }
        let rays = change.rays(map, grid.offset(at));
        let view = match colours {
            Colours::Recorded => Arc::clone(view),
            Colours::Photo => Arc::new(change.view(view, &rays, grid.offset(at), &photo, &far)?),
        };
        Ok((change.pasted(map, &rays.disparity_px), view))
    };
    let all: Vec<ViewIndex> = grid.views().collect();
    let made = all.into_par_iter().map(work).collect::<Result<Vec<_>, _>>()?;
    let (maps, views): (Vec<_>, Vec<_>) = made.into_iter().unzip();
    Ok((Arc::new(LightField::new(grid, views)?), Arc::new(RayDepths::new(grid, depths.size(), maps.concat())?)))
}

/// A rectangle around all that a change can reach in any view.
struct Change {
    whole: Size,
    /// First column and row of the rectangle.
    at: [usize; 2],
    /// The maps within the rectangle.
    from: DisparityMap,
    to: DisparityMap,
    /// Whether the map was changed at a pixel of it, or close by.
    is_near: Vec<bool>,
}

/// The rays of a view within the rectangle.
struct Rays {
    disparity_px: Vec<f32>,
    is_changed: Vec<bool>,
}

impl Change {
    /// None where both maps are the same.
    fn new(grid: ViewGrid, from: &DisparityMap, to: &DisparityMap) -> Option<Self> {
        let (whole, width) = (from.size(), from.size()[0] as usize);
        let pairs = from.disparity_px().iter().zip(to.disparity_px());
        let changed: Vec<usize> = pairs.enumerate().filter(|(_, (a, b))| a != b).map(|(i, _)| i).collect();
        let span = |of: &dyn Fn(usize) -> usize| {
            Some([changed.iter().map(|i| of(*i)).min()?, changed.iter().map(|i| of(*i)).max()?])
        };
        let spans = [span(&|i| i % width)?, span(&|i| i / width)?];
        let steps = grid.views().map(|at| grid.offset(at)).map(|o| o.du.abs().max(o.dv.abs())).fold(0.0, f32::max);
        let farthest = [from, to].into_iter().flat_map(DisparityMap::range_px).map(f32::abs).fold(0.0, f32::max);
        // A ray of a view starts this far from its end, and its start from what hides it.
        let margin = (2.0 * steps * farthest).ceil().min(whole[0].max(whole[1]) as f32) as usize + AROUND;
        let ends = [0, 1].map(|axis| {
            let [low, high] = spans[axis];
            [low.saturating_sub(margin), (high + margin + 1).min(whole[axis] as usize)]
        });
        let (at, end) = (ends.map(|[low, _]| low), ends.map(|[_, high]| high));
        let cut = |map: &DisparityMap| cut(map.disparity_px(), whole, at, end);
        let size = [(end[0] - at[0]) as u32, (end[1] - at[1]) as u32];
        let map = |map: &DisparityMap| DisparityMap::new(size, cut(map)).ok();
        let mut is_near = vec![false; sides(size).iter().product()];
        for i in &changed {
            let [x, y] = [i % width - at[0], i / width - at[1]];
            let [w, h] = sides(size);
            for y in y.saturating_sub(BESIDE)..(y + BESIDE + 1).min(h) {
                is_near[y * w + x.saturating_sub(BESIDE)..y * w + (x + BESIDE + 1).min(w)].fill(true);
            }
        }
        Some(Self { whole, at, from: map(from)?, to: map(to)?, is_near })
    }

    fn size(&self) -> Size {
        self.from.size()
    }

    /// The map of a view within the rectangle: the difference of both maps laid over its own.
    fn rays(&self, own: &[f32], offset: ViewOffset) -> Rays {
        let lifted = |map: &DisparityMap| {
            let mut out = vec![0.0; map.disparity_px().len()];
            lift_view(map, offset, &mut out);
            out
        };
        let (before, after) = (lifted(&self.from), lifted(&self.to));
        let end = [0, 1].map(|axis| self.at[axis] + self.size()[axis] as usize);
        let own = cut(own, self.whole, self.at, end);
        let is_changed: Vec<bool> = before.iter().zip(&after).map(|(a, b)| a != b).collect();
        let new = own.into_iter().zip(after).zip(&is_changed);
        Rays {
            disparity_px: new.map(|((own, after), changed)| if *changed { after } else { own }).collect(),
            is_changed,
        }
    }

    /// A whole map with the rectangle put into it.
    fn pasted(&self, own: &[f32], rays: &[f32]) -> Vec<f32> {
        let mut out = own.to_vec();
        let ([w, _], width) = (sides(self.size()), self.whole[0] as usize);
        for (y, row) in rays.chunks_exact(w).enumerate() {
            let start = (self.at[1] + y) * width + self.at[0];
            out[start..start + w].copy_from_slice(row);
        }
        out
    }

    fn cut_view(&self, view: &View) -> Result<View, SynthError> {
        let end = [0, 1].map(|axis| self.at[axis] + self.size()[axis] as usize);
        Ok(View::new(self.size(), cut(view.pixels(), self.whole, self.at, end).into_flattened())?)
    }

    /// A view whose changed rays have the photo's colours, or the far side's.
    fn view(
        &self,
        own: &View,
        rays: &Rays,
        offset: ViewOffset,
        photo: &Signed,
        far: &FarSide,
    ) -> Result<View, SynthError> {
        let ([w, h], width) = (sides(self.size()), self.whole[0] as usize);
        let mut rgba = own.rgba().to_vec();
        for (i, d) in rays.disparity_px.iter().enumerate() {
            let (x, y) = (i % w, i / w);
            let end = [x as f32 + offset.du * d, y as f32 + offset.dv * d];
            let inside = |at: f32, side: usize| (at.round().max(0.0) as usize).min(side - 1);
            let ends_in_it = self.is_near[inside(end[1], h) * w + inside(end[0], w)];
            if ends_in_it || rays.is_changed[i] {
                let colour = far.colour(photo.tap(end[0], end[1]), [x, y], offset, *d);
                let to = &mut rgba[((self.at[1] + y) * width + self.at[0] + x) * 4..][..3];
                to.copy_from_slice(&[colour.x, colour.y, colour.z].map(u8_from_signed));
            }
        }
        Ok(View::new(self.whole, rgba)?)
    }
}

/// A rectangle of a picture.
fn cut<T: Copy>(values: &[T], size: Size, at: [usize; 2], end: [usize; 2]) -> Vec<T> {
    let width = size[0] as usize;
    (at[1]..end[1]).flat_map(|y| values[y * width + at[0]..y * width + end[0]].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Cancel;
    use crate::synth::lift;

    const SIZE: Size = [160, 90];

    /// A red square before a green ground that becomes bluer to the right; `near` is the square's disparity.
    fn scene(near: f32) -> (View, DisparityMap) {
        let inside = |i: u32| (60..90).contains(&(i % 160)) && (30..55).contains(&(i / 160));
        let colour = |i: u32| if inside(i) { [220, 30, 30, 255] } else { [30, 160, (i % 160) as u8, 255] };
        let map = (0..160 * 90).map(|i| if inside(i) { near } else { -1.0 }).collect();
        (View::new(SIZE, (0..160 * 90).flat_map(colour).collect()).unwrap(), DisparityMap::new(SIZE, map).unwrap())
    }

    /// The light field of a map, from the photo and its far side.
    fn field(view: &View, map: &DisparityMap) -> (Arc<LightField>, Arc<RayDepths>) {
        let depths = lift::ray_depths(map, ViewGrid::PAPER);
        let photo = Signed::from_view(view);
        let far = FarSide::new(&photo, &depths);
        let made = |at: ViewIndex| {
            let (from, map) = (ViewGrid::PAPER.offset(at), depths.view(at));
            let rays = map.iter().enumerate().map(|(i, d)| {
                let (x, y) = (i % 160, i / 160);
                let own = photo.tap(x as f32 + from.du * d, y as f32 + from.dv * d);
                let colour = far.colour(own, [x, y], from, *d);
                [u8_from_signed(colour.x), u8_from_signed(colour.y), u8_from_signed(colour.z), 255]
            });
            Arc::new(View::new(SIZE, rays.collect::<Vec<_>>().into_flattened()).unwrap())
        };
        let views = ViewGrid::PAPER.views().map(made).collect();
        (Arc::new(LightField::new(ViewGrid::PAPER, views).unwrap()), Arc::new(depths))
    }

    fn carry(
        made: &(Arc<LightField>, Arc<RayDepths>),
        maps: [&DisparityMap; 2],
        colours: Colours,
    ) -> (Arc<LightField>, Arc<RayDepths>) {
        carried((&made.0, &made.1), maps, colours, &Job { cancel: &Cancel::default(), sink: &() }).unwrap()
    }

    #[test]
    fn what_is_carried_is_what_would_have_been_made() {
        let ((view, flat), (_, raised)) = (scene(-1.0), scene(1.5));
        let (flat_made, wanted) = (field(&view, &flat), field(&view, &raised));
        let (views, depths) = carry(&flat_made, [&flat, &raised], Colours::Photo);
        assert_eq!(*depths, *wanted.1, "every ray has the depth that the mended map gives it");
        let off = |a: &View, b: &View| {
            let pairs = a.pixels().iter().zip(b.pixels());
            pairs.filter(|(a, b)| a.iter().zip(b.iter()).any(|(a, b)| a.abs_diff(*b) > 12)).count()
        };
        for at in ViewGrid::PAPER.views() {
            let (now, before) = (off(views.view(at), wanted.0.view(at)), off(flat_made.0.view(at), wanted.0.view(at)));
            assert!(now * 20 <= before, "view {at:?}: {now} pixels differ, {before} did before");
        }
        assert!(Arc::ptr_eq(views.reference(), flat_made.0.reference()));
    }

    #[test]
    fn the_same_map_changes_nothing_and_recorded_colours_stay() {
        let ((view, flat), (_, raised)) = (scene(-1.0), scene(1.5));
        let made = field(&view, &flat);
        let same = carry(&made, [&flat, &flat], Colours::Photo);
        assert!(Arc::ptr_eq(&same.0, &made.0) && Arc::ptr_eq(&same.1, &made.1));
        let (views, depths) = carry(&made, [&flat, &raised], Colours::Recorded);
        assert_eq!(*views, *made.0);
        assert_eq!(depths.reference(), raised.disparity_px());
    }

    #[test]
    fn far_from_the_change_rays_keep_depths_of_their_own() {
        let ((view, flat), (_, raised)) = (scene(-1.0), scene(1.5));
        let (views, depths) = field(&view, &flat);
        // A net that has a map for every view.
        let own: Vec<f32> = depths.disparity_px().iter().enumerate().map(|(i, d)| d + (i % 7) as f32 * 0.001).collect();
        let own = Arc::new(RayDepths::new(ViewGrid::PAPER, SIZE, own).unwrap());
        let (_, mended) = carry(&(views, Arc::clone(&own)), [&flat, &raised], Colours::Photo);
        let corner = ViewIndex { v: 0, u: 0 };
        assert_eq!(mended.at(corner, 150, 5), own.at(corner, 150, 5));
        // The square's middle as view (0, 0) sees it: 4 steps of 1.5 px to the right and down.
        assert_eq!(mended.at(corner, 75 + 6, 42 + 6), 1.5);
    }
}
