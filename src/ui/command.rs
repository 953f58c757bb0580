//! Every command of the menu, in one list: it gives the menu, the shortcut sheet and the tool tips.

use super::words::{Id, id, t};
use egui::{Key, KeyboardShortcut, ModifierNames, Modifiers};

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
    Train,
    Shortcuts,
}

/// How an action is shown.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// Where it stands in menu and sheet.
    pub group: Id,
    /// Its name; `…` where a dialog follows.
    pub name: Id,
    /// Its key.
    pub shortcut: Option<KeyboardShortcut>,
}

impl Spec {
    /// Its name in the language of the window.
    pub fn label(&self) -> &'static str {
        self.name.text()
    }

    /// What it does, for the tool tip.
    pub fn hint(&self) -> &'static str {
        self.name.hint()
    }
}

const FILE: Id = id!("menu-file");
const EDIT: Id = id!("menu-edit");
const VIEWPOINT: Id = id!("menu-viewpoint");
const FILM: Id = id!("menu-film");
const VIEW: Id = id!("menu-view");
const LIGHT_FIELD: Id = id!("menu-light-field");
const HELP: Id = id!("menu-help");

/// The headings of the sheet's two columns.
pub const SHEET: ([Id; 4], [Id; 2]) = ([EDIT, VIEWPOINT, LIGHT_FIELD, HELP], [VIEW, FILE]);

/// What the mouse does, for the shortcut sheet, and with which movement.
pub const MOUSE: [Id; 9] = [
    id!("mouse-drag"),
    id!("mouse-click"),
    id!("mouse-shift-click"),
    id!("mouse-ctrl-click"),
    id!("mouse-wheel"),
    id!("mouse-pan"),
    id!("mouse-epipolar"),
    id!("mouse-hold"),
    id!("mouse-double-click"),
];

impl Command {
    /// All of them, in the order of the menu.
    pub const ALL: [Self; 58] = [
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
        Self::Train,
        Self::Shortcuts,
    ];

