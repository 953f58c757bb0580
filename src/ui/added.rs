//! A net that was added, while the window shows what it is.

use std::sync::Arc;

use egui::{Context, TextureHandle};

use super::adding::Card;

/// What is shown of a net that was added.
pub struct Shown {
    /// What it is.
    pub card: Card,
    /// The sample, and what the net says of it.
    pub textures: [TextureHandle; 2],
}

impl Shown {
    /// With its pictures on the device.
    pub fn new(card: Card, ctx: &Context) -> Self {
        let texture = |index: usize| ctx.load_texture("added", Arc::clone(&card.pictures[index]), Default::default());
        let textures = [texture(0), texture(1)];
        Self { card, textures }
    }
}
