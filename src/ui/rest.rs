//! What is drawn over the draft: the lens renderer's picture once the hand rests, and the edges that are in focus.
//!
//! A lens wider than the light field has no draft of views, nor has a scene so deep that copies would be seen beside each
//! other: there the lens renderer follows the hand itself, at the size of a view, one picture after the other as fast as
//! they come. Where the eye moves, which views follow faster, grain takes the place of the copies.

use std::sync::Arc;
use std::time::Duration;

use egui::TextureHandle;

use super::finals;
use super::keys::{Peaks, PeaksKey, RestKey};
use super::look::{Face, Look};
use super::open::Open;
use super::peaking;
use super::progress::now;
use super::tiles::{TileSet, Tiled};
use crate::field::Histogram;
use crate::scene::{Edit, OutputSize, Scene};

/// Rest before the picture at rest is asked for.
const REST_SECS: f64 = 0.2;
/// Pictures that are kept, so that sources of depth are compared without waiting.
const MOST_PICTURES: usize = 6;

/// What is looked at, and how.
pub struct Seen<'a> {
    /// What is open.
    pub open: &'a Open,
    /// Lens and viewpoint.
    pub edit: &'a Edit,
    /// Face, zoom and pan.
    pub look: &'a Look,
}

/// What is wanted, what has been asked for, and what is there.
#[derive(Default)]
pub struct AtRest {
    /// The light field that is shown: what was drawn of another is not.
    generation: u64,
    /// Light fields so far.
    generations: u64,
    /// Pictures of some light fields, one of each, the latest last.
    pictures: Vec<(RestKey, Tiled)>,
    wanted: Option<RestKey>,
    asked_for: Option<RestKey>,
    peaks: Option<(PeaksKey, TextureHandle)>,
    peaks_asked_for: Option<PeaksKey>,
    /// Of how many views in a row one is drawn while something moves.
    nth: u32,
}

impl AtRest {
    /// For drafts that are made of every `nth` view of a row.
    pub fn of_every(nth: u32) -> Self {
        Self { nth, ..Self::default() }
    }

    /// Another file is open.
    pub fn forget(&mut self) {
        *self = Self { generation: self.generation, generations: self.generations, ..Self::of_every(self.nth) };
    }

    /// Another light field is there; returns its number.
    pub fn begin(&mut self) -> u64 {
        self.generations += 1;
        self.generation = self.generations;
        self.generation
    }

    /// The number of the light field that is shown.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// One that was there before is shown again.
    pub fn resume(&mut self, generation: u64) {
        self.generation = generation;
    }

    /// Whether what is wanted is there.
    pub fn is_there(&self) -> bool {
        self.wanted.as_ref().is_none_or(|wanted| self.have(wanted.generation) == Some(wanted))
    }

    /// The lens renderer's picture is there.
    pub fn put(&mut self, key: RestKey, tiles: Arc<TileSet>) {
        self.pictures.retain(|(have, _)| have.generation != key.generation);
        self.pictures.push((key, Tiled::new(tiles)));
        let over = self.pictures.len().saturating_sub(MOST_PICTURES);
        self.pictures.drain(..over);
    }

    /// What the picture of a light field shows.
    fn have(&self, generation: u64) -> Option<&RestKey> {
        self.pictures.iter().map(|(key, _)| key).find(|key| key.generation == generation)
    }

    /// Marks are there.
    pub fn put_peaks(&mut self, peaks: Peaks, ctx: &egui::Context) {
        let texture = ctx.load_texture("peaking", peaks.image, egui::TextureOptions::LINEAR);
        self.peaks = Some((peaks.key, texture));
    }

    /// The picture, where it shows what is asked for at any size; where it follows the hand the last one, while the next is
    /// drawn.
    pub fn picture(&mut self, key: &RestKey, follows: bool) -> Option<(&RestKey, &mut Tiled)> {
        let (have, tiled) = self.pictures.iter_mut().find(|(have, _)| have.generation == key.generation)?;
        (have.edit == key.edit || follows).then_some((&*have, tiled))
    }

    /// Whether the lens renderer's pictures follow the hand, as no sum of views shows what they do. An eye that moves is
    /// followed by views as long as they reach across the lens: they are there already.
    pub fn follows(&self, seen: &Seen) -> bool {
        let (Some(scene), Some(grid)) = (seen.open.scene(), seen.open.grid()) else { return false };
        let is_elsewhere = |have: &RestKey| have.edit.viewpoint != seen.edit.viewpoint;
        let eye_moves = self.have(self.generation).is_none_or(is_elsewhere) && grid.spans(seen.edit.f_number);
        !eye_moves && !scene.views_draft(seen.edit, self.nth)
    }

