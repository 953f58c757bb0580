//! The system's file dialogs, on a thread of their own; and what to do where the system has none.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::ask::{Ask, PathFor, Picked, Preset};
use super::event::Event;
use super::near_end;
use super::words::message;
use super::worker::{JobId, Outbox};
use crate::io::formats::depth_map;
use crate::io::opening;
use crate::job::Cancel;
use crate::scene::Recipe;
use crate::scene::recipe::Presets;

/// A dialog that ends sooner than this without an answer was never shown.
const SHOWN: Duration = Duration::from_millis(400);

/// The dialog thread's work.
pub fn work(job: JobId, ask: Ask, _: &Cancel, outbox: &Outbox) {
    let start = Instant::now();
    let path = |file: rfd::FileHandle| file.path().to_owned();
    let or_none = |picked: Option<Picked>, wanted| picked.unwrap_or_else(|| none(start, wanted));
    let picked = match ask {
        Ask::Clipboard => return tell(job, clipboard(), outbox),
        Ask::ReadEdit(path) => return tell(job, edit_in_file(&path), outbox),
        Ask::Presets(what) => return tell(job, presets(what), outbox),
        Ask::PasteEdit => return tell(job, edit_in_clipboard(), outbox),
        Ask::ReadDepthMap(path) => return tell(job, depth_map(path), outbox),
        Ask::DepthMap { folder } => match pollster::block_on(dialog(folder).pick_file()) {
            Some(file) => return tell(job, depth_map(path(file)), outbox),
            None => none(start, PathFor::DepthMap),
        },
        Ask::ReadOpening(path) => return tell(job, opening(&path), outbox),
        Ask::Opening => match pollster::block_on(dialog(None).pick_file()) {
            Some(file) => return tell(job, opening(file.path()), outbox),
            None => none(start, PathFor::Opening),
        },
        Ask::Open { folder } => {
            or_none(pollster::block_on(dialog(folder).pick_file()).map(path).map(Picked::Open), PathFor::Open)
        }
        Ask::OpenFolder { folder } => {
            or_none(pollster::block_on(dialog(folder).pick_folder()).map(path).map(Picked::Open), PathFor::Open)
        }
        Ask::Photos { folder } => {
            let files = pollster::block_on(dialog(folder).pick_files());
            let files = files.map(|files| Picked::Photos(files.into_iter().map(path).collect()));
            or_none(files, PathFor::Export)
        }
        Ask::Models => {
            or_none(pollster::block_on(dialog(None).pick_folder()).map(path).map(Picked::Models), PathFor::Models)
        }
        Ask::Net => or_none(pollster::block_on(dialog(None).pick_file()).map(path).map(Picked::Net), PathFor::Net),
        Ask::LightFields => or_none(
            pollster::block_on(dialog(None).pick_folder()).map(path).map(Picked::LightFields),
            PathFor::LightFields,
        ),
        Ask::Folder { folder } => match pollster::block_on(dialog(folder).pick_folder()) {
            Some(folder) => Picked::Folder(path(folder)),
            None if start.elapsed() < SHOWN => Picked::NoFolderDialog,
            None => Picked::Nothing,
        },
    };
    outbox.send(job, Event::Picked(picked));
}

fn tell(job: JobId, event: Event, outbox: &Outbox) {
    outbox.send(job, event);
}

fn depth_map(path: PathBuf) -> Event {
    match depth_map::read(&path) {
        Ok(map) => match near_end::readings(&map) {
            Ok(readings) => Event::Picked(Picked::DepthMap { path, size: map.size(), readings }),
            Err(error) => Event::Failed(crate::errors::sentence(&error).into()),
        },
        Err(error) => Event::Failed(crate::errors::sentence(&error).into()),
    }
}

fn opening(path: &Path) -> Event {
    match opening::read(path) {
        Ok(opening) => Event::Picked(Picked::Opening(opening)),
        Err(error) => Event::Failed(crate::errors::sentence(&error).into()),
    }
}

fn dialog(folder: Option<PathBuf>) -> rfd::AsyncFileDialog {
    let dialog = rfd::AsyncFileDialog::new();
    match folder {
        Some(folder) => dialog.set_directory(folder),
        None => dialog,
    }
}

