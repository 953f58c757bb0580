//! What the threads tell the window.

use std::path::PathBuf;
use std::sync::Arc;

use super::adding::Card;
use super::ask::Picked;
use super::document::Document;
use super::keys::{Peaks, RestKey};
use super::mending::Answer;
use super::open::Made;
use super::points::Drawn;
use super::rays::Rays;
use super::tiles::TileSet;
use super::training;
use super::trust::TrustKey;
use super::words::Message;
use crate::field::{View, ViewIndex};
use crate::job::Progress;
use crate::render::Picture;
use crate::scene::DepthFrom;
use crate::synth::ModelTag;

/// What the threads tell the window. Big things come as handles that nobody copies.
pub enum Event {
    /// A photo or a light field has been read; with the ray depths that it holds, and of a photo what can be shown at once.
    Opened(Box<Document>, Option<Rays>, Option<Arc<TileSet>>),
    /// What was to be opened is a folder of photos: what they are for is asked.
    Several(Vec<PathBuf>),
    /// The photo, ready for the screen.
    Tiles(Arc<TileSet>),
    /// A job went on a little.
    Progress(Progress),
    /// Ray depths are there, before the views.
    Rays(Rays),
    /// A view is there; it comes again once it is corrected.
    View(ViewIndex, Arc<View>),
    /// The light field is complete.
    Made(Box<Made>),
    /// What was invented of a picture.
    Trust(TrustKey, egui::ColorImage),
    /// The scene as points.
    Points(Box<Drawn>),
    /// What mending depth was waiting for.
    Mending(Answer),
    /// The light field that is shown, at another strength.
    AtStrength(Box<Made>),
    /// A picture at rest, by the lens renderer.
    AtRest(RestKey, Arc<TileSet>),
    /// A file was written.
    Saved(PathBuf),
    /// Edges in focus.
    Peaks(Peaks),
    /// A small picture of a recent file.
    Thumbnail(PathBuf, Arc<egui::ColorImage>),
    /// Further depth nets that ray depths can come from.
    Models(Vec<Listed>),
    /// A depth net was added.
    Added(Box<Card>),
    /// What training tells.
    Training(training::Answer),
    /// The file was there already and was left as it is.
    Skipped(PathBuf),
    /// A picture for the clipboard.
    Copied(Arc<Picture>),
    /// Where a dialog led.
    Picked(Picked),
    /// Something went wrong that does not stop the job.
    Warning(Message),
    /// The job was stopped: not an error.
    Stopped,
    /// The job failed; the sentence says what, why and what to do.
    Failed(Message),
}

/// A depth net in the menu.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Its name.
    pub name: String,
    /// Its name and checksum, where they can be read.
    pub tag: Option<ModelTag>,
    /// Why it cannot be used.
    pub fault: Option<String>,
    /// Whether it is used for all photos without depth of their own.
    pub is_preferred: bool,
    /// Whether the person added it, and may remove it.
    pub is_added: bool,
}

impl Listed {
    /// The net as a source of depth.
    pub fn source(&self) -> DepthFrom {
        self.tag.clone().map_or_else(|| DepthFrom::Model(self.name.clone()), DepthFrom::Net)
    }
}
