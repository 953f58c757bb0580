//! The scene as points in space: what the face of that name shows, and the thread that draws it.
//!
//! While the hand turns it, drafts of half the size follow, one after the other as fast as they come. Once it rests, the
//! points of all views are drawn at the size of the screen; those of the reference view are there before.

use std::time::Duration;

use egui::{ColorImage, Context, TextureHandle, TextureOptions};

use super::command::Command;
use super::event::Event;
use super::progress::now;
use super::worker::{JobId, Outbox, Work};
use crate::errors::sentence;
use crate::field::Strength;
use crate::job::{Cancel, Job};
use crate::scene::dots::{Dots, Gathered, Turn};
use crate::scene::{Scene, SceneError};

/// The hand rests once nothing has turned for so long.
const REST_SECS: f64 = 0.2;
/// What an arrow key turns, in radians.
const STEP: f32 = 0.15;

/// What a picture of the points shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointsKey {
    /// From where.
    turn: Turn,
    /// Pixels.
    size: [u32; 2],
    /// Half the size, and the points that are there.
    is_draft: bool,
    of: LightFieldKey,
}

/// Which light field.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LightFieldKey {
    generation: u64,
    strength: Strength,
}

/// A request for a picture of the points.
pub struct Request {
    key: PointsKey,
    scene: Scene,
}

/// A picture of the points.
pub struct Drawn {
    key: PointsKey,
    image: ColorImage,
    gathered: Gathered,
    count: usize,
}

/// From where the points are seen, the picture that is there, and the one that was asked for.
#[derive(Default)]
pub struct Points {
    turn: Turn,
    /// When that changed last.
    turned_at_secs: f64,
    there: Option<(Shown, TextureHandle)>,
    asked_for: Option<PointsKey>,
}

/// What the picture that is there shows.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    key: PointsKey,
    /// Whether the points of all views are in it.
    pub has_all: bool,
    /// How many points there are.
    pub count: usize,
}

impl Points {
    /// Another file is open.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// From where they are seen.
    pub fn turn(&self) -> Turn {
        self.turn
    }

    /// Looks from elsewhere.
    pub fn turn_to(&mut self, turn: Turn) {
        if turn != self.turn {
            (self.turn, self.turned_at_secs) = (turn, now());
        }
    }

    /// What keys do here that move eye and picture elsewhere; false for all others.
    pub fn obey(&mut self, command: Command) -> bool {
        let turn = self.turn;
        self.turn_to(match command {
            Command::StepLeft => turn.by(-STEP, 0.0),
            Command::StepRight => turn.by(STEP, 0.0),
            Command::StepUp => turn.by(0.0, -STEP),
            Command::StepDown => turn.by(0.0, STEP),
            Command::ZoomIn => turn.nearer(1.25),
            Command::ZoomOut => turn.nearer(0.8),
            Command::Fit | Command::ResetViewpoint => Turn::default(),
            _ => return false,
        });
        true
    }

    /// What is to be drawn now, at a size in pixels. A draft that is on its way is waited for: else none would ever come.
    pub fn ask(&mut self, scene: &Scene, size: [u32; 2], generation: u64, ctx: &Context) -> Option<Request> {
        let is_moving = now() - self.turned_at_secs < REST_SECS;
        if is_moving {
            ctx.request_repaint_after(Duration::from_secs_f64(REST_SECS));
        }
        let of = LightFieldKey { generation, strength: scene.strength() };
        let size = if is_moving { size.map(|side| side.div_ceil(2)) } else { size };
        let key = PointsKey { turn: self.turn, size: size.map(|side| side.max(1)), is_draft: is_moving, of };
        let have = self.there.as_ref().map(|(shown, _)| shown);
        let is_on_its_way =
            self.asked_for.is_some_and(|asked| asked.is_draft && have.is_none_or(|have| have.key != asked));
        if self.asked_for == Some(key) || is_moving && is_on_its_way {
            return None;
        }
        self.asked_for = Some(key);
        Some(Request { key, scene: scene.clone() })
    }

    /// A picture is there.
    pub fn put(&mut self, Drawn { key, image, gathered, count }: Drawn, ctx: &Context) {
        let shown = Shown { key, has_all: gathered == Gathered::All, count };
        self.there = Some((shown, ctx.load_texture("points", image, TextureOptions::LINEAR)));
    }

    /// The picture that is there, of the light field that is shown.
    pub fn picture(&self, generation: u64) -> Option<(&Shown, &TextureHandle)> {
        self.there.as_ref().filter(|(shown, _)| shown.key.of.generation == generation).map(|(shown, id)| (shown, id))
    }

    /// Whether the picture that was asked for last is there, with the points of all views.
    pub fn is_there(&self) -> bool {
        let have = self.there.as_ref().filter(|(shown, _)| shown.has_all && !shown.key.is_draft);
        have.map(|(shown, _)| shown.key) == self.asked_for
    }
}

/// The work of the thread: it keeps the points of the light field that was drawn last.
pub fn worker() -> impl Work<Request> {
    let mut kept: Option<(LightFieldKey, Gathered, Dots)> = None;
    move |job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox| {
        let task = Job { cancel, sink: &() };
        if let Err(error) = draw(&mut kept, &request, &task, &|drawn| outbox.send(job, Event::Points(Box::new(drawn))))
            && !cancel.is_cancelled()
        {
            outbox.send(job, Event::Failed(sentence(&error).into()));
        }
    }
}

fn draw(
    kept: &mut Option<(LightFieldKey, Gathered, Dots)>,
    Request { key, scene }: &Request,
    job: &Job,
    send: &dyn Fn(Drawn) -> bool,
) -> Result<(), SceneError> {
    if kept.as_ref().is_none_or(|(of, ..)| *of != key.of) {
        *kept = Some((key.of, Gathered::Reference, scene.dots(Gathered::Reference, job)?));
    }
    loop {
        let Some((of, gathered, dots)) = kept else { return Ok(()) };
        let rgba = dots.drawn(key.turn, key.size, job)?;
        let image = ColorImage::from_rgba_unmultiplied(key.size.map(|side| side as usize), &rgba);
        send(Drawn { key: *key, image, gathered: *gathered, count: dots.count() });
        if key.is_draft || *gathered == Gathered::All {
            return Ok(());
        }
        *kept = Some((*of, Gathered::All, scene.dots(Gathered::All, job)?));
    }
}
