//! Every command of the menu, in one list: it gives the menu, the shortcut sheet and the tool tips.

use egui::{Key, KeyboardShortcut, Modifiers};

/// One thing to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs, reason = "each one's label and hint stand in `Command::spec`")]
pub enum Command {
    Open,
    OpenFolder,
    OpenSample,
    Paste,
    NextPhoto,
    PreviousPhoto,
    Export,
    ExportPhotos,
    Queue,
    CopyPicture,
    Settings,
    Stop,
    Quit,
    Undo,
    Redo,
    CopyEdit,
    PasteEdit,
    Presets,
    ResetLens,
    ResetViewpoint,
    StepLeft,
    StepRight,
    StepUp,
    StepDown,
    Circle,
    Nearer,
    Farther,
    Film,
    PlayFilm,
    AddKey,
    Earlier,
    Later,
    Picture,
    Views,
    Depths,
    Points,
    ToggleDepth,
    BeforeAfter,
    Stereo,
    Peaking,
    Fit,
    OneToOne,
    ZoomIn,
    ZoomOut,
    ToggleInspector,
    FullScreen,
    NextTheme,
    ClearRecent,
    OwnDepth,
    CompareSources,
    KeepSource,
    Opposite,
    Transpose,
    Serpentine,
    Repair,
    Trust,
    Shortcuts,
}

/// How an action is shown.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// Where it stands in menu and sheet.
    pub group: &'static str,
    /// Its name; `…` where a dialog follows.
    pub label: &'static str,
    /// What it does, for the tool tip.
    pub hint: &'static str,
    /// Its key.
    pub shortcut: Option<KeyboardShortcut>,
}

/// What the mouse does, for the shortcut sheet.
pub const MOUSE: [(&str, &str); 9] = [
    ("Drag the picture", "Look round"),
    ("Click the picture", "Focus there"),
    ("Shift-click", "Keep this sharp, too"),
    ("Ctrl-click", "Turn around this while looking round"),
    ("Wheel", "Zoom at the pointer"),
    ("Middle drag, Space + drag", "Move the picture"),
    ("Drag in an epipolar image", "Set a thing's depth"),
    ("Hold \\", "Show the photo itself"),
    ("Double-click a value's name", "Reset it"),
];

impl Command {
    /// All of them, in the order of the menu.
    pub const ALL: [Self; 57] = [
        Self::Open,
        Self::OpenFolder,
        Self::OpenSample,
        Self::Paste,
        Self::PreviousPhoto,
        Self::NextPhoto,
        Self::Export,
        Self::ExportPhotos,
        Self::Queue,
        Self::CopyPicture,
        Self::ClearRecent,
        Self::Settings,
        Self::Stop,
        Self::Quit,
        Self::Undo,
        Self::Redo,
        Self::CopyEdit,
        Self::PasteEdit,
        Self::Presets,
        Self::ResetLens,
        Self::ResetViewpoint,
        Self::StepLeft,
        Self::StepRight,
        Self::StepUp,
        Self::StepDown,
        Self::Circle,
        Self::Nearer,
        Self::Farther,
        Self::Film,
        Self::PlayFilm,
        Self::AddKey,
        Self::Earlier,
        Self::Later,
        Self::Picture,
        Self::Views,
        Self::Depths,
        Self::Points,
        Self::ToggleDepth,
        Self::BeforeAfter,
        Self::Stereo,
        Self::Peaking,
        Self::Trust,
        Self::Fit,
        Self::OneToOne,
        Self::ZoomIn,
        Self::ZoomOut,
        Self::ToggleInspector,
        Self::FullScreen,
        Self::NextTheme,
        Self::OwnDepth,
        Self::CompareSources,
        Self::KeepSource,
        Self::Repair,
        Self::Opposite,
        Self::Transpose,
        Self::Serpentine,
        Self::Shortcuts,
    ];

