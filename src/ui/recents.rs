//! Small pictures of the files that were opened last, kept in the user's cache folder.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui::ColorImage;

use super::event::Event;
use super::worker::{JobId, Outbox};
use crate::field::View;
use crate::io::save::{self, PictureOptions, Pixels, Samples};
use crate::job::{Cancel, Job};
use crate::scene::{Content, Subject};
use crate::synth::reference_view;

/// Long side of a small picture, in pixels: enough for a screen of two pixels a point.
const LONG_SIDE: u32 = 288;

/// The folder of small pictures; none where the system has no place for caches.
fn folder() -> Option<PathBuf> {
    Some(directories::ProjectDirs::from("", "", "plenoscope")?.cache_dir().join("thumbnails"))
}

fn place(folder: &Path, file: &Path) -> PathBuf {
    folder.join(format!("{:x}.jpg", md5::compute(file.as_os_str().as_encoded_bytes())))
}

/// Keeps a small picture of a file that has been opened. A cache that cannot be written is no harm.
pub fn keep(subject: &Subject) {
    let (Some(folder), Some(path)) = (folder(), &subject.path) else { return };
    let view = match &subject.content {
        Content::Photo(one) => {
            reference_view(&one.photo, LONG_SIDE, &Job { cancel: &Cancel::default(), sink: &() }).ok()
        }
        Content::Views(recorded) => Some(recorded.shown.reference().as_ref().clone()),
    };
    if let Some(view) = view
        && let Err(error) = std::fs::create_dir_all(&folder).map_err(|e| e.to_string()).and_then(|()| {
            let options = PictureOptions { quality: 80, ..PictureOptions::default() };
            save::pixels(&place(&folder, path), &pixels(&view), &options).map_err(|e| e.to_string())
        })
    {
        log::info!("no small picture is kept: {error}");
    }
}

fn pixels(view: &View) -> Pixels {
    let rgb = view.rgba().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    Pixels { size: view.size(), samples: Samples::Eight(rgb) }
}

/// The thread's work: tells the window of each file's small picture, and forgets those of files that are not asked for.
pub fn work(job: JobId, files: Vec<PathBuf>, cancel: &Cancel, outbox: &Outbox) {
    let Some(folder) = folder() else { return };
    let wanted: Vec<PathBuf> = files.iter().map(|file| place(&folder, file)).collect();
    for old in std::fs::read_dir(&folder).into_iter().flatten().flatten() {
        if !wanted.contains(&old.path())
            && let Err(error) = std::fs::remove_file(old.path())
        {
            log::info!("an old small picture stays: {error}");
        }
    }
    for (file, small) in files.into_iter().zip(wanted) {
        if cancel.is_cancelled() {
            return;
        }
        let Ok(picture) = image::open(&small) else { continue };
        let rgb = picture.to_rgb8();
        let size = [rgb.width() as usize, rgb.height() as usize];
        outbox.send(job, Event::Thumbnail(file, Arc::new(ColorImage::from_rgb(size, &rgb))));
    }
}
