//! What the system and the clipboard are asked for, and where that led.

use std::path::PathBuf;

use super::near_end::Reading;
use crate::field::Opening;
use crate::scene::Recipe;

/// What is asked for.
#[derive(Clone, Debug)]
pub enum Ask {
    /// A file to open.
    Open {
        /// Where to start.
        folder: Option<PathBuf>,
    },
    /// A folder to save into.
    Folder {
        /// Where to start.
        folder: Option<PathBuf>,
    },
    /// A folder of views to open.
    OpenFolder {
        /// Where to start.
        folder: Option<PathBuf>,
    },
    /// Photos to export.
    Photos {
        /// Where to start.
        folder: Option<PathBuf>,
    },
    /// A depth map of one's own.
    DepthMap {
        /// Where to start.
        folder: Option<PathBuf>,
    },
    /// The depth map in a file.
    ReadDepthMap(PathBuf),
    /// A picture as the opening of the lens.
    Opening,
    /// The one in a file.
    ReadOpening(PathBuf),
    /// A folder of models.
    Models,
    /// A depth net.
    Net,
    /// A folder of light fields to train on.
    LightFields,
    /// A picture, a path or an edit in the clipboard.
    Clipboard,
    /// An edit in the clipboard.
    PasteEdit,
    /// The edit in a file.
    ReadEdit(PathBuf),
    /// The presets: their names, after something was done to them.
    Presets(Preset),
}

/// What is done to presets.
#[derive(Clone, Debug)]
pub enum Preset {
    /// Nothing.
    List,
    /// A recipe gets a name.
    Keep(String, Box<Recipe>),
    /// One goes.
    Remove(String),
    /// One is applied.
    Take(String),
}

/// What a typed path is for, where the system shows no dialogs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PathFor {
    /// A photo or a light field to open.
    Open,
    /// A photo to export.
    Export,
    /// A depth map.
    DepthMap,
    /// A picture as the opening of the lens.
    Opening,
    /// A folder of models.
    Models,
    /// A depth net.
    Net,
    /// A folder of light fields to train on.
    LightFields,
}

/// Where a dialog led.
#[derive(Clone, Debug)]
pub enum Picked {
    /// A file to open.
    Open(PathBuf),
    /// A folder to save into.
    Folder(PathBuf),
    /// Photos to export.
    Photos(Vec<PathBuf>),
    /// A depth map of one's own.
    DepthMap {
        /// Where it lies.
        path: PathBuf,
        /// Its width and height.
        size: [u32; 2],
        /// The map, read both ways.
        readings: [Reading; 2],
    },
    /// The opening of the lens.
    Opening(Opening),
    /// A folder of models.
    Models(PathBuf),
    /// A depth net to add.
    Net(PathBuf),
    /// A folder of light fields to train on.
    LightFields(PathBuf),
    /// A picture from the clipboard, `[y, x, 4]`.
    Pixels([u32; 2], Vec<u8>),
    /// An edit from the clipboard or a file.
    Edit(Box<Recipe>),
    /// The names of the presets.
    Presets(Vec<String>),
    /// A preset to apply.
    Preset(Box<Recipe>),
    /// The system shows no dialogs: ask for a path in the window.
    Unavailable(PathFor),
    /// The system shows no dialog for the folder of exports, which the export dialog has a field for.
    NoFolderDialog,
    /// The person changed their mind.
    Nothing,
}
