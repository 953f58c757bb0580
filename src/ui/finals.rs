//! The picture at rest: once the hand rests, the lens renderer's picture of the visible part replaces the draft, at the
//! screen's size and, from 1:1 on, with the photo's true pixels.

use std::sync::Arc;

use super::event::Event;
use super::keys::RestKey;
use super::tiles::TileSet;
use super::worker::{JobId, Outbox, Work};
use crate::field::{Strength, ViewPoint};
use crate::job::{Cancel, Job};
use crate::render::Picture;
use crate::render::lens::{LensGpu, Prepared, Region, Rgbd, Space};
use crate::scene::{Edit, Making, Need, OutputSize, Scene, SceneError};
use crate::splats::{Painter, Processor, SplatGpu};

/// A request for a picture at rest.
pub struct Request {
    /// What it shows.
    pub key: RestKey,
    /// What it is made of.
    pub scene: Scene,
}

/// What draws pictures at rest where a device is faster than the processor.
pub struct Devices {
    /// The layered lens.
    pub lens: LensGpu,
    /// What a true lens sees of a scene of splats.
    pub splats: SplatGpu,
}

/// What of a picture does not depend on the lens, and what draws it.
struct Renderer {
    devices: Option<Devices>,
    rgbd: Option<(Which, Rgbd)>,
    prepared: Option<(Which, Eye, [u32; 2], Arc<Prepared>)>,
}

/// The light field's number, and how deep it is.
type Which = (u64, Strength);
/// Where the eye is, and what it turns around.
type Eye = (ViewPoint, f32);

/// The work of the thread that renders pictures at rest; it keeps what does not depend on the lens.
pub fn worker(devices: Option<Devices>) -> impl Work<Request> {
    let mut renderer = Renderer { devices, rgbd: None, prepared: None };
    move |job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox| {
        let event = match renderer.render(&request, &Job { cancel, sink: &() }) {
            Ok(picture) => Event::AtRest(request.key.clone(), Arc::new(TileSet::of_picture(&picture))),
            Err(_) if cancel.is_cancelled() => Event::Stopped,
            Err(error) => Event::Failed(crate::errors::sentence(&error).into()),
        };
        outbox.send(job, event);
        // What a lens renderer drafts of a scene of splats, a true lens takes the place of.
        let picture = renderer.true_picture(&request, &Job { cancel, sink: &() }).unwrap_or_else(|error| {
            log::info!("no true defocus: {error}");
            None
        });
        if let Some(picture) = picture {
            outbox.send(job, Event::AtRest(request.key, Arc::new(TileSet::of_picture(&picture))));
        }
    }
}

/// A part of a picture.
fn part(picture: &Picture, Region { at, size }: Region) -> Picture {
    let last = picture.size.map(|side| side.saturating_sub(1));
    Picture::from_fn(size, |x, y| picture.pixel((at[0] + x).min(last[0]), (at[1] + y).min(last[1])))
}

impl Renderer {
    /// The visible part of what a true lens sees, where the scene has one.
    fn true_picture(&self, request: &Request, job: &Job) -> Result<Option<Picture>, SceneError> {
        let RestKey { ref edit, size, region, .. } = request.key;
        let scene = request.scene.at_strength(edit.strength, &Making::default(), Need::Map, job)?;
        let painter: &dyn Painter = self.devices.as_ref().map_or(&Processor, |devices| &devices.splats);
        let whole = scene.through_true_lens(edit, OutputSize::Within(size), painter, job)?;
        Ok(whole.map(|picture| part(&picture, region)))
    }

    fn render(&mut self, request: &Request, job: &Job) -> Result<Picture, SceneError> {
        let RestKey { ref edit, region, .. } = request.key;
        // The views of a strength may be on their way: the map is there at once.
        let scene = request.scene.at_strength(edit.strength, &Making::default(), Need::Map, job)?;
        let prepared = self.prepared(&scene, &request.key, job)?;
        job.check()?;
        let lens = scene.lens(edit);
        if let Some(devices) = &mut self.devices
            && let Some(picture) = devices.lens.render(&prepared, &lens, region, job)?
        {
            return Ok(picture);
        }
        Ok(prepared.render(&lens, region, job)?)
    }

    fn prepared(&mut self, scene: &Scene, key: &RestKey, job: &Job) -> Result<Arc<Prepared>, SceneError> {
        let RestKey { edit: Edit { viewpoint, pivot, .. }, size, generation, .. } = *key;
        let generation = (generation, scene.strength());
        if let Some((have, from, at, prepared)) = &self.prepared
            && (*have, *from, *at) == (generation, (viewpoint, pivot), size)
        {
            return Ok(Arc::clone(prepared));
        }
        let rgbd = match self.rgbd.take().filter(|(have, _)| *have == generation) {
            Some((_, rgbd)) => rgbd,
            None => scene.rgbd()?.in_space(Space::Srgb),
        };
        let (_, rgbd) = self.rgbd.insert((generation, rgbd));
        job.check()?;
        let pivot_px = key.edit.pivot_px(rgbd.disparity().size()[0], scene.strength());
        let prepared = Arc::new(rgbd.seen_from(viewpoint, pivot_px, size, job)?.prepare(size, job.cancel)?);
        self.prepared = Some((generation, (viewpoint, pivot), size, Arc::clone(&prepared)));
        Ok(prepared)
    }
}