    /// Label, hint and key.
    pub fn spec(self) -> Spec {
        let (group, label, hint, shortcut) = match self {
            Self::Open => ("File", "Open…", "Open a photo or a light field", ctrl(Key::O)),
            Self::OpenFolder => ("File", "Open folder…", "Open a folder of views", shift(Key::O)),
            Self::OpenSample => ("File", "Try the sample", "Open the built-in picture", None),
            Self::Paste => {
                ("File", "Paste", "Open the picture or path in the clipboard, or apply the edit in it", ctrl(Key::V))
            }
            Self::PreviousPhoto => ("File", "Previous photo", "Open the photo before this one", ctrl(Key::ArrowLeft)),
            Self::NextPhoto => ("File", "Next photo", "Open the photo after this one", ctrl(Key::ArrowRight)),
            Self::Export => ("File", "Export…", "Save the picture, or anything else it can become", ctrl(Key::S)),
            Self::ExportPhotos => ("File", "Export photos…", "Export other photos with this edit", shift(Key::S)),
            Self::Queue => ("File", "Queue", "What is being exported, and what waits", ctrl(Key::J)),
            Self::Settings => ("File", "Settings…", "Theme, light field, models", ctrl(Key::Comma)),
            Self::CopyPicture => ("File", "Copy picture", "Put the picture into the clipboard", ctrl(Key::C)),
            Self::Stop => ("File", "Stop", "Stop what is running", key(Key::Escape)),
            Self::Quit => ("File", "Quit", "Close the window", ctrl(Key::Q)),
            Self::Undo => ("Edit", "Undo", "Take the last edit back", ctrl(Key::Z)),
            Self::Redo => ("Edit", "Redo", "Do the last edit again", ctrl(Key::Y)),
            Self::CopyEdit => ("Edit", "Copy edit", "Put lens, focus and viewpoint into the clipboard", shift(Key::C)),
            Self::PasteEdit => ("Edit", "Paste edit", "Apply the edit in the clipboard", shift(Key::V)),
            Self::Presets => ("Edit", "Presets…", "Lens and export under a name", ctrl(Key::P)),
            Self::ResetLens => ("Edit", "Reset lens", "Back to f/3.5, focus in the middle", key(Key::R)),
            Self::ResetViewpoint => ("Edit", "Centre viewpoint", "Back to where the photo was taken", key(Key::Home)),
            Self::StepLeft => ("Viewpoint", "Step left", "Move the eye one view left", key(Key::ArrowLeft)),
            Self::StepRight => ("Viewpoint", "Step right", "Move the eye one view right", key(Key::ArrowRight)),
            Self::StepUp => ("Viewpoint", "Step up", "Move the eye one view up", key(Key::ArrowUp)),
            Self::StepDown => ("Viewpoint", "Step down", "Move the eye one view down", key(Key::ArrowDown)),
            Self::Circle => ("Viewpoint", "Circle", "Let the viewpoint go round", key(Key::P)),
            Self::Nearer => ("Viewpoint", "Nearer layer", "Focus on the next nearer depth layer", key(Key::PageUp)),
            Self::Farther => {
                ("Viewpoint", "Farther layer", "Focus on the next farther depth layer", key(Key::PageDown))
            }
            Self::Film => ("Film", "Timeline", "Show or hide the keys of a film", key(Key::F)),
            Self::PlayFilm => ("Film", "Play", "Show the film, or end it", upper(Key::P)),
            Self::AddKey => ("Film", "Add key", "Keep lens and eye as they are at the playhead", upper(Key::K)),
            Self::Earlier => ("Film", "Earlier", "Move the playhead back", key(Key::Comma)),
            Self::Later => ("Film", "Later", "Move the playhead on", key(Key::Period)),
            Self::Picture => ("View", "Picture", "The refocused picture", ctrl(Key::Num1)),
            Self::Views => ("View", "Views", "All views of the light field", ctrl(Key::Num2)),
            Self::Depths => ("View", "Ray depths", "Ray depths of the current view", ctrl(Key::Num3)),
            Self::Points => (
                "View",
                "Points",
                "The scene as points: a drag turns it, a double click turns it back",
                ctrl(Key::Num4),
            ),
            Self::ToggleDepth => {
                ("View", "Ray depths on and off", "Change between picture and ray depths", key(Key::D))
            }
            Self::BeforeAfter => {
                ("View", "Before / after", "The photo left of the line, the picture right", key(Key::C))
            }
            Self::Stereo => ("View", "Both eyes", "Red-cyan, beside each other, crossed, and off", key(Key::Num3)),
            Self::Peaking => ("View", "Focus peaking", "Mark the edges that are in focus", key(Key::K)),
            Self::Trust => ("View", "Trust view", "Tint what was invented, not seen", key(Key::U)),
            Self::Fit => ("View", "Fit", "Show the whole picture", key(Key::Num0)),
            Self::OneToOne => ("View", "1:1", "One picture pixel for one screen pixel", key(Key::Num1)),
            Self::ZoomIn => ("View", "Zoom in", "Closer", key(Key::Plus)),
            Self::ZoomOut => ("View", "Zoom out", "Farther", key(Key::Minus)),
            Self::ToggleInspector => ("View", "Inspector", "Show or hide the panel on the right", key(Key::I)),
            Self::FullScreen => ("View", "Full screen", "Use the whole screen", key(Key::F11)),
            Self::NextTheme => ("View", "Theme", "Dark, light, or as the system", key(Key::T)),
            Self::ClearRecent => ("File", "Forget recent files", "Empty the list of recent files", None),
            Self::OwnDepth => ("Light field", "Depth map…", "Take ray depths from a map of your own", ctrl(Key::D)),
            Self::CompareSources => {
                ("Light field", "Compare sources", "Show the next source of ray depths; Esc goes back", key(Key::S))
            }
            Self::KeepSource => ("Light field", "Keep this source", "Use the source that is compared", upper(Key::S)),
            Self::Repair => ("Light field", "Repair depth", "Mend what the depth got wrong, by hand", key(Key::M)),
            Self::Opposite => ("Light field", "Exchange near and far", "Turn the sign of every disparity", None),
            Self::Transpose => ("Light field", "Exchange rows and columns", "Rows of views are columns", None),
            Self::Serpentine => ("Light field", "To and fro", "Every second row of views runs backwards", None),
            Self::Shortcuts => ("Help", "Shortcuts", "All keys and what the mouse does", key(Key::F1)),
        };
        Spec { group, label, hint, shortcut }
    }

