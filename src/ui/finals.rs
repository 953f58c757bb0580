//! The picture at rest: once the hand rests, the lens renderer's picture of the visible part replaces the draft, at the
//! screen's size and, from 1:1 on, with the photo's true pixels.

use std::sync::Arc;

use egui::{Rect, Vec2};

use super::state::Edit;
use super::tiles::TileSet;
use super::worker::{Event, JobId, Outbox, Work};
use crate::field::{Lens, Photo, RayDepths, ViewPoint, fit_long_side};
use crate::job::{Cancel, Job};
use crate::render::Picture;
use crate::render::lens::{LensError, LensGpu, Prepared, Region, Scene, Space};

/// What a picture at rest shows: it is drawn only while this is what the window asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// The lens.
    pub lens: Lens,
    /// Where it stands.
    pub viewpoint: ViewPoint,
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
    pub fn new(edit: &Edit, generation: u64, photo: [u32; 2], rect: Rect, canvas: Rect) -> Self {
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
        Self { lens: edit.lens, viewpoint: edit.viewpoint, size, region: part, generation }
    }

    /// The same, all of it, at another size.
    #[must_use]
    pub fn whole_at(self, size: [u32; 2]) -> Self {
        Self { size, region: Region { at: [0, 0], size }, ..self }
    }

    /// Whether it shows all of the picture at this size.
    pub fn is_whole_at(&self, size: [u32; 2]) -> bool {
        *self == self.whole_at(size)
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
    /// Their ray depths.
    pub depths: Arc<RayDepths>,
}

/// What of a picture does not depend on the lens, and the device that draws it, if it is faster than the processor.
struct Renderer {
    device: Option<LensGpu>,
    scene: Option<(u64, Scene)>,
    prepared: Option<(u64, ViewPoint, [u32; 2], Arc<Prepared>)>,
}

/// The work of the thread that renders pictures at rest; it keeps what does not depend on the lens.
pub fn worker(device: Option<LensGpu>) -> impl Work<Request> {
    let mut renderer = Renderer { device, scene: None, prepared: None };
    move |job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox| {
        let event = match renderer.render(&request, &Job { cancel, sink: &() }) {
            Ok(picture) => Event::Final(Box::new((request.key, Arc::new(TileSet::of_picture(&picture))))),
            Err(LensError::Cancelled(_)) => Event::Stopped,
            Err(error) => Event::Failed(crate::errors::sentence(&error)),
        };
        outbox.send(job, event);
    }
}

impl Renderer {
    fn render(&mut self, request: &Request, job: &Job) -> Result<Picture, LensError> {
        let Key { lens, region, .. } = request.key;
        let prepared = self.prepared(request, job)?;
        job.check()?;
        if let Some(device) = &mut self.device
            && let Some(picture) = device.render(&prepared, &lens, region, job)?
        {
            return Ok(picture);
        }
        prepared.render(&lens, region, job)
    }

    fn prepared(&mut self, request: &Request, job: &Job) -> Result<Arc<Prepared>, LensError> {
        let Key { viewpoint, size, generation, .. } = request.key;
        if let Some((have, from, at, prepared)) = &self.prepared
            && (*have, *from, *at) == (generation, viewpoint, size)
        {
            return Ok(Arc::clone(prepared));
        }
        let scene = match self.scene.take().filter(|(have, _)| *have == generation) {
            Some((_, scene)) => scene,
            None => scene_of(&request.photo, &request.depths)?.in_space(Space::Srgb),
        };
        let (_, scene) = self.scene.insert((generation, scene));
        job.check()?;
        let prepared = Arc::new(scene.seen_from(viewpoint, size, job)?.prepare(size));
        self.prepared = Some((generation, viewpoint, size, Arc::clone(&prepared)));
        Ok(prepared)
    }
}

/// A photo with the depths of its light field, ready for the lens renderer.
pub fn scene_of(photo: &Arc<Photo>, depths: &RayDepths) -> Result<Scene, LensError> {
    Scene::new(Arc::clone(photo), depths.reference_map())
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
        let key = Key::new(&Edit::default(), 1, photo, whole, canvas);
        assert_eq!(key.region, Region { at: [0, 0], size: key.size });
        assert!(key.size[0] >= 800 && key.size[0] < 960, "{:?}", key.size);

        let close = Rect::from_min_size(pos2(-1900.0, -950.0), vec2(4000.0, 3000.0));
        let key = Key::new(&Edit::default(), 1, photo, close, canvas);
        assert_eq!(key.size, photo, "never more than the photo's own pixels");
        assert!(key.on_screen(close).contains_rect(canvas));
        assert!(key.region.size[0] < 1300 && key.region.size[1] < 1000);
    }
}
