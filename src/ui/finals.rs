//! The picture at rest: once the hand rests, the lens renderer's picture of the visible part replaces the draft, at the
//! screen's size and, from 1:1 on, with the photo's true pixels.

use std::sync::Arc;

use egui::{Rect, Vec2};

use super::tiles::TileSet;
use super::worker::{Event, JobId, Outbox, Work};
use crate::field::{DisparityMap, Lens, LightField, Photo, RayDepths, fit_long_side};
use crate::job::{Cancel, Job};
use crate::render::Picture;
use crate::render::lens::{LensError, Prepared, Region, Scene, Space, revealed};

/// What a picture at rest shows: it is drawn only while this is what the window asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// The lens.
    pub lens: Lens,
    /// Size of the whole picture, in pixels.
    pub size: [u32; 2],
    /// The part of it that is seen.
    pub region: Region,
    /// Which light field, counted by the window.
    pub generation: u64,
}

/// Regions begin and end at multiples of this, so that a little panning asks for nothing new.
const STEP: u32 = 128;

impl Key {
    /// What is needed for a picture that lies at `rect` (in screen pixels) behind a canvas.
    pub fn new(lens: Lens, generation: u64, photo: [u32; 2], rect: Rect, canvas: Rect) -> Self {
        let long = rect.size().max_elem().max(64.0);
        // Sizes in steps of a quarter octave, so that a little zoom asks for nothing new either.
        let wanted = 2f32.powf((long.log2() * 4.0 - 0.1).ceil() / 4.0) as u32;
        let size = fit_long_side(photo, wanted);
        let seen = rect.intersect(canvas);
        let place = |p: f32, start: f32, extent: f32, side: u32| ((p - start) / extent).clamp(0.0, 1.0) * side as f32;
        let low = |p: f32| (p as u32) / STEP * STEP;
        let high = |p: f32, side: u32| (p.ceil() as u32).next_multiple_of(STEP).clamp(1, side);
        let at = [
            low(place(seen.left(), rect.left(), rect.width(), size[0])),
            low(place(seen.top(), rect.top(), rect.height(), size[1])),
        ];
        let end = [
            high(place(seen.right(), rect.left(), rect.width(), size[0]), size[0]),
            high(place(seen.bottom(), rect.top(), rect.height(), size[1]), size[1]),
        ];
        let part = Region { at, size: [0, 1].map(|axis| end[axis].saturating_sub(at[axis]).max(1)) };
        Self { lens, size, region: part, generation }
    }

    /// Where the region lies within a picture that is drawn at `rect`.
    pub fn on_screen(&self, rect: Rect) -> Rect {
        let scale = rect.size() / Vec2::new(self.size[0] as f32, self.size[1] as f32);
        let at = Vec2::new(self.region.at[0] as f32, self.region.at[1] as f32) * scale;
        let size = Vec2::new(self.region.size[0] as f32, self.region.size[1] as f32) * scale;
        Rect::from_min_size(rect.min + at, size)
    }
}

/// A request for a picture at rest.
pub struct Request {
    /// What it shows.
    pub key: Key,
    /// The photo.
    pub photo: Arc<Photo>,
    /// The views, for what stands behind near edges.
    pub field: Arc<LightField>,
    /// Their ray depths.
    pub depths: Arc<RayDepths>,
}

/// The work of the thread that renders pictures at rest; it keeps what does not depend on the lens.
pub fn worker() -> impl Work<Request> {
    let mut scene: Option<(u64, Scene)> = None;
    let mut prepared: Option<(u64, [u32; 2], Prepared)> = None;
    move |job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox| {
        let key = request.key;
        let event = match render(&request, &mut scene, &mut prepared, &Job { cancel, sink: &() }) {
            Ok(picture) => Event::Final(Box::new((key, Arc::new(TileSet::of_picture(&picture))))),
            Err(LensError::Cancelled(_)) => Event::Stopped,
            Err(error) => Event::Failed(super::jobs::sentence(&error)),
        };
        outbox.send(job, event);
    }
}

fn render(
    request: &Request,
    scene: &mut Option<(u64, Scene)>,
    prepared: &mut Option<(u64, [u32; 2], Prepared)>,
    job: &Job,
) -> Result<Picture, LensError> {
    let Key { lens, size, region, generation } = request.key;
    if scene.as_ref().is_none_or(|(have, _)| *have != generation) {
        *scene = Some((generation, scene_of(&request.photo, &request.field, &request.depths)?.in_space(Space::Srgb)));
    }
    job.check()?;
    if prepared.as_ref().is_none_or(|(have, at, _)| (*have, *at) != (generation, size)) {
        *prepared = scene.as_ref().map(|(_, scene)| (generation, size, scene.prepare(size)));
    }
    job.check()?;
    match prepared {
        Some((_, _, prepared)) => prepared.render(&lens, region, job),
        None => Err(LensError::NotANumber),
    }
}

/// A photo with the depths of its light field, ready for the lens renderer.
pub fn scene_of(photo: &Arc<Photo>, field: &LightField, depths: &RayDepths) -> Result<Scene, LensError> {
    let map = DisparityMap { size: depths.size(), disparity_px: depths.reference().to_vec() };
    Ok(Scene::new(Arc::clone(photo), map)?.with_behind(revealed(field, depths)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{pos2, vec2};

    #[test]
    fn a_region_covers_what_is_seen_and_no_more_than_there_is() {
        let canvas = Rect::from_min_size(pos2(100.0, 50.0), vec2(900.0, 600.0));
        let photo = [4000, 3000];
        let whole = Rect::from_min_size(pos2(150.0, 50.0), vec2(800.0, 600.0));
        let key = Key::new(Lens::default(), 1, photo, whole, canvas);
        assert_eq!(key.region, Region { at: [0, 0], size: key.size });
        assert!(key.size[0] >= 800 && key.size[0] < 960, "{:?}", key.size);

        let close = Rect::from_min_size(pos2(-1900.0, -950.0), vec2(4000.0, 3000.0));
        let key = Key::new(Lens::default(), 1, photo, close, canvas);
        assert_eq!(key.size, photo, "never more than the photo's own pixels");
        assert!(key.on_screen(close).contains_rect(canvas));
        assert!(key.region.size[0] < 1300 && key.region.size[1] < 1000);
    }
}
