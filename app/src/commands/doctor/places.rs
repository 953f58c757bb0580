//! The folders that the program keeps things in.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use plenoscope::aside::{self, NewFile};
use plenoscope::crash;
use plenoscope::scene::real;
use plenoscope::synth::adopt::Shelf;
use plenoscope::synth::cache::Cache;

use super::{Section, size};

/// Bytes that a light field and a few pictures need.
const LITTLE_BYTES: u64 = 200 << 20;

/// Looks whether each can be written to, how full it is, and what lies in it.
pub(super) fn look() -> Section {
    let mut section = Section::new("folders");
    let crashes = crash::folder();
    let places: [(&str, Option<PathBuf>); 5] = [
        ("settings", crashes.as_deref().and_then(Path::parent).map(Path::to_owned)),
        ("light fields kept", Cache::user().map(|cache| cache.folder().to_owned())),
        ("nets", Shelf::user().map(|shelf| shelf.folder().to_owned())),
        ("lenses", real::own_folder()),
        ("reports of faults", crashes),
    ];
    for (name, folder) in places {
        match folder {
            Some(folder) => place(&mut section, name, &folder),
            None => section.wrong.push(format!(
                "there is no folder for {name} — the system names none — set HOME, or XDG_DATA_HOME and XDG_CACHE_HOME"
            )),
        }
    }
    section
}

fn place(section: &mut Section, name: &str, folder: &Path) {
    let files = fs::read_dir(folder).map_or(0, |entries| entries.flatten().count());
    let shown = folder.display();
    match try_to_write(folder) {
        Ok(true) => section.say(name, format!("{shown} ({files} in it)")),
        Ok(false) => return section.say(name, format!("{shown} (not there yet)")),
        Err(error) => {
            section.say(name, format!("{shown} ({error})"));
            section.wrong.push(format!(
                "{name} cannot be kept — {error} — give yourself the right to write there, or make room: {shown}"
            ));
        }
    }
    if let Some(free) = aside::free_bytes(folder).filter(|free| *free < LITTLE_BYTES) {
        section.wrong.push(format!("the disk is nearly full — {} are free — make room: {shown}", size(free)));
    }
}

/// Whether a folder is there; an error where a file cannot be put there.
fn try_to_write(folder: &Path) -> io::Result<bool> {
    match fs::metadata(folder) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
        Ok(facts) if !facts.is_dir() => Err(io::ErrorKind::NotADirectory.into()),
        Ok(_) => NewFile::new(&folder.join("doctor")).map(|_| true),
    }
}