    /// Whether copies would be seen beside each other in a draft of views, of a picture that has none.
    pub fn has_copies(&self, seen: &Seen) -> bool {
        let is_true = |scene: &Scene| scene.sums_views(seen.edit, OutputSize::Photo);
        seen.open.scene().is_some_and(|scene| !is_true(scene) && !scene.views_draft(seen.edit, self.nth))
    }

    /// How bright the last picture of the light field is that was drawn.
    pub fn histogram(&self) -> Option<&Histogram> {
        let last = self.pictures.iter().find(|(have, _)| have.generation == self.generation);
        last.and_then(|(_, tiled)| tiled.histogram())
    }

    /// Whether this is being drawn.
    fn is_drawing(&self, is_it: impl Fn(&RestKey) -> bool) -> bool {
        self.asked_for.as_ref().is_some_and(|key| is_it(key) && self.have(key.generation) != Some(key))
    }

    /// The picture at rest that is to be drawn now: once nothing has moved for a while, or of a wide lens at once.
    pub fn ask(&mut self, seen: &Seen, ctx: &egui::Context) -> Option<finals::Request> {
        self.wanted = self.key(seen, ctx.pixels_per_point());
        let Some(mut key) = self.wanted.clone() else {
            self.asked_for = None;
            return None;
        };
        if self.is_there() || self.asked_for.as_ref() == Some(&key) {
            return None;
        }
        let (scene, field) = (seen.open.scene()?, seen.open.field()?);
        if seen.look.is_moving || now() - seen.look.moved_at_secs < REST_SECS {
            ctx.request_repaint_after(Duration::from_secs_f64(REST_SECS));
            key = key.whole_at(field.size());
            // The hand does not stop a draft: else it would never see one.
            let is_busy = self.is_drawing(|asked| asked.is_whole_at(field.size()));
            if !self.follows(seen) || is_busy || self.asked_for.as_ref() == Some(&key) {
                return None;
            }
        }
        self.asked_for = Some(key.clone());
        Some(finals::Request { key, scene: scene.clone() })
    }

    /// What the picture at rest has to show; `None` where the draft, or the photo itself, is all there is.
    pub fn key(&self, seen: &Seen, pixels_per_point: f32) -> Option<RestKey> {
        let Seen { open, edit, look } = seen;
        let scene = open.scene()?;
        let on_screen = look.pose.screen_rect(look.canvas, open.picture_size()?) * pixels_per_point;
        let canvas = look.canvas * pixels_per_point;
        // A recorded light field is drawn of its views, which are still those of another strength.
        if scene.subject().photo().is_none() && open.wanted_strength(edit).is_some() {
            return None;
        }
        let is_draft_true = edit.shows_photo_itself() || scene.sums_views(edit, OutputSize::Photo);
        let key = RestKey::new(edit, self.generation, scene.subject().size(), on_screen, canvas);
        let is_wanted = look.face == Face::Picture && !is_draft_true;
        is_wanted.then_some(key)
    }

    /// The marks of what is in focus that are to be made now, when the lens or the view has changed.
    pub fn ask_peaks(&mut self, seen: &Seen) -> Option<peaking::Request> {
        let key = self.peaks_key(seen).filter(|key| self.peaks_asked_for.as_ref() != Some(key))?;
        self.peaks_asked_for = Some(key.clone());
        let (field, depths) = (Arc::clone(seen.open.field()?), Arc::clone(&seen.open.rays()?.depths));
        Some(peaking::Request { key, field, depths })
    }

    fn peaks_key(&self, seen: &Seen) -> Option<PeaksKey> {
        let (field, depths) = (seen.open.field()?, &seen.open.rays()?.depths);
        let fits = field.grid() == depths.grid() && field.size() == depths.size();
        let view = seen.open.nearest_view(seen.edit.viewpoint).filter(|_| fits && seen.look.face == Face::Picture)?;
        let (lens, strength) =
            (seen.open.lens(seen.edit), seen.open.scene().map_or_else(Default::default, Scene::strength));
        Some(PeaksKey { lens, view, strength, generation: self.generation })
    }

    /// Marks that belong to what is shown.
    pub fn peaks(&self, seen: &Seen) -> Option<&TextureHandle> {
        let key = self.peaks_key(seen)?;
        self.peaks.as_ref().filter(|(have, _)| *have == key).map(|(_, texture)| texture)
    }
}