    /// Headings of the menu and the sheet, in order.
    pub const GROUPS: [&'static str; 7] = ["File", "Edit", "Viewpoint", "Film", "View", "Light field", "Help"];

    /// The actions of a group.
    pub fn of_group(group: &str) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |action| action.spec().group == group)
    }

    /// Hint with the key behind it, for tool tips.
    pub fn tip(self, ctx: &egui::Context) -> String {
        let spec = self.spec();
        match spec.shortcut {
            Some(keys) => format!("{}  {}", spec.hint, ctx.format_shortcut(&keys)),
            None => spec.hint.to_owned(),
        }
    }
}

fn key(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::NONE, key))
}

fn upper(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::SHIFT, key))
}

fn ctrl(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND, key))
}

fn shift(key: Key) -> Option<KeyboardShortcut> {
    Some(KeyboardShortcut::new(Modifiers::COMMAND | Modifiers::SHIFT, key))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn no_key_does_two_things_and_no_action_is_listed_twice() {
        let keys: Vec<_> = Command::ALL.iter().filter_map(|action| action.spec().shortcut).collect();
        assert_eq!(keys.iter().collect::<HashSet<_>>().len(), keys.len());
        assert_eq!(Command::ALL.iter().collect::<HashSet<_>>().len(), Command::ALL.len());
    }
}