    /// Heading, name and key.
    pub fn spec(self) -> Spec {
        let (group, name, shortcut) = match self {
            Self::Open => (FILE, id!("command-open"), ctrl(Key::O)),
            Self::OpenFolder => (FILE, id!("command-open-folder"), shift(Key::O)),
            Self::OpenSample => (FILE, id!("command-open-sample"), None),
            Self::Paste => (FILE, id!("command-paste"), ctrl(Key::V)),
            Self::PreviousPhoto => (FILE, id!("command-previous-photo"), ctrl(Key::ArrowLeft)),
            Self::NextPhoto => (FILE, id!("command-next-photo"), ctrl(Key::ArrowRight)),
            Self::Export => (FILE, id!("command-export"), ctrl(Key::S)),
            Self::ExportPhotos => (FILE, id!("command-export-photos"), shift(Key::S)),
            Self::Queue => (FILE, id!("command-queue"), ctrl(Key::J)),
            Self::Settings => (FILE, id!("command-settings"), ctrl(Key::Comma)),
            Self::CopyPicture => (FILE, id!("command-copy-picture"), ctrl(Key::C)),
            Self::Stop => (FILE, id!("command-stop"), key(Key::Escape)),
            Self::Quit => (FILE, id!("command-quit"), ctrl(Key::Q)),
            Self::Undo => (EDIT, id!("command-undo"), ctrl(Key::Z)),
            Self::Redo => (EDIT, id!("command-redo"), ctrl(Key::Y)),
            Self::CopyEdit => (EDIT, id!("command-copy-edit"), shift(Key::C)),
            Self::PasteEdit => (EDIT, id!("command-paste-edit"), shift(Key::V)),
            Self::Presets => (EDIT, id!("command-presets"), ctrl(Key::P)),
            Self::ResetLens => (EDIT, id!("command-reset-lens"), key(Key::R)),
            Self::ResetViewpoint => (EDIT, id!("command-reset-viewpoint"), key(Key::Home)),
            Self::StepLeft => (VIEWPOINT, id!("command-step-left"), key(Key::ArrowLeft)),
            Self::StepRight => (VIEWPOINT, id!("command-step-right"), key(Key::ArrowRight)),
            Self::StepUp => (VIEWPOINT, id!("command-step-up"), key(Key::ArrowUp)),
            Self::StepDown => (VIEWPOINT, id!("command-step-down"), key(Key::ArrowDown)),
            Self::Circle => (VIEWPOINT, id!("command-circle"), key(Key::P)),
            Self::Nearer => (VIEWPOINT, id!("command-nearer"), key(Key::PageUp)),
            Self::Farther => (VIEWPOINT, id!("command-farther"), key(Key::PageDown)),
            Self::Film => (FILM, id!("command-film"), key(Key::F)),
            Self::PlayFilm => (FILM, id!("command-play-film"), upper(Key::P)),
            Self::AddKey => (FILM, id!("command-add-key"), upper(Key::K)),
            Self::Earlier => (FILM, id!("command-earlier"), key(Key::Comma)),
            Self::Later => (FILM, id!("command-later"), key(Key::Period)),
            Self::Picture => (VIEW, id!("command-picture"), ctrl(Key::Num1)),
            Self::Views => (VIEW, id!("command-views"), ctrl(Key::Num2)),
            Self::Depths => (VIEW, id!("command-depths"), ctrl(Key::Num3)),
            Self::Points => (VIEW, id!("command-points"), ctrl(Key::Num4)),
            Self::ToggleDepth => (VIEW, id!("command-toggle-depth"), key(Key::D)),
            Self::BeforeAfter => (VIEW, id!("command-before-after"), key(Key::C)),
            Self::Stereo => (VIEW, id!("command-stereo"), key(Key::Num3)),
            Self::Peaking => (VIEW, id!("command-peaking"), key(Key::K)),
            Self::Trust => (VIEW, id!("command-trust"), key(Key::U)),
            Self::Fit => (VIEW, id!("command-fit"), key(Key::Num0)),
            Self::OneToOne => (VIEW, id!("command-one-to-one"), key(Key::Num1)),
            Self::ZoomIn => (VIEW, id!("command-zoom-in"), key(Key::Plus)),
            Self::ZoomOut => (VIEW, id!("command-zoom-out"), key(Key::Minus)),
            Self::ToggleInspector => (VIEW, id!("command-toggle-inspector"), key(Key::I)),
            Self::FullScreen => (VIEW, id!("command-full-screen"), key(Key::F11)),
            Self::NextTheme => (VIEW, id!("command-next-theme"), key(Key::T)),
            Self::ClearRecent => (FILE, id!("command-clear-recent"), None),
            Self::OwnDepth => (LIGHT_FIELD, id!("command-own-depth"), ctrl(Key::D)),
            Self::CompareSources => (LIGHT_FIELD, id!("command-compare-sources"), key(Key::S)),
            Self::KeepSource => (LIGHT_FIELD, id!("command-keep-source"), upper(Key::S)),
            Self::Repair => (LIGHT_FIELD, id!("command-repair"), key(Key::M)),
            Self::Opposite => (LIGHT_FIELD, id!("command-opposite"), None),
            Self::Transpose => (LIGHT_FIELD, id!("command-transpose"), None),
            Self::Serpentine => (LIGHT_FIELD, id!("command-serpentine"), None),
            Self::Train => (LIGHT_FIELD, id!("command-train"), None),
            Self::Shortcuts => (HELP, id!("command-shortcuts"), key(Key::F1)),
        };
        Spec { group, name, shortcut }
    }

    /// Headings of the menu and the sheet, in order.
    pub const GROUPS: [Id; 7] = [FILE, EDIT, VIEWPOINT, FILM, VIEW, LIGHT_FIELD, HELP];

    /// The actions of a group.
    pub fn of_group(group: Id) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |action| action.spec().group == group)
    }

    /// Hint with the key behind it, for tool tips.
    pub fn tip(self, ctx: &egui::Context) -> String {
        let spec = self.spec();
        match spec.shortcut {
            Some(keys) => format!("{}  {}", spec.hint(), spelled(&keys, ctx)),
            None => spec.hint().to_owned(),
        }
    }
}

/// A shortcut as the keyboard of the language names it; a Mac's has signs.
pub fn spelled(keys: &KeyboardShortcut, ctx: &egui::Context) -> String {
    if ctx.os().is_mac() {
        return ctx.format_shortcut(keys);
    }
    let names = ModifierNames { ctrl: t!("key-ctrl"), shift: t!("key-shift"), ..ModifierNames::NAMES };
    let (modifiers, key) = (names.format(&keys.modifiers, false), name(keys.logical_key));
    if modifiers.is_empty() { key.to_owned() } else { format!("{modifiers}{}{key}", names.concat) }
}

fn name(key: Key) -> &'static str {
    match key {
        Key::ArrowLeft => t!("key-left"),
        Key::ArrowRight => t!("key-right"),
        Key::ArrowUp => t!("key-up"),
        Key::ArrowDown => t!("key-down"),
        Key::Escape => t!("key-escape"),
        Key::Home => t!("key-home"),
        Key::PageUp => t!("key-page-up"),
        Key::PageDown => t!("key-page-down"),
        Key::Comma => t!("key-comma"),
        Key::Period => t!("key-period"),
        _ => key.name(),
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
