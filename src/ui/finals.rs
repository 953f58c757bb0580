//! The picture at rest: once the hand rests, the lens renderer's picture at screen size replaces the draft.

use std::sync::Arc;

use super::tiles::TileSet;
use super::worker::{Event, JobId, Outbox};
use crate::field::{Lens, Photo, RayDepths};
use crate::job::Cancel;

/// What a picture at rest shows: it is drawn only while this is what the window asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// The lens.
    pub lens: Lens,
    /// Long side of the picture, in pixels.
    pub long_side: u32,
    /// Which light field, counted by the window.
    pub generation: u64,
}

/// A request for a picture at rest.
#[derive(Debug)]
pub struct Request {
    /// What it shows.
    pub key: Key,
    /// The photo.
    pub photo: Arc<Photo>,
    /// Its ray depths.
    pub depths: Arc<RayDepths>,
}

/// The work of the thread that renders pictures at rest.
pub fn work(job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox) {
    let Some(picture) = render(&request, cancel) else {
        outbox.send(job, Event::Stopped);
        return;
    };
    let tiles = Arc::new(TileSet::of_picture(&picture));
    outbox.send(job, Event::Final(Box::new((request.key, tiles))));
}

fn render(_request: &Request, _cancel: &Cancel) -> Option<crate::render::Picture> {
    None
}

/// Whether there is a renderer for pictures at rest.
pub const IS_THERE: bool = false;

/// Long side of a picture at rest: that of the screen in steps, so that a little zoom asks for nothing new, and never
/// more than the photo's.
pub fn long_side(wanted: f32, photo: f32) -> u32 {
    let step = 2f32.powf((wanted.max(64.0).log2() * 4.0).ceil() / 4.0);
    step.min(photo) as u32
}
