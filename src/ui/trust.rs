//! What was invented of the picture that is shown, and where sources of depth disagree: tinted over it once the hand rests.

use std::sync::Arc;

use egui::{ColorImage, Context, TextureHandle, TextureOptions};

use super::event::Event;
use super::look::Face;
use super::rest::Seen;
use super::theme;
use super::worker::{JobId, Outbox, Work};
use crate::field::{Lens, Raster, ViewPoint};
use crate::job::{Cancel, Job};
use crate::scene::trust::Trust;
use crate::scene::{Maker, Making, Scene};

/// How clearly what was invented is covered.
const ALPHA: f32 = 0.85;

/// What a tint belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct TrustKey {
    lens: Lens,
    from: ViewPoint,
    generation: u64,
}

/// A request for a tint.
pub struct Request {
    key: TrustKey,
    scene: Scene,
    making: Making,
}

/// The tint that is there, and the one that was asked for.
#[derive(Default)]
pub struct Tint {
    there: Option<(TrustKey, TextureHandle)>,
    asked_for: Option<TrustKey>,
}

impl Tint {
    /// Another file is open.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    fn key(seen: &Seen, generation: u64) -> Option<TrustKey> {
        let lens = seen.open.lens(seen.edit);
        (seen.look.face == Face::Picture).then_some(TrustKey { lens, from: seen.edit.viewpoint, generation })
    }

    /// The tint that is to be made now: once the hand rests.
    pub fn ask(&mut self, seen: &Seen, generation: u64, making: &Making) -> Option<Request> {
        let key = Self::key(seen, generation).filter(|key| self.asked_for.as_ref() != Some(key))?;
        let scene = seen.open.scene()?;
        if seen.look.is_moving {
            return None;
        }
        self.asked_for = Some(key.clone());
        Some(Request { key, scene: scene.clone(), making: making.clone() })
    }

    /// A tint is there.
    pub fn put(&mut self, key: TrustKey, image: ColorImage, ctx: &Context) {
        self.there = Some((key, ctx.load_texture("trust", image, TextureOptions::LINEAR)));
    }

    /// The tint of what is shown.
    pub fn texture(&self, seen: &Seen, generation: u64) -> Option<&TextureHandle> {
        let key = Self::key(seen, generation)?;
        self.there.as_ref().filter(|(have, _)| *have == key).map(|(_, texture)| texture)
    }
}

/// The work of the thread: what was invented at once, and where sources of depth disagree as soon as the second one is there,
/// which is made for this alone.
pub fn worker(maker: Arc<Maker>) -> impl Work<Request> {
    let mut known: Option<(u64, Option<Raster<f32>>)> = None;
    move |job: JobId, Request { key, scene, making }: Request, cancel: &Cancel, outbox: &Outbox| {
        let Ok(trust) = scene.trust() else { return };
        if known.as_ref().is_none_or(|(generation, _)| *generation != key.generation) {
            outbox.send(job, Event::Trust(key.clone(), tint(trust, &key)));
            let torn = maker.disagreement(&scene, &making, &Job { cancel, sink: &() });
            let Ok(torn) = torn else { return };
            known = Some((key.generation, torn));
        }
        let torn = known.as_ref().and_then(|(_, torn)| torn.as_ref());
        let image = tint(trust.with_torn_edges(torn), &key);
        outbox.send(job, Event::Trust(key, image));
    }
}

fn tint(trust: Trust, key: &TrustKey) -> ColorImage {
    let doubt = trust.of_picture(&key.lens, key.from);
    let sides = doubt.sides();
    let tint = |doubt: f32| theme::PEAK.gamma_multiply(doubt.clamp(0.0, 1.0).sqrt() * ALPHA);
    ColorImage::new(sides, doubt.into_pixels().into_iter().map(tint).collect())
}
