//! What is drawn over the draft: the lens renderer's picture once the hand rests, and the edges that are in focus.
//!
//! A lens wider than the light field has no draft of views: there the lens renderer follows the hand itself, at the size
//! of a view, one picture after the other as fast as they come.

use std::sync::Arc;
use std::time::Duration;

use egui::TextureHandle;

use super::app::App;
use super::document::Document;
use super::finals;
use super::peaking::{self, Peaks};
use super::progress::now;
use super::state::Face;
use super::tiles::{TileSet, Tiled};
use crate::field::{FNumber, Lens};

/// Rest before the picture at rest is asked for.
const REST_SECS: f64 = 0.2;

/// What is wanted, what has been asked for, and what is there.
#[derive(Default)]
pub struct AtRest {
    picture: Option<(finals::Key, Tiled)>,
    wanted: Option<finals::Key>,
    asked_for: Option<finals::Key>,
    peaks: Option<(peaking::Key, TextureHandle)>,
    peaks_asked_for: Option<peaking::Key>,
}

impl AtRest {
    /// Whether what is wanted is there.
    pub fn is_there(&self) -> bool {
        self.wanted.is_none() || self.picture.as_ref().map(|(key, _)| *key) == self.wanted
    }

    /// The lens renderer's picture is there.
    pub fn put(&mut self, key: finals::Key, tiles: Arc<TileSet>) {
        self.picture = Some((key, Tiled::new(tiles)));
    }

    /// Marks are there.
    pub fn put_peaks(&mut self, peaks: Peaks, ctx: &egui::Context) {
        let texture = ctx.load_texture("peaking", peaks.image, egui::TextureOptions::LINEAR);
        self.peaks = Some((peaks.key, texture));
    }

    /// The picture, where it shows what is asked for at any size; of a wide lens the last one, while the next is drawn.
    pub fn picture(&mut self, key: finals::Key) -> Option<(&finals::Key, &mut Tiled)> {
        let (have, tiled) = self.picture.as_mut()?;
        let is_same = (have.lens, have.viewpoint) == (key.lens, key.viewpoint);
        let follows = is_wide(&have.lens) && is_wide(&key.lens);
        (have.generation == key.generation && (is_same || follows)).then_some((&*have, tiled))
    }

    /// Whether this is being drawn.
    fn is_drawing(&self, is_it: impl Fn(&finals::Key) -> bool) -> bool {
        let done = self.picture.as_ref().map(|(have, _)| *have);
        self.asked_for.is_some_and(|key| is_it(&key) && done != Some(key))
    }
}

/// Whether a lens is wider than the light field, so that a sum of views cannot show it.
fn is_wide(lens: &Lens) -> bool {
    lens.f_number.0 < FNumber::PAPER_WIDEST.0
}

impl App {
    /// Asks for the picture at rest once nothing has moved for a while.
    pub(super) fn rest(&mut self, ctx: &egui::Context) {
        self.rest.wanted = self.key_at_rest(ctx.pixels_per_point());
        let Some(key) = self.rest.wanted else {
            self.rest.asked_for = None;
            return;
        };
        let is_there = self.rest.picture.as_ref().is_some_and(|(have, _)| *have == key);
        if is_there || self.rest.asked_for == Some(key) {
            return;
        }
        let Document { photo: Some(photo), field: Some(field), depths: Some(depths), .. } = &self.document else {
            return;
        };
        let mut key = key;
        if self.is_moving || now() - self.moved_at_secs < REST_SECS {
            ctx.request_repaint_after(Duration::from_secs_f64(REST_SECS));
            key = key.whole_at(field.size());
            // The hand does not stop a draft: else it would never see one.
            let is_busy = self.rest.is_drawing(|asked| asked.is_whole_at(field.size()));
            if !is_wide(&key.lens) || is_busy || self.rest.asked_for == Some(key) {
                return;
            }
        }
        let (photo, depths) = (Arc::clone(photo), Arc::clone(depths));
        self.workers.finisher.replace(finals::Request { key, photo, depths });
        self.rest.asked_for = Some(key);
    }

    /// What the picture at rest has to show; `None` where the draft, or the photo itself, is all there is.
    pub(super) fn key_at_rest(&self, pixels_per_point: f32) -> Option<finals::Key> {
        let size = self.picture_size()?;
        let photo = self.document.photo.as_ref()?;
        let is_possible = self.document.field.is_some()
            && self.document.depths.is_some()
            && self.face == Face::Picture
            && !self.shows_photo_itself();
        let on_screen = self.pose.screen_rect(self.canvas, size) * pixels_per_point;
        let canvas = self.canvas * pixels_per_point;
        is_possible.then(|| finals::Key::new(&self.edit, self.generation, photo.size(), on_screen, canvas))
    }

    /// Asks for the marks of what is in focus, whenever the lens or the view has changed.
    pub(super) fn mark_peaks(&mut self) {
        let Some(key) = self.peaking_key() else { return };
        if self.rest.peaks_asked_for == Some(key) {
            return;
        }
        let (Some(field), Some(depths)) = (&self.document.field, &self.document.depths) else { return };
        let (field, depths) = (Arc::clone(field), Arc::clone(depths));
        self.workers.peaker.replace(peaking::Request { key, field, depths });
        self.rest.peaks_asked_for = Some(key);
    }

    fn peaking_key(&self) -> Option<peaking::Key> {
        let (field, depths) = (self.document.field.as_ref()?, self.document.depths.as_ref()?);
        let fits = field.grid() == depths.grid() && field.size() == depths.size();
        let is_wanted = self.settings.peaking && self.face == Face::Picture && fits;
        let view = self.nearest_view().filter(|_| is_wanted)?;
        Some(peaking::Key { lens: self.edit.lens, view, generation: self.generation })
    }

    /// Marks that belong to what is shown.
    pub(super) fn peaks(&self) -> Option<&TextureHandle> {
        let key = self.peaking_key()?;
        self.rest.peaks.as_ref().filter(|(have, _)| *have == key).map(|(_, texture)| texture)
    }
}