fn none(start: Instant, wanted: PathFor) -> Picked {
    if start.elapsed() < SHOWN { Picked::Unavailable(wanted) } else { Picked::Nothing }
}

fn edit_in_file(path: &Path) -> Event {
    match Recipe::read(path) {
        Ok(recipe) => Event::Picked(Picked::Edit(Box::new(recipe))),
        Err(error) => Event::Failed(crate::errors::sentence(&error).into()),
    }
}

/// Does something to the presets, and says which there are then.
fn presets(what: Preset) -> Event {
    let Some(presets) = Presets::user() else {
        return Event::Failed(message!("presets-no-folder"));
    };
    let done = match what {
        Preset::List => Ok(None),
        Preset::Keep(name, recipe) => presets.keep(&name, &recipe).map(|()| None),
        Preset::Remove(name) => presets.remove(&name).map(|()| None),
        Preset::Take(name) => presets.read(&name).map(|recipe| Some(Box::new(recipe))),
    };
    match done {
        Ok(Some(recipe)) => Event::Picked(Picked::Preset(recipe)),
        Ok(None) => Event::Picked(Picked::Presets(presets.names())),
        Err(error) => Event::Failed(crate::errors::sentence(&error).into()),
    }
}

fn edit_in_clipboard() -> Event {
    let text = arboard::Clipboard::new().and_then(|mut board| board.get_text()).unwrap_or_default();
    match edit_from_text(&text) {
        Some(edit) => Event::Picked(Picked::Edit(edit)),
        None => Event::Failed(message!("paste-no-edit")),
    }
}

/// An edit, if that is what a text holds.
pub fn edit_from_text(text: &str) -> Option<Box<Recipe>> {
    let text = text.trim();
    (text.starts_with('{') && text.contains("\"lens\"")).then(|| Recipe::from_json(text).ok()).flatten().map(Box::new)
}

/// A picture, or the path of one.
fn clipboard() -> Event {
    let Ok(mut board) = arboard::Clipboard::new() else {
        return Event::Failed(message!("paste-no-answer"));
    };
    if let Ok(image) = board.get_image() {
        return Event::Picked(Picked::Pixels([image.width as u32, image.height as u32], image.bytes.into_owned()));
    }
    let text = board.get_text().unwrap_or_default();
    match (edit_from_text(&text), path_from_text(&text)) {
        (Some(edit), _) => Event::Picked(Picked::Edit(edit)),
        (None, Some(path)) => Event::Picked(Picked::Open(path)),
        (None, None) => Event::Failed(message!("paste-nothing")),
    }
}

/// A path from what people paste: quoted, as a `file://` address, with a line end, with `~`.
pub fn path_from_text(text: &str) -> Option<PathBuf> {
    let line = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'))?.trim();
    let line = line.trim_matches(['"', '\'']);
    let path = match line.strip_prefix("file://") {
        Some(address) => PathBuf::from(percent_decoded(address)),
        None => match (line.strip_prefix("~/"), directories::UserDirs::new()) {
            (Some(rest), Some(dirs)) => dirs.home_dir().join(rest),
            _ => PathBuf::from(line),
        },
    };
    (path.is_absolute() || path.exists()).then_some(path)
}

fn percent_decoded(address: &str) -> String {
    let bytes = address.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while i < bytes.len() {
        let hex = (bytes[i] == b'%').then(|| address.get(i + 1..i + 3)).flatten();
        match hex.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                out.push(byte);
                i += 3;
            }
            None => {
                out.push(bytes[i]);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_found_in_what_people_paste() {
        let want = Some(PathBuf::from("/photos/a b.jpg"));
        for text in ["/photos/a b.jpg\n", "\"/photos/a b.jpg\"", "file:///photos/a%20b.jpg\r\n", "\n'/photos/a b.jpg'"]
        {
            assert_eq!(path_from_text(text), want, "{text:?}");
        }
        assert_eq!(path_from_text("just some words"), None);
        assert_eq!(path_from_text(""), None);
    }

    #[test]
    fn an_edit_is_told_from_other_text() {
        let edit = Recipe::default().to_json();
        assert!(edit_from_text(&edit).is_some());
        assert!(edit_from_text("{\"lens\": 3}").is_none());
        assert!(edit_from_text("/a/lens.jpg").is_none());
    }
}
