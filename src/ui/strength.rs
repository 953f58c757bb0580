//! The light field that is open at another strength: views and ray depths follow once the hand rests, the draft at once.

use super::event::Event;
use super::open::{Made, Open};
use super::worker::{JobId, Outbox};
use crate::errors::sentence;
use crate::field::Strength;
use crate::job::{Cancel, Job};
use crate::scene::{Edit, Making, Need, Scene};

/// A request for a light field at another strength.
pub struct Request {
    /// The light field as it is.
    scene: Scene,
    /// The strength it is to have.
    strength: Strength,
    /// How it was made.
    making: Making,
}

/// What was asked for last: of which light field, and how deep.
#[derive(Default)]
pub struct Shaping {
    asked_for: Option<(u64, Strength)>,
}

impl Shaping {
    /// What is to be made now, if anything: once the pointer is up.
    pub fn ask(
        &mut self,
        open: &Open,
        edit: &Edit,
        generation: u64,
        making: &Making,
        is_moving: bool,
    ) -> Option<Request> {
        let Some(strength) = open.wanted_strength(edit) else {
            self.asked_for = None;
            return None;
        };
        if is_moving || self.asked_for == Some((generation, strength)) {
            return None;
        }
        self.asked_for = Some((generation, strength));
        Some(Request { scene: open.scene()?.clone(), strength, making: making.clone() })
    }
}

/// Whether two scenes are of the same light field.
pub fn is_same(one: &Scene, other: &Scene) -> bool {
    std::sync::Arc::ptr_eq(one.as_made().map(), other.as_made().map())
}

/// The work of the thread.
pub fn work(job: JobId, request: Request, cancel: &Cancel, outbox: &Outbox) {
    let Request { scene, strength, making } = request;
    let task = Job { cancel, sink: &() };
    let made = scene.at_strength(strength, &making, Need::Views, &task).and_then(Made::of);
    outbox.send(
        job,
        match made {
            _ if cancel.is_cancelled() => Event::Stopped,
            Ok(made) => Event::AtStrength(Box::new(made)),
            Err(error) => Event::Failed(sentence(&error).into()),
        },
    );
}
