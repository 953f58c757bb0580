//! What panels, dialogs and keys ask for; `apply` does it, and nothing else does.

use super::adding::Change;
use std::path::PathBuf;

use super::ask::Ask;
use super::command::Command;
use super::dialog::Dialog;
use super::film::Cut;
use super::hints::Hint;
use super::jobs::OpenFrom;
use super::training::Wanted;
use super::words::Message;
use super::worker::JobId;
use crate::field::{Opening, ViewOffset};
use crate::io::formats::depth_map::GivenDepth;
use crate::repair::Repair;
use crate::scene::{DepthFrom, Recipe};

/// One thing that a person wants done.
pub enum Action {
    /// A command of the menu.
    Do(Command),
    /// Opens something; what is open stays usable until it is there.
    Open(OpenFrom),
    /// Asks the system for a file or a folder, or the clipboard for what is in it.
    Ask(Ask),
    /// Shows a dialog of the window's own in place of the one that is shown.
    Show(Dialog),
    /// Takes the dialog away.
    CloseDialog,
    /// Says what a person should know.
    Tell(Message),
    /// Says why something cannot be done.
    Refuse(Message),
    /// Looks from another place.
    LookFrom(ViewOffset),
    /// Focuses where the subject most likely is.
    FocusOnSubject,
    /// Mends the depth.
    Repair(Repair),
    /// Takes a repair away, by its number.
    Unrepair(usize),
    /// Takes a picture as the opening of the lens.
    TakeOpening(Opening),
    /// Applies an edit of another photo.
    PasteEdit(Box<Recipe>),
    /// Applies lens and export of a preset.
    TakePreset(Box<Recipe>),
    /// Keeps lens and export as a preset.
    KeepPreset(String),
    /// Takes ray depths from elsewhere.
    TakeDepths(DepthFrom),
    /// Takes them from a map of one's own.
    TakeMap(GivenDepth),
    /// Takes the nets from a folder.
    UseModels(PathBuf),
    /// Adds a depth net, takes one away, or uses one for all photos.
    ChangeNets(Change),
    /// Trains on a folder of light fields, or looks at what was trained on it.
    TrainOn(PathBuf),
    /// Trains, rests, or uses what was trained.
    Train(Wanted),
    /// Makes the light field anew, after a setting changed.
    MakeAgain,
    /// Starts the export that the dialog describes: of these photos, or of what is open where there are none.
    StartExport(Vec<PathBuf>),
    /// Something that is told once was put away.
    Learn(Hint),
    /// Changes the timeline.
    Cut(Cut),
    /// Puts the playhead somewhere, 0 … 1.
    Playhead(f32),
    /// Stops one export.
    StopTask(JobId),
}

impl Action {
    /// What a report of a fault says of it: no path, nothing that was typed.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Do(command) => command.spec().name.0,
            Self::Open(_) => "open",
            Self::Ask(_) => "ask the system for a file",
            Self::Show(_) => "show a dialog",
            Self::CloseDialog => "close the dialog",
            Self::Tell(_) => "tell",
            Self::Refuse(_) => "refuse",
            Self::LookFrom(_) => "look from elsewhere",
            Self::FocusOnSubject => "focus on the subject",
            Self::Repair(_) => "mend the depth",
            Self::Unrepair(_) => "take a repair away",
            Self::TakeOpening(_) => "take a picture as opening",
            Self::PasteEdit(_) => "paste an edit",
            Self::TakePreset(_) => "apply a preset",
            Self::KeepPreset(_) => "keep a preset",
            Self::TakeDepths(_) => "take depth from elsewhere",
            Self::TakeMap(_) => "take a depth map",
            Self::UseModels(_) => "take nets from a folder",
            Self::ChangeNets(_) => "change the nets",
            Self::TrainOn(_) => "choose light fields to train on",
            Self::Train(_) => "train",
            Self::MakeAgain => "make the light field again",
            Self::StartExport(_) => "export",
            Self::Learn(_) => "put a hint away",
            Self::Cut(_) => "change the timeline",
            Self::Playhead(_) => "move the playhead",
            Self::StopTask(_) => "stop an export",
        }
    }
}
