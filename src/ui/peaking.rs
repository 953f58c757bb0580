//! Focus peaking: the edges that are in focus, marked over the picture. Computed on a thread, at light-field size.

use std::sync::Arc;

use egui::ColorImage;

use super::theme;
use super::worker::{Event, JobId, Outbox};
use crate::field::{Lens, LightField, RayDepths, ViewIndex, sides};
use crate::job::Cancel;
use crate::render::lens::peaking;

/// What the marks belong to: they are drawn only while this is what the window shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// The lens.
    pub lens: Lens,
    /// The view that is looked at.
    pub view: ViewIndex,
    /// Which light field, counted by the window.
    pub generation: u64,
}

/// A request for marks.
pub struct Request {
    /// What they belong to.
    pub key: Key,
    /// The views.
    pub field: Arc<LightField>,
    /// Their ray depths.
    pub depths: Arc<RayDepths>,
}

/// Marks, ready for the screen.
#[derive(Debug)]
pub struct Peaks {
    /// What they belong to.
    pub key: Key,
    /// The marks, transparent elsewhere, at light-field size.
    pub image: ColorImage,
}

/// The thread's work.
pub fn work(job: JobId, request: Request, _: &Cancel, outbox: &Outbox) {
    let Request { key, field, depths } = request;
    let view = field.view(key.view);
    let map = depths.map(key.view);
    let marks = peaking(view, &map, &key.lens);
    let pixels = marks.into_iter().map(|mark| theme::PEAK.gamma_multiply(f32::from(mark) / 255.0)).collect();
    let image = ColorImage::new(sides(view.size()), pixels);
    outbox.send(job, Event::Peaks(Box::new(Peaks { key, image })));
}
