//! The system's file dialogs, on a thread of their own; and what to do where the system has none.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::worker::{Event, JobId, Outbox};
use crate::job::Cancel;

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
    /// Text or a picture in the clipboard.
    Clipboard,
}

/// Where a dialog led.
#[derive(Clone, Debug)]
pub enum Picked {
    /// A file to open.
    Open(PathBuf),
    /// A folder to save into.
    Folder(PathBuf),
    /// A picture from the clipboard, `[y, x, 4]`.
    Pixels([u32; 2], Vec<u8>),
    /// The system shows no dialogs: ask for a path in the window.
    Unavailable,
    /// The person changed their mind.
    Nothing,
}

/// A dialog that ends sooner than this without an answer was never shown.
const SHOWN: Duration = Duration::from_millis(400);

/// The dialog thread's work.
pub fn work(job: JobId, ask: Ask, _: &Cancel, outbox: &Outbox) {
    let start = Instant::now();
    let event = match ask {
        Ask::Clipboard => clipboard(),
        Ask::Open { folder } => {
            let file = pollster::block_on(dialog(folder).pick_file());
            Event::Picked(file.map_or_else(|| none(start), |file| Picked::Open(file.path().to_owned())))
        }
        Ask::Folder { folder } => {
            let folder = pollster::block_on(dialog(folder).pick_folder());
            Event::Picked(folder.map_or_else(|| none(start), |folder| Picked::Folder(folder.path().to_owned())))
        }
    };
    outbox.send(job, event);
}

fn dialog(folder: Option<PathBuf>) -> rfd::AsyncFileDialog {
    let dialog = rfd::AsyncFileDialog::new();
    match folder {
        Some(folder) => dialog.set_directory(folder),
        None => dialog,
    }
}

fn none(start: Instant) -> Picked {
    if start.elapsed() < SHOWN { Picked::Unavailable } else { Picked::Nothing }
}

/// A picture, or the path of one.
fn clipboard() -> Event {
    let nothing = "nothing to paste — the clipboard holds no picture and no path of a file — copy one first";
    let Ok(mut board) = arboard::Clipboard::new() else {
        return Event::Failed(
            "could not paste — the system's clipboard does not answer — open the file instead".into(),
        );
    };
    if let Ok(image) = board.get_image() {
        return Event::Picked(Picked::Pixels([image.width as u32, image.height as u32], image.bytes.into_owned()));
    }
    let text = board.get_text().unwrap_or_default();
    match path_from_text(&text) {
        Some(path) => Event::Picked(Picked::Open(path)),
        None => Event::Failed(nothing.to_owned()),
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
}
