//! Focus peaking: the edges that are in focus, marked over the picture. Computed on a thread, at light-field size.

use std::sync::Arc;

use egui::ColorImage;

use super::event::Event;
use super::keys::{Peaks, PeaksKey};
use super::theme;
use super::worker::{JobId, Outbox};
use crate::field::{LightField, RayDepths, sides};
use crate::job::Cancel;
use crate::render::lens::peaking;

/// A request for marks.
pub struct Request {
    /// What they belong to.
    pub key: PeaksKey,
    /// The views.
    pub field: Arc<LightField>,
    /// Their ray depths.
    pub depths: Arc<RayDepths>,
}

/// The thread's work.
pub fn work(job: JobId, request: Request, _: &Cancel, outbox: &Outbox) {
    let Request { key, field, depths } = request;
    let view = field.view(key.view);
    let map = depths.map(key.view);
    let marks = peaking(view, &map, &key.lens);
    let pixels = marks.into_iter().map(|mark| theme::PEAK.gamma_multiply(f32::from(mark) / 255.0)).collect();
    let image = ColorImage::new(sides(view.size()), pixels);
    outbox.send(job, Event::Peaks(Peaks { key, image }));
}
